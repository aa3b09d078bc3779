"""The unit of a time column that states none: found in stamps that are dates, named where one alone fits, or asked."""

from __future__ import annotations

import re

import numpy as np
import pytest

from ingest.model import ColumnDeclaration, Declarations, ReadFile
from ingest.read import read_file
from tests.helpers.wording import says
from tests.ingest.reading import channel, finding, refusal, rules
from tests.ingest.synthetic import text

FIRST_NS = 1_690_000_000_123_456_789
"""2023-07-22 04:26:40 UTC, of which float64 holds every 256th."""
HEIGHTS = [f"{0.4 + 0.05 * np.sin(k / 15):.5f}" for k in range(600)]


def read(header: str, rows: list[str], **declared: object) -> ReadFile:
    return read_file(text(header, rows), Declarations(**declared))  # type: ignore[arg-type]


def of_rostopic(step_ns: int = 5_000_001) -> list[str]:
    """Rows as `rostopic echo -p` writes them: time of arrival and stamp of the header in ns since 1970."""
    return [f"{FIRST_NS + step_ns * k},{k},{FIRST_NS - 77 + step_ns * k},base,{h}" for k, h in enumerate(HEIGHTS)]


ROSTOPIC = "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.position0"


def test_stamps_of_19_digits_are_dates_in_ns_to_the_last_digit() -> None:
    """600 of 600 rows were left out, for the stamps exceeded 1e18."""
    result = read(ROSTOPIC, of_rostopic())
    assert (result.refused, result.rows_kept) == (False, 600)
    (part,) = result.parts
    assert np.array_equal(part.time_s, np.arange(600) * 5_000_001 / 1e9)
    assert (part.start_utc, part.start_original) == ("2023-07-22T04:26:40.123457Z", f"{FIRST_NS} ns")
    (use,) = [column for column in result.explanation.tables[0].columns if column.holds == "time"]
    assert (use.unit, use.unit_from) == ("ns", "its stamps")


@pytest.mark.parametrize(
    ("unit", "first", "per_second"),
    [
        ("s", 1_622_534_400, 1.0),
        ("ms", 1_622_534_400_000, 1e3),
        ("us", 1_622_534_400_000_000, 1e6),
        ("ns", 1_622_534_400_000_000_000, 1e9),
        ("filetime", 132_670_080_000_000_000, 1e7),
    ],
)
def test_stamps_that_are_dates_in_one_unit_alone_are_read_so(unit: str, first: int, per_second: float) -> None:
    """FILETIME was asked for `UNIT: one of us, ns`, of which each gave a wrong rate and no date."""
    for rate_hz in (50, 200):
        step = per_second / rate_hz
        rows = [
            f"{first + step * k:.3f},{h}" if unit == "s" else f"{first + int(step) * k},{h}"
            for k, h in enumerate(HEIGHTS)
        ]
        result = read("Timestamp,height [m]", rows)
        (part,) = result.parts
        assert (part.rate_hz, part.start_utc) == (pytest.approx(rate_hz), "2021-06-01T08:00:00.000000Z")
        says(finding(result, "time_unit_found").message, f" {unit} ", "2021-06-01")


@pytest.mark.parametrize(
    ("header", "step"),
    [
        ("time [0.1 ms]", 50),
        ("time [0,1 ms]", 50),
        ("time [1/10 ms]", 50),
        ("time [100 us]", 50),
        ("time [5msec]", 1),
        ("time [d]", 5e-3 / 86_400),
    ],
)
def test_a_tick_is_the_multiple_of_a_unit_that_the_header_says(header: str, step: float) -> None:
    """100 Hz in `[0.1 ms]` were to be declared `--unit time=us`, which gave 10 kHz."""
    rows = [f"{step * k:.12g},{h}" for k, h in enumerate(HEIGHTS)]
    said = {"time": ColumnDeclaration(unit=header.removeprefix("time [").removesuffix("]"))}
    for result in (read(f'"{header}",height [m]', rows), read("time,height [m]", rows, columns=said)):
        assert result.parts[0].rate_hz == pytest.approx(200.0, rel=1e-6)


def test_the_serial_day_of_a_spreadsheet_gives_the_start_in_the_books_zone() -> None:
    rows = [f"{44348.375 + k / 200 / 86_400:.10f},{h}" for k, h in enumerate(HEIGHTS)]
    refused = refusal(read("time,height [m]", rows))
    assert refused.rule == "time_unit_missing"
    says(refused.message, "h, d")
    declared = {"columns": {"time": ColumnDeclaration(unit="day")}, "time_zone": "America/New_York"}
    (part,) = read("time,height [m]", rows, **declared).parts
    assert (part.start_utc, part.start_original) == ("2021-06-01T13:00:00.000000Z", "44348.375 d")
    assert part.rate_hz == pytest.approx(200.0, rel=1e-4)
    assert part.gaps == ()


def test_a_stamp_that_is_damaged_costs_its_row_and_no_digit_of_the_others() -> None:
    rows = of_rostopic()
    rows[0] = rows[0].replace(str(FIRST_NS), "0", 1)
    rows[300] = rows[300].replace(",base", ",")
    (part,) = read(ROSTOPIC, rows).parts
    assert part.time_s == pytest.approx(np.arange(599) * 5_000_001 / 1e9, abs=1e-12)


