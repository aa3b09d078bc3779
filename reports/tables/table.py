"""A table as data: what the page and LaTeX show, and beside it the unrounded values that CSV carries."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias, TypeVar

from data_schema.notebook import table_html
from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports.display import (
    DASH,
    decimal_text,
    degrees_text,
    interval_text,
    level_text,
    p_text,
    shown_unit,
    unit_slug,
    value_text,
)
from reports.numbers import Number, SignificanceTest, Value
from reports.results import StudyResults

Raw = str | int | float | Undefined | None
"""One field of CSV: unrounded, in the stored unit."""
PROVENANCE = "provenance"
"""The field that says where a row's numbers came from."""


@dataclass(frozen=True, slots=True)
class Column:
    """A column: `title` and `unit` head it on the page, `fields` are its names in CSV and JSON.

    A column that is not `shown` is in CSV only; one of `prose` may break its lines on the page.
    """

    title: str
    fields: tuple[str, ...]
    unit: str = ""
    numeric: bool = True
    shown: bool = True
    prose: bool = False

    @property
    def head(self) -> str:
        """Return the title with its unit: "mean (J)"."""
        return f"{self.title} ({self.unit})" if self.unit else self.title


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell: its text, its CSV values in the order of the column's fields, the footnote it needs.

    The page draws `marks` beside the text from left to right, each at a share of the way up, and folds `details` below
    it, paragraph by paragraph.
    """

    text: str
    values: tuple[Raw, ...]
    note: str = ""
    provenance: bool = False
    marks: tuple[float, ...] = ()
    details: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Row:
    """A row; rows of one `block` stand together under its name. `strong` marks the rows to look at first.

    `anchor` is what the page links to it by, "" for none.
    """

    cells: tuple[Cell, ...]
    block: str = ""
    strong: bool = False
    anchor: str = ""


@dataclass(frozen=True, slots=True)
class Table:
    """A table with its caption; the name is also the file's."""

    name: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]

    def _repr_html_(self) -> str:
        """Return the shown columns as notebooks show them: caption, heads, rows."""
        head, *texts = self.texts
        return table_html(head, texts, caption=self.caption)

    @property
    def texts(self) -> list[list[str]]:
        """Return the shown columns as text, their heads first."""
        return [[column.head for column in self.heads], *([cell.text for cell in self.cells(row)] for row in self.rows)]

    @property
    def records(self) -> list[dict[str, Raw]]:
        """Return the values of each row by field."""
        names = [name for column in self.columns for name in column.fields]
        values = ([value for cell in row.cells for value in cell.values] for row in self.rows)
        return [dict(zip(names, of_row, strict=True)) for of_row in values]

    @property
    def heads(self) -> tuple[Column, ...]:
        """Return the columns that are shown."""
        return tuple(column for column in self.columns if column.shown)

    def cells(self, row: Row) -> tuple[Cell, ...]:
        """Return the cells of a row that are shown."""
        return tuple(c for c, column in zip(row.cells, self.columns, strict=True) if column.shown)

    @property
    def blocks(self) -> list[tuple[str, list[Row]]]:
        """Return the rows by block, neighbours of one block together."""
        return [(block, list(rows)) for block, rows in itertools.groupby(self.rows, key=lambda row: row.block)]

    @property
    def footnotes(self) -> dict[str, str]:
        """Return the footnotes in order of appearance: reason -> mark (a, b, ..., aa)."""
        reasons = dict.fromkeys(cell.note for row in self.rows for cell in self.cells(row) if cell.note)
        return {reason: _mark(index) for index, reason in enumerate(reasons)}

    @property
    def explained(self) -> dict[str, str]:
        """Return the footnotes by mark: why dashes are undefined, and the reservations about other cells."""
        shown = {cell.note for row in self.rows for cell in self.cells(row) if cell.text != DASH}
        return {mark: note if note in shown else f"undefined: {note}" for note, mark in self.footnotes.items()}


def _mark(index: int) -> str:
    letters, index = "", index + 1
    while index:
        index, rest = divmod(index - 1, 26)
        letters = chr(ord("a") + rest) + letters
    return letters


@dataclass(frozen=True, slots=True)
class TableKind:
    """How one table is made from a study's results; `outcome` is the only one that it shows, None for any other.

    A table `by_run` has a row for each run.
    """

    name: str
    make: Callable[[StudyResults], Table]
    outcome: Outcome | None = None
    by_run: bool = False


T = TypeVar("T")
ColumnOf: TypeAlias = tuple[Column | tuple[Column, ...], Callable[[T], Cell | tuple[Cell, ...]]]
"""A column with what makes its cell of an item, or several that belong together with what makes theirs."""
Columns: TypeAlias = Sequence[ColumnOf[T]]


def table_of(
    name: str,
    caption: str,
    items: Iterable[T],
    columns: Columns[T],
    *,
    block: Callable[[T], str] = lambda _item: "",
    strong: Callable[[T], bool] = lambda _item: False,
) -> Table:
    """Make a table with a row an item."""
    rows = tuple(Row(_flat([make(item) for _, make in columns]), block(item), strong(item)) for item in items)
    return Table(name, caption, _flat([column for column, _ in columns]), rows)


def _flat(parts: Iterable[T | tuple[T, ...]]) -> tuple[T, ...]:
    found: list[T] = []
    for part in parts:
        if isinstance(part, tuple):
            found += part
        else:
            found.append(part)
    return tuple(found)


