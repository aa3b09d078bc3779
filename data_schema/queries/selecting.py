"""Whether `--where` selects anything: what names no level, or no run, is refused with the nearest that there are."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UsageError, nearest
from data_schema.queries.runs import has_runs, values_of_runs, where_columns
from data_schema.where.compiling import DATE, WhereColumn, as_number, compile_expression
from data_schema.where.parsing import And, Comparison, Expression, Membership, Not, Or, parse
from data_schema.where.tokens import Operator, Word

_SAME = (Operator.EQUAL, Operator.NOT_EQUAL)


def refuse_empty_selection(connection: sa.Connection, where: str | None) -> None:
    """Raise `UsageError` where no run fulfils `where`; it names the nearest values that runs have."""
    if not where:
        return
    columns, expression = where_columns(connection), parse(where)
    condition = compile_known(expression, columns)
    if has_runs(connection, condition):
        return
    why = "some run fulfils each part of it, and none all"
    for one in _comparisons(expression):
        if not has_runs(connection, compile_expression(one, columns)):
            name = one.column.text
            near = _nearest(_words(one)[0].text, values_of_runs(connection, columns[name].expression))
            why = f"the nearest is {name}={near}" if near else f"no run has {name}"
            break
    raise UsageError(f"no run fulfils --where {where!r}: {why}; `labbook runs list` lists all.")


def compile_known(expression: Expression, columns: Mapping[str, WhereColumn]) -> sa.ColumnElement[bool]:
    """Build the condition; raises `UsageError`, too, for a number that is no level of its factor, as for such a word.

    A selection that was stated before still selects no run: only what is asked now is refused.
    """
    condition = compile_expression(expression, columns)
    for one in _comparisons(expression):
        levels = {number for label in columns[one.column.text].choices if (number := as_number(label)) is not None}
        for word in _words(one) if levels and (isinstance(one, Membership) or one.operator in _SAME) else ():
            if as_number(word.text) not in (None, *levels):
                raise UsageError(
                    f"{word.text!r} is not a known level of {one.column.text} (character {word.position} of --where): "
                    f"the nearest is {_nearest(word.text, levels)}."
                )
    return condition


def _comparisons(expression: Expression) -> Iterator[Comparison | Membership]:
    match expression:
        case Not(operand):
            yield from _comparisons(operand)
        case And(operands) | Or(operands):
            for operand in operands:
                yield from _comparisons(operand)
        case Comparison() | Membership():
            yield expression


def _words(one: Comparison | Membership) -> Sequence[Word]:
    return one.values if isinstance(one, Membership) else [one.value]


def _nearest(given: str, values: Collection[float | str]) -> str:
    """Return the values on both sides of a number or a date; of words the one that looks most like it, or the first."""
    number, dates = as_number(given), all(DATE.fullmatch(str(value)) for value in values)
    if number is None and not dates:
        return nearest(given, map(str, values)) or " or ".join(sorted(map(str, values))[:3])
    wanted: Any = given if dates else number
    numbers: list[Any] = sorted(values)
    if wanted in values:
        return f"{given}"
    below, above = [each for each in numbers if each < wanted], [each for each in numbers if each > wanted]
    return " or ".join(str(each) if dates else f"{each:g}" for each in (*below[-1:], *above[:1]))
