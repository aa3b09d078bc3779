"""Workbooks: sheets are read as text is, exactly; damaged and oversized ones are refused; these are synthetic."""

from __future__ import annotations

import numpy as np
import pytest

from ingest.model import ColumnDeclaration, Declarations
from ingest.read import read_file
from tests.helpers.wording import says
from tests.ingest.reading import finding, read, refusal, rules
from tests.ingest.synthetic_workbooks import MAIN, Rows, workbook

HEIGHTS = np.random.default_rng(2).normal(0.4, 0.01, 50)
LOG: Rows = [["time [s]", "height [m]", "count"], *([n / 300, float(h), n] for n, h in enumerate(HEIGHTS))]


def test_numbers_keep_all_their_digits() -> None:
    result = read(workbook({"Run 1": LOG}))
    assert not result.refused
    (part,) = result.parts
    assert part.part == "run_1"
    assert part.channels[0].name == "body_height"
    assert part.channels[0].values.tolist() == HEIGHTS.tolist()
    assert part.rate_hz == pytest.approx(300.0)


def test_whole_and_broken_numbers_side_by_side_are_no_thousands() -> None:
    rows: Rows = [["time [ms]", "height [mm]"], *([4.0 * n, 999.0 if n % 2 else 1.002] for n in range(50))]
    (part,) = read(workbook({"a": rows})).parts
    assert part.channels[0].values[:2] == pytest.approx([0.001002, 0.999])


def test_each_of_two_time_columns_governs_the_columns_to_its_right() -> None:
    rows: Rows = [["time (s)", "state", "time (s)", "height (m)"], [0.0, 1.0, 0.0, 0.4], [2.0, 3.0, 0.01, 0.5]]
    rows += [["", "", n / 100, 0.4 + n / 1000] for n in range(2, 30)]
    first, second = read(workbook({"log": rows})).parts
    assert [first.part, second.part] == ["log_1", "log_2"]
    assert (first.time_s.tolist(), first.channels[0].name) == ([0.0, 2.0], "controller_state")
    assert (len(second.time_s), second.rate_hz) == (30, pytest.approx(100.0))


def test_sheets_are_parts_and_a_sheet_of_words_is_left_out() -> None:
    result = read(workbook({"a": LOG, "Notes": [["measured by", "M"]], "b": LOG}))
    assert [part.part for part in result.parts] == ["a", "b"]
    assert "sheet_without_numbers" in rules(result)


def test_a_charger_sheet_with_dates_in_a_workbook() -> None:
    rows: Rows = [["date", "run", "mAh", "minutes", "end_voltage", "pack"]]
    rows += [[44000.5 + n, f"r{n:03d}", 461.0 + n, 12.5, 16.8, "A"] for n in range(3)]
    result = read(workbook({"charges": rows}, dates=True))
    assert (result.refused, result.role) == (False, "charge")
    assert [charge.charge_mah for charge in result.charges] == [461.0, 462.0, 463.0]
    assert {charge.resolution_mah for charge in result.charges} == {1.0}
    assert result.charges[0].ended_original == "2020-06-18 12:00:00"


def test_a_log_and_a_charger_sheet_in_one_workbook_are_refused() -> None:
    charges: Rows = [["run", "mAh", "pack"], ["r001", 461.0, "A"]]
    result = read(workbook({"log": LOG, "charges": charges}))
    assert "members_differ" in {finding.rule for finding in result.findings if finding.severity == "file"}


def test_a_row_in_a_finding_is_the_row_of_the_sheet() -> None:
    rows: Rows = [[], ["title"], *LOG]
    rows[20] = [*rows[20][:1], "ERROR", 3.0]
    assert finding(read(workbook({"a": rows})), "not_a_number").line == 21


@pytest.mark.parametrize(
    "last",
    [
        '<row r="1048576"><c r="XFD1048576"><v>1</v></c></row>',
        '<row r="2"><c r="AAA1048576"><v>1</v></c></row>',
        "<row r='30000'><c r='zzz30000'><v>1</v></c></row>",
        f'<row r="2">{"<c><v>1</v></c>" * 9000}</row><row r="9999"><c><v>1</v></c></row>',
    ],
    ids=["far", "row of the cell alone", "other quotes", "no places"],
)
def test_two_cells_far_apart_are_no_memory_bomb(last: str) -> None:
    first = '<row r="1"><c r="A1"><v>1</v></c></row>'
    xml = f'<worksheet xmlns="{MAIN}"><sheetData>{first}{last}</sheetData></worksheet>'
    says(refusal(read(workbook({"a": []}, raw=xml))).message, "most_cells")


@pytest.mark.parametrize("entity", ["<!ENTITY a0 'lol'>", "<!ENTITY a0 SYSTEM 'file:///etc/hostname'>"])
def test_entities_of_xml_are_never_expanded(entity: str) -> None:
    tenfold = "".join(f"<!ENTITY a{n} '{f'&a{n - 1};' * 10}'>" for n in range(1, 10))
    cells = '<c r="A1" t="inlineStr"><is><t>&a9;</t></is></c><c r="B1"><v>1</v></c>'
    xml = f'<!DOCTYPE x [{entity}{tenfold}]><worksheet xmlns="{MAIN}"><sheetData><row r="1">{cells}</row></sheetData>'
    result = read(workbook({"a": []}, raw=f'<?xml version="1.0"?>{xml}</worksheet>'))
    assert [finding.rule for finding in result.findings] == ["workbook_refused"]


def test_an_old_workbook_that_is_none_is_refused() -> None:
    assert refusal(read(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600))).rule == "workbook_refused"


def test_blanks_in_the_names_of_a_sheet_part_no_columns() -> None:
    """`geladen [Ah]` and a date with a time were two cells each; a workbook's columns are known."""
    names = ["Versuch", "Akku", "geladen [Ah]", "Ende", "Spannung [V]"]
    rows = [["r710", "A", 0.812, 45228.6, 16.8], ["r712", "B", 0.844, 45229.5, 16.79]]
    declared = {"Versuch": ColumnDeclaration("run"), "geladen": ColumnDeclaration("charge")}
    result = read_file(workbook({"Laden": [names, *rows]}), Declarations(columns=declared))
    assert [charge.charge_mah for charge in result.charges] == [812, 844]


INFO = [["Logger", "SX50"], ["Rate", 100], ["Mass (kg)", 2]]
SUMMARY = [["Jumps", "Mean height (mm)"], [12, 341.5]]


@pytest.mark.parametrize("beside", [INFO, SUMMARY], ids=["settings", "summary"])
@pytest.mark.parametrize("rate_hz", [None, 100.0])
def test_a_sheet_of_a_few_lines_beside_a_log_is_left_out(beside: Rows, rate_hz: float | None) -> None:
    """Its masses were samples of a part of its own."""
    data = [["Time (s)", "Body height (mm)"], *([0.01 * k, 300.0 + k % 7] for k in range(60))]
    result = read_file(workbook({"Info": beside, "Data": data}), Declarations(rate_hz=rate_hz))
    assert not result.refused
    assert [part.part for part in result.parts] == ["data"]
    assert [finding.column for finding in result.findings if finding.rule == "member_left_out"] == ["Info"]
    alone = read_file(workbook({"Info": beside, "Data": data[:9]}), Declarations(rate_hz=100.0))
    assert "member_left_out" not in rules(alone)
