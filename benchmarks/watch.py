"""`labbook watch`: the time from a file's end to its line, and what looking through folders takes."""

from __future__ import annotations

import json
import queue
import statistics
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.inputs import SEED, campaign, new_book
from benchmarks.processes import LABBOOK
from benchmarks.section import Benchmark, Budget, Section, Table
from data_schema.vocabulary import RunKind
from ingest.tables.sheet import SheetFile
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.files.watching import LOOK_EVERY_S, STILL_S, Folders, look
from labbook.actions.runs.runs_importing import import_runs
from labbook.book.opening import opened
from labbook.demo.files import FACTORS
from labbook.demo.logger import DECIMALS, run_log
from labbook.demo.writers import charger_sheet, run_sheet, string_pot_log

FILES = 100
LIMIT_S = 0.5
IDLE_S = 10.0
MANY = (10, 1000, 10_000)
LOOKS = 20
NOT_WITHIN_S = 60.0
"""A file of which nothing is said for so long is given up."""


def measure(say: Callable[[str], None]) -> Section:
    """Write logs one after the other into a folder that is watched, and wait for the line of each."""
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        folder = Path(name)
        runs = campaign().of_kind(RunKind.JUMPS)[:FILES]
        (folder / "charges.csv").write_bytes(charger_sheet(campaign().runs))
        with opened(new_book(folder / "book")) as book:
            with book.session(None) as session:
                import_runs(book, session, SheetFile("runs.csv", run_sheet(FACTORS, campaign().runs)))
            ingest_file(book, folder / "charges.csv", IngestRequest())
        say(f"{FILES} logs of 25 jumps")
        logs = {}
        for run in runs:
            log = run_log(SEED, campaign().truth, run)
            logs[f"{run.name}.csv"] = string_pot_log(log.time_ms, log.channels, DECIMALS)
        lines_s, cpu_s, idle = _watched(folder, logs, say)
        looks = [_look(folder, files, say) for files in MANY]
    p99_s = float(np.percentile(lines_s, 99))
    megabytes = statistics.mean(map(len, logs.values())) / 1e6
    return Section(
        "From the end of a file to its line",
        "`labbook watch FOLDER --json` as a process of its own on a book that has runs and charges of the whole "
        f"demonstration, and {FILES} logs ({megabytes:.1f} MB on average) that are written into the folder one after "
        "the other, each in one piece: from the end of writing to the line that says how its run does, which is "
        f"printed when the book has the file on the disk. Of that, {STILL_S:g} s are waited to see whether more comes.",
        (Budget(f"from the end of a file to its line (99th percentile of {FILES} files)", LIMIT_S, "s", p99_s),),
        (
            Table(
                ("", "s"),
                (
                    ("first file", f"{lines_s[0]:.3f}"),
                    *((what, f"{np.percentile(lines_s, share):.3f}") for what, share in _SHARES.items()),
                ),
                f"A file takes {cpu_s * 1e3:.0f} ms of processor time; where the longest took much more than the "
                f"median, other programs had the cores or the disk. A watch of {FILES} files in which nothing happens "
                f"takes {idle * 100:.1f} % of a core.",
            ),
            Table(
                ("files in the folder", "one look, ms", "of a core, %"),
                tuple(looks),
                "A look asks the system for size and time of every file. The next one follows after "
                f"{LOOK_EVERY_S:g} s, or four times as long as the last one took.",
            ),
        ),
    )


_SHARES = {"median": 50, "99th percentile": 99, "longest": 100}


def _watched(folder: Path, logs: dict[str, bytes], say: Callable[[str], None]) -> tuple[list[float], float, float]:
    """Return the times from the end of each file to its line and the mean processor time of a file, in s, and the share
    of a core that waiting takes.
    """
    inbox = folder / "inbox"
    inbox.mkdir()
    command: list[str | Path] = [LABBOOK, "watch", inbox, "--json", "--book", folder / "book"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        told: queue.Queue[tuple[float, Any]] = queue.Queue()
        out = process.stdout
        assert out is not None

        def listen() -> None:
            for line in out:
                told.put((time.perf_counter(), json.loads(line)))

        listener = threading.Thread(target=listen)
        listener.start()
        told.get(timeout=NOT_WITHIN_S)
        lines_s, began_s = [], _cpu_s(process.pid)
        for name, content in logs.items():
            (inbox / name).write_bytes(content)
            ended_s = time.perf_counter()
            said_s, happened = told.get(timeout=NOT_WITHIN_S)
            if happened.get("file") != name or happened["status"] != "imported" or not happened["rig"]:
                raise RuntimeError(f"{name}: {happened}")
            lines_s.append(said_s - ended_s)
        cpu_s = (_cpu_s(process.pid) - began_s) / len(logs)
        say(f"nothing happens for {IDLE_S:g} s")
        before = _cpu_s(process.pid)
        time.sleep(IDLE_S)
        idle = (_cpu_s(process.pid) - before) / IDLE_S
        process.terminate()
        listener.join()
    return lines_s, cpu_s, idle


def _cpu_s(pid: int) -> float:
    """Return the processor time of a process so far, s."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / 100.0


def _look(folder: Path, files: int, say: Callable[[str], None]) -> tuple[str, ...]:
    """Time looks at a folder of so many files."""
    say(f"looks at {files} files")
    there = folder / f"{files} files"
    there.mkdir()
    for number in range(files):
        (there / f"{number}.csv").write_bytes(b"1\n")
    watched = Folders(folder / "book", (there,))
    files_seen = {path: one.as_taken() for path, one in look({}, watched.look({})[0], 0.0).items()}
    taken_s = []
    for _ in range(LOOKS):
        began_s = time.perf_counter()
        look(files_seen, watched.look(files_seen)[0], 1.0)
        taken_s.append(time.perf_counter() - began_s)
    least_s = min(taken_s)
    share = least_s / (least_s + max(LOOK_EVERY_S, 4 * least_s))
    return (f"{files}", f"{least_s * 1e3:.2f}", f"{share * 100:.1f}")


BENCHMARK = Benchmark("watch", measure)
