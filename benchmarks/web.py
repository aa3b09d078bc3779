"""The page in Chromium: from a key to the next jump painted, panning a million samples, opening 10 000 runs."""

from __future__ import annotations

import contextlib
import json
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.processes import LABBOOK, run_process
from benchmarks.report_costs import book_of_charges
from benchmarks.section import Benchmark, Budget, Section, Table
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.book.opening import opened
from labbook.demo.truth import CHAPTER_5

KEYS, RUNS, SAMPLES, FRAMES = 1000, 10_000, 1_000_000, 120
MORE_RUNS = 160
_BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
_NO_BROWSER = "no Chromium here"
_PRESS = """async (count) => {
  const painted = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 0)));
  const took = [];
  for (let number = 0; number < count; number += 1) {
    const begin = performance.now();
    document.dispatchEvent(new KeyboardEvent("keydown", { key: "a", bubbles: true }));
    await painted();
    took.push(performance.now() - begin);
  }
  return took;
}"""
_PAN = """async (frames) => {
  const canvas = document.getElementById("trace");
  const begin = performance.now();
  for (let number = 0; number < frames; number += 1) {
    canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: number % 2 ? 1 : -1, bubbles: true, cancelable: true }));
    await new Promise((done) => requestAnimationFrame(done));
  }
  return frames / (performance.now() - begin) * 1000;
}"""


@contextlib.contextmanager
def _page(book: Path, path: str) -> Iterator[tuple[Any, float]]:
    """Open a view of a book's page; also gives how long it took until its data stood there, in s."""
    from playwright.sync_api import sync_playwright

    command: list[str | Path] = [LABBOOK, "web", "--json", "--no-browser", "--book", book]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server, sync_playwright() as playwright:
        assert server.stdout is not None
        url = json.loads(server.stdout.readline())["url"]
        browser = playwright.chromium.launch(executable_path=_BROWSER, args=["--no-sandbox"])
        page = browser.new_context(viewport={"width": 1280, "height": 860}, bypass_csp=True).new_page()
        page.goto(url)
        begin = time.perf_counter()
        page.goto(url.partition("/?")[0] + path)
        page.wait_for_function(_READY[path.partition("?")[0].split("/")[1]])
        yield page, time.perf_counter() - begin
        browser.close()
        server.terminate()


_READY = {
    "": "document.querySelectorAll('#runs tbody tr').length > 0",
    "review": "document.getElementById('number').textContent !== ''",
    "runs": "document.getElementById('trace').width > 300",
}
"""When a view stands there, by the first part of its path."""
_LOOKED = "document.getElementById('progress').textContent.includes('look at')"


def _keys(folder: Path, say: Callable[[str], None]) -> tuple[np.ndarray[Any, Any], int]:
    """Return the times of `KEYS` keys in ms, and how many jumps were queued; all verdicts are in the book then."""
    say("labbook demo")
    run_process([LABBOOK, "demo", folder / "demo"])
    book = folder / "demo" / "book"
    say(f"{MORE_RUNS} runs more")
    _more_runs(folder, book)
    say(f"{KEYS} keys")
    with _page(book, "/review") as (page, _opened_s):
        took = np.array(page.evaluate(_PRESS, KEYS))
        queued = int(page.text_content("#saved").partition(" of ")[2].split()[0])
        page.wait_for_function("!document.getElementById('saved').textContent.includes('waiting')", timeout=600_000)
        saved = int(page.text_content("#saved").split()[0])
    if saved < KEYS:
        raise RuntimeError(f"{KEYS - saved} verdicts of {KEYS} are not in the book")
    return took, queued


