"""Turn the text of `--where` into a condition on runs that a database evaluates.

A person's text never reaches SQL: names are only looked up in the mapping of columns, values only become bound
parameters.

A run may lack what is asked about (an idle run has no foot). Whether a comparison holds for it is then unknown, and
so is `not` of it: `foot != small` and `not foot = small` are the same, and neither matches a run without a foot.
`and` and `or` combine unknowns as SQL does (Kleene's logic); only runs for which the whole is known to be true match.
"""

from __future__ import annotations

import datetime
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UsageError, unknown_name
from data_schema.where.parsing import COMPARE, And, Comparison, Expression, Membership, Not, Operator, Or, Word, parse

__all__ = ["ColumnKind", "WhereColumn", "compile_where", "parse"]


class ColumnKind(StrEnum):
    """What the values of a column are, which decides how they are read and compared."""

    NUMBER = "number"
    LABEL = "label"  # a level of a factor
    DATE = "date"
    TEXT = "text"
    CHOICE = "choice"  # a word of a closed list


@dataclass(frozen=True, slots=True)
class WhereColumn:
    """A column that may be asked about.

    `expression` is what SQL compares; NULL where a run has no such value. A date is stored as ISO text or as DATE.
    `choices` are the levels of a factor, one of which a label must be, and the words of a choice; others have none.
    """

    kind: ColumnKind
    expression: sa.ColumnElement[Any]
    choices: tuple[str, ...] = ()


_EQUALITY = (Operator.EQUAL, Operator.NOT_EQUAL)
_ORDERED = (ColumnKind.NUMBER, ColumnKind.DATE)
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
DATE = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2}")
"""How a date is written."""


def compile_where(text: str, columns: Mapping[str, WhereColumn]) -> sa.ColumnElement[bool]:
    """Build the condition that `text` states over `columns` (name: column).

    Raises `UsageError`, and `UnknownName` for a column, level or word that is not known: one sentence, with position.
    """
    return compile_expression(parse(text), columns)


def compile_expression(expression: Expression, columns: Mapping[str, WhereColumn]) -> sa.ColumnElement[bool]:
    """Build the condition that was parsed, as `compile_where` does."""
    match expression:
        case Or(operands):
            return sa.or_(*(compile_expression(operand, columns) for operand in operands))
        case And(operands):
            return sa.and_(*(compile_expression(operand, columns) for operand in operands))
        case Not(operand):
            return sa.not_(compile_expression(operand, columns))
        case Comparison(name, comparison, value):
            column = _column(name, columns)
            if comparison not in _EQUALITY and column.kind not in _ORDERED:
                raise UsageError(
                    f"{name.text!r} at character {name.position} of --where has no order, "
                    f"so {comparison.value!r} means nothing: compare it with =, != or in."
                )
            compared: sa.ColumnElement[bool] = COMPARE[comparison](column.expression, _bound(value, name.text, column))
            return compared
        case Membership(name, values):
            column = _column(name, columns)
            return column.expression.in_([_bound(value, name.text, column) for value in values])


def _column(name: Word, columns: Mapping[str, WhereColumn]) -> WhereColumn:
    try:
        return columns[name.text]
    except KeyError:
        what = f"factor or column (character {name.position} of --where)"
        raise unknown_name(what, name.text, columns) from None


@dataclass(frozen=True, slots=True)
class _Given:
    """A value as written, and the column it is compared with."""

    value: Word
    name: str
    column: WhereColumn

    def __str__(self) -> str:
        return f"{self.value.text!r} at character {self.value.position} of --where"


def _bound(value: Word, name: str, column: WhereColumn) -> sa.ColumnElement[Any]:
    return _READERS[column.kind](_Given(value, name, column))


def as_number(text: str) -> float | None:
    """Return the finite number that a text is, None where it is none."""
    number = float(text) if _NUMBER.fullmatch(text) else math.nan
    return number if math.isfinite(number) else None


def _number(given: _Given) -> sa.ColumnElement[Any]:
    number = as_number(given.value.text)
    if number is None:
        raise UsageError(
            f"{given} is not a number, and {given.name!r} is compared with numbers: write one such as {given.name}=400."
        )
    # Always a double: bound with the type of a whole-number column, PostgreSQL would round 2.5 to 2.
    return sa.literal(number, sa.Double())


def _date(given: _Given) -> sa.ColumnElement[Any]:
    try:
        if not DATE.fullmatch(given.value.text):
            raise ValueError
        date = datetime.date.fromisoformat(given.value.text)
    except ValueError:
        raise UsageError(
            f"{given} is not a date, and {given.name!r} is compared with dates: "
            f"write year-month-day, such as {given.name}>=2021-06-01."
        ) from None
    if isinstance(given.column.expression.type, sa.Date):
        return sa.literal(date, sa.Date())
    return sa.literal(date.isoformat(), sa.Text())


def _text(given: _Given) -> sa.ColumnElement[Any]:
    return sa.literal(given.value.text, sa.Text())


def _listed(given: _Given) -> sa.ColumnElement[Any]:
    if given.value.text not in given.column.choices:
        what = "level" if given.column.kind is ColumnKind.LABEL else "value"
        raise unknown_name(
            f"{what} of {given.name} (character {given.value.position} of --where)",
            given.value.text,
            given.column.choices,
        )
    return _text(given)


_READERS: dict[ColumnKind, Callable[[_Given], sa.ColumnElement[Any]]] = {
    ColumnKind.NUMBER: _number,
    ColumnKind.LABEL: _listed,
    ColumnKind.DATE: _date,
    ColumnKind.TEXT: _text,
    ColumnKind.CHOICE: _listed,
}
