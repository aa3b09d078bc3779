"""A book whose analysis was decided on before its first run was ingested, and what may be said in it."""

from __future__ import annotations

import zlib
from pathlib import Path

from data_schema.queries.facts import find_uid
from data_schema.queries.runs import list_runs
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct
from labbook.analysis.preregistration.planned import Planned, planned_analysis
from labbook.analysis.study import Analysis
from tests.helpers.books import ADA, SmallBook, copy_of, ingest_all, small_book

DECIDED = '\n[analysis]\nexclusions = ["misfire"]\napex_bounds_percent = [-3, 3]\n'


def decided_book(folder: Path, analysis: str = DECIDED, *, without: str = "") -> SmallBook:
    """Return a small book of two feet, of the caller's own; nothing was decided where `analysis` is empty.

    The log `without` is not ingested, but lies beside the others as `loose.csv`.
    """

    def make(above: Path) -> SmallBook:
        made = small_book(above, ingested=False)
        made.toml.write_text(made.toml.read_text() + analysis)
        if without:
            (made.instruments / "logs" / without).rename(made.instruments / "loose.csv")
        with made.open() as book:
            ingest_all(book, made.instruments)
        return made

    return copy_of(f"decided-{zlib.crc32(analysis.encode())}-{without}", make, folder)


def planned(made: SmallBook) -> Planned:
    """What the book holds of its plan, and what departed from it."""
    with made.open() as book, book.reading() as connection:
        return planned_analysis(connection, book.configuration)


def reports(made: SmallBook, where: str | None = None) -> Analysis:
    """Make a report."""
    with made.open() as book:
        return state_report(book, where, ADA, lambda _step: None)


def corrects(made: SmallBook, target: str, *assignments: str) -> None:
    """Correct a row."""
    with made.open() as book, book.session(ADA) as session:
        correct(book, session, target, assignments, "looked odd")


def assigns(made: SmallBook, what: str, run: str, *, add: bool = False) -> None:
    """Give a file or a row of a sheet to a run."""
    with made.open() as book, book.session(ADA) as session:
        assign(session, what, run, None if add else "looked odd", add=add)


def ingests(made: SmallBook, path: Path) -> None:
    """Ingest a file."""
    with made.open() as book:
        ingest_file(book, path, IngestRequest(person=ADA))


def key_of(made: SmallBook, run: str) -> str:
    """The condition of a run."""
    with made.open() as book, book.reading() as connection:
        (found,) = (one for one in list_runs(connection) if one.name == run)
    return str(found.condition_key)


def charge_of(made: SmallBook, run: str) -> str:
    """The charge of a run, as a correction names it."""
    with made.open() as book, book.reading() as connection:
        return f"charge:{find_uid(connection, 'charge', stated_run=run)}"