def _more_runs(folder: Path, book: Path) -> None:
    """Let the demonstration have more runs, with logs of its own without their last row, so that 10 000 jumps wait."""
    (more := folder / "more").mkdir()
    levels = {"foot": CHAPTER_5.groups[0].foot, "k_gain": str(CHAPTER_5.groups[0].k_gain), "b_ad_gain": "0"}
    names = [f"x{number:03d}" for number in range(MORE_RUNS)]
    rows = (
        {"run": name, "date": "2030-01-01", "position": number + 1, "kind": "jumps", **levels, "battery": "A",
         "robot": "hopper", "started": "", "duration_s": 720, "jumps_made": 25}
        for number, name in enumerate(names)
    )  # fmt: skip
    pd.DataFrame(rows).to_csv(folder / "more.csv", index=False)
    run_process([LABBOOK, "runs", "import", folder / "more.csv", "--book", book])
    logs = sorted((folder / "demo" / "instruments" / "logs").iterdir())
    for name, log in zip(names, logs, strict=False):
        (more / f"{name}.csv").write_bytes(log.read_bytes().rstrip().rpartition(b"\n")[0] + b"\n")
    run_process([LABBOOK, "ingest", more, "--book", book])


def _pan(folder: Path, say: Callable[[str], None]) -> float:
    """Return the frames a second at which a log of `SAMPLES` samples zooms."""
    say(f"a log of {SAMPLES} samples")
    book = folder / "long"
    level = {"foot": CHAPTER_5.groups[0].foot, "k_gain": str(CHAPTER_5.groups[0].k_gain), "b_ad_gain": "0"}
    book_of_charges(book, 20, [level])
    time_s = np.arange(SAMPLES) / 1000.0
    height_mm = 400.0 + 50.0 * np.sin(2.0 * np.pi * time_s / 3.0)
    log = folder / "r000001.csv"
    rows = "\n".join(f"{at:.3f},{high:.2f}" for at, high in zip(time_s, height_mm, strict=True))
    log.write_text(f"time_s,body_height_mm\n{rows}\n")
    with opened(book) as opened_book:
        ingest_file(opened_book, log, IngestRequest(run="r000001"))
    say("zooming")
    with _page(book, "/runs/r000001") as (page, _opened_s):
        return float(page.evaluate(_PAN, FRAMES))


def _overview(folder: Path, say: Callable[[str], None]) -> tuple[float, float]:
    """Return how long the overview of `RUNS` runs takes to stand there, and what needs attention in it, in s."""
    say(f"a book of {RUNS} runs")
    book = folder / "many"
    level = {"foot": CHAPTER_5.groups[0].foot, "k_gain": str(CHAPTER_5.groups[0].k_gain), "b_ad_gain": "0"}
    book_of_charges(book, RUNS, [level])
    with _page(book, "/") as (page, _first_s):
        page.wait_for_function(_LOOKED)
        begin = time.perf_counter()
        page.reload()
        page.wait_for_function(_READY[""])
        rows_s = time.perf_counter() - begin
        page.wait_for_function(_LOOKED)
        return rows_s, time.perf_counter() - begin


def measure(say: Callable[[str], None]) -> Section:
    """Drive the page."""
    took: np.ndarray[Any, Any] | None = None
    queued, frames, rows_s, looked_s = 0, None, None, 0.0
    if _BROWSER is not None:
        with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
            folder = Path(name)
            took, queued = _keys(folder, say)
            frames = _pan(folder, say)
            rows_s, looked_s = _overview(folder, say)
    p95 = None if took is None else float(np.quantile(took, 0.95))
    cells = () if took is None else (f"{np.median(took):.1f}", f"{p95:.1f}", f"{np.max(took):.1f}")
    return Section(
        "The page",
        f"Chromium without a graphics card. {KEYS} times `a` on the review of the demonstration and {MORE_RUNS} "
        f"more runs ({queued} jumps queued), from the key until the frame after it; every verdict is in the book at "
        "the end. A log of "
        f"{SAMPLES} samples, zoomed {FRAMES} times. The overview of {RUNS} runs, loaded again, until its rows stand; "
        f"what to look at stands beside them after {looked_s:.1f} s.",
        (
            Budget("from a key to the next jump painted (p95)", 50.0, "ms", p95, why=_NO_BROWSER),
            Budget("a run of a million samples, zoomed", 30.0, "frames/s", frames, at_least=True, why=_NO_BROWSER),
            Budget("the overview of 10 000 runs", 1.0, "s", rows_s, why=_NO_BROWSER),
        ),
        (Table(("key to paint", "median, ms", "p95, ms", "most, ms"), (("`a`", *cells),) if cells else (), ""),),
    )


BENCHMARK = Benchmark("web", measure)
