"""`--where` against an evaluator in plain Python, on a real SQLite table."""

from __future__ import annotations

import datetime
import operator as operators
from collections.abc import Callable
from typing import Any

import pytest
import sqlalchemy as sa
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import UnknownName, UsageError
from data_schema.vocabulary import RunKind
from data_schema.where import (
    And,
    ColumnKind,
    Comparison,
    Expression,
    Membership,
    Not,
    Operator,
    Or,
    WhereColumn,
    Word,
    comparing,
    compile_where,
    parse,
)

HOSTILE = (
    "'; DROP TABLE run; --",
    '" OR 1=1 --',
    "x' UNION SELECT sql FROM sqlite_master --",
    "%(x)s :name ? $1",
    "back\\slash 'and' \"quotes\"",
    "Løkke 砂 ½",
    "",
)
FEET = ("small", "large", HOSTILE[0])

METADATA = sa.MetaData()
RUN = sa.Table(
    "run",
    METADATA,
    sa.Column("id", sa.Integer, primary_key=True),
    sa.Column("name", sa.Text),
    sa.Column("kind", sa.Text),
    sa.Column("foot", sa.Text),
    sa.Column("k_gain", sa.REAL),
    sa.Column("jumps_made", sa.Integer),
    sa.Column("day", sa.Text),
    sa.Column("started_on", sa.Date),
)
COLUMNS = {
    "run": WhereColumn(ColumnKind.TEXT, RUN.c.name),
    "kind": WhereColumn(ColumnKind.CHOICE, RUN.c.kind, tuple(RunKind)),
    "foot": WhereColumn(ColumnKind.LABEL, RUN.c.foot, FEET),
    "k_gain": WhereColumn(ColumnKind.NUMBER, RUN.c.k_gain),
    "jumps_made": WhereColumn(ColumnKind.NUMBER, RUN.c.jumps_made),
    "day": WhereColumn(ColumnKind.DATE, RUN.c.day),
    "started on": WhereColumn(ColumnKind.DATE, RUN.c.started_on),
}
FIELDS = {"run": "name", "started on": "started_on"}

dates = st.dates(datetime.date(2021, 5, 30), datetime.date(2021, 6, 3))
numbers = st.sampled_from([-1.0, 0.0, 2.5, 24.0, 25.0, 300.0, 400.0, 1e300])
texts = st.one_of(st.sampled_from(["r1", "r2", "in", "400", *HOSTILE]), st.text("rR1é砂 -%:;'\"\\", max_size=4))
VALUES: dict[str, st.SearchStrategy[str]] = {
    "run": texts,
    "kind": st.sampled_from(["jumps", "idle"]),
    "foot": st.sampled_from(FEET),
    "k_gain": numbers.map(repr),
    "jumps_made": numbers.map(repr),
    "day": dates.map(str),
    "started on": dates.map(str),
}


