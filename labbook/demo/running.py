"""The demonstration from its files to its report, through the same functions that any book uses."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from data_schema.errors import UsageError
from data_schema.vocabulary import PlanMethod
from ingest.tables.sheet import SheetFile
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.files.named_files import files_of
from labbook.actions.planning.runs import PlannedEntry, state_plan
from labbook.actions.report_command import write
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.day_checks import state_check
from labbook.actions.runs.runs_importing import import_runs
from labbook.book.making import make_book
from labbook.book.opening import CONFIGURATION, Book, opened
from labbook.demo.campaign import Campaign, DemoRun
from labbook.demo.files import write_campaign

RUN_SHEET = "runs.csv"


@dataclass(frozen=True, slots=True)
class DemoDone:
    """Where the demonstration lies."""

    book: str
    instruments: str
    truth: str
    page: str


def run_demo(
    folder: Path, campaign: Campaign, full: bool, step: Callable[[str], None], say: Callable[[str], None]
) -> DemoDone:
    """Write a campaign's files, make its book, and write the report."""
    clock = Stopwatch(say)
    book_folder = make_demo_book(folder, campaign, full, step, clock)
    with opened(book_folder) as book:
        written = write(book, None, book_folder / "reports" / "demo", None, step)
    clock.lap(f"analysed and wrote the report ({written.results_computed} results)")
    return DemoDone(str(book_folder), str(folder / "instruments"), str(folder / "truth.json"), written.page)


def make_demo_book(folder: Path, campaign: Campaign, full: bool, step: Callable[[str], None], clock: Stopwatch) -> Path:
    """Write a campaign's files, ingest them into a new book, correct the typing error; returns the book's folder."""
    new_folder(folder)
    write_campaign(campaign, folder, full=full, progress=lambda done, total: step(f"writing file {done} of {total}"))
    clock.lap(f"wrote the instruments' files of {len(campaign.runs)} runs to {folder / 'instruments'}")
    book_folder = make_book_of(folder, step, clock, lambda book, sheet: _state_runs(book, campaign, sheet))
    with opened(book_folder) as book:
        _correct(book, campaign)
    return book_folder


def new_folder(folder: Path) -> None:
    """Raise `UsageError` for a folder that is not empty."""
    if folder.exists() and any(folder.iterdir()):
        raise UsageError(f"{folder} is not empty: name a new folder for the demonstration.")


def make_book_of(
    folder: Path, step: Callable[[str], None], clock: Stopwatch, state_runs: Callable[[Book, Path], None] | None = None
) -> Path:
    """Make a book of the files written below `folder`, state its runs and ingest all; returns the book's folder."""
    book_folder = folder / "book"
    book_folder.mkdir()
    (folder / CONFIGURATION).rename(book_folder / CONFIGURATION)
    make_book(book_folder, None)
    with opened(book_folder) as book:
        (state_runs or _import_runs)(book, folder / "instruments" / RUN_SHEET)
        clock.lap(f"made the book {book_folder} and stated its runs")
        counts = _ingest(book, folder / "instruments", step)
        clock.lap("ingested " + ", ".join(f"{count} {status}" for status, count in sorted(counts.items())))
    return book_folder


def _import_runs(book: Book, sheet: Path) -> None:
    if not sheet.exists():
        return
    with book.session(None) as session:
        import_runs(book, session, SheetFile(str(sheet), sheet.read_bytes()))


class Stopwatch:
    """Says what was done and how long it took."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._last = time.perf_counter()

    def lap(self, what: str) -> None:
        """Say what was done since the last lap."""
        now = time.perf_counter()
        self._say(f"{what} ({now - self._last:.1f} s)")
        self._last = now


def _state_runs(book: Book, campaign: Campaign, sheet: Path) -> None:
    dates = sorted({run.date for run in campaign.runs})
    entries = [PlannedEntry(run.name, dates.index(run.date) + 1, _block(run), _planned(run)) for run in campaign.runs]
    with book.session(None) as session:
        state_plan(session, book.configuration, campaign.seed, PlanMethod.BLOCKED, entries)
        import_runs(book, session, SheetFile(str(sheet), sheet.read_bytes()))
        for date in dates:
            for kind in book.configuration.protocol.checks:
                state_check(session, book.configuration, kind, None, None, passed=True, day=date.isoformat())


def _block(run: DemoRun) -> str:
    return "" if run.condition is None else f"{run.condition.foot} {run.condition.k_gain}"


def _planned(run: DemoRun) -> dict[str, str] | None:
    return {name: str(level) for name, level in run.levels.items()} or None


def _ingest(book: Book, folder: Path, step: Callable[[str], None]) -> Counter[str]:
    files = [path for path in files_of([folder], book.folder).files if path.name != RUN_SHEET]
    counts: Counter[str] = Counter()
    for position, path in enumerate(files, start=1):
        step(f"ingesting {position} of {len(files)}")
        counts[str(ingest_file(book, path, IngestRequest()).status)] += 1
    return counts


def _correct(book: Book, campaign: Campaign) -> None:
    for correction in campaign.corrections:
        with book.session(None) as session:
            correct(book, session, correction.run, [f"{correction.field}={correction.right}"], correction.why)
