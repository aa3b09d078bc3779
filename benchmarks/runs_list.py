"""Ten thousand runs, queried and set in columns."""

from __future__ import annotations

import sqlite3
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from benchmarks.inputs import new_book, nth_run
from benchmarks.processes import run_process
from benchmarks.section import Benchmark, Budget, Section, times_table
from benchmarks.timing import Work, in_turns
from data_schema.queries.runs import shown_runs
from ingest.tables.sheet import SheetFile
from labbook.actions.runs.runs_importing import import_runs
from labbook.book.opening import DATABASE, Book, opened
from labbook.cli.main import GARBAGE_AFTER
from labbook.cli.runs import run_lines
from labbook.demo.files import FACTORS
from labbook.demo.writers import run_sheet

RUNS, RUNS_A_DAY = 10_000, 12
REPEATS, FIRST_REPEATS = 25, 7
LIST_MS = 100.0
_SQL = """
SELECT run.*, day.date_local, robot.name, battery.name, condition.key FROM run
JOIN day ON run.day = day.id JOIN robot ON run.robot = robot.id JOIN battery ON run.battery = battery.id
LEFT JOIN condition ON run.condition = condition.id ORDER BY day.date_local, run.position_in_day, run.id
"""


_FIRST = """
import gc, sys, time
from pathlib import Path
from data_schema.queries.runs import shown_runs
from labbook.book.opening import opened
from labbook.cli.runs import run_lines
gc.set_threshold({garbage_after})
with opened(Path(sys.argv[1])) as book:
    start = time.perf_counter()
    with book.reading() as connection:
        rows = shown_runs(connection)
    run_lines(rows)
    print(time.perf_counter() - start)
"""


def measure(say: Callable[[str], None]) -> Section:
    """State the runs from a sheet, then list them many times."""
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name, opened(new_book(Path(name) / "book")) as book:
        say(f"stating {RUNS} runs from a sheet")
        start = time.perf_counter()
        sheet = run_sheet(FACTORS, [nth_run(number, RUNS_A_DAY) for number in range(RUNS)])
        with book.session(None) as session:
            import_runs(book, session, SheetFile("runs.csv", sheet))
        stating_s = time.perf_counter() - start
        say(f"{REPEATS} rounds of listing them")
        with closing(sqlite3.connect(book.folder / DATABASE)) as bare:
            works = {
                "sqlite3: the rows alone": Work(lambda _: bare.execute(_SQL).fetchall()),
                "labbook: query and columns": Work(lambda _: _listed(book)),
            }
            times = in_turns(works, REPEATS, warm_ups=3)
        say(f"the first list of {FIRST_REPEATS} processes")
        command: list[str | Path] = [sys.executable, "-c", _FIRST.format(garbage_after=GARBAGE_AFTER), book.folder]
        first_s = min(float(run_process(command).output) for _ in range(FIRST_REPEATS))
    ours = times["labbook: query and columns"]
    alone = times["sqlite3: the rows alone"].minimum
    return Section(
        "A list of 10 000 runs",
        "10 000 runs with their days, packs, robots and conditions, listed as `labbook runs list` does: one query, "
        "typed rows, cells, columns. The peer is Python's `sqlite3` fetching the same joined rows as bare tuples.",
        (Budget("10 000 runs queried and formatted (min)", LIST_MS, "ms", ours.minimum * 1e3),),
        (
            times_table(
                times,
                "sqlite3: the rows alone",
                f"The database itself takes {100 * alone / ours.minimum:.0f} % of it; the rest is making typed "
                "rows and text. Rounds in which Python's garbage collector passes over everything new take longer, "
                "which the median shows. The first list of a process also compiles its query: "
                f"{first_s * 1e3:.0f} ms (least of {FIRST_REPEATS} processes). Stating the runs "
                f"took {stating_s:.0f} s ({stating_s / RUNS * 1e3:.1f} ms a run: each is a journal entry of its own).",
            ),
        ),
    )


def _listed(book: Book) -> list[str]:
    with book.reading() as connection:
        rows = shown_runs(connection)
    return run_lines(rows)


BENCHMARK = Benchmark("runs_list", measure)
