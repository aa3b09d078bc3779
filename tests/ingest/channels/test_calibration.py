"""A calibrated column is what the calibration says, whatever the unit; counts without one are asked about."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.calibration import Calibration, line_through
from ingest.model import ColumnDeclaration, Declarations, ReadFile
from ingest.read import read_file
from tests.helpers.wording import says
from tests.ingest.reading import refusal, rules

RAW = np.array([1000 + 37 * (row % 50) for row in range(400)])


def log(head: str, start: str | None = None) -> bytes:
    lines = [f"{'' if start is None else start + ','}{2 * row},{raw}" for row, raw in enumerate(RAW)]
    return (head + "\n" + "\n".join(lines) + "\n").encode()


def read(data: bytes, unit: str | None, *calibrations: Calibration, column: str = "h", **more: object) -> ReadFile:
    declared = {column: ColumnDeclaration("body_height", unit, 1, calibrations)}
    return read_file(data, Declarations(columns=declared, **more))  # type: ignore[arg-type]


@given(scale=st.floats(1e-4, 1e-3), offset=st.floats(-0.4, 0.4), unit=st.sampled_from(["m", "mm", "cm", "in"]))
def test_stored_values_are_scale_times_raw_plus_offset_in_the_named_unit(
    scale: float, offset: float, unit: str
) -> None:
    per_m = {"m": 1.0, "mm": 1e3, "cm": 1e2, "in": 1 / 0.0254}[unit]
    result = read(log("t [ms],h (counts)"), unit, Calibration(scale * per_m, offset * per_m))
    assert not result.refused
    (channel,) = result.parts[0].channels
    assert (channel.name, channel.unit, channel.source_unit) == ("body_height", "m", "counts")
    assert channel.values == pytest.approx(scale * RAW + offset, abs=1e-12)
    assert channel.scale * RAW + channel.offset == pytest.approx(channel.values, abs=1e-12)


def test_a_zero_that_is_off_is_taken_off_in_the_unit_of_the_header() -> None:
    result = read(log("t [ms],h [mm]"), "mm", Calibration(offset=-47.0, source="ruler"))
    assert result.parts[0].channels[0].values == pytest.approx((RAW - 47) / 1000)
    assert "unit_contradicts" in rules(read(log("t [ms],h [mm]"), "cm", Calibration(offset=-4.7)))


@pytest.mark.parametrize("unit", [None, "counts", "1"])
def test_counts_need_a_calibration(unit: str | None) -> None:
    result = read(log("t [ms],h (counts)"), unit)
    assert rules(result) == {"calibration_missing"}
    says(refusal(result).message, f"{unit or 'counts'!r}")


EARLY = Calibration(1e-4, 0.1, last_day="2024-03-04")
LATE = Calibration(1e-4, 0.2, first_day="2024-03-05")


def epoch_log(day: int) -> bytes:
    start_s = 1_709_510_400 + 86_400 * (day - 4)  # 2024-03-04 00:00 UTC
    lines = [f"{start_s + 43_200 + 0.002 * row:.3f},{raw}" for row, raw in enumerate(RAW)]
    return ("t [s],h (counts)\n" + "\n".join(lines) + "\n").encode()


@pytest.mark.parametrize(("day", "offset_m"), [(4, 0.1), (5, 0.2)])
def test_the_calibration_in_force_on_the_day_of_the_log_is_used(day: int, offset_m: float) -> None:
    of_stamps = read(epoch_log(day), "m", EARLY, LATE, time_zone="Europe/Berlin")
    declared = read(log("t [ms],h (counts)"), "m", EARLY, LATE, day=f"2024-03-0{day}")
    for result in (of_stamps, declared):
        assert not result.refused
        assert result.parts[0].channels[0].values == pytest.approx(1e-4 * RAW + offset_m)


def test_a_log_without_a_date_or_without_a_calibration_for_it_is_asked_about() -> None:
    assert rules(read(log("t [ms],h (counts)"), "m", EARLY, LATE)) == {"calibration_undated"}
    gap = Calibration(1e-4, 0.2, first_day="2024-03-07")
    assert rules(read(log("t [ms],h (counts)"), "m", EARLY, gap, day="2024-03-05")) == {"calibration_unclear"}
    overlap = Calibration(1e-4, 0.2, first_day="2024-03-01")
    assert rules(read(log("t [ms],h (counts)"), "m", EARLY, overlap, day="2024-03-02")) == {"calibration_unclear"}


@pytest.mark.parametrize(
    ("name", "stamps"),
    [
        ("time (filetime)", [f"{133540128000000000 + 100_000 * row}.0" for row in range(200)]),
        ("time", [f"2024-03-05 10:00:{row / 100:05.2f}" for row in range(200)]),
    ],
)
def test_the_day_of_a_log_is_that_of_its_first_row_with_a_time(name: str, stamps: list[str]) -> None:
    lines = [f"{name},h (counts)", *(f"{'' if row == 0 else stamp},{row % 50}" for row, stamp in enumerate(stamps))]
    result = read("\n".join([*lines, ""]).encode(), "m", EARLY, LATE, time_zone="UTC")
    assert not rules(result) & {"calibration_undated", "calibration_unclear"}
    assert result.parts[0].channels[0].calibration == (EARLY if name != "time" else LATE)


def test_a_unit_of_the_command_line_stands_over_the_calibration_of_a_profile() -> None:
    profile = {"h": ColumnDeclaration("body_height", "m", 1, (line_through([0, 10_000], [0.0, 1.0]),))}
    declared = Declarations(profile_columns=profile, columns={"h": ColumnDeclaration(None, "mm")})
    result = read_file(log("t [ms],h"), declared)
    assert result.parts[0].channels[0].values == pytest.approx(RAW / 1000)
