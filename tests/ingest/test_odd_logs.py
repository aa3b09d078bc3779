"""Logs that people write oddly: read right, or refused in one sentence that says how to get in; all synthetic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from ingest.model import ColumnDeclaration, Declarations, ReadFile
from ingest.read import read_file
from tests.helpers.wording import says
from tests.ingest.reading import channel, refusal, rules
from tests.ingest.synthetic_workbooks import workbook

HEIGHTS = [0.30 + 0.05 * abs(math.sin(k / 20)) for k in range(120)]
MM = [f"{1000 * h:.2f}" for h in HEIGHTS]
TIMES = [f"{k * 0.005:.3f}" for k in range(120)]


def read(lines: Sequence[str], **declared: Any) -> ReadFile:
    return read_file(("\n".join(lines) + "\n").encode(), Declarations(**declared))


def check_heights(result: ReadFile, rate_hz: float = 200.0) -> None:
    assert not result.refused, result.findings
    assert channel(result, "body_height").values == pytest.approx(np.round(HEIGHTS, 5), abs=1e-12)
    assert result.parts[0].rate_hz == pytest.approx(rate_hz, rel=1e-5)


COMMAS = [f"{t},{h}".replace(".", ",") for t, h in zip(TIMES, MM, strict=True)]
"""A decimal comma and a comma between cells: 0,005,300,12."""


@pytest.mark.parametrize("end", ["", ","])
@pytest.mark.parametrize("title", [[], ["# string pot, 2024-03-04", ""]])
def test_a_comma_that_is_both_is_never_guessed_at(title: list[str], end: str) -> None:
    lines = [*title, f"time [s],body_height [mm]{end}", *(row + end for row in COMMAS)]
    said = refusal(read(lines))
    assert said.rule == "decimal_comma_unquoted"
    says(said.message, "semicolons")
    assert refusal(read(lines, decimal_sign=",")).rule == "decimal_comma_unquoted"
    assert refusal(read(lines, decimal_sign=",", delimiter=",")).rule == "decimal_comma_unquoted"


BY_PLACE = {"1": ColumnDeclaration("time", "ms"), "2": ColumnDeclaration("body_height", "mm")}
WHOLE = [f"{5 * k},{round(1000 * h)},12,1" for k, h in enumerate(HEIGHTS)]


@pytest.mark.parametrize("above", [[], ["String pot of Monday"], ["Rig A, Monday"]])
def test_commas_without_names_are_never_read_in_pairs(above: list[str]) -> None:
    """A height of 300 mm beside a column of 12 was 0.0121 m."""
    for header_row in (0, None):
        both = Declarations(decimal_sign=",", delimiter=",", columns=BY_PLACE, header_row=header_row)
        pairs, whole = (read_file("\n".join([*above, *rows, ""]).encode(), both) for rows in (COMMAS, WHOLE))
        assert pairs.refused
        assert channel(whole, "body_height").values == pytest.approx(np.round(HEIGHTS, 3), abs=1e-12)


def test_a_title_of_half_as_many_cells_is_no_header_of_pairs() -> None:
    lines = ["Rig A, Monday", "time [ms],body_height [mm],k_gain,state", *WHOLE]
    result = read(lines, decimal_sign=",", delimiter=",")
    assert not result.refused
    assert result.parts[0].channels[0].values == pytest.approx(np.round(HEIGHTS, 3), abs=1e-12)


def test_quoted_decimal_commas_between_commas_need_no_pairs() -> None:
    rows = [f'"{t}","{h}"'.replace(".", ",") for t, h in zip(TIMES, MM, strict=True)]
    check_heights(read(["time [s],body_height [mm]", *rows], decimal_sign=",", delimiter=","))


def with_units(delimiter: str = ";", decimal: str = ".", blank: str = " ") -> list[str]:
    return [f"{5 * k}{blank}ms{delimiter}{h.replace('.', decimal)}{blank}mm" for k, h in enumerate(MM)]


@pytest.mark.parametrize("blank", ["", " ", "\u00a0"])
@pytest.mark.parametrize(("delimiter", "decimal"), [(";", "."), (";", ","), ("\t", "."), (",", "."), ("|", ".")])
def test_numbers_with_units_behind_them_are_no_numbers(delimiter: str, decimal: str, blank: str) -> None:
    rows = with_units(delimiter, decimal, blank)
    for header in (f"time{delimiter}body_height", f"time [ms]{delimiter}body_height [mm]"):
        assert read(["# a title", header, *rows]).refused
    one = read([f"time [ms]{delimiter}body_height", *(row.replace(f"{blank}ms", "") for row in rows)])
    assert one.refused or "text_column" in rules(one)


@pytest.mark.parametrize(
    "cell",
    [lambda h: f"{1000 + h:,.2f}".replace(",", "_").replace(".", ",").replace("_", "."), lambda h: f"{1000 + h:,.2f}"],
    ids=["1.234,5", "1,234.5"],
)
@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_thousands_separators_are_the_one_thing_that_is_told(delimiter: str, cell: Any) -> None:
    for time in (lambda k: f"{5 * k}", lambda k: cell(5.0 * k)):
        rows = [f"{time(k)}{delimiter}{cell(float(h))}" for k, h in enumerate(MM)]
        result = read([f"time [ms]{delimiter}body_height [mm]", *rows])
        assert rules(result) - {"decimal_comma"} == {"thousands_separator"}
        assert result.findings[0].severity == "file"
        assert result.findings[0].line == 2


@pytest.mark.parametrize(
    "header",
    ["time [s] body_height [m]", "time (s)   body_height (m)", "  time [s]  body height [m]", "# time [s] height [m]"],
)
def test_units_apart_from_their_names_by_a_blank_belong_to_them(header: str) -> None:
    result = read([header, *(f"{t} {h:.5f}" for t, h in zip(TIMES, HEIGHTS, strict=True))])
    check_heights(result)


def test_a_name_of_two_words_beside_one_without_a_unit_is_refused() -> None:
    """`body height [m]` over a column each of four: the height was read from the third."""
    rows = [f"{t} {h:.5f} 0.7 3" for t, h in zip(TIMES, HEIGHTS, strict=True)]
    assert refusal(read(["time [s] body height [m] load", *rows])).rule == "header_mismatch"
    check_heights(read(["time [s] body_height [m] seq load [N]", *rows]))


def test_a_header_of_other_width_is_refused_with_the_keys_that_decide() -> None:
    rows = [f"{t} {h:.5f} 3" for t, h in zip(TIMES, HEIGHTS, strict=True)]
    said = refusal(read(["time height", *rows]))
    assert said.rule == "header_mismatch"
    says(said.message, "header_row", "--column 1=")


@pytest.mark.parametrize("title", ["String pot", "String pot [mm]"])
@pytest.mark.parametrize("width", [2, 3])
def test_a_title_above_the_names_of_a_workbook_is_no_header(width: int, title: str) -> None:
    names = ["time [s]", "body_height [m]", "state"][:width]
    rows = [[k * 0.005, round(h, 5), k % 3][:width] for k, h in enumerate(HEIGHTS)]
    blank = [""] * (width - 1)
    check_heights(read_file(workbook({"log": [[title, *blank], names, *rows]}), Declarations()))


def test_a_title_of_a_workbook_that_seems_a_header_is_refused_with_the_key() -> None:
    rows = [[k * 0.005, round(h, 5)] for k, h in enumerate(HEIGHTS)]
    names = ["time [s]", "body_height [m]"]
    for title in (["Rig A", "of Monday"], ["time", "and place"]):
        check_heights(read_file(workbook({"log": [title, names, *rows]}), Declarations()))
    said = read_file(workbook({"log": [["Rig A", "2024-03-04"], names, *rows]}), Declarations()).findings[0]
    assert (said.severity, said.rule) == ("file", "header_missing")
    says(said.message, "header_row = 2")


def dated() -> list[str]:
    return ["Tag;Uhr;body_height [m]", *(f"2024-03-04;12:00:{k * 0.005:06.3f};{h:.5f}" for k, h in enumerate(HEIGHTS))]


def test_columns_of_dates_and_clock_times_are_the_time_once_they_are_named() -> None:
    result = read(dated())
    said = refusal(result)
    assert said.rule == "rate_missing"
    says(said.message, '--column "NAME=time"')
    columns = {"Uhr": ColumnDeclaration("time"), "Tag": ColumnDeclaration("date")}
    read_as_said = read(dated(), columns=columns, time_zone="UTC")
    check_heights(read_as_said)
    assert read_as_said.parts[0].start_utc == "2024-03-04T12:00:00.000000Z"


def test_a_row_of_units_may_be_shorter_than_that_of_names() -> None:
    """It ended in an exception where a person named the row."""
    rows = [f"{k / 100}\t{0.4 + k % 7 / 100:.2f}\t{15 + k % 3}" for k in range(60)]
    data = "\n".join(["time\theight\tvoltage", "s\tm", *rows, ""]).encode()
    result = read_file(data, Declarations(units_row=2))
    assert [(channel.name, channel.unit) for channel in result.parts[0].channels] == [
        ("body_height", "m"),
        ("voltage", None),
    ]
