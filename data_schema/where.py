"""The language of `--where`: its words, its grammar, and the condition that a database evaluates.

A person's text never reaches SQL: names are only looked up in the mapping of columns, values only become bound
parameters.

A run may lack what is asked about (an idle run has no foot). Whether a comparison holds for it is then unknown, and
so is `not` of it: `foot != small` and `not foot = small` are the same, and neither matches a run without a foot.
`and` and `or` combine unknowns as SQL does (Kleene's logic); only runs for which the whole is known to be true match.

A text is read into words and marks, and these into a tree:

    expression  = conjunction { "or" conjunction }
    conjunction = negation { "and" negation }
    negation    = "not" negation | "(" expression ")" | comparison
    comparison  = name ("=" | "==" | "!=" | "<>" | "<" | "<=" | ">" | ">=") value
                | name ["not"] "in" "(" value { "," value } ")"

`and`, `or`, `not` and `in` are read in any case. A name or value is a bare word (letters, digits and `_ . + - : /`)
or stands in single or double quotes, where a backslash takes the next quote or backslash as it is. What a value
means (number, date, level) is decided by the column that it is compared with. Every token
knows where it stands.
"""

from __future__ import annotations

import datetime
import math
import operator
import re
import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UsageError, unknown_name

LONGEST_TEXT = 10_000
"""Characters that a condition may have."""


class Operator(StrEnum):
    """How a column is compared with one value."""

    EQUAL = "="
    NOT_EQUAL = "!="
    LESS = "<"
    LESS_OR_EQUAL = "<="
    GREATER = ">"
    GREATER_OR_EQUAL = ">="


COMPARE: Mapping[Operator, Callable[[Any, Any], Any]] = {
    Operator.EQUAL: operator.eq,
    Operator.NOT_EQUAL: operator.ne,
    Operator.LESS: operator.lt,
    Operator.LESS_OR_EQUAL: operator.le,
    Operator.GREATER: operator.gt,
    Operator.GREATER_OR_EQUAL: operator.ge,
}
"""What each makes of two values, and of a column of a database and a value: a condition in SQL."""


@dataclass(frozen=True, slots=True)
class Word:
    """A name or value as written (quotes and escapes removed), and the character it starts at, from 1."""

    text: str
    position: int = field(default=0, compare=False)


_OPERATORS = {**{str(one): one for one in Operator}, "==": Operator.EQUAL, "<>": Operator.NOT_EQUAL}
"""Every spelling of a comparison."""

_KEYWORDS = frozenset({"and", "or", "not", "in"})
_TOKEN = re.compile(
    r"""(?P<quoted>"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*')|(?P<operator>[=!<>]+)|(?P<mark>[(),])|(?P<bare>[\w.+\-:/]+)""",
    re.DOTALL,
)
_ESCAPE = re.compile(r"\\(.)", re.DOTALL)
_ESCAPED = re.compile(r"""[\\"]""")


@dataclass(frozen=True, slots=True)
class _Token:
    """A piece of the text; `kind` is quoted, operator, mark, bare, keyword or end."""

    kind: str
    text: str
    position: int

    def __str__(self) -> str:
        return "the end" if self.kind == "end" else repr(self.text)


def _tokens(text: str) -> list[_Token]:
    """Cut `text` into tokens; the last one has the kind `end`.

    Raises `UsageError` with the position of the first character that cannot be read.
    """
    if len(text) > LONGEST_TEXT:
        raise UsageError(
            f"the condition of --where has {len(text)} characters, at most {LONGEST_TEXT} are read: shorten it."
        )
    found: list[_Token] = []
    place = 0
    while place < len(text):
        # A database refuses NUL and broken UTF-8 with an error of its own, far from what the person typed.
        if unicodedata.category(text[place]) in ("Cc", "Cs") and not text[place].isspace():
            raise UsageError(f"character {place + 1} of --where is not printable: take it out.")
        if text[place].isspace():
            place += 1
            continue
        match = _TOKEN.match(text, place)
        if match is None:
            raise UsageError(_unreadable(text[place], place + 1))
        found.append(_token(match))
        place = match.end()
    found.append(_Token("end", "", len(text) + 1))
    return found


def _unreadable(character: str, position: int) -> str:
    if character in "'\"":
        return f"the quote at character {position} of --where is never closed: add a second {character}."
    return (
        f"{character!r} at character {position} of --where means nothing here: write comparisons such as kind=jumps, "
        "joined by 'and', 'or', 'not', and put quotes round a value with unusual characters."
    )


def _token(match: re.Match[str]) -> _Token:
    kind, text, position = str(match.lastgroup), match.group(), match.start() + 1
    if kind == "quoted":
        inside = text[1:-1]
        for escape in _ESCAPE.finditer(inside):
            if escape.group(1) not in "\\'\"":
                raise UsageError(
                    f"{escape.group()!r} at character {position + 1 + escape.start()} of --where is not an escape: "
                    "after a backslash comes a quote or a second backslash."
                )
        text = _ESCAPE.sub(r"\1", inside)
        if any(unicodedata.category(character) in ("Cc", "Cs") for character in text):
            raise UsageError(f"the value at character {position} of --where has an unprintable character: take it out.")
    elif kind == "operator" and text not in _OPERATORS:
        raise UsageError(f"{text!r} at character {position} of --where is not a comparison: use =, !=, <, <=, > or >=.")
    elif kind == "bare" and text.lower() in _KEYWORDS:
        return _Token("keyword", text.lower(), position)
    return _Token(kind, text, position)


