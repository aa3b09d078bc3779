"""The demonstration as a whole: making it, ingesting it, and analysis and report of all its runs."""

from __future__ import annotations

import re
import shutil
import sqlite3
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import pyarrow.parquet as pq

from benchmarks.processes import LABBOOK, ProcessRun, run_process
from benchmarks.section import Benchmark, Budget, Section, Table
from data_schema.file_cache import cache_folder
from labbook.analysis.outcomes.detection import BODY_HEIGHT, LEG_LENGTH
from labbook.book.opening import DATABASE

REPEATS = 2
DERIVED = ("jump", "detection")
"""What an ingest finds in logs, in an order in which it can be removed."""
CACHES = ("jumps", "predictions", "figures")
_LAP = re.compile(r"(?P<what>.+) \((?P<seconds>[\d.]+) s\)")


@dataclass(frozen=True, slots=True)
class Size:
    """One size of the demonstration: how to ask for it, and the space it needs."""

    title: str
    options: tuple[str, ...]
    disk_gb: float
    logs: str


DEFAULT = Size("The demonstration", (), 1.5, "logs of about 80 seconds")
FULL = Size("The full campaign", ("--full",), 7.0, "logs of 12 minutes")


def measure(size: Size, say: Callable[[str], None]) -> Section:
    """Run `labbook demo`, then `labbook report` with nothing derived, and a second time."""
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        folder = Path(name)
        if shutil.disk_usage(folder).free < size.disk_gb * 1e9:
            why = f"not enough space for temporary files, {size.disk_gb:g} GB are needed"
            return Section(size.title, f"Not measured: {why}.", _budgets(size, None, why), ())
        say(f"labbook {' '.join(('demo', *size.options))}")
        demo = run_process([LABBOOK, "demo", *size.options, folder / "demo"])
        shutil.rmtree(folder / "demo" / "instruments")
        book = folder / "demo" / "book"
        counts = _counts(book / DATABASE)
        analysis, again = _reports(book, folder / "report", say)
        bare_s = _bare_reading(book)
    laps = [found.groupdict() for line in demo.output.splitlines() if (found := _LAP.fullmatch(line))]
    stages = tuple((_without_folder(lap["what"]), lap["seconds"]) for lap in laps)
    shows = (
        f"{demo.wall_s:.0f} s of wall time and {demo.cpu_s:.0f} s of processor time in all, at most "
        f"{demo.peak_mb or 0:.0f} MB."
    )
    return Section(
        size.title,
        f"`labbook {' '.join(('demo', *size.options, 'DIR'))}`, a whole process: {counts['run']} runs, "
        f"{counts['signal']} signals with {counts['samples'] / 1e6:.1f} million samples, {size.logs}. Then everything "
        "derived is removed (jumps from its database; cached jumps, predictions and figures) and `labbook report` run, "
        "again a whole process: it reads every log from Parquet, finds the jumps with both detectors, simulates, "
        "computes, draws and writes. What is not in it: writing the logs and ingesting them. The shortest of "
        f"{REPEATS}.",
        _budgets(size, demo if size is DEFAULT else analysis, ""),
        (Table(("stage of `labbook demo`", "s"), stages, shows), _reports_table(analysis, again, bare_s)),
    )


def _reports(book: Path, out: Path, say: Callable[[str], None]) -> tuple[ProcessRun, ProcessRun]:
    """Return the shortest report with nothing derived, and the shortest that came after one."""
    taken: tuple[list[ProcessRun], list[ProcessRun]] = ([], [])
    for turn in range(1, REPEATS + 1):
        _remove(book / DATABASE)
        for what, runs in zip(("with nothing derived", "a second time"), taken, strict=True):
            say(f"labbook report {what}, {turn} of {REPEATS}")
            runs.append(run_process([LABBOOK, "report", "--book", book, "--out", out]))
    first, second = (min(runs, key=lambda run: run.wall_s) for runs in taken)
    return first, second


def _budgets(size: Size, taken: ProcessRun | None, why: str) -> tuple[Budget, ...]:
    """Return the budgets of the demonstration's process, or of the full campaign's report; `why` nothing was taken."""
    wall_s, peak_mb = (None, None) if taken is None else (taken.wall_s, taken.peak_mb)
    if size is DEFAULT:
        return (Budget("`labbook demo DIR`, all of it", 120.0, "s", wall_s, why=why),)
    unknown = why or "this system does not tell a process's peak of memory"
    return (
        Budget("analysis and report of the full campaign", 60.0, "s", wall_s, why=why),
        Budget("its peak of resident memory", 2000.0, "MB", peak_mb, why=unknown),
    )


def _reports_table(analysis: ProcessRun, again: ProcessRun, bare_s: float) -> Table:
    derived_s = max(0.0, analysis.cpu_s - again.cpu_s)
    return Table(
        ("`labbook report`, whole process", "wall, s", "processor, s", "peak, MB"),
        (
            ("nothing derived: both detectors over all logs", *analysis.cells),
            ("a second time: jumps, predictions and figures are cached", *again.cells),
        ),
        f"Of the processor time {derived_s:.1f} s go into what a second report takes from caches: reading the logs and "
        "finding their jumps, on two threads, simulating and drawing. The rest is starting, gathering, computing every "
        f"result and writing. pyarrow alone reads the same columns of all logs in {bare_s:.1f} s.",
    )


def _bare_reading(book: Path) -> float:
    """Return how long pyarrow takes to read what a detector looks at from every log."""
    with closing(sqlite3.connect(book / DATABASE)) as connection:
        paths = [row[0] for row in connection.execute("SELECT store_path FROM signal")]
    start = time.perf_counter()
    for path in paths:
        with pq.ParquetFile(book / path) as file:
            names = [
                name for name in file.schema_arrow.names if name.split(" ")[0] in ("time", BODY_HEIGHT, LEG_LENGTH)
            ]
            file.read(columns=names)
    return time.perf_counter() - start


def _counts(database: Path) -> dict[str, int]:
    with closing(sqlite3.connect(database)) as connection:
        found = {
            table: int(connection.execute(f"SELECT count(*) FROM {table}").fetchone()[0]) for table in ("run", "signal")
        }
        found["samples"] = int(connection.execute("SELECT sum(n_samples) FROM signal").fetchone()[0])
    return found


def _remove(database: Path) -> None:
    """Remove what is derived from logs, and the caches of it."""
    with closing(sqlite3.connect(database)) as connection, connection:
        for table in DERIVED:
            connection.execute(f"DELETE FROM {table}")
    for kind in CACHES:
        shutil.rmtree(cache_folder(kind), ignore_errors=True)


def _without_folder(what: str) -> str:
    """Leave out where a stage put things: the folder is a temporary one."""
    return re.sub(r"( to)? /\S+", "", what)


BENCHMARKS = (
    Benchmark("demonstration", lambda say: measure(DEFAULT, say)),
    Benchmark("campaign", lambda say: measure(FULL, say)),
)
