"""Steady jumps against the numbers that two other programs give for the same scenes.

The tables stand as an independent simulation of the same equations printed them, to half a unit of the last digit;
where that digit was rounded twice, the test says so. The few numbers to more digits are of
`benchmarks.reference_simulator`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from decimal import Decimal
from typing import Any

import pytest

from simulator.gains import stiffness_n_m
from simulator.jump import simulate
from simulator.steady.tables import RECORDED_JUMPS, Yielding, steady_jump, yielding_of
from tests.helpers.steady import steady_tables as tables

Columns = tuple[Callable[[Any], float], ...]
EMULATOR_COLUMNS: Columns = (
    lambda row: row.ce.apex_height_m,
    lambda row: row.ce.cost_j,
    lambda row: 100 * row.scaled_saving,
    lambda row: 100 * row.constant_saving,
    lambda row: 100 * row.scaled_loss,
    lambda row: 100 * row.constant_loss,
    lambda row: 1e3 * row.yielding.switch_depth_m,
    lambda row: 1e3 * row.ce.max_depth_m,
    lambda row: row.ce.period_s,
    lambda row: 1e3 * row.ce.capped_time_s,
)
EMULATOR = {
    100: "0.258 14.9  1.2  2.2 0.2 0.6 13 24 0.69  0",
    200: "0.347 24.2  8.6 10.5 2.1 2.7 18 38 0.60  0",
    300: "0.418 36.0 17.3 17.3 4.4 4.4 21 48 0.62  0",
    400: "0.461 43.1 16.3 14.2 3.3 3.0 22 51 0.63 37",
    500: "0.480 46.4 14.5 11.3 2.0 1.8 23 52 0.64 47",
}
PLATE_COLUMNS: Columns = (
    lambda row: row.jump.apex_height_m,
    lambda row: row.jump.heat_j,
    lambda row: row.jump.mechanical_j,
    lambda row: row.jump.drag_j,
    lambda row: row.jump.cost_j,
    lambda row: row.battery_j,
    lambda row: row.jump.touchdown_velocity_m_s,
    lambda row: row.jump.impact_loss_j,
    lambda row: 1e3 * row.jump.capped_time_s,
    lambda row: row.jump.min_leg_length_m,
)
PLATE = {
    300: "0.337 44.3 0.1 0.8 45.2 33.5 -1.14 0.11 29 0.176",
    400: "0.399 56.1 0.2 1.2 57.6 42.6 -1.59 0.22 55 0.161",
    500: "0.442 62.1 0.3 1.5 63.9 47.3 -1.84 0.30 64 0.152",
    600: "0.475 65.6 0.4 1.8 67.7 50.1 -2.00 0.35 69 0.146",
}
ROUNDED_TWICE = {("emulator", 300, 8), ("force_plate", 500, 1), ("force_plate", 500, 7)}
"""0.61486 s, 62.0466 J and 0.29486 J, printed as 0.62, 62.1 and 0.30: by way of 0.615, 62.05 and 0.295."""


def test_both_tables_to_the_last_printed_digit() -> None:
    tabled: tuple[tuple[str, dict[int, str], Columns, Sequence[Any]], ...] = (
        ("emulator", EMULATOR, EMULATOR_COLUMNS, tables().emulator.rows),
        ("force_plate", PLATE, PLATE_COLUMNS, tables().force_plate.rows),
    )
    compared = 0
    for table, lines, columns, rows in tabled:
        for (gain, line), row in zip(lines.items(), rows, strict=True):
            for number, (text, column) in enumerate(zip(line.split(), columns, strict=True)):
                if (table, gain, number) not in ROUNDED_TWICE:
                    compared, printed = compared + 1, Decimal(text)
                    half = Decimal(1).scaleb(int(printed.as_tuple().exponent)) / 2
                    assert abs(Decimal(column(row)) - printed) <= half, (table, gain, number)
    assert compared == 87


def test_those_three_against_taylor_series() -> None:
    """Jump 6 on the emulator and jump 26 on the plate to 22 digits: there the jumps repeat to a millionth."""
    emulator, table = tables().emulator.at(300.0).ce, tables().force_plate
    plate = steady_jump(table.scene.changed({"k_extension": stiffness_n_m(table.rows[2].gain)}), 1e-8)
    assert emulator.period_s == pytest.approx(0.614864938, rel=1e-6)
    assert emulator.apex_height_m == pytest.approx(0.418200673, rel=1e-6)
    assert (emulator.heat_j, emulator.mechanical_j) == pytest.approx((32.12903547, 3.857686117), rel=1e-6)
    assert (plate.heat_j, plate.drag_j) == pytest.approx((62.0466195, 1.534923567), rel=1e-6)
    # On rigid ground all mechanical energy of a steady jump is lost at the foot's impact.
    assert (plate.mechanical_j, plate.impact_loss_j) == pytest.approx((0.294861378, 0.294861378), rel=3e-6)


def test_the_last_jump_repeats_the_one_before() -> None:
    jumps = [row.jump for row in tables().force_plate.rows]
    for row in tables().emulator.rows:
        jumps += [row.ce, row.scaled, row.constant]
    assert max(abs(jump.apex_change_m) for jump in jumps) < 1e-12


def test_the_recorded_jump_is_the_steady_one() -> None:
    for row in tables().emulator.rows:
        assert 0.0 < row.yielding.switch_depth_m < row.ce.max_depth_m
        assert 0.0 < row.yielding.heat_j < row.ce.heat_j
    scene = tables().emulator.scene
    assert scene.jumps > RECORDED_JUMPS
    found = yielding_of(scene, 1e-8)  # the shipped scene is the row of gain 300
    shown = tables().emulator.at(300.0).yielding
    for field in fields(Yielding):
        assert getattr(found, field.name) == pytest.approx(getattr(shown, field.name), rel=1e-5)


@pytest.mark.parametrize(
    ("foot", "gain", "stiffness", "damping_gain", "b_ad"),
    [
        ("small", 400.0, 1091.36, 0.0, 0.0),
        ("small", 300.0, 835.36, 250.0, 849.67),
        ("large", 400.0, 1091.36, 50.0, 185.67),
        ("large", 300.0, 835.36, 150.0, 517.67),
    ],
)
def test_a_condition_of_the_bed_is_a_drop_of_its_scene(
    foot: str, gain: float, stiffness: float, damping_gain: float, b_ad: float
) -> None:
    bed = tables().bed
    (row,) = bed.of(foot, gain, (damping_gain,))
    changed = bed.scene.changed({"foot_radius": 0.038 if foot == "small" else 0.051, "k_extension": stiffness})
    ce, jump = (simulate(changed.changed({"b_ad": value})).jump for value in (0.0, b_ad))
    assert (row.cost_j, row.apex_height_m) == pytest.approx((jump.cost_J, jump.apex_height_m))
    assert (row.max_depth_m, row.capped_time_s) == pytest.approx((jump.max_depth_m, jump.capped_time_s))
    assert row.saving == pytest.approx(1.0 - jump.cost_J / ce.cost_J)
    assert row.apex_gain_m == pytest.approx((jump.apex_height_m or 0.0) - (ce.apex_height_m or 0.0))
    assert bed.saving(foot, gain, (damping_gain,)) == row.saving
    assert len(bed.rows) == len({(row.foot, row.gain, row.damping_gain) for row in bed.rows}) == 24