def optional(strategy: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.one_of(st.none(), strategy)


rows = st.fixed_dictionaries(
    {
        "name": optional(texts),
        "kind": optional(VALUES["kind"]),
        "foot": optional(VALUES["foot"]),
        "k_gain": optional(numbers),
        "jumps_made": optional(st.sampled_from([-1, 0, 24, 25])),
        "day": optional(dates.map(str)),
        "started_on": optional(dates),
    }
)


@st.composite
def leaves(draw: st.DrawFn) -> Expression:
    name = draw(st.sampled_from(sorted(COLUMNS)))
    if draw(st.booleans()):
        return Membership(Word(name), tuple(Word(v) for v in draw(st.lists(VALUES[name], min_size=1, max_size=3))))
    ordered = COLUMNS[name].kind in (ColumnKind.NUMBER, ColumnKind.DATE)
    operator = draw(st.sampled_from(list(Operator) if ordered else [Operator.EQUAL, Operator.NOT_EQUAL]))
    return Comparison(Word(name), operator, Word(draw(VALUES[name])))


def branches(inner: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
    several = st.lists(inner, min_size=2, max_size=3).map(tuple)
    return st.one_of(inner.map(Not), several.map(And), several.map(Or))


expressions = st.recursive(leaves(), branches, max_leaves=6)


def known(expression: Expression, row: dict[str, Any]) -> bool | None:
    """What is known about a row: True, False, or None where a value is missing (Kleene's logic)."""
    match expression:
        case Not(operand):
            found = known(operand, row)
            return None if found is None else not found
        case And(operands):
            results = [known(operand, row) for operand in operands]
            return False if False in results else None if None in results else True
        case Or(operands):
            results = [known(operand, row) for operand in operands]
            return True if True in results else None if None in results else False
        case Comparison(name, operator, value):
            return compared(row, name.text, operator, value.text)
        case Membership(name, values):
            return known(Or(tuple(Comparison(name, Operator.EQUAL, value) for value in (*values, values[0]))), row)


ORDERS: dict[Operator, Callable[[Any, Any], Any]] = {
    Operator.EQUAL: operators.eq,
    Operator.NOT_EQUAL: operators.ne,
    Operator.LESS: operators.lt,
    Operator.LESS_OR_EQUAL: operators.le,
    Operator.GREATER: operators.gt,
    Operator.GREATER_OR_EQUAL: operators.ge,
}


def compared(row: dict[str, Any], name: str, operator: Operator, text: str) -> bool | None:
    have = row[FIELDS.get(name, name)]
    if have is None:
        return None
    want: Any = text
    if COLUMNS[name].kind is ColumnKind.NUMBER:
        want = float(text)
    elif COLUMNS[name].kind is ColumnKind.DATE:
        want, have = str(text), str(have)
    return bool(ORDERS[operator](have, want))


def quoted(text: str, quote: str) -> str:
    return quote + text.replace("\\", "\\\\").replace("'", "\\'").replace('"', '\\"') + quote


@st.composite
def written(draw: st.DrawFn, expression: Expression) -> str:
    """Write a tree as a person might: any case, any spacing, bare or quoted words, brackets round every part."""
    space = draw(st.sampled_from([" ", "  ", "\n", "\t "]))

    def word(text: str) -> str:
        bare = text != "" and all(c.isascii() and (c.isalnum() or c in "_.+-:/") for c in text)
        if bare and text.lower() not in ("and", "or", "not", "in") and draw(st.booleans()):
            return text
        return quoted(text, draw(st.sampled_from("'\"")))

    def keyword(name: str) -> str:
        return draw(st.sampled_from([name, name.upper(), name.title()]))

    def text_of(part: Expression) -> str:
        match part:
            case Not(operand):
                return f"{keyword('not')}{space}({text_of(operand)})"
            case And(operands):
                return f"{space}{keyword('and')}{space}".join(f"({text_of(operand)})" for operand in operands)
            case Or(operands):
                return f"{space}{keyword('or')}{space}".join(f"({text_of(operand)})" for operand in operands)
            case Comparison(name, operator, value):
                spellings = {"=": ["=", "=="], "!=": ["!=", "<>"]}.get(operator, [str(operator)])
                gap = draw(st.sampled_from(["", space]))
                return word(name.text) + gap + draw(st.sampled_from(spellings)) + gap + word(value.text)
            case Membership(name, values):
                listed = f",{space}".join(word(value.text) for value in values)
                return f"{word(name.text)}{space}{keyword('in')}({listed})"

    return text_of(expression)


def matching(text: str, table_rows: list[dict[str, Any]]) -> list[int]:
    engine = sa.create_engine("sqlite://")
    with engine.begin() as connection:
        METADATA.create_all(connection)
        if table_rows:
            connection.execute(RUN.insert(), [{"id": n, **row} for n, row in enumerate(table_rows)])
        condition = compile_where(text, COLUMNS)
        found = list(connection.scalars(sa.select(RUN.c.id).where(condition).order_by(RUN.c.id)))
        assert connection.scalar(sa.select(sa.func.count()).select_from(RUN)) == len(table_rows)
    engine.dispose()
    return found


@given(st.data(), expressions, st.lists(rows, max_size=6))
def test_matches_the_same_runs_as_plain_python(
    data: st.DataObject, expression: Expression, table_rows: list[dict[str, Any]]
) -> None:
    text = data.draw(written(expression))
    assert matching(text, table_rows) == [n for n, row in enumerate(table_rows) if known(expression, row) is True]


@given(st.data(), expressions)
def test_a_persons_text_never_reaches_sql(data: st.DataObject, expression: Expression) -> None:
    statement = str(compile_where(data.draw(written(expression)), COLUMNS))
    for text in HOSTILE[:-1]:
        assert text not in statement
    assert not any(quote in statement for quote in "'\"")


@given(st.text("ab=!<>()'\"\\ ,.1andortin_é砂\x00\ud800&;", max_size=40))
def test_any_text_is_read_or_refused_in_one_sentence(text: str) -> None:
    refusal = ""
    try:
        parse(text)
    except UsageError as error:
        refusal = str(error)
    assert not refusal or ("--where" in refusal and refusal.endswith("."))


@pytest.mark.parametrize("value", ["r007", "and", "run 7", 'a "quoted\\', "400", "2021-06-01", "größer", "(r)", ""])
def test_a_condition_that_is_written_is_read_as_such(value: str) -> None:
    assert parse(comparing("run", value)) == Comparison(Word("run"), Operator.EQUAL, Word(value))


def test_a_run_without_the_value_matches_neither_the_comparison_nor_its_opposite() -> None:
    idle = {column.name: None for column in RUN.c if column.name != "id"} | {"kind": "idle", "jumps_made": 0}
    for text in ("foot=small", "foot!=small", "not foot=small", "not foot in (small)", "foot not in (small, large)"):
        assert matching(text, [idle]) == []
    assert matching("kind=idle or foot=small", [idle]) == [0]
    assert matching("not (jumps_made=25 and foot=small)", [idle]) == [0]  # false whatever the foot would be


@pytest.mark.parametrize(
    ("text", "error", "words"),
    [
        ("fot=small", UnknownName, ["character 1 ", "did you mean 'foot'?"]),
        ("k_gain=300 and foot=smal", UnknownName, ["level of foot", "character 21 ", "did you mean 'small'?"]),
        ("kind=jump", UnknownName, ["value of kind", "did you mean 'jumps'?"]),
        ("foot<small", UsageError, ["'foot' at character 1 ", "'<'", "=, != or in"]),
        ("k_gain=lots", UsageError, ["'lots' at character 8 ", "k_gain=400"]),
        ("k_gain=1_000", UsageError, ["is not a number"]),
        ("day=2021-6-1", UsageError, ["'2021-6-1' at character 5 ", "day>=2021-06-01"]),
        ("", UsageError, ["character 1 ", "the end", "kind=jumps"]),
        ("foot=", UsageError, ["the end, expected a value"]),
        ("k_gain=300 or 400", UsageError, ["after '400'", "run in (r001, r002)"]),
        ("foot in small", UsageError, ["character 9 ", "expected '('"]),
        ("(foot=small", UsageError, ["the end, expected 'and', 'or' or ')'"]),
        ("foot=small large", UsageError, ["quotes round a value of several words"]),
        ("foot=in", UsageError, ["put 'in' in quotes"]),
        ("foot=>small", UsageError, ["'=>' at character 5 ", ">="]),
        ("foot='small", UsageError, ["quote at character 6 ", "never closed"]),
        (r"run='a\n'", UsageError, [r"at character 7 ", "not an escape"]),
        ("foot=small & k_gain=300", UsageError, ["'&' at character 12 "]),
        ("run='a\x00'", UsageError, ["unprintable"]),
        ("not " * 51 + "foot=small", UsageError, ["more than 50"]),
        (" or ".join(["foot=small"] * 201), UsageError, ["more than 200", "in (r1, r2)"]),
        ("run=" + "x" * 10_000, UsageError, ["10004 characters", "shorten"]),
    ],
)
def test_refused_with_place_and_remedy(text: str, error: type[UsageError], words: list[str]) -> None:
    with pytest.raises(error) as caught:
        compile_where(text, COLUMNS)
    for word in words:
        assert word in str(caught.value)
