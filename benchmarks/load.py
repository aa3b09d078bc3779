"""A book of ten thousand runs, or a hundred thousand: taking in, listing, checking, rebuilding; a hundred reports."""

from __future__ import annotations

import json
import os
import shutil
import statistics
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.inputs import run_name
from benchmarks.large_books import AT_ONCE, Grown, grow_book, log_of
from benchmarks.processes import LABBOOK, ProcessRun, run_process
from benchmarks.section import Benchmark, Budget, Section, Table
from labbook.actions.report_command import state_report
from labbook.book.opening import opened

RUNS, MANY_RUNS = 10_000, 100_000
RUNS_REPORTED, REPORTS = 200, 100
TURNS = 3
INGEST = "ingest FILE"
FOLDER = "LABBOOK_BENCH_FOLDER"
"""Names a folder that keeps the books and what was measured of them, so that hours of growing can be interrupted."""
COMMAND_S, REBUILD_S, PEAK_MB, BACKUP_MB = 1.5, 15.0, 1500.0, 300.0
FLAT = LINEAR = 1.3
"""A tenth of noise on either side, and a little for trees of indexes that grow deeper."""
TWICE = 2.0


@dataclass(frozen=True, slots=True)
class Taken:
    """What was done with a book of so many runs."""

    runs: int
    check: ProcessRun
    rebuild: ProcessRun


