"""A small book in which everything has happened that people and instruments do."""

from __future__ import annotations

import shutil
from pathlib import Path

from ingest.tables.sheet import SheetFile
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.planning.asked import PlanRequest
from labbook.actions.planning.plan import make_plan
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct, state_charge, state_check, void
from labbook.actions.runs.jump_review import decide
from labbook.actions.runs.runs_importing import import_runs
from labbook.book.opening import Book
from tests.helpers.books import ADA, BEN, DAYS, SmallBook, ingest_all, on_server, small_book
from tests.helpers.once import made_once
from tests.helpers.statements import note

UNNAMED = "log of the morning.csv"
PACK_D = "[batteries.D]\ncells = 4\ncapacity_mah = 5000\n\n[batteries.A]"
UNREADABLE = b"%PDF-1.7 not a log at all\n"


def copy_of_whole_book(folder: Path) -> SmallBook:
    """Copy one on SQLite, made once a test run, to `folder/book`; the instruments' files are shared."""
    return _copy(made_once("whole-book", whole_book), folder)


def copy_of_judged_book(folder: Path) -> SmallBook:
    """Copy one like it before its first report."""
    return _copy(made_once("judged-book", judged_book), folder)


def whole_book(folder: Path, database_url: str | None = None) -> SmallBook:
    """Make one: planned, ingested, assigned, noted, judged, reported, corrected and reported again."""
    if database_url is not None:
        return on_server("whole-book", lambda above: _whole_book(above, database_url), folder, database_url)
    return _whole_book(folder, None)


def _whole_book(folder: Path, database_url: str | None) -> SmallBook:
    made = judged_book(folder, database_url)
    with made.open() as book:
        state_report(book, None, ADA, lambda _step: None)
    made.rewrite("exclude_first_jumps = 0", "exclude_first_jumps = 1")
    made.rewrite("[batteries.A]", PACK_D)
    with made.open() as book:
        _change_and_report_again(book)
    return made


def judged_book(folder: Path, database_url: str | None = None) -> SmallBook:
    """Make one: planned, ingested, assigned, noted and judged."""
    made = small_book(folder, runs=False, ingested=False, two_people=True, database_url=database_url)
    with made.open() as book:
        _measure_and_judge(made, book)
    return made


def _copy(made: SmallBook, folder: Path) -> SmallBook:
    shutil.copytree(made.folder, folder / "book")
    return SmallBook(folder / "book", made.instruments)


def _measure_and_judge(made: SmallBook, book: Book) -> None:
    strays = made.instruments / "strays"
    strays.mkdir()
    unnamed, unreadable = strays / UNNAMED, strays / "scan.pdf"
    made.log("r001").rename(unnamed)
    unreadable.write_bytes(UNREADABLE)
    sheet = made.instruments / "charger" / f"{DAYS[0]}.csv"
    lines = sheet.read_text().splitlines(keepends=True)
    sheet.write_text("".join(line for line in lines if not line.startswith("r006,")))  # forgotten, typed in below
    make_plan(book, 7, PlanRequest(2, 8, start="2021-06-21", out=strays / "plan.csv"), BEN)
    ingest_file(book, made.log("r002"), IngestRequest(person=ADA))  # before its run is known
    ingest_file(book, unnamed, IngestRequest(person=BEN))
    ingest_file(book, unreadable, IngestRequest(person=BEN))
    with book.session(ADA) as session:
        import_runs(book, session, SheetFile("runs.csv", (made.instruments / "runs.csv").read_bytes()))
        state_check(session, book.configuration, "rail_angle", 0.4, "deg", True, "2021-06-14")
        state_check(session, book.configuration, "lubrication", None, None, False, "2021-06-16")
    for log in ("r007", "r010", "r011", "r012", "r013"):  # the second day's, but for its first run
        made.log(log).unlink(missing_ok=True)
    ingest_all(book, made.instruments)
    with book.session(BEN) as session:
        assign(session, UNNAMED, "r001", None)
        note(session, "left rail squeaked — ÄÖÜ", "r003")
        void(session, "r006", "foot came loose")
        state_charge(session, book.configuration, "r006", 120.0, 12.0, 16.7)
    with book.session(ADA) as session:
        decide(book, session, "r002", [1], "reject", "touched_by_hand", "saw it")
        decide(book, session, "r003", [1, 2], "reject", "misfire", None)
        decide(book, session, "r003", [2], "clear", "other", None)
        decide(book, session, "r004", [3], "accept", "looks_right", None)


def _change_and_report_again(book: Book) -> None:
    with book.session(BEN) as session:
        correct(book, session, "r004", ["foot=large", "duration_s=722"], "typed wrong")
        assign(session, UNNAMED, "r002", "mixed up")
    state_report(book, "foot=small", BEN, lambda _step: None)
    with book.session(BEN) as session:
        correct(book, session, "r004", ["foot=small"], "typed right the first time")
        assign(session, UNNAMED, "r001", "not mixed up after all")
    state_report(book, "foot=small", BEN, lambda _step: None)
