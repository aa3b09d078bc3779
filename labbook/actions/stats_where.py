"""`--where` on the rows of a table: the same words as on runs, decided in Kleene's logic where a cell is empty."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from typing import Any

from data_schema.errors import UsageError, unknown_name
from data_schema.where_parser import And, Comparison, Expression, Membership, Not, Or, parse
from data_schema.where_tokens import Operator, Word

Column = Sequence[str | Decimal | None]
"""One cell a row: text, or numbers where all that are filled in are numbers; None where empty."""

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
