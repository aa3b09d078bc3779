"""Encodings, and facts in the lines above a table."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.model import Declarations, FindingCollector
from ingest.read import read_file
from ingest.text import open_text
from tests.ingest.reading import rules
from tests.ingest.synthetic import robot_log, text


@given(st.text(st.characters(blacklist_categories=["Cs", "Cc"])))
def test_text_is_read_as_it_was_written_in_every_marked_encoding(words: str) -> None:
    for mark, encoding in ((b"\xef\xbb\xbf", "utf-8"), (b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be")):
        source = open_text(mark + words.encode(encoding), "cp1252", FindingCollector())
        assert source.decode(source.data[source.start :]) == unicodedata.normalize("NFC", words)


@pytest.mark.parametrize("tail", [500, 100_000])
def test_a_tail_of_nuls_is_cut_off_and_noted(tail: int) -> None:
    """A preallocated file was neither text nor a format known, or its last row was damaged."""
    for data, kept in ((robot_log(400), 400), (robot_log(400)[:-9], 399)):
        result = read_file(data + bytes(tail), Declarations())
        assert (result.refused, result.rows_kept) == (False, kept)
        assert "nul_padding" in rules(result)
    sheet = read_file(b"run,mAh,pack\nr001,461,A\nr002,470,B\n" + bytes(tail), Declarations())
    assert [charge.charge_mah for charge in sheet.charges] == [461.0, 470.0]


@pytest.mark.parametrize("page", ["utf-16-le", "utf-16-be"])
def test_utf16_without_a_mark_is_read_as_declared(page: str) -> None:
    data = robot_log(40).decode().encode(page)
    (found,) = read_file(data, Declarations()).findings
    assert f"`--encoding {page}`" in found.message
    (part,), (plain,) = (
        read_file(*read).parts for read in ((data, Declarations(encoding=page)), (robot_log(40), Declarations()))
    )
    assert np.array_equal(part.channels[0].values, plain.channels[0].values)


def quoted(line: str) -> str:
    return '"' + line.replace('"', '""') + '"'


@pytest.mark.parametrize("wrapped", [lambda _: True, lambda row: row == 0], ids=["every line", "the header"])
@pytest.mark.parametrize(("delimiter", "decimal"), [(",", "."), (";", ","), ("\t", ".")])
def test_lines_wholly_in_quotes_are_refused(wrapped: Callable[[int], bool], delimiter: str, decimal: str) -> None:
    """`"time (s),height (mm)"` is one column, and never numbers with thousands separators."""
    rows = [f"{0.005 * k:.3f}{delimiter}{300 + k % 7}".replace(".", decimal) for k in range(100)]
    lines = [f"time (s){delimiter}height (mm)", *rows]
    data = "\n".join(quoted(line) if wrapped(place) else line for place, line in enumerate(lines)) + "\n"
    assert read_file(data.encode(), Declarations()).refused


def test_a_quoted_cell_is_no_line_in_quotes() -> None:
    decimal_commas = text('"height [m]"', [f'"0,4{k % 7}"' for k in range(60)])
    (part,) = read_file(decimal_commas, Declarations(rate_hz=100.0)).parts
    assert part.channels[0].values[:2] == pytest.approx([0.40, 0.41])
    title = b'"Rig A, Monday"\n' + robot_log(40)
    assert read_file(title, Declarations()).rows_kept == 40


@pytest.mark.parametrize(
    ("line", "dates", "start"),
    [
        ("# recorded: 2021-06-05 14:30:00", None, "2021-06-05T18:30:00.000000Z"),
        ("# Datum 08.09.2026 18:40", None, "2026-09-08T22:40:00.000000Z"),
        ("# Datum: 2026-09-08 18:40", None, "2026-09-08T22:40:00.000000Z"),
        ("# Date: 08.09.2026 8:40", None, "2026-09-08T12:40:00.000000Z"),
        ("# date: 2026-09-08T18:40:30.5Z", "d/m/y", "2026-09-08T18:40:30.500000Z"),
        ("# date: 2026-09-08T18:40:30+02:00", None, "2026-09-08T16:40:30.000000Z"),
        ("# date: 2021-01-05T14:30:00.25", None, "2021-01-05T19:30:00.250000Z"),
        ("Date,06/05/2021 1:02:03 PM", None, None),
        ("Date,06/05/2021 1:02:03 PM", "m/d/y", "2021-06-05T17:02:03.000000Z"),
        ("Date,25/05/2021 13:02", None, "2021-05-25T17:02:00.000000Z"),
        ("firmware 1.4 of 08.09.2026 18:40", None, None),
        ("# Datum 31.02.2026 18:40", None, None),
    ],
)
def test_the_date_above_a_table_is_the_start_in_the_zone_of_the_book(
    line: str, dates: str | None, start: str | None
) -> None:
    declared = Declarations(time_zone="America/New_York", date_format=dates)
    (part,) = read_file(f"title\n{line}\n".encode() + robot_log(60), declared).parts
    assert part.start_utc == start
    assert start is None or str(part.start_original) in line


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_a_typeset_minus_is_one(encoding: str) -> None:
    rows = [f"{k / 100};{0.44 + k / 100:.2f};{'-' if k % 2 else ''}1.{k}" for k in range(9)]
    lines = "\n".join(["time_s;body_height_m;current (A)", *rows, ""]).replace("-", "\N{MINUS SIGN}")
    result = read_file(lines.encode(encoding), Declarations())
    assert (result.refused, result.rows_kept) == (False, 9)
    assert result.parts[0].channels[1].values.tolist() == [(-1) ** k * (1 + k / 10) for k in range(9)]
