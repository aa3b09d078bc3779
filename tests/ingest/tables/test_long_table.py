"""Tables as `labbook stats` reads them: whatever the separator and the decimal sign, the decimals that were written."""

from __future__ import annotations

from decimal import Decimal

import pytest
import sqlalchemy as sa
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused, UnknownName
from data_schema.where.compiling import ColumnKind, WhereColumn, compile_where
from ingest.tables.long_table import column_for_where, maybe_thousands, numbers_of, read_table
from labbook.actions.stats.data import rows_where
from tests.helpers.wording import refuses

NUMBERS = st.decimals(-(10**9), 10**9, places=4) | st.decimals(-1, 1, places=2)
SEPARATORS = st.sampled_from([",", ";", "\t", "|"])


@given(
    st.lists(NUMBERS | st.none(), min_size=1, max_size=12), SEPARATORS, st.booleans(), st.sampled_from(["\n", "\r\n"])
)
def test_numbers_are_those_that_were_written(
    values: list[Decimal | None], sep: str, comma: bool, line_end: str
) -> None:
    comma = comma and sep != ","
    cells = ["" if value is None else str(value).replace(".", "," if comma else ".") for value in values]
    text = line_end.join([f"group{sep}value", *(f"a{sep} {cell}" for cell in cells)])
    table = read_table(text, "data.csv")
    assert table.columns["group"] == ("a",) * len(values)
    assert numbers_of(table, "value", "--value", "," if comma else ".") == values


def test_quotes_hold_separators_and_lines_are_counted_as_in_the_file() -> None:
    table = read_table('name,"x, mm"\n\n"a, b",1\nc,oops\n', "data.csv")
    assert table.columns["name"] == ("a, b", "c")
    with refuses(InputRefused, "'oops'", "'x, mm'", "4", "data.csv"):
        numbers_of(table, "x, mm", "--value")
    with refuses(UnknownName, "'name'"):
        numbers_of(table, "nane", "--value")


def numbers(cells: str, declared: str | None = None) -> list[Decimal | None]:
    rows = "\n".join(f"a;{cell}" for cell in cells.split())
    return numbers_of(read_table(f"g;v\n{rows}\n", "data.csv"), "v", "--value", declared)


def test_points_are_thousands_only_where_the_comma_was_said_to_be_the_decimal_sign() -> None:
    assert numbers("1.234,5 -12.345.678 999,25 7", ",") == [
        Decimal(text) for text in ("1234.5", "-12345678", "999.25", "7")
    ]
    for cells, declared in (("1.234,5 1,5", None), ("1.234,5", "."), ("0.123 1,5", ","), ("12.34 1,5", ",")):
        with refuses(InputRefused, "'v'", "2", "data.csv"):
            numbers(cells, declared)
    with refuses(InputRefused, "--decimal"):
        numbers("1.234,5")


def test_points_that_could_be_thousands_are_named_between_semicolons_alone() -> None:
    assert maybe_thousands(["1.234", "-5.678", "", "2"], ";", None) == "1.234"
    for cells, delimiter, declared in (
        (["1.234", "5.678"], ",", None),
        (["1.234", "5.678"], ";", "."),
        (["1.234", "0.678"], ";", None),
        (["1.234", "5.67"], ";", None),
        (["1.234", "5,678"], ";", None),
        (["12", ""], ";", None),
    ):
        assert maybe_thousands(cells, delimiter, declared) is None
    assert read_table("g;v\na;1.234\n", "data.csv").delimiter == ";"
    assert read_table("sep=|\ng|v\na|1.234\n", "data.csv").delimiter == "|"


def test_a_typeset_minus_is_a_minus() -> None:
    assert numbers("\N{MINUS SIGN}1.5 2e\N{MINUS SIGN}3 -4") == [Decimal("-1.5"), Decimal("0.002"), Decimal(-4)]
    assert numbers("\N{MINUS SIGN}1,5", ",") == [Decimal("-1.5")]
    assert column_for_where(("\N{MINUS SIGN}1.5", "2", "")) == [Decimal("-1.5"), Decimal(2), None]
    assert column_for_where(("1.234,5", "2", ""), "v", ",") == [Decimal("1234.5"), Decimal(2), None]


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        ("1.5 J", "is a number and more: write 1.5 alone, and where 'J' is a unit, name the column as in 'v (J)'."),
        ("-3%", "write -3 alone, and where '%' is a unit"),
        ("2 m/s", "where 'm/s' is a unit"),
        ("1,234.5", "holds a separator of thousands: write it without, as 1234.5."),
        ("#DIV/0!", "is no number that can be used: write it as 12.5, or leave it empty where it is missing."),
        ("1e999", "is no number that can be used"),
    ],
)
def test_what_is_no_number_is_refused_with_what_to_write(cell: str, said: str) -> None:
    with pytest.raises(InputRefused) as refused:
        numbers_of(read_table(f"g;v\na;{cell}\n", "data.csv"), "v", "--value")
    assert said in str(refused.value)


ROWS = st.lists(
    st.tuples(st.sampled_from(["", "small", "large"]), st.sampled_from(["", "0", "100", "2.5"])), min_size=1, max_size=8
)
COMPARISONS = st.sampled_from(
    [
        "foot=small",
        "foot!=small",
        "foot in (small, large)",
        "gain<100",
        "gain>=2.5",
        "gain != 0",
        "gain in (0, 2.5)",
        "gain=100.0",
    ]
)
CONDITIONS = st.recursive(
    COMPARISONS,
    lambda inner: st.tuples(inner, inner, st.sampled_from(["({} and {})", "({} or {})", "not ({} and {})"])).map(
        lambda both: both[2].format(*both[:2])
    ),
    max_leaves=5,
)


@given(ROWS, CONDITIONS)
def test_conditions_choose_the_rows_that_a_database_chooses(rows: list[tuple[str, str]], condition: str) -> None:
    """The same words mean the same on a table and on a book's runs, empty cells included."""
    foot, gain = ([row[place] for row in rows] for place in (0, 1))
    if not any(gain):
        gain = ["0", *gain[1:]]
    chosen = rows_where(condition, {"foot": foot, "gain": gain})

    table = sa.Table(
        "t", sa.MetaData(), sa.Column("i", sa.Integer), sa.Column("foot", sa.Text), sa.Column("gain", sa.Double)
    )
    known = {
        "foot": WhereColumn(ColumnKind.LABEL, table.c.foot, ("small", "large")),
        "gain": WhereColumn(ColumnKind.NUMBER, table.c.gain),
    }
    engine = sa.create_engine("sqlite://")
    with engine.begin() as connection:
        table.create(connection)
        filled = [
            {"i": i, "foot": f or None, "gain": float(g) if g else None}
            for i, (f, g) in enumerate(zip(foot, gain, strict=True))
        ]
        connection.execute(table.insert(), filled)
        found = set(connection.execute(sa.select(table.c.i).where(compile_where(condition, known))).scalars())
    engine.dispose()
    assert {place for place, kept in enumerate(chosen) if kept} == found
