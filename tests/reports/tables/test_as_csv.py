import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.tables.formats import csv_bytes
from reports.tables.registry import TABLES
from reports.tables.table import Cell, Column, Row, Table, value_cell, words
from tests.helpers.pages import TABLE_NAMES


def read(data):
    return list(csv.DictReader(io.StringIO(data.decode("utf-8"), newline="")))


def one_row(*cells, columns=None):
    names = columns or [(f"field_{index}",) for index in range(len(cells))]
    return Table("t", "", tuple(Column("", name) for name in names), (Row(cells),))


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_keep_every_digit(value):
    assert float(read(csv_bytes(one_row(value_cell(value, 1))))[0]["field_0"]) == value


@given(st.text(st.characters(exclude_categories=["Cs", "Cc"])))
def test_text_comes_back_as_it_was(text):
    found = read(csv_bytes(one_row(words(text), words("x"))))[0]["field_0"]
    assert found.removeprefix("'") == text.replace("\u00a0", " ").removeprefix("'")


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@SUM(A1)", "\tx", "\nx"])
def test_text_that_a_spreadsheet_would_run_gets_an_apostrophe(text):
    assert read(csv_bytes(one_row(words(text))))[0]["field_0"] == f"'{text}"


def test_line_ends_of_any_kind_stay_within_a_field():
    rows = read(csv_bytes(one_row(words("a\r\nb\rc"), words("d"))))
    assert rows == [{"field_0": "a\nb\nc", "field_1": "d"}]


def test_a_number_that_does_not_exist_is_empty_and_its_reason_stands_last():
    row = read(
        csv_bytes(
            one_row(
                words("a"), value_cell(Undefined(Reason.AS_SAID, said="one run only")), columns=[("name",), ("sd_j",)]
            )
        )
    )[0]
    assert row == {"name": "a", "sd_j": "", "undefined": "sd_j: one run only"}


def test_fields_of_one_column_and_the_block():
    columns = (Column("CI", ("low", "high")),)
    table = Table("t", "", columns, (Row((Cell("1 to 2", (1, 2.0)),), block="first"),))
    assert csv_bytes(table) == b"block,low,high\nfirst,1,2.0\n"


@pytest.mark.parametrize("name", TABLE_NAMES)
def test_every_table_has_one_field_a_column_name(plated, name):
    table = TABLES[name].make(plated)
    data = csv_bytes(table)
    lines = list(csv.reader(io.StringIO(data.decode("utf-8"), newline="")))
    assert len(lines) == len(table.rows) + 1 > 1
    assert len(set(lines[0])) == len(lines[0])
    assert {len(line) for line in lines} == {len(lines[0])}
