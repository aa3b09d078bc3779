"""A campaign from its files to its book and report, through the same functions that any book uses."""

from __future__ import annotations

import json
import shlex
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from itertools import chain, groupby
from pathlib import Path

from data_schema.errors import UsageError
from data_schema.queries.study import PlannedEntry
from data_schema.vocabulary import PlanMethod, RunKind
from ingest.tables.sheet import SheetFile
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.files.named_files import files_of
from labbook.actions.planning.plan import state_plan
from labbook.actions.report_command import write
from labbook.actions.runs.correcting import correct, state_check
from labbook.actions.runs.runs_importing import import_runs
from labbook.book.making import make_book
from labbook.book.opening import CONFIGURATION, Book, opened
from labbook.demo.campaign import make_campaign
from labbook.demo.files import campaign_files
from labbook.demo.writers import MARK, CampaignFiles, Record, charger_sheet, run_sheet

RUN_SHEET = "runs.csv"
Say = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class DemoDone:
    """Where the demonstration lies."""

    book: str
    instruments: str
    truth: str
    page: str


def run_demo(folder: Path, files: CampaignFiles, step: Say, say: Say) -> DemoDone:
    """Write a campaign's files, make its book, and write the report."""
    book_folder, clock = make_campaign_book(folder, files, step, say), Stopwatch(say)
    with opened(book_folder) as book:
        written = write(book, None, book_folder / "reports" / "demo", None, step)
    clock.lap("analysed and wrote the report")
    return DemoDone(str(book_folder), str(folder / "instruments"), str(folder / "truth.json"), written.page)


def make_campaign_book(folder: Path, files: CampaignFiles, step: Say, say: Say) -> Path:
    """Write a campaign's files below a new folder, and ingest them into a book; returns the book's folder."""
    new_folder(folder)
    clock, book_folder = Stopwatch(say), folder / "book"
    book_folder.mkdir(parents=True)
    write_files(folder, files, step)
    clock.lap(f"wrote the instruments' files to {folder / 'instruments'}")
    (folder / CONFIGURATION).rename(book_folder / CONFIGURATION)
    make_book(book_folder, None)
    with opened(book_folder) as book:
        _state_runs(book, files, folder / "instruments" / RUN_SHEET)
        clock.lap(f"made the book {book_folder} and stated its runs")
        counts = _ingest(book, folder / "instruments", step)
        clock.lap("ingested " + ", ".join(f"{count} {status}" for status, count in sorted(counts.items())))
        for one in files.corrections:
            with book.session(None) as session:
                correct(book, session, one.run, [f"{one.field}={one.right}"], one.why)
    return book_folder


def new_folder(folder: Path) -> None:
    """Raise `UsageError` for a folder that is not empty."""
    if folder.exists() and any(folder.iterdir()):
        raise UsageError(f"{folder} is not empty: name a new folder for the demonstration.")


def write_files(folder: Path, files: CampaignFiles, step: Say) -> None:
    """Write `labbook.toml`, the files of the instruments and `truth.json`; the same campaign gives the same bytes."""
    (folder / CONFIGURATION).write_text(files.configuration, encoding="utf-8")
    of_runs = []
    for record in chain(_sheets(files), files.records):
        step(f"writing {record.path}")
        path = folder / "instruments" / record.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(record.content)
        if record.truth is not None:
            of_runs.append(record.truth)
    truth = {**files.truth, **({"runs": of_runs} if of_runs else {})}
    (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")


def _sheets(files: CampaignFiles) -> Iterator[Record]:
    """Write the run sheet, and the charger's sheet of each day; a run on the force plate has a charger's own log."""
    if files.runs:
        yield Record(RUN_SHEET, run_sheet(files.factors, files.runs))
    for date, of_day in groupby(files.runs, key=lambda run: run.date):
        charged = charger_sheet(run for run in of_day if run.kind is not RunKind.CHARACTERISATION)
        yield Record(f"charger/{date:%Y-%m-%d}_charger_{MARK}.csv", charged)


def _state_runs(book: Book, files: CampaignFiles, sheet: Path) -> None:
    if not files.runs:
        return
    dates = sorted({run.date for run in files.runs})
    with book.session(None) as session:
        if files.planned is not None:
            seed, entries = files.planned
            planned = [PlannedEntry(*entry) for entry in entries]
            state_plan(session, book.configuration, seed, PlanMethod.BLOCKED, planned)
        import_runs(book, session, SheetFile(str(sheet), sheet.read_bytes()))
        for date in dates:
            for kind in book.configuration.protocol.checks:
                state_check(session, book.configuration, kind, None, None, passed=True, day=date.isoformat())


class Stopwatch:
    """Says what was done and how long it took."""

    def __init__(self, say: Say) -> None:
        self._say = say
        self._last = time.perf_counter()

    def lap(self, what: str) -> None:
        """Say what was done since the last lap."""
        now = time.perf_counter()
        self._say(f"{what} ({now - self._last:.1f} s)")
        self._last = now


def _ingest(book: Book, folder: Path, step: Say) -> Counter[str]:
    files = [path for path in files_of([folder], book.folder).files if path.name != RUN_SHEET]
    counts: Counter[str] = Counter()
    for position, path in enumerate(files, start=1):
        step(f"ingesting {position} of {len(files)}")
        counts[str(ingest_file(book, path, IngestRequest()).status)] += 1
    return counts


_DRAWN_BY = {
    "force-plate": ("force_plate", "demonstration"),
    "characterisation": ("sheets", "oscillation_campaign"),
    "emulator": ("emulator", "demonstration"),
    "compaction": ("sheets", "flask_campaign"),
    "field": ("sheets", "walk_campaign"),
}
"""In the order of the thesis (3.2.2, 4.2.6, 4.3, 5.2, 5.1.2, 2.2.3): a module here, and its function that draws the
files of a campaign from a seed. Of another study's runs, as of the bed's, it is the demonstration itself.
"""


def make_study(study: str, folder: Path, seed: int, step: Say, say: Say) -> str:
    """Make the book of a study's campaign; returns the command to go on with."""
    place = _DRAWN_BY.get(study)
    step("drawing the campaign")
    if place is None:
        book = run_demo(folder, campaign_files(make_campaign(seed)), step, say).book
    else:
        module, draw = place
        files = vars(import_module(f"labbook.demo.studies.{module}"))[draw](seed)
        book = str(make_campaign_book(folder, files, step, say))
    return shlex.join(["labbook", "study", study, "--book", book])