def tables_of_outcomes(name: str, make: Callable[[StudyResults, Outcome, str], Table]) -> tuple[TableKind, ...]:
    """Make a table an outcome; `{}` in its name is the outcome's key."""

    def of(outcome: Outcome) -> TableKind:
        own = name.format(outcome.key)
        return TableKind(own, lambda results: make(results, outcome, own), outcome)

    return tuple(map(of, Outcome))


def column(
    title: str,
    names: str,
    make: Callable[[T], Cell],
    *,
    unit: str = "",
    numeric: bool = True,
    shown: bool = True,
    prose: bool = False,
) -> ColumnOf[T]:
    """Make a column of any cells, of a stored unit; the page has the unit that people read.

    `names` are those of its fields in CSV and JSON, with blanks between; programs rely on them, so that they stay where
    a title changes. `{unit}` in a name is the stored unit.
    """
    fields = tuple(names.format(unit=unit_slug(unit)).split())
    return Column(title, fields, shown_unit(unit)[0], numeric, shown, prose), make


def text(
    title: str, names: str, of: Callable[[T], str | Cell], *, prose: bool = False, shown: bool = True
) -> ColumnOf[T]:
    """Make a column of words, or of cells of them."""

    def cell(item: T) -> Cell:
        found = of(item)
        return words(found) if isinstance(found, str) else found

    return column(title, names, cell, numeric=False, prose=prose, shown=shown)


def counts(
    title: str, names: str, of: Callable[[T], int | tuple[int | None, ...] | None], *, shown: bool = True
) -> ColumnOf[T]:
    """Make a column of a count, or of the counts of both sides; None is a dash."""

    def cell(item: T) -> Cell:
        found = of(item)
        numbers = found if isinstance(found, tuple) else (found,)
        return Cell(", ".join(DASH if number is None else str(number) for number in numbers), numbers)

    return column(title, names, cell, shown=shown)


def number(
    title: str, names: str, unit: str, of: Callable[[T], Number | None], places: int | None, *, shown: bool = True
) -> ColumnOf[T]:
    """Make a column of numbers in a stored unit."""
    return column(title, names, lambda item: number_cell(of(item), places), unit=unit, shown=shown)


def interval(
    numbers: Iterable[Number | None],
    unit: str,
    of: Callable[[T], Number | None],
    places: int | None,
    *,
    names: str = "ci_low_{unit} ci_high_{unit} ci_level",
    shown: bool = True,
) -> ColumnOf[T]:
    """Make a column of intervals in a stored unit, headed by the levels of all `numbers`: "95 % CI"."""
    levels = dict.fromkeys(level_text(one) for one in numbers if one is not None)
    title = " or ".join(levels) or "CI"
    return column(title, names, lambda item: interval_cell(of(item), places), unit=unit, shown=shown)


PLAIN_INTERVAL = "ci_low ci_high ci_level"
"""The fields of an interval whose unit stands beside it."""


def statistic(
    title: str, name: str, of: Callable[[T], SignificanceTest], degrees: int = 1, *, shown: bool = True
) -> ColumnOf[T]:
    """Make the columns of a test: the statistic with its degrees of freedom (t has one, F two), and p."""
    df = "df" if degrees == 1 else "df_1 df_2"
    fields = tuple(f"{name}_{each}" for each in ("statistic", *df.split()))

    def cells(item: T) -> tuple[Cell, Cell]:
        test = of(item)
        values = (test.statistic, *(*test.df, *(None,) * degrees)[:degrees])
        if isinstance(test.statistic, Undefined):
            return Cell(DASH, values, note=test.statistic.reason), p_cell(test.p)
        return Cell(f"{decimal_text(test.statistic, 2)} ({degrees_text(test.df)})", values), p_cell(test.p)

    return (Column(f"{title} (df)", fields, shown=shown), Column("p", (f"{name}_p",), shown=shown)), cells


def ids(of: Callable[[T], str], title: str = "id", name: str = PROVENANCE, *, shown: bool = True) -> ColumnOf[T]:
    """Make the column that says where a row's numbers came from; the page links it to the table of provenance."""

    def cell(item: T) -> Cell:
        identity = of(item)
        return Cell(identity or DASH, (identity,), provenance=bool(identity))

    return column(title, name, cell, numeric=False, shown=shown)


@lru_cache(maxsize=1024)  # of many runs on few days
def words(text: str) -> Cell:
    """Make a cell of plain text."""
    return Cell(text, (text,))


def value_cell(value: Value | None, places: int | None = None, factor: float = 1.0) -> Cell:
    """Make a cell of a bare value, shown times `factor`; `Undefined` is a dash with a footnote."""
    if isinstance(value, Undefined):
        return Cell(DASH, (value,), note=value.reason)
    return Cell(value_text(None if value is None else value * factor, places), (value,))


def number_cell(number: Number | None, places: int | None = None) -> Cell:
    """Make a cell of a number's value in the unit it is shown in."""
    return value_cell(None) if number is None else value_cell(number.value, places, shown_unit(number.unit)[1])


def interval_cell(number: Number | None, places: int | None = None) -> Cell:
    """Make a cell of a number's interval, "15.36 to 17.26"; CSV has both ends and the level."""
    if number is None:
        return Cell(DASH, (None, None, None))
    ends = (number.ci_low, number.ci_high, number.ci_level)
    note = next((end.reason for end in ends if isinstance(end, Undefined)), "")
    return Cell(DASH if note else interval_text(number, places, unit=False) or DASH, ends, note)


def p_cell(p: Value | None) -> Cell:
    """Make a cell of a p-value."""
    return Cell(p_text(p, name=False), (p,)) if isinstance(p, float) else value_cell(p)