def measure(runs: int, say: Callable[[str], None]) -> Section:
    """Grow a book, and time what grows with it at two sizes; then rebuild a small one with one and many reports.

    Where `LABBOOK_BENCH_FOLDER` names a folder, what was measured there before is not measured again.
    """
    with _folder() as folder:
        grown, sizes = [], []
        for first, last in ((0, runs // 5), (runs // 5, runs)):
            for start in range(first, last, AT_ONCE):
                stop = min(last, start + AT_ONCE)
                grow = partial(grow_book, folder / "book", start, stop, say)
                grown.append(Grown(**_once(folder, f"grown to {stop}", grow)))
            sizes.append(Taken(last, *(_at_size(folder, last, command, say) for command in ("db check", "rebuild"))))
        commands = _commands(folder, runs, say)
        backups = [
            ProcessRun(**_once(folder, f"backup {turn} of {runs}", partial(_run, folder, "backup", folder / "backup")))
            for turn in (1, 2)
        ]
        reports = _with_reports(folder / "reported", say)
    return Section(
        f"A book of {runs:,} runs".replace(",", " "),
        f"Run sheets, {runs} logs of 25 jumps, charger sheets, verdicts and corrections through the functions of the "
        f"commands: {25 * runs} jumps. Each command is a whole process, the shortest of {TURNS}; check and rebuild "
        f"once, at a fifth of the runs and at all. A book of {RUNS_REPORTED} runs is rebuilt with one report and with "
        f"{REPORTS}.",
        (*_budgets(runs, grown, sizes, commands, reports), _backup_budget(backups[1])),
        (_sizes_table(sizes, grown), _commands_table(commands), _reports_table(reports)),
    )


@contextmanager
def _folder() -> Iterator[Path]:
    if kept := os.environ.get(FOLDER):
        Path(kept, "measured").mkdir(parents=True, exist_ok=True)
        yield Path(kept)
        return
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        Path(name, "measured").mkdir()
        yield Path(name)


def _once(folder: Path, name: str, measured: Callable[[], Grown | ProcessRun]) -> dict[str, Any]:
    """Return what was measured under this name before, or measure it and write it down."""
    file = folder / "measured" / f"{name}.json"
    if not file.exists():
        file.write_text(json.dumps(asdict(measured())), encoding="utf-8")
    found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return found


def _at_size(folder: Path, runs: int, command: str, say: Callable[[str], None]) -> ProcessRun:
    say(f"{command} of {runs} runs")
    found = _once(folder, f"{command} of {runs}", partial(_run, folder, *command.split()))
    say(f"{found['wall_s']:.1f} s")
    return ProcessRun(**found)


def _run(folder: Path, *words: str | Path) -> ProcessRun:
    return run_process([LABBOOK, *words, "--book", folder / "book"])


def _commands(folder: Path, runs: int, say: Callable[[str], None]) -> dict[str, ProcessRun]:
    """Time the commands of a day at the rig, on a run in the middle of the book."""
    say("the commands of a day")
    middle, day = run_name(runs // 2), "2001-01-05"
    logs = [folder / f"{run_name(runs + turn)}.csv" for turn in range(TURNS)]
    for turn, path in enumerate(logs):
        path.write_bytes(log_of(runs + turn))
    with opened(folder / "book") as book:
        number = state_report(book, f"day={day}", None, lambda _what: None).shown[0]
    wanted: Mapping[str, Callable[[int], tuple[str | Path, ...]]] = {
        "runs list": lambda _: ("runs", "list"),
        "runs list --where": lambda _: ("runs", "list", "--where", f"day={day}"),
        "files list": lambda _: ("files", "list"),
        "show RUN": lambda _: ("show", middle),
        "jumps list RUN": lambda _: ("jumps", "list", middle),
        "files show NAME": lambda _: ("files", "show", f"{middle}.csv"),
        "today --day": lambda _: ("today", "--day", day),
        "why ID": lambda _: ("why", number),
        "note RUN": lambda _: ("note", middle, "looked at"),
        INGEST: lambda turn: ("ingest", logs[turn], "--run", middle),
    }
    found = {}
    for what, words in wanted.items():
        shortest = partial(_shortest, folder, words)
        found[what] = ProcessRun(**_once(folder, f"{what} of {runs}", shortest))
        say(f"{what}: {found[what].wall_s:.2f} s, {found[what].cpu_s:.2f} s of processor time")
    return found


def _shortest(folder: Path, words: Callable[[int], tuple[str | Path, ...]]) -> ProcessRun:
    return min((_run(folder, *words(turn)) for turn in range(TURNS)), key=lambda run: run.wall_s)


def _with_reports(folder: Path, say: Callable[[str], None]) -> dict[int, ProcessRun]:
    """Rebuild a book with one report, then with many of the same runs."""
    say(f"{REPORTS} reports of {RUNS_REPORTED} runs")
    shutil.rmtree(folder, ignore_errors=True)
    grow_book(folder / "book", 0, RUNS_REPORTED, say)
    found = {}
    for first, last in ((0, 1), (1, REPORTS)):
        with opened(folder / "book") as book:
            for _ in range(first, last):
                state_report(book, None, None, lambda _what: None)
        found[last] = _run(folder, "rebuild")
    return found


def _budgets(
    runs: int,
    grown: list[Grown],
    sizes: list[Taken],
    commands: Mapping[str, ProcessRun],
    reports: Mapping[int, ProcessRun],
) -> tuple[Budget, ...]:
    small, large = sizes
    looked_up = {what: run.wall_s for what, run in commands.items() if what != INGEST}  # that one has its own, above
    slowest = max(looked_up, key=looked_up.__getitem__)
    first, last = _ms_a_log(grown)
    runs_taken = (*(run for size in sizes for run in (size.check, size.rebuild)), *commands.values())
    known = [run.peak_mb for run in runs_taken if run.peak_mb is not None]
    more = f" of {large.runs} runs over that of {small.runs}, a run"
    ratios = {
        "db check": large.check.wall_s / small.check.wall_s,
        "rebuild": large.rebuild.wall_s / small.rebuild.wall_s,
    }
    return (
        Budget("ingest of a log, the last tenth of the runs over the first (medians)", FLAT, "×", last / first),
        Budget(
            f"the slowest list or look-up in a book of {runs} runs (`{slowest}`, min)", COMMAND_S, "s",
            looked_up[slowest],
        ),
        *(Budget(f"{what}{more}", LINEAR, "×", ratio * small.runs / large.runs) for what, ratio in ratios.items()),
        Budget("rebuild, for each 10 000 runs", REBUILD_S, "s", large.rebuild.wall_s * RUNS / large.runs),
        Budget(
            f"rebuild with {REPORTS} reports over that with one", TWICE, "×",
            reports[REPORTS].wall_s / reports[1].wall_s,
        ),
        Budget("the most memory of all these", PEAK_MB, "MB", max(known, default=None), why="not told by this system"),
    )  # fmt: skip


def _backup_budget(second: ProcessRun) -> Budget:
    what = f"the memory of a backup that has all already ({second.wall_s:.0f} s)"
    return Budget(what, BACKUP_MB, "MB", second.peak_mb, why="not told by this system")


def _ms_a_log(grown: list[Grown]) -> tuple[float, float]:
    """Return the median time of a log in ms in the first tenth of the runs and in the last."""
    each = [part.ingest_s / part.runs * 1e3 for part in grown]
    tenth = max(1, len(each) // 10)
    return statistics.median(each[:tenth]), statistics.median(each[-tenth:])


def _sizes_table(sizes: list[Taken], grown: list[Grown]) -> Table:
    rows = []
    for size in sizes:
        check, rebuild = size.check, size.rebuild
        each = f"{rebuild.wall_s / size.runs * 1e3:.1f}"
        rows.append((f"{size.runs}", check.cells[0], rebuild.cells[0], each, check.peak_text, rebuild.peak_text))
    first, last = _ms_a_log(grown)
    return Table(
        ("runs", "db check, s", "rebuild, s", "rebuild, ms a run", "check, MB", "rebuild, MB"),
        tuple(rows),
        f"Taking in a log took {first:.1f} ms in the first tenth of the runs and {last:.1f} ms in the last. A rebuild "
        "reads the kept copies whose readings are not cached, in other processes, as many as there are cores, at most "
        "four, while one writes rows; the memory is that one's.",
    )


def _commands_table(commands: Mapping[str, ProcessRun]) -> Table:
    rows = tuple(
        (what, f"{run.wall_s:.2f}", f"{run.cpu_s:.2f}", run.peak_text, f"{run.output.count(chr(10))}")
        for what, run in commands.items()
    )
    return Table(
        ("command", "wall, s", "processor, s", "peak, MB", "lines"),
        rows,
        "Lists print all that there is; the other commands look up what they need by an index.",
    )


def _reports_table(reports: Mapping[int, ProcessRun]) -> Table:
    rows = tuple((f"{count}", run.cells[0], run.peak_text) for count, run in reports.items())
    return Table(
        ("reports", "rebuild, s", "peak, MB"),
        rows,
        "A report after which nothing was said but reports is not computed again when it is replayed.",
    )


BENCHMARKS = (
    Benchmark("load", partial(measure, RUNS)),
    Benchmark("load_large", partial(measure, MANY_RUNS), long=True),
)
