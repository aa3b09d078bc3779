"""Logs that people write oddly: read right, or refused in one sentence that says how to get in; all synthetic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from ingest.model import ColumnDeclaration, Declarations, Finding, ReadFile
from ingest.read import read_file
from tests.helpers.wording import says
from tests.ingest.synthetic_workbooks import workbook

HEIGHTS = [0.30 + 0.05 * abs(math.sin(k / 20)) for k in range(120)]
MM = [f"{1000 * h:.2f}" for h in HEIGHTS]
TIMES = [f"{k * 0.005:.3f}" for k in range(120)]


def read(lines: Sequence[str], **declared: Any) -> ReadFile:
    return read_file(("\n".join(lines) + "\n").encode(), Declarations(**declared))


def refusal(result: ReadFile) -> Finding:
    """The only thing that refuses the file, which is told first."""
    first, *others = result.findings
    assert result.refused
    assert (first.severity, [each for each in others if each.severity == "file"]) == ("file", [])
    return first


def check_heights(result: ReadFile, rate_hz: float = 200.0) -> None:
    assert not result.refused, result.findings
    (part,) = result.parts
    (height,) = [channel for channel in part.channels if channel.name == "body_height"]
    assert height.values == pytest.approx(np.round(HEIGHTS, 5), abs=1e-12)
    assert part.rate_hz == pytest.approx(rate_hz, rel=1e-5)


@pytest.mark.parametrize("declared", [{}, {"decimal_sign": ","}, {"decimal_sign": ",", "delimiter": ","}])
@pytest.mark.parametrize("header", [["time [s],body_height [mm]"], []])
def test_a_comma_that_is_both_is_refused(header: list[str], declared: dict[str, str]) -> None:
    """0,005,300,12 is 0.005 and 300.12, or four whole numbers."""
    rows = [f"{t},{h}".replace(".", ",") for t, h in zip(TIMES, MM, strict=True)]
    columns = {"1": ColumnDeclaration("time", "ms"), "2": ColumnDeclaration("body_height", "mm")}
    said = refusal(read([*header, *rows], **declared, columns={} if header else columns))
    assert said.rule in ("decimal_comma_unquoted", "header_mismatch", "no_data_rows")


def test_quoted_decimal_commas_between_commas_are_read() -> None:
    rows = [f'"{t}","{h}"'.replace(".", ",") for t, h in zip(TIMES, MM, strict=True)]
    rows = [row.replace('","', '"|"').replace(".", ",").replace('"|"', '","') for row in rows]
    check_heights(read(["time [s],body_height [mm]", *rows]))


@pytest.mark.parametrize("delimiter", ";\t, ")
def test_units_in_cells_are_read_as_no_number(delimiter: str) -> None:
    rows = [f"{t} s{delimiter}{h} mm" for t, h in zip(TIMES, MM, strict=True)]
    assert read([f"time{delimiter}body_height", *rows]).refused


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
        assert {finding.rule for finding in result.findings} - {"decimal_comma"} == {"thousands_separator"}
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


def test_that_header_again_inside_the_rows_is_skipped() -> None:
    rows = [f"{t} {h:.5f}" for t, h in zip(TIMES, HEIGHTS, strict=True)]
    header = "time [s] body_height [m]"
    result = read([header, *rows[:60], header, *rows[60:]])
    check_heights(result)
    assert "header_repeated" in {finding.rule for finding in result.findings}


def test_a_header_of_other_width_is_refused_with_the_keys_that_decide() -> None:
    rows = [f"{t} {h:.5f} 3" for t, h in zip(TIMES, HEIGHTS, strict=True)]
    said = refusal(read(["time height", *rows]))
    assert said.rule == "header_mismatch"
    assert "header_row" in said.message
    assert "--column 1=" in said.message


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
    assert "header_row = 2" in said.message


def dated() -> list[str]:
    return ["Tag;Uhr;body_height [m]", *(f"2024-03-04;12:00:{k * 0.005:06.3f};{h:.5f}" for k, h in enumerate(HEIGHTS))]


def test_a_missing_rate_names_the_columns_of_dates_and_clock_times_that_are_there() -> None:
    result = read(dated())
    said = refusal(result)
    assert said.rule == "rate_missing"
    assert '--column "Uhr=time"' in said.message
    assert '--column "Tag=date"' in said.message
    columns = {"Uhr": ColumnDeclaration("time"), "Tag": ColumnDeclaration("date")}
    read_as_said = read(dated(), columns=columns, time_zone="UTC")
    check_heights(read_as_said)
    assert read_as_said.parts[0].start_utc == "2024-03-04T12:00:00.000000Z"


@pytest.mark.parametrize(("name", "flag"), [("Uhr $", "2"), ("Tag", "Tag#2")])
def test_columns_of_clock_times_are_called_as_flags_call_them(name: str, flag: str) -> None:
    header, *lines = dated()
    says(refusal(read([header.replace("Uhr", name), *lines])).message, f"{flag}=time")


@pytest.mark.parametrize(
    ("header", "flags", "works"),
    [
        ("tick;height [m]", {"tick": ColumnDeclaration("time", "s")}, {"tick": ColumnDeclaration("time", "ms")}),
        ("timestamp [s];height [m]", {}, {"timestamp": ColumnDeclaration(None, "ms")}),
    ],
)
def test_an_implausible_rate_names_the_column_and_a_flag_that_works(
    header: str, flags: dict[str, ColumnDeclaration], works: dict[str, ColumnDeclaration]
) -> None:
    lines = [header, *(f"{5 * k};{h:.5f}" for k, h in enumerate(HEIGHTS))]
    name = header.partition(";")[0].partition(" ")[0]
    said = refusal(read(lines, columns=flags))
    assert said.rule == "rate_implausible"
    assert f"--unit {name}=UNIT" in said.message
    assert ("--override-units" in said.message) is ("[s]" in header)
    check_heights(read(lines, columns=works, override_units="[s]" in header or None))


def test_a_row_of_units_may_be_shorter_than_that_of_names() -> None:
    """It ended in an exception where a person named the row."""
    rows = [f"{k / 100}\t{0.4 + k % 7 / 100:.2f}\t{15 + k % 3}" for k in range(60)]
    data = "\n".join(["time\theight\tvoltage", "s\tm", *rows, ""]).encode()
    result = read_file(data, Declarations(units_row=2))
    assert [(channel.name, channel.unit) for channel in result.parts[0].channels] == [
        ("body_height", "m"),
        ("voltage", None),
    ]
