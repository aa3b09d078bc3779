from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulator.gains import active_damping_kg_m, fitted_active_damping_kg_m, stiffness_n_m
from simulator.jump import simulate
from simulator.kinematics import lever_m
from simulator.result import JumpResult
from simulator.scene_file import load_scene
from simulator.steady.published_numbers import MEASURES, apex_between_m, comparisons, published_numbers
from simulator.steady.tables import (
    BED_DAMPING_GAINS,
    BED_GAINS,
    ESTIMATED_OVER_MEASURED,
    FEET_M,
    GAINS,
    EmulatorRow,
    EmulatorTable,
    SteadyTables,
)
from tests.helpers.steady import steady_tables

SHARED = Path(__file__).parents[3].parent / "shared"
RESULTS = SHARED / "reference" / "published_results.csv"
COMBINATIONS = tuple((foot, gain) for foot in FEET_M for gain in BED_GAINS)
BY_ID = {number.claim.id: number for number in published_numbers()}


def test_every_number_is_measured_or_says_why_not() -> None:
    assert [number.claim.id for number in published_numbers() if number.claim.measure] == list(MEASURES)
    assert len(BY_ID) == len(published_numbers())
    for number in published_numbers():
        claim = number.claim
        assert claim.statement
        limited = claim.at_least is not None or claim.at_most is not None
        assert limited == bool(claim.measure)
        assert limited or number.reason
        if limited and claim.published is not None:
            assert claim.at_least is None or claim.at_least <= claim.published
            assert claim.at_most is None or claim.published <= claim.at_most


def test_what_does_not_agree_has_a_reason_and_nothing_else_has() -> None:
    for item in comparisons(steady_tables()):
        assert item.agrees == (not item.published.reason), item.published.claim.id
        assert (item.finding is None) == (not item.published.claim.measure)


def test_what_stands_beside_the_tables_is_what_is_published() -> None:
    for number in published_numbers():
        assert bool(number.column) == bool(number.gains) == bool(number.beside)
        if number.beside.replace(".", "").isdigit():
            scale = 1.0 if number.claim.unit == "m" else 100.0
            assert float(number.beside) == pytest.approx(scale * (number.claim.published or math.nan))
    assert BY_ID["plate.slope"].claim.published == ESTIMATED_OVER_MEASURED


def test_an_apex_between_is_on_the_line() -> None:
    assert [apex_between_m(gain) for gain in (100, 200, 300, 400)] == pytest.approx([0.256, 0.335, 0.414, 0.493])


@pytest.mark.skipif(not RESULTS.is_file(), reason="the collected results lie beside the project: ../shared/reference")
def test_numbers_of_the_collected_results_are_carried_over() -> None:
    with RESULTS.open(encoding="utf-8", newline="") as file:
        rows = {row["id"]: row for row in csv.DictReader(file) if row["id"].startswith(("emu.", "plate."))}
    assert set(rows) - set(BY_ID) == {"plate.window"}  # how the plate's forces were smoothed, not a result
    for name in set(rows) & set(BY_ID):
        claim = BY_ID[name].claim
        assert (claim.where, claim.published) == (rows[name]["section"], float(rows[name]["value"]))
        assert claim.unit == {"fraction": "1"}.get(rows[name]["unit"], rows[name]["unit"])


def made_up(apexes_m: list[float], costs_j: list[float]) -> SteadyTables:
    """Tables with these apexes under every controller, and these joules under constant damping where CE takes 1 J."""
    tables = steady_tables()
    like = tables.emulator.rows[0]
    rows = []
    for gain, apex_m, cost_j in zip(GAINS, apexes_m, costs_j, strict=True):
        ce = replace(like.ce, apex_height_m=apex_m, cost_j=1.0)
        rows.append(EmulatorRow(gain, ce, ce, replace(ce, cost_j=cost_j), like.yielding))
    return replace(tables, emulator=EmulatorTable(tables.emulator.scene, tuple(rows)))


heights = st.lists(st.floats(0.2, 0.6), min_size=5, max_size=5)


