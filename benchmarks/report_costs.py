"""What a report costs: again, of one foot, anew, and of books of many runs on many days."""

from __future__ import annotations

import datetime as dt
import shutil
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.inputs import new_book, nth_run
from benchmarks.processes import LABBOOK, ProcessRun, run_process
from benchmarks.section import Benchmark, Budget, Section, Table
from data_schema.file_cache import cache_folder
from data_schema.vocabulary import RunKind
from ingest.tables.sheet import SheetFile
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.runs.runs_importing import import_runs
from labbook.book.opening import DATABASE, opened
from labbook.demo.files import FACTORS
from labbook.demo.truth import CHAPTER_5
from labbook.demo.writers import SheetRun, charger_sheet, run_sheet
from reports.figures.registry import DRAWN

RUNS_A_DAY, AT_ONCE, _FIRST_DAY = 20, 5000, dt.date(1990, 1, 1)
IDLE_RUNS = 17
"""In a book of any size, on days spread over all of it."""


def book_of_charges(folder: Path, runs: int, levels: Sequence[dict[str, str]]) -> None:
    """Make a book of runs with a charge and no log, `RUNS_A_DAY` a day, the conditions of `levels` by turns."""
    new_book(folder)
    rng = np.random.default_rng([2, runs])
    idle = {int(number) for number in np.linspace(0, runs - 1, IDLE_RUNS)}
    with opened(folder) as book:
        for first in range(0, runs, AT_ONCE):
            numbers = range(first, min(first + AT_ONCE, runs))
            rows = [_row(number, None if number in idle else levels[number % len(levels)]) for number in numbers]
            charges = [replace(row, charge_mah=_charge_mah(row, rng.normal())) for row in rows]
            with book.session(None) as session:
                import_runs(book, session, SheetFile(f"runs-{first}.csv", run_sheet(FACTORS, rows)))
            sheet = folder.parent / f"charges-{first}.csv"
            sheet.write_bytes(charger_sheet(charges))
            ingest_file(book, sheet, IngestRequest())
            sheet.unlink()


def _row(number: int, levels: dict[str, str] | None) -> SheetRun:
    """Return a run, an idle one without `levels`."""
    if levels:
        return nth_run(number, RUNS_A_DAY, _FIRST_DAY, levels=levels)
    idle: dict[str, Any] = {"kind": RunKind.IDLE, "duration_s": 60 * (6 + number % 7 * 2), "jumps_made": 0}
    return nth_run(number, RUNS_A_DAY, _FIRST_DAY, levels={}, **idle)


def _charge_mah(row: SheetRun, scatter: float) -> int:
    return round(800 + 20 * scatter if row.kind is RunKind.JUMPS else 5 + 0.13 * row.duration_s + scatter)


@dataclass(frozen=True, slots=True)
class Reported:
    """What was reported, how long it took, and the size of its `numbers.json`."""

    what: str
    run: ProcessRun
    numbers_mb: float


def measure_demonstration(say: Callable[[str], None]) -> Section:
    """Report the demonstration with nothing cached, again, and of one foot, each a process of its own."""
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        folder = Path(name)
        say("labbook demo")
        run_process([LABBOOK, "demo", folder / "demo"])
        book = folder / "demo" / "book"
        for kind in ("predictions", DRAWN.kind):
            shutil.rmtree(cache_folder(kind), ignore_errors=True)
        first = _report(book, "no prediction and no figure cached", say)
        again = _report(book, "again: both are cached", say)
        foot = _report(book, "`--foot small`, the first time", say, "--foot", "small")
        foot_again = _report(book, "`--foot small`, again", say, "--foot", "small")
    return Section(
        "Reports of the demonstration",
        "`labbook report`, a whole process, on the demonstration's book; jumps are found already.",
        (
            Budget("the first report", 5.0, "s", first.run.wall_s),
            Budget("a second report", 1.5, "s", again.run.wall_s),
            Budget("a report of one foot", 3.0, "s", foot.run.wall_s),
        ),
        (_table((first, again, foot, foot_again)),),
    )


def measure_days(say: Callable[[str], None], runs: int, limits: tuple[float, float]) -> Section:
    """Report a book of runs of one condition for the first time; `limits` are of its time in s and its peak in MB."""
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        folder = Path(name)
        say(f"a book of {runs} runs")
        book = folder / "book"
        group = CHAPTER_5.groups[0]
        level = {"foot": group.foot, "k_gain": str(group.k_gain), "b_ad_gain": str(CHAPTER_5.ad_gains[0])}
        book_of_charges(book, runs, [level])
        first = _report(book, "the first time", say)
        again = _report(book, "again", say)
        size_mb = (book / DATABASE).stat().st_size / 1e6
    title = f"Reports of {runs} runs on {runs // RUNS_A_DAY} days"
    most_s, most_mb = limits
    budgets = [Budget("its first report", most_s, "s", first.run.wall_s)]
    budgets.append(Budget("its peak of resident memory", most_mb, "MB", first.run.peak_mb, why="not told here"))
    return Section(
        title,
        f"`labbook report`, a whole process, on a book of runs of one condition, {RUNS_A_DAY} a day, with charges and "
        f"no logs, {IDLE_RUNS} of them idle runs. The database has {size_mb:.0f} MB then.",
        tuple(budgets),
        (_table((first, again)),),
    )


def _table(reported: Sequence[Reported]) -> Table:
    return Table(
        ("`labbook report`", "wall, s", "processor, s", "peak, MB", "numbers.json, MB"),
        tuple((one.what, *one.run.cells, f"{one.numbers_mb:.1f}") for one in reported),
        "Every report computes its results; numbers.json has each with its inputs.",
    )


def _report(book: Path, what: str, say: Callable[[str], None], *options: str) -> Reported:
    say(what)
    run = run_process([LABBOOK, "report", "--book", book, *options])
    newest = max((book / "reports").glob("*/numbers.json"), key=lambda path: path.stat().st_mtime)
    return Reported(what, run, newest.stat().st_size / 1e6)


BENCHMARKS = (
    Benchmark("reports", measure_demonstration),
    Benchmark("reports-10000", lambda say: measure_days(say, 10_000, (4.0, 1000.0))),
    Benchmark("reports-100000", lambda say: measure_days(say, 100_000, (30.0, 1000.0)), long=True),
)
