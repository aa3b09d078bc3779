"""Clock texts as people and loggers write them: read where only one meaning is possible or declared, else asked for."""

from __future__ import annotations

from datetime import datetime, timedelta

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.model import ColumnDeclaration, Declarations, ReadFile
from ingest.read import read_file
from ingest.timebase.clock_formats import DATE_FORMATS, iso_text, parse_stamp
from tests.ingest.synthetic import text

day = datetime.fromisoformat
STRPTIME = {"y-m-d": "%Y-%m-%d", "d.m.y": "%d.%m.%Y", "d/m/y": "%d/%m/%Y", "m/d/y": "%m/%d/%Y"}


def log(times: list[str], header: str = "time;k gain") -> bytes:
    return text(header, [f"{time};{k % 5}" for k, time in enumerate(times)])


def read(data: bytes, **declared: object) -> ReadFile:
    return read_file(data, Declarations(time_zone="UTC", **declared))  # type: ignore[arg-type]


def seconds(result: ReadFile) -> list[float]:
    assert not result.refused, result.findings
    (part,) = result.parts
    return [round(float(value), 6) for value in part.time_s]


def rules(result: ReadFile) -> set[str]:
    return {finding.rule for finding in result.findings}


@pytest.mark.parametrize(
    ("times", "start"),
    [
        (["5.6.2021 14:30:00", "5.6.2021 14:30:01", "5.6.2021 14:30:02"], "2021-06-05T14:30:00"),
        (["05.06.21 14:30:00", "05.06.21 14:30:01", "05.06.21 14:30:02"], "2021-06-05T14:30:00"),
        (["14:30:00 13-06-2021", "14:30:01 13-06-2021", "14:30:02 13-06-2021"], "2021-06-13T14:30:00"),
        (["06/13/2021 2:30:00 PM", "06/13/2021 2:30:01 PM", "06/13/2021 2:30:02 PM"], "2021-06-13T14:30:00"),
        (["12/31/2021 23:59:59", "01/01/2022 00:00:00", "01/01/2022 00:00:01"], "2021-12-31T23:59:59"),
    ],
)
def test_dates_that_only_one_order_allows_are_read(times: list[str], start: str) -> None:
    result = read(log(times))
    assert seconds(result) == [0, 1, 2]
    (part,) = result.parts
    assert part.start_utc == f"{start}.000000Z"
    assert part.start_original == times[0]


def test_a_date_that_two_orders_allow_is_asked_for_and_read_as_declared() -> None:
    data = log([f"03/04/2019 10:00:{k:02d}" for k in range(5)])
    refused = read(data)
    assert refused.refused
    assert any(finding.rule == "date_unclear" and "--dates d/m/y" in finding.message for finding in refused.findings)
    for order, start in (("d/m/y", "2019-04-03"), ("m/d/y", "2019-03-04")):
        (part,) = read(data, date_format=order).parts
        assert (part.start_utc or "").startswith(start)


def test_a_year_in_front_contradicts_another_order() -> None:
    assert "date_contradicts" in rules(read(log(["2021-06-05 10:00:00", "2021-06-05 10:00:01"]), date_format="d.m.y"))


def test_minutes_run_on_past_the_hour_and_twelve_thirty_is_asked_about() -> None:
    times = [f"{(59 * 60 + 58 + k) // 60 % 60:02d}:{(58 + k) % 60:02d}" for k in range(5)]
    assert times[1:3] == ["59:59", "00:00"]
    assert seconds(read(log(times), clock_format="m:s")) == [0, 1, 2, 3, 4]
    assert seconds(read(log([f"{time}.5" for time in times]))) == [0, 1, 2, 3, 4]
    unclear = log([f"12:{k:02d}" for k in range(5)])
    assert "clock_unclear" in rules(read(unclear))
    assert seconds(read(unclear, clock_format="m:s")) == [0, 1, 2, 3, 4]
    assert seconds(read(unclear, clock_format="h:m")) == [0, 60, 120, 180, 240]


@pytest.mark.parametrize("header", ["Date;time;k gain", "Tag;Uhr;k gain"])
def test_dates_in_a_column_of_their_own_go_with_the_times(header: str) -> None:
    data = log(["31.12.2021;23:59:59", "01.01.2022;00:00:00", "01.01.2022;00:00:01"], header)
    said = {"Tag": ColumnDeclaration("date"), "Uhr": ColumnDeclaration("time")} if "Tag" in header else {}
    result = read(data, columns=said)
    assert seconds(result) == [0, 1, 2]
    assert result.parts[0].start_utc == "2021-12-31T23:59:59.000000Z"


def test_unclear_dates_beside_times_are_left_out_with_a_note() -> None:
    result = read(log([f"03/04/2019;10:00:{k:02d}" for k in range(4)], "date;time;k gain"))
    assert seconds(result) == [0, 1, 2, 3]
    assert "date_unclear" in rules(result)
    assert result.parts[0].start_utc is None


def test_a_time_that_does_not_exist_is_left_out_alone() -> None:
    times = [f"5.6.2021 14:{k // 60:02d}:{k % 60:02d}" for k in range(300)]
    times[7] = "31.6.2021 14:00:07"
    result = read(log(times))
    assert (result.rows_kept, result.rows_rejected) == (299, 1)
    assert "time_missing" in rules(result)


@given(moment=st.datetimes(day("2000-01-01"), day("2099-01-01")), order=st.sampled_from(DATE_FORMATS))
def test_what_strftime_writes_is_read_back(moment: datetime, order: str) -> None:
    moment = moment.replace(microsecond=0)
    for clock in ("%H:%M:%S", "%I:%M:%S %p"):
        written = moment.strftime(f"{STRPTIME[order]} {clock}")
        assert parse_stamp(written) is not None
        assert iso_text(written, order) == moment.isoformat()


@given(start=st.datetimes(day("2021-01-01"), day("2022-01-01")), step_s=st.integers(1, 900))
def test_a_declared_order_gives_the_axis_of_iso_texts(start: datetime, step_s: int) -> None:
    moments = [start.replace(microsecond=0) + timedelta(seconds=k * step_s) for k in range(6)]
    iso = read(log([moment.isoformat(" ") for moment in moments]))
    for order in ("d/m/y", "m/d/y"):
        own = read(log([moment.strftime(f"{STRPTIME[order]} %H:%M:%S") for moment in moments]), date_format=order)
        assert np.array_equal(own.parts[0].time_s, iso.parts[0].time_s)
        assert own.parts[0].start_utc == iso.parts[0].start_utc