@given(st.floats(0.2, 0.3), st.floats(0.01, 0.1), st.floats(0.2, 0.6))
def test_apexes_on_a_line_have_no_distance_from_it_wherever_the_excluded_one_is(
    lowest_m: float, step_m: float, stiffest_m: float
) -> None:
    apexes_m = [*(lowest_m + step_m * place for place in range(4)), stiffest_m]
    found = made_up(apexes_m, [0.9] * 5)
    assert MEASURES["emu.apex_line"](found) == pytest.approx(np.zeros(3), abs=1e-9)
    assert MEASURES["emu.apex_plateau"](found) == pytest.approx(np.full(3, stiffest_m - apexes_m[3]))


@given(heights, st.lists(st.floats(0.5, 1.5), min_size=5, max_size=5))
def test_savings_and_their_changes_are_those_of_the_analysed_gains(apexes_m: list[float], costs_j: list[float]) -> None:
    found = made_up(apexes_m, costs_j)
    saved = 1.0 - np.array(costs_j)
    assert MEASURES["emu.saving_constant_low"](found) == pytest.approx(saved[:1])
    assert MEASURES["emu.saving_constant_high"](found) == pytest.approx(saved[3:4])
    assert MEASURES["emu.saving_constant_falls"](found) == pytest.approx(np.diff(saved[:4]))
    assert MEASURES["emu.improves"](found)[:, 1] == pytest.approx(saved)
    assert MEASURES["emu.apex_loss"](found) == pytest.approx(np.zeros(8))


def jump(gain: float, **values: float) -> JumpResult:
    return simulate(load_scene("emulator").changed({"k_extension": stiffness_n_m(gain), **values})).jump


def test_the_reasons_say_what_the_simulation_gives() -> None:
    scene, rows = load_scene("emulator"), steady_tables().emulator.rows
    # emu.apex_high, emu.apex_plateau
    lengths_m = np.linspace(scene["guard_length"], scene["rest_length"], 20_001)
    push_n = [2 * scene["stall_torque"] / lever_m(scene["upper_link"], scene["lower_link"], r) for r in lengths_m]
    work_j = float(np.trapezoid(push_n, lengths_m))
    assert f"{work_j:.1f} J of work" in BY_ID["emu.apex_high"].reason
    assert [row.gain for row in rows if row.ce.capped_time_s > 0.0] == [400.0, 500.0]
    at_400, at_500 = (
        [jump(gain, stall_torque=torque).apex_height_m or 0.0 for torque in (3, 3.5, 4)] for gain in (400, 500)
    )
    assert at_400 == sorted(at_400)
    assert at_500 == sorted(at_500)
    assert all(stiff < stiffest - 0.007 for stiff, stiffest in zip(at_400, at_500, strict=True))
    assert [bool(jump(gain).counters["guard_switch"]) for gain in GAINS] == [False, True, True, True, True]
    # emu.saving_scaled
    assert 1.0 - jump(100, b_ad=active_damping_kg_m(1000)).cost_J / rows[0].ce.cost_j < 0.1
    power_w = scene["passive_power"]
    for row in rows:
        drawn = [item.cost_j + power_w * item.period_s for item in (row.ce, row.scaled)]
        assert 1.0 - drawn[1] / drawn[0] < row.scaled_saving
    # emu.saving_constant_high
    saved = [1.0 - jump(400, b_ad=active_damping_kg_m(gain)).cost_J / rows[3].ce.cost_j for gain in (0, 50, 100, 150)]
    slopes = np.diff(saved)
    assert (slopes > 0.0).all()
    assert (np.diff(slopes) < 0.0).all()
    # emu.saving_constant_falls
    shares = [row.yielding.heat_j / row.ce.cost_j for row in rows]
    assert np.argsort(shares).tolist() == np.argsort([row.constant_saving for row in rows]).tolist()


