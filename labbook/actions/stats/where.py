"""`--where` on the rows of a table: the same words as on runs, decided in Kleene's logic where a cell is empty."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from decimal import Decimal
from typing import Any

from data_schema.errors import UsageError, unknown_name
from data_schema.where_parser import And, Comparison, Expression, Membership, Not, Or, parse
from data_schema.where_tokens import Operator, Word
from labbook.actions.stats.table import LongTable, column_for_where, is_number_text

Column = Sequence[str | Decimal | None]
"""One cell a row: text, or numbers where all that are filled in are numbers; None where empty."""


class WhereColumns(Mapping[str, Column]):
    """The columns of a table as `--where` compares them, each read when it is asked for."""

    def __init__(self, table: LongTable, declared: str | None = None) -> None:
        """Take a table, and its decimal sign where that was given."""
        self._table, self._declared = table, declared

    def __getitem__(self, name: str) -> Column:
        """Return a column; raises `UsageError` where its commas could be decimals or thousands."""
        return column_for_where(self._table.columns[name], name, self._declared)

    def __contains__(self, name: object) -> bool:
        """Tell whether there is such a column, without reading it."""
        return name in self._table.columns

    def __iter__(self) -> Iterator[str]:
        """Return the names in the order of the table."""
        return iter(self._table.columns)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._table.columns)


_COMPARE: Mapping[Operator, Callable[[Any, Any], bool]] = {
    Operator.EQUAL: operator.eq,
    Operator.NOT_EQUAL: operator.ne,
    Operator.LESS: operator.lt,
    Operator.LESS_OR_EQUAL: operator.le,
    Operator.GREATER: operator.gt,
    Operator.GREATER_OR_EQUAL: operator.ge,
}


def rows_where(text: str, columns: Mapping[str, Column], n_rows: int) -> list[bool]:
    """Tell which rows fulfil the condition; raises `UsageError` for a text that cannot be read, `UnknownName` for a
    column that is not there.
    """
    return [known is True for known in _decided(parse(text), columns, n_rows)]


def _decided(expression: Expression, columns: Mapping[str, Column], n: int) -> list[bool | None]:
    match expression:
        case Or(operands):
            parts = [_decided(operand, columns, n) for operand in operands]
            return [_any(row) for row in zip(*parts, strict=True)]
        case And(operands):
            parts = [_decided(operand, columns, n) for operand in operands]
            return [_not(_any([_not(part) for part in row])) for row in zip(*parts, strict=True)]
        case Not(operand):
            return [_not(part) for part in _decided(operand, columns, n)]
        case Comparison(name, comparison, word):
            cells = _column(name, columns)
            value = _value(word, name, cells)
            _refuse_letters(comparison, value, name, cells)
            return [None if cell is None else _COMPARE[comparison](cell, value) for cell in cells]
        case Membership(name, words):
            cells = _column(name, columns)
            values = [_value(word, name, cells) for word in words]
            return [None if cell is None else cell in values for cell in cells]


def _any(parts: Sequence[bool | None]) -> bool | None:
    if any(parts):
        return True
    return None if None in parts else False


def _not(part: bool | None) -> bool | None:
    return None if part is None else not part


def _column(name: Word, columns: Mapping[str, Column]) -> Column:
    if name.text not in columns:
        raise unknown_name(f"column (character {name.position} of --where)", name.text, columns)
    return columns[name.text]


def _value(word: Word, name: Word, cells: Column) -> str | Decimal:
    if not any(isinstance(cell, Decimal) for cell in cells):
        return word.text
    try:
        return Decimal(word.text)
    except ArithmeticError:
        raise UsageError(
            f"{word.text!r} at character {word.position} of --where is not a number, and column {name.text!r} holds "
            f"numbers: write one such as {name.text}=400."
        ) from None


def _refuse_letters(comparison: Operator, value: str | Decimal, name: Word, cells: Column) -> None:
    """Raise `UsageError` where a number would be compared with other numbers letter by letter, because of some text."""
    if comparison in (Operator.EQUAL, Operator.NOT_EQUAL) or isinstance(value, Decimal):
        return
    texts = [cell for cell in cells if isinstance(cell, str)]
    other = next((cell for cell in texts if not is_number_text(cell)), None)
    if other is not None and is_number_text(value) and any(map(is_number_text, texts)):
        raise UsageError(
            f"column {name.text!r} holds {other!r} among its numbers, so that {comparison} {value} at character "
            f"{name.position} of --where would compare letters: mend that cell, or choose by another column."
        )