@pytest.mark.parametrize("first", [FIRST_NS, 133_500_000_000_000_000, 2**63 - 1000, 18_446_744_073_709_551_000, 10**39])
def test_long_integers_in_any_column_drop_no_row(first: int) -> None:
    rows = [f"{5 * k},{first + k},{h}" for k, h in enumerate(HEIGHTS)]
    result = read("time [ms],id,height [m]", rows)
    assert (result.refused, result.rows_kept) == (False, 600)
    assert channel(result, "id").values.tolist() == [float(first + k) for k in range(600)]
    assert "digits_rounded" in rules(result)


def named(message: str) -> str:
    found = re.search(r"`--unit t=(\w+)`", message)
    assert found is not None, message
    return found[1]


@pytest.mark.parametrize(
    ("first", "step"), [(0, 0.1), (0, 100), (0, 5), (0, 5_000_000), (960_000_000, 10_000), (0, 1e12)]
)
def test_a_unit_is_named_for_no_rate_that_it_would_give(first: int, step: float) -> None:
    """The one unit fast enough for jumps was: `ms` for 10 Hz in seconds. 960 s in us are no dates in s."""
    rows = [f"{first + step * k:.18g},{h}" for k, h in enumerate(HEIGHTS)]
    said = refusal(read("t,height [m]", rows))
    assert (said.rule, named(said.message)) == ("time_unit_missing", "UNIT")
    says(said.message, "s, ms, us, ns, filetime, min, h, d")
    unknown = refusal(read("t [fortnight],height [m]", rows))
    assert (unknown.rule, named(unknown.message)) == ("time_unit_unknown", "UNIT")


SECONDS = pytest.mark.parametrize("header", ["time [s],height [m]", "time_s,height [m]", "time,height\ns,m"])


@SECONDS
def test_a_rate_at_which_no_jump_is_seen_is_read_once_a_person_or_the_file_says_it(header: str) -> None:
    """10 Hz in `time (s)` had no way in but `--unit time=ms --override-units`, ten kilohertz."""
    rows = [f"{k / 10:.1f},{h}" for k, h in enumerate(HEIGHTS)]
    said = refusal(read(header, rows))
    assert said.rule == "rate_implausible"
    says(said.message, "`--rate 10`")
    for result in (read(header, rows, rate_hz=10.0), read(f"# rate: 10 Hz\n{header}", rows)):
        assert result.parts[0].rate_hz == pytest.approx(10.0)


FIRST_S = 1_622_534_400
PAIRS = {
    "header.stamp.sec,header.stamp.nanosec": 10**9,
    "stamp_secs,stamp_nsecs": 10**9,
    "secs,nsecs": 10**9,
    "tv_sec,tv_usec": 10**6,
}


def in_two(pair: str, step: int, n: int = 600) -> list[str]:
    per_second = PAIRS[pair]
    stamps = [divmod(FIRST_S * per_second + per_second - 20 * step + 7 + step * k, per_second) for k in range(n)]
    return [f"{whole},{fraction},{h}" for (whole, fraction), h in zip(stamps, HEIGHTS, strict=False)]


@pytest.mark.parametrize("pair", PAIRS)
def test_seconds_and_the_fractions_beside_them_are_one_time(pair: str) -> None:
    """Of ROS 2's stamps each column alone was refused; by `--rate` the start was lost, and every loss."""
    step = PAIRS[pair] // 100
    rows = in_two(pair, step)
    rows[3] = "," + rows[3].partition(",")[2]
    del rows[400:403]
    result = read(f"{pair},height [m]", rows)
    (part,) = result.parts
    assert (part.rate_hz, [channel.name for channel in part.channels]) == (pytest.approx(100.0), ["body_height"])
    assert [(gap.samples_missing, gap.kind) for gap in part.gaps] == [(1, "rejected"), (3, "dropped")]
    assert part.start_utc == f"2021-06-01T08:00:00.80000{7 if PAIRS[pair] == 10**6 else 0}Z"
    assert part.start_original == f"{FIRST_S * PAIRS[pair] + PAIRS[pair] * 4 // 5 + 7} {part.start_original[-2:]}"
    assert part.time_s[100] == pytest.approx(1.01, abs=1e-12)
    used = [(column.holds, column.unit_from) for column in result.explanation.tables[0].columns]
    assert used[:2] == [("time", "header")] * 2


def test_two_pairs_of_seconds_are_asked_about_and_a_time_that_is_named_is_the_time() -> None:
    pair, other = list(PAIRS)[:2]
    twice = [f"{row.rpartition(',')[0]},{row}" for row in in_two(pair, 10_000_000)]
    said = refusal(read(f"{pair},{other},height [m]", twice))
    assert said.rule == "several_time_columns"
    declared = {"columns": {"stamp_secs": ColumnDeclaration("time")}}
    assert read(f"{pair},{other},height [m]", twice, **declared).parts[0].rate_hz == pytest.approx(100.0)
    named = [f"{5 * k},{row}" for k, row in enumerate(in_two(pair, 10_000_000))]
    assert read(f"time [ms],{pair},height [m]", named).parts[0].rate_hz == pytest.approx(200.0)
