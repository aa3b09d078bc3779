"""Single jumps on a plate: against simulated jumps of known height, and what published rules give for real ones."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from data_schema.reasons import Reason
from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import Undefined
from stats.single_jump import (
    ONSETS,
    TAKE_OFFS,
    SingleJump,
    Standing,
    find_jumps,
    measure_jump,
    speed_m_s,
    take_off_sample,
    weigh,
)
from tests.helpers.single_jumps import DEEP, SQUAT, SimulatedJump
from tests.stats.test_force_plate import Hops

Floats = NDArray[np.float64]
SAMPLES = Path(__file__).parents[3] / "shared" / "samples" / "single_jumps"
RATE_HZ = 1200.0
PUBLISHED_GRAVITY_M_S2 = 9.81
needs_samples = pytest.mark.skipif(
    not SAMPLES.is_dir(), reason="the sample files lie beside the project: ../shared/samples"
)


def every_jump(time_s: Floats, force_n: Floats, *rules: str) -> list[SingleJump]:
    """The jumps of a record, by rules of onset and take-off."""
    found = find_jumps(time_s, force_n)
    assert isinstance(found, tuple), found
    results = [measure_jump(jump, *rules) for jump in found]
    return [result for result in results if isinstance(result, SingleJump)]


def measured(time_s: Floats, force_n: Floats, *rules: str) -> SingleJump:
    """The one jump of a record."""
    (result,) = every_jump(time_s, force_n, *rules)
    return result


def why(time_s: Floats, force_n: Floats) -> Reason:
    found = find_jumps(time_s, force_n)
    assert isinstance(found, Undefined), found
    return found.code


ROBOT = {"mass_kg": 2.0, "slower": 0.5, "rate_hz": 1000.0, "sway_n": 0.05}
CONDITIONS: dict[str, dict[str, Any]] = {
    "still": {"sway_n": 0.0},
    "swaying": {},
    "swaying much": {"sway_n": 5.0},
    "noisy plate": {"noise_n": 5.0},
    "converter's steps": {"noise_n": 0.3, "step_n": 1.4},
    "drift up": {"drift_n_s": 0.5},
    "drift down": {"drift_n_s": -0.5},
    "offset": {"offset_n": -45.0, "drift_n_s": 0.1},
    "500 Hz": {"rate_hz": 500.0},
    "deep": {"shape": DEEP},
    "squat": {"shape": SQUAT},
    "short standing": {"quiet_s": 1.1},
    "robot": {**ROBOT, "noise_n": 0.2},
    "robot on a noisy plate": {**ROBOT, "noise_n": 1.0},
}
MOST_BIAS_M = {"noisy plate": 0.012, "robot on a noisy plate": 0.015, "drift up": 0.008, "swaying much": 0.007}


@pytest.mark.parametrize("name", CONDITIONS)
def test_the_truth_is_within_two_standard_errors_as_often_as_it_should_be(name: str) -> None:
    """Of 60 jumps each; and an error is not stated four times as large as it is."""
    off, stated = np.zeros((60, 5)), np.zeros((60, 5))
    names = ("height_m", "flight_height_m", "push_off_s", "weight_n", "peak_n")
    for seed in range(60):
        true = SimulatedJump(seed, **CONDITIONS[name])
        found = measured(true.time_s, true.force_n)
        truth = {one: getattr(true, one.removeprefix("flight_")) for one in names}
        off[seed] = [getattr(found, one) - truth[one] for one in names]
        stated[seed] = [getattr(found, re.sub("_(m|s|n)$", r"_se_\1", one)) for one in names]
    covered = np.mean(np.abs(off) <= 1.96 * stated, axis=0)
    assert (covered[:4] >= 0.9).all(), covered
    assert covered[4] >= (0.7 if "steps" in name else 0.9)  # steps of 1.4 N hide a noise of 0.3 N
    assert abs(off[:, 0].mean()) < MOST_BIAS_M.get(name, 0.005)
    assert np.sqrt(np.mean(stated[:, 0] ** 2)) < 4.0 * np.sqrt(np.mean(off[:, 0] ** 2))


@pytest.mark.parametrize("sway_n", [0.0, 2.0])
def test_steps_of_a_converter_that_no_noise_evens_out_are_part_of_the_error(sway_n: float) -> None:
    """Steps of 10 N put the weight up to 5 N, and a jump of 0.32 m up to 22 mm, off."""
    random = np.random.default_rng(6)
    off, stated = [], []
    for seed in range(60):
        mass_kg, offset_n = random.uniform(50.0, 70.0), random.uniform(-10.0, 10.0)
        true = SimulatedJump(seed, mass_kg=mass_kg, offset_n=offset_n, noise_n=0.0, sway_n=sway_n, step_n=10.0)
        found = measured(true.time_s, true.force_n)
        off.append([found.height_m - true.height_m, found.weight_n - true.weight_n, found.peak_n - true.peak_n])
        stated.append([found.height_se_m, found.weight_se_n, found.peak_se_n])
    assert (np.mean(np.abs(off) <= 1.96 * np.array(stated), axis=0) >= 0.9).all()
    assert (np.mean(np.square(stated), axis=0) < 4.0**2 * np.mean(np.square(off), axis=0)).all()


LEAST_BIAS_M = {"5sd_back_30ms flight_5sd": 0.0, "10_percent flight_5sd": 0.008, "5sd_back_30ms 20_percent": 0.015}


@pytest.mark.parametrize("onset", ONSETS)
@pytest.mark.parametrize("take_off", TAKE_OFFS)
def test_every_rule_states_an_error_that_covers_what_it_is_off_by(onset: str, take_off: str) -> None:
    """By 2 mm to 35 mm: the later the onset and the higher the threshold of take-off, the higher the jump.

    The rules that are used unless others are named are off least.
    """
    off, stated = [], []
    for seed in range(30):
        true = SimulatedJump(seed)
        found = measured(true.time_s, true.force_n, onset, take_off)
        off.append(found.height_m - true.height_m)
        stated.append(found.height_se_m)
    assert -0.01 < min(off) <= max(off) < 0.06
    assert np.mean(np.abs(off) <= 1.96 * np.array(stated)) >= 0.9
    rules = f"{onset} {take_off}"
    assert LEAST_BIAS_M.get(rules, -1.0) < np.mean(off) < (0.004 if rules == "5sd_back_30ms flight_5sd" else 0.06)


def test_several_jumps_on_a_plate_that_is_empty_before_and_after() -> None:
    """Four with quiet standing between; and twice a body steps onto the plate, stands, jumps, stands, and steps off."""
    made = [SimulatedJump(seed, after_s=0.6) for seed in range(4)]
    true, step, random = SimulatedJump(1), np.linspace(0.0, 1.0, 240), np.random.default_rng(0)
    empty, around = np.zeros(2400), true.weight_n * step
    before_n, after_n = np.concatenate([empty, around]), np.concatenate([around[::-1], empty])
    before_n, after_n = (part + random.normal(0.0, 1.0, part.size) for part in (before_n, after_n))
    for parts, wanted in (([one.force_n for one in made], made), (2 * [before_n, true.force_n, after_n], [true, true])):
        force_n = np.concatenate(parts)
        found = every_jump(np.arange(force_n.size) / RATE_HZ, force_n)
        assert [jump.height_m for jump in found] == pytest.approx([one.height_m for one in wanted], abs=0.02)


def test_a_record_that_ends_in_flight_has_a_height_by_impulse_alone() -> None:
    true = SimulatedJump(2)
    kept = true.time_s < true.take_off_s + 0.3
    found = measured(true.time_s[kept], true.force_n[kept])
    assert found.height_m == pytest.approx(true.height_m, abs=0.015)
    assert isinstance(found.flight_height_m, Undefined)
    assert found.flight_height_m.code is Reason.NO_LANDING


@pytest.mark.parametrize("share", [-0.01, 0.1, 0.5, 0.9, 0.99, 1.02])
@pytest.mark.parametrize("blank", [True, False])
def test_samples_missing_in_the_flight_are_no_landing(share: float, blank: bool) -> None:
    """Twelve of them made a flight of 0.5 s one of 0.02 s; those at take-off leave no push-off to measure."""
    true = SimulatedJump(3)
    first = int((true.take_off_s + share * (true.landing_s - true.take_off_s)) * RATE_HZ)
    hole = slice(first, first + 12)
    time_s, force_n = true.time_s, true.force_n.copy()
    force_n[hole] = np.nan
    if not blank:
        time_s, force_n = np.delete(time_s, hole), np.delete(force_n, hole)
    if share < 0.0:
        assert why(time_s, force_n) is Reason.NO_QUIET_STANDING
        return
    found = measured(time_s, force_n)
    assert found.height_m == pytest.approx(true.height_m, abs=1.96 * found.height_se_m)
    assert isinstance(found.flight_height_m, Undefined)
    assert found.flight_height_m.code is Reason.NO_LANDING


def test_what_is_no_jump_has_no_height() -> None:
    true = SimulatedJump(3)
    quick = true.time_s > true.onset_s - 0.5
    assert why(true.time_s[quick] - true.time_s[quick][0], true.force_n[quick]) is Reason.NO_QUIET_STANDING
    standing = true.time_s < true.onset_s
    assert isinstance(find_jumps(true.time_s[standing], true.force_n[standing]), Undefined)
    stepped_off = np.concatenate([true.force_n[standing], true.weight_n * np.linspace(1.0, 0.0, 300), np.zeros(600)])
    assert why(np.arange(stepped_off.size) / RATE_HZ, stepped_off) is Reason.NO_TAKE_OFF
    missing_n = true.force_n.copy()
    missing_n[np.searchsorted(true.time_s, true.onset_s + 0.3)] = np.nan
    assert why(true.time_s, missing_n) is Reason.NO_QUIET_STANDING
    hops = Hops(10)
    assert why(hops.time_s, hops.noisy_n()) is Reason.NO_QUIET_STANDING


def test_a_rule_that_does_not_fit_the_jump_says_so() -> None:
    squat, robot = SimulatedJump(4, shape=SQUAT), SimulatedJump(4, **ROBOT, noise_n=0.2)
    for true, rules, code in (
        (squat, ("10_percent", "flight_5sd"), Reason.NO_ONSET),
        (robot, ("5sd_back_30ms", "50n"), Reason.THRESHOLD_ABOVE_WEIGHT),
    ):
        found = find_jumps(true.time_s, true.force_n)
        assert isinstance(found, tuple)
        result = measure_jump(found[0], *rules)
        assert isinstance(result, Undefined)
        assert result.code is code


# Real jumps ----------------------------------------------------------------------------------------------------------


def published() -> list[dict[str, str]]:
    """What published variants give for the four real jumps; no rows without the samples."""
    path = SAMPLES / "published_variants.csv"
    return list(csv.DictReader(path.read_text().splitlines())) if path.is_file() else []


def recorded(row: dict[str, str]) -> Floats:
    return np.loadtxt(SAMPLES / f"subject01_trial{row['trial']}.force.txt")


@needs_samples
@pytest.mark.parametrize("trial", range(4))
def test_onsets_take_offs_and_heights_of_real_jumps_are_the_published_ones(trial: int) -> None:
    """Sample by sample, with each variant's own window of standing; its 5 SD to either side take no 30 ms back."""
    row = published()[trial]
    force_n = recorded(row)
    peak = int(np.argmax(force_n[: int(row["takeoff_jm"])]))
    half_second, quarter = force_n[:600], weigh(force_n, 0, 300)
    middling = Standing(0, 600, float(np.median(half_second)), float(half_second.std()))
    quietest = quietest_second(force_n, int(row["takeoff_jm"]))
    assert f"{quarter.weight_n:.9f}" == f"{float(row['bw_025']):.9f}"
    assert f"{quietest.weight_n:.9f}" == f"{float(row['bw_lowvar']):.9f}"
    low = np.flatnonzero(force_n[peak:] <= 10.0) + peak
    edge = int(0.25 * (low[-1] - low[0]))
    flight_n = force_n[low[0] + edge : low[-1] - edge]
    for onset, standing, later, column in (
        ("5sd_back_30ms", middling, 36, "bilalovski"),
        ("5sd_back_to_weight", quietest, 0, "sams_bw"),
        ("10_percent", quarter, 0, "pct10bw"),
    ):
        begin = ONSETS[onset](force_n, standing, peak, RATE_HZ)
        assert begin is not None
        assert begin + later == int(row[f"onset_{column}"])
        speed = speed_m_s(force_n, quarter, begin + later, int(row["takeoff_jm"]), RATE_HZ)
        height_m = speed**2 / (2.0 * STANDARD_GRAVITY_M_S2) * PUBLISHED_GRAVITY_M_S2 / STANDARD_GRAVITY_M_S2
        assert 100.0 * height_m == pytest.approx(float(row[f"jh_{column}_cm"]), rel=1e-14)
    for take_off, column in (
        ("flight_5sd", "sams"),
        ("10n", "jm"),
        ("50n", "labanalysis"),
        ("20_percent", "bilalovski"),
    ):
        threshold_n = TAKE_OFFS[take_off](middling.weight_n, flight_n)
        assert take_off_sample(force_n, peak, threshold_n) == int(row[f"takeoff_{column}"])


def quietest_second(force_n: Floats, stop: int) -> Standing:
    windows = np.lib.stride_tricks.sliding_window_view(force_n[:stop], 1200)
    start = int(np.argmin(windows.var(axis=1)))
    return weigh(force_n, start, start + 1200)


@needs_samples
@pytest.mark.parametrize("trial", range(4))
def test_a_real_jump_agrees_with_published_heights_within_its_error(trial: int) -> None:
    """Weighed elsewhere and with the plate's offset they are 41.2, 43.4, 42.9 and 41.9 cm; the take-off is theirs."""
    row = published()[trial]
    force_n = recorded(row)
    found = measured(np.arange(force_n.size) / RATE_HZ, force_n)
    assert round(found.take_off_s * RATE_HZ) == int(row["takeoff_sams"])
    assert abs(found.onset_s * RATE_HZ - int(row["onset_sams_30ms"])) <= 21
    assert found.height_m == pytest.approx(float(row["jh_sams_30ms_cm"]) / 100.0, abs=1.96 * found.height_se_m)
    if trial == 0:
        assert found.flight_height_m == pytest.approx(0.436, abs=0.001)
    else:
        assert isinstance(found.flight_height_m, Undefined)
