"""One file in, one frozen result out: all faults at once, never a foreign exception."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import LabbookError, UsageError
from data_schema.vocabulary import Severity
from ingest.model import ColumnDeclaration, Declarations, Profile
from ingest.read import read_file
from tests.ingest.good_files import GOOD_FILES
from tests.ingest.reading import check_invariants, rules
from tests.ingest.synthetic import LOG_HEADER, robot_log, robot_rows, text, twenty_faults
from tests.ingest.test_truncation import EDITS, edited


def test_twenty_faults_of_different_kinds_are_all_found_in_one_reading_by_line_column_and_value_gravest_first() -> None:
    data, faults = twenty_faults()
    result = read_file(data, Declarations())
    assert len(faults) >= 20
    assert faults <= rules(result)
    assert result.refused
    grades = [finding.severity for finding in result.findings]
    assert grades == sorted(grades, key=[Severity.FILE, Severity.ROW, Severity.NOTE].index)
    by_rule = {finding.rule: finding for finding in result.findings}
    lines = data.replace(b"\r\n", b"\n").split(b"\n")
    bad_cell = by_rule["not_a_number"]
    assert b"ERROR" in lines[(bad_cell.line or 0) - 1]
    assert (bad_cell.column, bad_cell.value, bad_cell.severity) == ("height [m]", "ERROR", Severity.ROW)
    assert lines[(by_rule["ragged_row"].line or 0) - 1] == b"1,2,3"
    assert by_rule["last_line_cut"].line == len(lines)


def test_a_clean_log_has_no_findings() -> None:
    result = read_file(robot_log(), Declarations())
    assert result.findings == ()
    assert (result.rows_read, result.rows_kept, result.rows_rejected) == (600, 600, 0)
    assert (result.format, result.role) == ("delimited_log", "log")


@pytest.mark.parametrize(("bad", "refused"), [(6, False), (7, True)])
def test_more_than_one_percent_rejected_refuses(bad: int, refused: bool) -> None:
    rows = robot_rows(600)
    for row in range(0, 10 * bad, 10):
        rows[row] = rows[row].replace(",400", ",ERROR")
    result = read_file(text(LOG_HEADER, rows), Declarations())
    assert result.rows_rejected == bad
    assert result.refused is refused
    assert ("too_many_rejected" in rules(result)) is refused


@pytest.mark.parametrize(
    ("declared", "right"),
    [(Declarations(encoding="cp99999"), "cp1252"), (Declarations(time_zone="Pennsylvania"), "America/New_York")],
)
def test_an_unknown_encoding_or_zone_is_a_usage_error(declared: Declarations, right: str) -> None:
    with pytest.raises(UsageError, match=right):
        read_file(b"# recorded: 2021-06-05 14:30:00\n" + robot_log(60), declared)


ALL = Profile(
    "all",
    files="*",
    columns={"1": ColumnDeclaration("time", "ms"), "3#1": ColumnDeclaration("body_height", "mm", -1)},
    header_row=1,
    first_row=3,
    comment="#",
    footer="e",
    delimiter=",",
    trials="2",
    date_format="d.m.y",
    clock_format="m:s",
    axes="y up",
)
DECLARED = st.sampled_from(
    [
        Declarations(),
        Declarations(rate_hz=300.0, time_unit="ms", time_zone="America/New_York"),
        Declarations(columns={"1": ColumnDeclaration("force_z", "N")}, decimal_sign=","),
        Declarations(profiles=(Profile("log", ("height [m]",), time_column="time [ms]", time_unit="us"),)),
        Declarations(profiles=(ALL,), file_name="r001.csv"),
        Declarations(format="charger_sheet", header_row=0, columns={"2": ColumnDeclaration("charge", "mAh")}),
    ]
)


SEEDS = [GOOD_FILES[name]() for name in ("delimited_log", "bertec_text", "charger_sheet", "icharger_log")]
DAMAGED = st.builds(edited, st.sampled_from([*SEEDS, robot_log(20).decode().encode("utf-16")]), EDITS)


@given(st.binary(max_size=3000) | DAMAGED, DECLARED)
def test_any_bytes_and_damaged_files_give_a_result_or_a_labbook_error(data: bytes, declared: Declarations) -> None:
    with contextlib.suppress(LabbookError):
        check_invariants(read_file(data, declared))