_MOST_COMPARISONS = 200
"""Comparisons that a condition may have; SQLite refuses expressions 1000 deep."""

_DEEPEST_NESTING = 50
"""Brackets and `not` that may stand inside each other."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """A column against one value."""

    column: Word
    operator: Operator
    value: Word


@dataclass(frozen=True, slots=True)
class Membership:
    """A column against a list of values."""

    column: Word
    values: tuple[Word, ...]


@dataclass(frozen=True, slots=True)
class Not:
    """The opposite of `operand`."""

    operand: Expression


@dataclass(frozen=True, slots=True)
class And:
    """All of `operands`, two or more."""

    operands: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Or:
    """At least one of `operands`, two or more."""

    operands: tuple[Expression, ...]


Expression = Comparison | Membership | Not | And | Or


def parse(text: str) -> Expression:
    """Read a condition such as `k_gain=400 and day>=2021-06-01`.

    Raises `UsageError` with the position of the first thing that cannot be read.
    """
    parser = _Parser(_tokens(text))
    expression = parser.expression(depth=0)
    if parser.next.kind != "end":
        raise parser.unexpected("'and', 'or' or the end", "put quotes round a value of several words")
    return expression


def comparing(name: str, value: str) -> str:
    """Return the condition that a column has a value, in quotes where this needs them."""
    token = _TOKEN.fullmatch(value)
    if token is not None and token.lastgroup == "bare" and value.lower() not in _KEYWORDS:
        return f"{name}={value}"
    escaped = _ESCAPED.sub(r"\\\g<0>", value)
    return f'{name}="{escaped}"'


def names_in(expression: Expression) -> set[str]:
    """Return the names of factors and run columns that a condition asks about."""
    match expression:
        case Or(operands) | And(operands):
            return set().union(*map(names_in, operands))
        case Not(operand):
            return names_in(operand)
        case Comparison(name) | Membership(name):
            return {name.text}


class _Parser:
    """Recursive descent over the tokens; one method a rule of the grammar."""

    def __init__(self, tokens: list[_Token]) -> None:
        self._tokens = tokens
        self._place = 0
        self._comparisons = 0

    @property
    def next(self) -> _Token:
        return self._tokens[self._place]

    def unexpected(self, expected: str, remedy: str) -> UsageError:
        return UsageError(f"character {self.next.position} of --where is {self.next}, expected {expected}: {remedy}.")

    def _take(self, kind: str, *texts: str) -> bool:
        found = self.next.kind == kind and self.next.text in texts
        self._place += found
        return found

    def expression(self, depth: int) -> Expression:
        operands = [self._conjunction(depth)]
        while self._take("keyword", "or"):
            operands.append(self._conjunction(depth))
        return operands[0] if len(operands) == 1 else Or(tuple(operands))

    def _conjunction(self, depth: int) -> Expression:
        operands = [self._negation(depth)]
        while self._take("keyword", "and"):
            operands.append(self._negation(depth))
        return operands[0] if len(operands) == 1 else And(tuple(operands))

    def _negation(self, depth: int) -> Expression:
        if depth > _DEEPEST_NESTING:
            raise UsageError(
                f"--where has more than {_DEEPEST_NESTING} brackets or 'not' inside each other at character "
                f"{self.next.position}: write it flatter."
            )
        if self._take("keyword", "not"):
            return Not(self._negation(depth + 1))
        if self._take("mark", "("):
            expression = self.expression(depth + 1)
            if not self._take("mark", ")"):
                raise self.unexpected(
                    "'and', 'or' or ')'", "close the bracket, and put quotes round a value of several words"
                )
            return expression
        return self._comparison()

    def _comparison(self) -> Expression:
        self._comparisons += 1
        if self._comparisons > _MOST_COMPARISONS:
            raise UsageError(
                f"--where has more than {_MOST_COMPARISONS} comparisons: write lists such as run in (r1, r2)."
            )
        column = self._word("the name of a factor or run column", "write a comparison such as kind=jumps")
        if self.next.kind == "operator":
            operator = _OPERATORS[self.next.text]
            self._place += 1
            return Comparison(column, operator, self._word("a value", "write one such as kind=jumps"))
        negated = self._take("keyword", "not")
        if self._take("keyword", "in"):
            membership = Membership(column, self._values())
            return Not(membership) if negated else membership
        raise self.unexpected(
            "'in'" if negated else f"a comparison after {column.text!r}",
            "write for example run=r001, and run in (r001, r002) for several values",
        )

    def _values(self) -> tuple[Word, ...]:
        remedy = "write the values in brackets with commas between, such as in (r001, r002)"
        if not self._take("mark", "("):
            raise self.unexpected("'('", remedy)
        values = [self._word("a value", remedy)]
        while self._take("mark", ","):
            values.append(self._word("a value", remedy))
        if not self._take("mark", ")"):
            raise self.unexpected("',' or ')'", remedy)
        return tuple(values)

    def _word(self, expected: str, remedy: str) -> Word:
        token = self.next
        if token.kind not in ("bare", "quoted"):
            hint = f"put {token.text!r} in quotes if it is one" if token.kind == "keyword" else remedy
            raise self.unexpected(expected, hint)
        self._place += 1
        return Word(token.text, token.position)


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
