"""Clock texts as people and loggers write them: read where only one meaning is possible or declared, else asked for."""

from __future__ import annotations

from datetime import datetime, timedelta
from zoneinfo import ZoneInfo

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.model import ColumnDeclaration, Declarations, ReadFile
from ingest.read import read_file
from ingest.timebase.clock import iso_text
from tests.ingest.reading import rules
from tests.ingest.synthetic import text

day = datetime.fromisoformat


def log(times: list[str], header: str = "time;k gain") -> bytes:
    return text(header, [f"{time};{k % 5}" for k, time in enumerate(times)])


def read(data: bytes, **declared: object) -> ReadFile:
    return read_file(data, Declarations(time_zone="UTC", **declared))  # type: ignore[arg-type]


def seconds(result: ReadFile) -> list[float]:
    assert not result.refused, result.findings
    (part,) = result.parts
    return [round(float(value), 6) for value in part.time_s]


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
    assert (result.parts[0].start_utc, result.parts[0].start_original) == (f"{start}.000000Z", times[0])


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


DATES = (("d.m.y", "%d.%m.%Y"), ("d/m/y", "%d/%m/%Y"), ("m/d/y", "%m/%d/%Y"))
FORMS = [(order, f"{date} {clock}") for order, date in DATES for clock in ("%H:%M:%S", "%I:%M:%S %p")]


@given(st.datetimes(day("2000-01-02"), day("2099-01-01")), st.integers(1, 900), st.sampled_from(FORMS))
def test_a_declared_order_gives_the_axis_of_iso_texts(start: datetime, step_s: int, form: tuple[str, str]) -> None:
    moments = [start.replace(microsecond=0) + timedelta(seconds=k * step_s) for k in range(6)]
    iso = read(log([moment.isoformat(" ") for moment in moments]))
    own = read(log([moment.strftime(form[1]) for moment in moments]), date_format=form[0])
    assert np.array_equal(own.parts[0].time_s, iso.parts[0].time_s)
    assert own.parts[0].start_utc == iso.parts[0].start_utc


def elapsed(start: datetime, form: str = "%Y-%m-%d %H:%M:%S", first_s: int = 1, n: int = 300) -> list[str]:
    """Elapsed time beside the date and time of each row, as a battery cycler writes them."""
    return [
        f"{k // 3600:02d}:{k // 60 % 60:02d}:{k % 60:02d};{start + timedelta(seconds=k):{form}}"
        for k in range(first_s, first_s + n)
    ]


@pytest.mark.parametrize(
    ("form", "declared"),
    [("%Y-%m-%d %H:%M:%S", {}), ("%d.%m.%Y %H:%M:%S", {}), ("%m/%d/%Y %I:%M:%S %p", {"date_format": "m/d/y"})],
)
@pytest.mark.parametrize("first_s", [1, 86_390, 359_990])
def test_clock_times_beside_dates_that_have_their_own_are_elapsed(
    form: str, declared: dict[str, str], first_s: int
) -> None:
    """`2021-06-05 14:30:01 00:00:01` was no time, so that no row was kept."""
    start = day("2021-06-05 14:30:00")
    result = read(log(elapsed(start, form, first_s), "Time;Date;k gain"), **declared)
    assert seconds(result) == list(range(300))
    (part,) = result.parts
    first = start + timedelta(seconds=first_s)
    assert (part.start_utc, part.start_original) == (f"{first.isoformat()}.000000Z", f"{first:{form}}")


@pytest.mark.parametrize("form", ["%Y-%m-%d 00:00:00", "%m/%d/%Y 12:00:00 AM"])
def test_dates_at_midnight_are_those_of_the_clock_times_beside_them(form: str) -> None:
    """So spreadsheets export a date."""
    moments = [day("2021-06-15 14:30:00") + timedelta(seconds=k) for k in range(5)]
    result = read(log([f"{moment:%H:%M:%S};{moment:{form}}" for moment in moments], "Time;Date;k gain"))
    assert seconds(result) == [0, 1, 2, 3, 4]
    assert result.parts[0].start_utc == "2021-06-15T14:30:00.000000Z"


@pytest.mark.parametrize(
    ("every", "kept", "rule"), [(100, 595, "time_duplicate"), (20, 600, "arrival_times"), (5, 600, "arrival_times")]
)
def test_equal_whole_seconds_refuse_no_file(every: int, kept: int, rule: str) -> None:
    """2 % of stamps that equal the one before refused the file: `too_many_rejected`."""
    start = day("2021-06-05 14:30:00")
    result = read(log([f"{start + timedelta(seconds=k - k // every)}" for k in range(600)]))
    assert (result.refused, result.rows_kept) == (False, kept)
    assert rule in rules(result)


def test_ten_rows_a_second_of_a_clock_in_whole_seconds_are_ten_hertz() -> None:
    """It ended in an exception."""
    start = day("2021-06-05 14:30:00")
    result = read(log([f"{start + timedelta(seconds=k // 10)}" for k in range(600)]))
    (part,) = result.parts
    assert (result.refused, result.rows_kept) == (False, 600)
    assert part.time_s == pytest.approx(np.arange(600) / 10)
    assert part.start_utc == "2021-06-05T14:30:00.000000Z"


def local_log(start_utc: str, step_s: float, n: int, zone: str, form: str = "%Y-%m-%d %H:%M:%S.%f") -> bytes:
    moments = [day(start_utc + "+00:00") + timedelta(seconds=step_s * k) for k in range(n)]
    header = "date;time;k gain" if ";" in form else "time;k gain"
    return log([moment.astimezone(ZoneInfo(zone)).strftime(form) for moment in moments], header)


def test_where_the_clocks_are_set_forward_a_pause_of_an_hour_is_told() -> None:
    data = local_log("2023-03-26 00:55:00", 1.0, 600, "Europe/Zurich")
    result = read_file(data, Declarations(time_zone="Europe/Zurich"))
    assert (result.refused, result.rows_kept) == (False, 600)
    assert sum(len(part.time_s) for part in result.parts) == 600


def test_a_clock_that_runs_through_the_change_does_not_follow_it() -> None:
    moments = [day("2023-10-29 01:30:00") + timedelta(seconds=10 * k) for k in range(1000)]
    result = read_file(log([moment.isoformat(" ") for moment in moments]), Declarations(time_zone="Europe/Zurich"))
    assert seconds(result) == [10 * k for k in range(1000)]


@pytest.mark.parametrize("zone", [None, "Europe/Zurich"])
def test_where_the_clocks_are_set_back_all_rows_are_kept_in_two_segments(zone: str | None) -> None:
    data = local_log("2023-10-29 00:55:00", 1.0, 600, "Europe/Zurich")
    result = read_file(data, Declarations(time_zone=zone))
    assert [len(part.time_s) for part in result.parts] == [300, 300]
    assert [part.start_utc for part in result.parts] == [None, None]


@pytest.mark.parametrize("decimals", ["9999995", "99999951", "9999999", "999999999999999999"])
def test_a_stamp_just_before_midnight_stays_on_its_day(decimals: str) -> None:
    result = read(log([f"5.6.2021 23:59:59.{decimals}", *(f"6.6.2021 00:00:0{k}" for k in range(1, 9))]))
    assert result.parts[0].start_utc == "2021-06-05T23:59:59.999999Z"
    assert iso_text(f"31.12.9999 23:59:59.{decimals}", "d.m.y") == "9999-12-31T23:59:59.999999"
