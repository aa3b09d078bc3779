"""A book opened from Python, for reading alone: `labbook.open("mybook")`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self

from data_schema import journal
from data_schema.errors import UsageError, unknown_name
from data_schema.queries.runs import refuse_empty_selection, run_names
from data_schema.vocabulary import FileRole
from labbook.book.naming import run_named
from labbook.book.opening import Book, find_folder, open_book
from labbook.export.tables import Selection, table_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from labbook.analysis.measured import Measured
    from reports.page.study import Study
    from reports.results import StudyResults
    from reports.tables.table import Table


class ReadOnlyBook:
    """An open book whose facts and numbers are asked for as frames; nothing here writes to it.

    Every method reads the book as it stands then. `where` selects runs as on the command line, for example
    `"k_gain=400 and day>=2021-06-01"`; without it all runs are meant. Columns have their unit in the name; what each
    means is in `frame.attrs["columns"]`, what a missing value means in `frame.attrs["missing"]`.
    """

    def __init__(self, book: Book) -> None:
        self._opened: Book | None = book
        self._last: tuple[tuple[str | None, int, str], Measured] | None = None

    def __repr__(self) -> str:
        if self._opened is None:
            return "<closed book>"
        study = self._book.configuration.study
        with self._book.reading() as connection:
            return f"<book of {study.name!r} with {len(run_names(connection))} runs in {self._book.folder}>"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    @property
    def _book(self) -> Book:
        if self._opened is None:
            raise UsageError("the book was closed: open it again with labbook.open.")
        return self._opened

    def close(self) -> None:
        """Give the database connections back; the book answers no more."""
        if self._opened is not None:
            self._opened.close()
            self._opened = None

    def runs(self, where: str | None = None) -> pd.DataFrame:
        """Return one row a run: when and how it was made, its levels, and each outcome with its standard error."""
        return self._frame("runs", where)

    def jumps(self, where: str | None = None) -> pd.DataFrame:
        """Return one row a jump of the runs' logs, with the verdict on it and whether a report counts it."""
        return self._frame("jumps", where)

    def charges(self, where: str | None = None) -> pd.DataFrame:
        """Return one row a charge that counts for a run."""
        return self._frame("charges", where)

    def conditions(self, where: str | None = None) -> pd.DataFrame:
        """Return one row a condition, with the mean of each outcome over its runs, its interval and their scatter."""
        return self._frame("conditions", where)

    def findings(self, where: str | None = None) -> pd.DataFrame:
        """Return one row a finding of a check in a file in use."""
        return self._frame("findings", where)

    def verdicts(self, where: str | None = None) -> pd.DataFrame:
        """Return one row a verdict of a person on a jump, also one that was taken back later."""
        return self._frame("verdicts", where)

    def signals(self, where: str | None = None) -> pd.DataFrame:
        """Return one row a table of samples in use; `signal` reads one."""
        return self._frame("signals", where)

    def notes(self, where: str | None = None) -> pd.DataFrame:
        """Return one row a note that a person wrote."""
        return self._frame("notes", where)

    def planned_runs(self) -> pd.DataFrame:
        """Return one row a run of a plan, with the run that was made of it."""
        return self._frame("planned_runs", None)

    def _frame(self, name: str, where: str | None) -> pd.DataFrame:
        with self._book.reading() as connection:
            at = (where, *journal.head(connection))
            known = self._last[1] if self._last is not None and self._last[0] == at else None
            selection = Selection(connection, self._book.store, self._book.configuration, where, known=known)
            frame = table_of(selection, name).frame()
            if selection.known is not None:
                self._last = (at, selection.known)
            return frame

    def signal(self, run: str, *, role: str | None = None, file: str | None = None) -> xr.Dataset:
        """Return the samples of a run's log, or of the record that `role` ("log", "force") or `file` names.

        Time is in s from the first sample; the attribute `start_utc` is that instant. Gaps are NaN. Raises
        `UsageError` where a run has several: name the file then.
        """
        from labbook.export.signals import dataset, signals_named

        if role is not None and role not in list(FileRole):
            raise unknown_name("role of a signal", role, [FileRole.LOG, FileRole.FORCE])
        with self._book.reading() as connection:
            row = run_named(connection, run)
            found = signals_named(connection, row, None if role is None else FileRole(role), file)
            if len(found) > 1 and role is file is None:
                found = [one for one in found if one.role == FileRole.LOG] or found
            if len(found) > 1:
                names = ", ".join(repr(one.file_name) for one in found)
                raise UsageError(f"run {run} has several signals: name one of them, file={names}.")
            return dataset(connection, self._book.store, row, found[0])

    def report(self, where: str | None = None) -> BookReport:
        """Return what a report of these runs shows; nothing is stored, so that `labbook why` knows none of it."""
        from labbook.analysis.study import analyse
        from labbook.book.write_session import now_utc

        made_at = now_utc().split(".")[0] + "Z"
        with self._book.reading() as connection:
            refuse_empty_selection(connection, where)
            made = analyse(connection, self._book.store, self._book.configuration, where=where, made_at=made_at)
        return BookReport(made.results)

    def compare(self, where: str | None = None) -> BookReport:
        """Return the same with the tables of what the simulator predicts alone, and of hypotheses.

        Raises `UsageError` where there is nothing to predict.
        """
        from labbook.actions.simulate.comparing_predictions import COMPARED, compare_predictions

        compared = compare_predictions(self._book, where, lambda _what: None)
        return BookReport(compared.results, tuple(COMPARED))

    def study(self, name: str, where: str | None = None) -> Study:
        """Return a study of the thesis by its name, for example "emulator": numbers, sentences, figure, table.

        `where` selects runs of a study that is made of runs.
        """
        from labbook.config.model import StudyProtocol
        from labbook.config.studies import STUDIES
        from labbook.studies.registry import ask
        from labbook.studies.study import Asked

        if name not in STUDIES:
            raise unknown_name("study", name, STUDIES)
        return ask(name, Asked(book=self._book.folder, options=StudyProtocol(where=where))).study