def bed(**values: float) -> dict[tuple[str, float], tuple[float, list[float]]]:
    """Pooled saving and apexes gained of each foot and extension gain on a changed bed."""
    found = {}
    for foot, radius_m in FEET_M.items():
        for gain in BED_GAINS:
            changed = {**values, "foot_radius": radius_m, "k_extension": stiffness_n_m(gain)}
            ce, *ad = (
                simulate(load_scene("bed").changed({**changed, "b_ad": fitted_active_damping_kg_m(damping)})).jump
                for damping in (0.0, *BED_DAMPING_GAINS)
            )
            saving = 1.0 - float(np.mean([item.cost_J for item in ad])) / ce.cost_J
            found[foot, gain] = saving, [(item.apex_height_m or 0.0) - (ce.apex_height_m or 0.0) for item in ad]
    return found


def test_the_reasons_of_the_bed_say_what_the_simulation_gives() -> None:
    table = steady_tables().bed
    capped = {
        key: [1e3 * row.capped_time_s for row in table.of(*key, (0.0, *BED_DAMPING_GAINS))] for key in COMBINATIONS
    }
    pooled = {key: 100 * table.saving(*key) for key in COMBINATIONS}
    small_stiff, small_soft, large_stiff, large_soft = COMBINATIONS
    stronger = bed(stall_torque=2 * table.scene["stall_torque"])
    softer = bed(kg_scale=table.scene["kg_scale"] / 2)
    # bed.saving_best
    reason = BY_ID["bed.saving_best"].reason
    assert f"for {capped[small_stiff][0]:.0f} ms" in reason
    assert f"the saving is {100 * stronger[small_stiff][0]:.1f} %" in reason
    assert f"the large foot saves {100 * stronger[large_stiff][0]:.1f} %" in reason
    least, most = (1e3 * -end(stronger[large_stiff][1]) for end in (max, min))
    assert f"{least:.0f} to {most:.0f} mm lower" in reason
    assert f"it is {100 * softer[small_stiff][0]:.1f} %" in reason
    assert f"the large foot saves {100 * softer[large_stiff][0]:.1f} %" in reason
    # bed.least_combination
    reason = BY_ID["bed.least_combination"].reason
    assert min(pooled, key=pooled.__getitem__) == large_stiff
    assert f"{pooled[large_stiff]:.1f} % against {pooled[large_soft]:.1f} %" in reason
    assert max(capped.values())[0] == capped[large_stiff][0]
    assert f"{capped[large_stiff][0]:.0f} ms against {capped[large_soft][0]:.0f} ms" in reason
    assert max(stronger, key=lambda key: stronger[key][0]) == large_stiff
    # bed.small_foot
    savings = [[row.saving for row in table.of(*key)] for key in (small_soft, large_soft)]
    differences = 100 * np.subtract(*savings)
    assert (np.diff(differences) < 0.0).all()
    assert f"from {differences[0]:.1f} percentage points" in BY_ID["bed.small_foot"].reason
    assert f"to {-differences[-1]:.1f} against" in BY_ID["bed.small_foot"].reason
    # bed.elbow
    reason = BY_ID["bed.elbow"].reason
    for key in COMBINATIONS:
        assert table.of(*key)[-1].saving > table.of(*key)[-2].saving
        assert np.diff(capped[key][1:]).max() < 1e-9
    assert f"for {max(times[1] for times in capped.values()):.0f} ms of" in reason
    ends = sorted(times[0] for times in capped.values())
    assert f"it is {ends[0]:.0f} to {ends[-1]:.0f} ms" in reason
    # bed.apex_gain
    reason = BY_ID["bed.apex_gain"].reason
    small, large = ([1e3 * row.apex_gain_m for gain in BED_GAINS for row in table.of(foot, gain)] for foot in FEET_M)
    assert f"gains {min(small):.1f} to {max(small):.1f} mm" in reason
    assert f"loses {-max(large):.1f} to {-min(large):.1f} mm" in reason
    small, large = ([1e3 * gained for gain in BED_GAINS for gained in softer[foot, gain][1]] for foot in FEET_M)
    assert f"gains {min(small):.0f} to {max(small):.0f} mm" in reason
    assert f"loses {-max(large):.0f} to {-min(large):.0f} mm" in reason
