"""Where the values of `labbook stats` come from: a table that is named, or the book."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import sqlalchemy as sa

from data_schema.errors import InputRefused, UsageError, unknown_name
from data_schema.outcomes import Outcome
from data_schema.where.compiling import DATE, ColumnKind, WhereColumn, compile_where
from data_schema.where.parsing import names_in, parse
from ingest.channels.names import parse_header
from ingest.tables.sheet import (
    MINUS,
    Sheet,
    SheetFile,
    decimal_sign,
    is_blank,
    is_number_text,
    number_in,
    numbers_of,
    read_sheet,
)
from ingest.text.cells import CellFault
from labbook.actions.files.named_files import own_name, read_bytes
from labbook.actions.stats.asked import Values
from labbook.analysis.comparison.pairing import with_control
from labbook.analysis.observations import Observation, ObservationRequest, Observations, observations_of_book
from labbook.book.opening import opened
from stats.checks import MISSING


def rows_where(text: str, sheet: Sheet) -> list[bool]:
    """Tell which rows of a sheet fulfil a condition, decided as that on runs, by a database.

    Raises `UsageError` for a text that cannot be read and for commas that could be decimals or thousands, `UnknownName`
    for a column that is not there.
    """
    asked = {name: _column(sheet, name) for name in sorted(names_in(parse(text)) & sheet.columns.keys())}
    types = {name: sa.Double if kind is ColumnKind.NUMBER else sa.Text for name, (kind, _cells) in asked.items()}
    rows = sa.Table("rows", sa.MetaData(), *(sa.Column(f"c{at}", kind) for at, kind in enumerate(types.values())))
    known = {name: WhereColumn(asked[name][0], column) for name, column in zip(asked, rows.c, strict=True)}
    unasked = WhereColumn(ColumnKind.TEXT, sa.null())
    fulfilled = compile_where(text, {name: known.get(name, unasked) for name in sheet.columns})
    cells = zip(*(cells for _kind, cells in asked.values()), strict=True)
    with sa.create_engine("sqlite://").begin() as connection:
        rows.create(connection)
        connection.execute(rows.insert(), [dict(zip(rows.c.keys(), row, strict=True)) for row in cells])
        in_order = sa.select(fulfilled).select_from(rows).order_by(sa.literal_column("rowid"))
        return [known_to_be is True for known_to_be in connection.scalars(in_order)]


def _column(sheet: Sheet, name: str) -> tuple[ColumnKind, Sequence[str | float | None]]:
    """Return a column as it is compared: numbers or dates where all that is filled in are, else words without order."""
    cells = sheet.columns[name]
    filled = [cell for cell in cells if not is_blank(cell)]
    if filled and all(map(is_number_text, filled)):
        sign = decimal_sign(sheet, [name])
        numbers = [number_in(cell, sign) for cell in cells]
        if not any(isinstance(number, CellFault) for number in numbers):
            return ColumnKind.NUMBER, [number for number in numbers if not isinstance(number, CellFault)]
    dates = bool(filled) and all(map(DATE.fullmatch, filled))
    return ColumnKind.DATE if dates else ColumnKind.TEXT, [cell or None for cell in cells]


QUANTITIES = {outcome.key: outcome for outcome in Outcome}


def observe(given: Values, step: Callable[[str], None]) -> Observations:
    """Read the values that are asked for; raises `UsageError` for options that do not belong to their source."""
    if given.missing not in MISSING:
        raise unknown_name("way with missing values", given.missing, MISSING)
    return _of_book(given, step) if given.file is None else _of_table(given, given.file)


def _of_book(given: Values, step: Callable[[str], None]) -> Observations:
    for option, value in (("--value", given.value), ("--decimal", given.decimal), ("--day", given.day)):
        if value is not None:
            raise UsageError(
                f"{option} is about a table: name a CSV file first, or leave it out for the book's values."
            )
    if given.missing != "refuse":
        raise UsageError(
            "--missing is about a table: of a book, runs without a value are left out as in its report, and named."
        )
    quantity = given.quantity or "joules"
    if quantity not in QUANTITIES:
        raise unknown_name("quantity", quantity, QUANTITIES)
    asked = ObservationRequest(QUANTITIES[quantity], given.by, given.control, given.where)
    with opened(given.book) as book, book.reading() as connection:
        return observations_of_book(connection, book.store, book.configuration, asked, step)


def _of_table(given: Values, file: Path) -> Observations:
    for option, value in (("--quantity", given.quantity), ("--book", given.book)):
        if value is not None:
            raise UsageError(f"{option} is about a book and {own_name(file)} is a table: leave one of the two out.")
    table = read_sheet(
        SheetFile(own_name(file), read_bytes(file), decimal=given.decimal),
        "a header such as controller,energy_J and one value a row",
    )
    table.refuse()
    if given.value is None or given.by is None:
        columns = ", ".join(repr(name) for name in table.columns)
        raise UsageError(
            f"a table needs --value and --by, the columns of values and of groups: {own_name(file)} has {columns}."
        )
    value, by = given.value, given.by
    labels, days = (
        ("",) * len(table.lines) if name is None else table.cells(name, option)
        for name, option in ((by, "--by"), (given.day, "--day"))
    )
    selected = [*range(len(table.lines))]
    if given.where is not None:
        selected = [*itertools.compress(selected, rows_where(given.where, table))]
    table.cells(value, "--value")
    sign = decimal_sign(table, [value])
    numbers = dict(zip(selected, numbers_of(table, value, "--value", sign, selected), strict=True))
    named = [cells for cells, name in ((labels, by), (days, given.day)) if name is not None]
    lacking = [place for place in selected if numbers[place] is None or not all(cells[place] for cells in named)]
    if lacking and given.missing == "refuse":
        raise InputRefused(
            f"{len(lacking)} of {len(selected)} rows of {own_name(file)} lack a value or a label, the first in line "
            f"{table.lines[lacking[0]]}: fill them in, or leave them out with --missing drop."
        )
    rows = tuple(
        Observation(numbers[place], labels[place], days[place])
        for place in selected
        if all(cells[place] for cells in named)
    )
    header = parse_header(value)
    control = with_control(given.control, by, list(dict.fromkeys(row.label for row in rows)))
    return Observations(
        source=own_name(file),
        quantity=header.suffix_base or header.base if header.unit or header.suffix_unit else value,
        unit=header.unit or header.suffix_unit or "",
        by=by,
        control=control,
        rows=rows,
        notes=(*_about(lacking, selected, given, rows, control), *_page(table)),
    )


def _about(
    lacking: list[int], selected: list[int], given: Values, rows: tuple[Observation, ...], control: str
) -> list[str]:
    notes = []
    if lacking:
        named = [name for name in (given.by, given.day) if name is not None]
        notes.append(_lacking_text(len(lacking), len(selected), sum(row.value is None for row in rows), named))
    if given.control is None and rows:
        notes.append(f"The control is taken to be {control!r}, the first in order: name another with --control.")
    labels = {row.label for row in rows}
    for same, what in (
        (_alike(filter(is_number_text, labels), _number), "are one number written in several ways"),
        (_alike(labels, str.casefold), "differ only in capital letters"),
    ):
        if same:
            listed = "; ".join(" and ".join(map(repr, group)) for group in same)
            notes.append(f"Groups that {what} count as several: {listed}.")
    return notes


def _lacking_text(left_out: int, of: int, without_value: int, named: Sequence[str]) -> str:
    """Say how many rows are left out and for what, given the columns of labels; one that lacks both counts for these.

    The sentences of results count the rows without a value, for the others belong to no group.
    """
    counts = ((without_value, "a value"), (left_out - without_value, f"a label in {' or '.join(map(repr, named))}"))
    why = " and ".join(f"{count} lack{'s' if count == 1 else ''} {what}" for count, what in counts if count)
    return f"{left_out} of {of} rows {'is' if left_out == 1 else 'are'} left out: {why}."


def _page(table: Sheet) -> list[str]:
    """Return a note where the text is of a page that was not declared."""
    return (
        [] if table.encoding == "utf-8" else [f"{table.file.name} is no UTF-8 text and was read as {table.encoding}."]
    )


def _alike(labels: Iterable[str], key: Callable[[str], str | float]) -> list[list[str]]:
    """Return the labels that have a key in common: AD and ad by their letters, 0 and 0.0 by their number."""
    found: dict[str | float, list[str]] = {}
    for label in sorted(labels):
        found.setdefault(key(label), []).append(label)
    return [same for same in found.values() if len(same) > 1]


def _number(label: str) -> float:
    return float(label.replace(",", ".").replace(MINUS, "-"))