@dataclass(frozen=True)
class BookReport:
    """What a report shows: `results` has all, `tables` and `figure` show them; a notebook prints the claims."""

    results: StudyResults = field(repr=False)
    names: tuple[str, ...] | None = None
    """The tables that it has; all without them."""

    @property
    def claims(self) -> tuple[str, ...]:
        """The sentences that a report opens with."""
        return tuple(claim.text for claim in self.results.claims)

    @cached_property
    def tables(self) -> Mapping[str, Table]:
        """The tables by name, those with rows alone; a notebook prints each."""
        from reports.tables.registry import tables_of

        made = {kind.name: kind.make(self.results) for kind in tables_of(self.results)}
        return {name: table for name, table in made.items() if table.rows and name in (self.names or made)}

    def frame(self, name: str) -> pd.DataFrame:
        """Return a table as a frame of unrounded values under the names that CSV has."""
        import pandas as pd

        if name not in self.tables:
            raise unknown_name("table of this report", name, self.tables)
        return pd.DataFrame.from_records(self.tables[name].records)

    @property
    def figures(self) -> tuple[str, ...]:
        """The names of the figures that can be drawn."""
        from reports.figures.registry import figures_of

        return tuple(kind.name for kind in figures_of(self.results) if kind.absent(self.results) is None)

    def figure(self, name: str = "savings", width_in: float = 7.0) -> Figure:
        """Draw a figure of the report as wide as asked, in inches."""
        from reports.figures.registry import FIGURES

        if name not in self.figures:
            raise unknown_name("figure of this report", name, self.figures)
        return FIGURES[name].draw(FIGURES[name].drawn(self.results), width_in)

    def __repr__(self) -> str:
        return "\n".join(self.claims) or "a report without a claim"

    def _repr_html_(self) -> str:
        """Return the claims, and where tables are named, these."""
        claims = "".join(f"<p>{escape(text)}</p>" for text in self.claims)
        return "".join([claims, *(self.tables[name]._repr_html_() for name in self.names or () if name in self.tables)])


def open_read_only(folder: str | Path | None = None) -> ReadOnlyBook:
    """Open the book in a folder, or the one that holds this folder, for reading alone."""
    return ReadOnlyBook(open_book(find_folder(None if folder is None else Path(folder))))
