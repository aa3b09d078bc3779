"""Both apex detectors on whole logs of known jumps: numbers, heights, bias, gaps, hands, and whatever a log holds."""

import json
import math
from dataclasses import asdict, replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused, UnknownName
from data_schema.vocabulary import Undefined
from stats.apexes.detectors import DETECTORS, PublishedParameters, RobustParameters, find_jumps, smoothing_bias_m
from stats.apexes.jumps import FLAGS
from tests.helpers.wording import refuses, says

REST_LENGTH_M = 0.27


def measured(log, sd_m=0.001, seed=0):
    return log.height_m + np.random.default_rng(seed).normal(0.0, sd_m, log.height_m.size)


def jumps_of(log, height_m=None, *, leg=True, **options):
    height = measured(log) if height_m is None else height_m
    return find_jumps(
        log.time_s, height, rest_length_m=REST_LENGTH_M, leg_length_m=log.leg_m if leg else None, **options
    )


def height_errors(found, log):
    pairs = zip(found.jumps, log.apex_height_m, strict=True)
    return np.array([jump.apex_height_m - truth for jump, truth in pairs if isinstance(jump.apex_height_m, float)])


@pytest.mark.parametrize("leg", [True, False])
@pytest.mark.parametrize("detector", DETECTORS)
def test_a_bed_log_has_exactly_its_jumps(bed_log, detector, leg):
    log = bed_log(misfires=(4, 15))
    found = jumps_of(log, detector=detector, leg=leg)
    assert len(found.jumps) == 25
    assert [jump.number for jump in found.jumps if jump.undefined_reason] == [4, 15]
    assert found.apex_times_s == pytest.approx(log.apex_s[~np.isnan(log.apex_s)], abs=0.02)
    for jump in found.jumps:
        assert set(jump.flags) <= set(FLAGS)
        assert (jump.samples_used == 0) == isinstance(jump.apex_height_m, Undefined)
        assert not jump.gap_touched


@pytest.mark.parametrize("detector", DETECTORS)
def test_an_emulator_log_has_an_apex_for_every_jump(emulator_log, detector):
    log = emulator_log(100)
    found = jumps_of(log, detector=detector)
    assert len(found.with_apex) == 100
    assert found.apex_times_s == pytest.approx(log.apex_s, abs=0.02)
    seen = [jump.flight_time_s for jump in found.jumps if "landing_extrapolated" not in jump.flags]
    truth = log.touchdown_s[1:] - log.liftoff_s[:-1]
    assert seen == pytest.approx(list(truth), abs=0.01)


@pytest.mark.parametrize("make", ["bed", "emulator"])
@pytest.mark.parametrize(("rate_hz", "bias_m", "rmse_m"), [(1000.0, 0.02e-3, 0.2e-3), (300.0, 0.03e-3, 0.3e-3)])
@pytest.mark.parametrize("spoilt", [pytest.param(False, marks=pytest.mark.soak), True])
def test_robust_heights_of_whole_logs(bed_log, emulator_log, make, rate_hz, bias_m, rmse_m, spoilt):
    """1 mm of noise; spoilt: 10 % dropouts to zero and 2 % spikes. Catches begin 25 to 60 ms after the apex."""
    errors, scores = [], []
    for seed in range(4):
        rng = np.random.default_rng(100 + seed)
        short = {"rest_s": (0.3, 0.5)}  # only the jumps matter here
        made = partial(bed_log, 50, **short) if make == "bed" else partial(emulator_log, 100)
        log = made(rate_hz=rate_hz, seed=seed)
        height = measured(log, seed=seed)
        if spoilt:
            hit = rng.random(height.size) < 0.02
            height[hit] += rng.choice([-1.0, 1.0], int(hit.sum())) * rng.uniform(0.05, 0.45, int(hit.sum()))
            height[rng.random(height.size) < 0.1] = 0.0
        found = jumps_of(log, height)
        assert len(found.with_apex) == log.apex_s.size
        errors.append(height_errors(found, log))
        scores.append(errors[-1] / [jump.apex_height_se_m for jump in found.with_apex])
    pooled = np.concatenate(errors)
    assert abs(pooled.mean()) < bias_m + 2.0 * pooled.std() / pooled.size**0.5
    assert np.sqrt(np.mean(pooled**2)) < rmse_m
    assert np.sqrt(np.mean(np.concatenate(scores) ** 2)) == pytest.approx(1.0, abs=0.15)


def test_published_heights_are_low_by_the_known_bias(emulator_log):
    """g (w / fs)^2 / 24 = 0.454 mm at 300 Hz and 10 samples; without noise nothing else is left."""
    log = emulator_log(100)
    found = jumps_of(log, log.height_m, detector="published")
    assert found.smoothing_bias_m == pytest.approx(0.454e-3, rel=1e-3)
    assert height_errors(found, log).mean() == pytest.approx(-found.smoothing_bias_m, rel=0.03)
    assert jumps_of(log, detector="robust").smoothing_bias_m == 0.0
    for rate_hz, width, bias_mm in ((100.0, 5, 1.0219), (200.0, 51, 26.579), (1000.0, 51, 1.0632)):
        assert 1000.0 * smoothing_bias_m(width, 1.0 / rate_hz, 9.81) == pytest.approx(bias_mm, rel=1e-3)


def test_touchdown_and_liftoff(bed_log):
    log = bed_log(25)
    with_leg, without = jumps_of(log), jumps_of(log, leg=False)
    assert [jump.touchdown_s for jump in with_leg.jumps] == pytest.approx(list(log.touchdown_s), abs=0.003)
    assert [jump.touchdown_s for jump in without.jumps] == pytest.approx(list(log.touchdown_s), abs=0.003)
    assert [jump.liftoff_s for jump in with_leg.jumps] == pytest.approx(list(log.liftoff_s), abs=0.004)
    late = np.array([jump.liftoff_s for jump in without.jumps]) - log.liftoff_s
    assert abs(np.median(late)) < 0.01
    assert np.max(np.abs(late)) < 0.05
    for jump in with_leg.jumps:
        assert jump.touchdown_s < jump.liftoff_s < jump.apex_s < jump.liftoff_s + jump.flight_time_s
        assert "landing_extrapolated" in jump.flags  # a hand catches it: its landing is read off the parabola
        falling_s = math.sqrt(2.0 * (jump.apex_height_m - REST_LENGTH_M) / 9.80665)
        assert jump.flight_time_s == pytest.approx(jump.apex_s - jump.liftoff_s + falling_s, abs=0.01)


def test_a_jump_whose_flight_touches_a_gap_is_marked_and_no_other(bed_log):
    """A gap while the leg stood on the ground was counted too, and cost jumps whose height and flight are whole."""
    log = bed_log(6)
    height = measured(log)
    # In flight, early in stance, over the lift-off, and on the clamp, which is no jump.
    holes = [log.apex_s[1] - 0.04, log.touchdown_s[2] + 0.1, log.liftoff_s[3] - 0.03, log.apex_s[4] + 1.5]
    kept = np.ones(log.time_s.size, dtype=bool)
    for hole in holes:
        kept &= (log.time_s < hole) | (log.time_s > hole + 0.02)
    for detector in DETECTORS:
        holed = replace(log, time_s=log.time_s[kept], leg_m=log.leg_m[kept])
        found = jumps_of(holed, height[kept], detector=detector)
        assert [jump.gap_touched for jump in found.jumps] == [False, True, False, True, False, False]
        assert len(found.with_apex) == 6
        assert abs(height_errors(found, log)[2]) < 0.002
    stated = jumps_of(log, height, gaps=[[hole, 0.02] for hole in holes])
    assert [jump.gap_touched for jump in stated.jumps] == [False, True, False, True, False, False]
    assert not any(jump.gap_touched for jump in jumps_of(log, height, gaps=()).jumps)
    over = np.abs(log.time_s - log.apex_s[1]) > 0.06
    lost = jumps_of(replace(log, time_s=log.time_s[over], leg_m=log.leg_m[over]), height[over]).jumps[1]
    assert lost.gap_touched
    says(lost.undefined_reason, "samples are missing")
    height[np.abs(log.time_s - log.apex_s[2]) < 0.01] = 0.0  # a dropout over the apex makes no peaks
    assert abs(height_errors(jumps_of(log, height), log)[2]) < 0.001


@pytest.mark.parametrize("leg", [True, False])
@pytest.mark.parametrize("detector", DETECTORS)
def test_gaps_from_shortly_before_liftoff_to_shortly_after_landing_count(emulator_log, detector, leg):
    log = emulator_log(4)
    whole = jumps_of(log, leg=leg, detector=detector)
    jump, following = whole.jumps[1:3]

    def marked(at_s):
        found = jumps_of(log, gaps=[[at_s, 0.005]], leg=leg, detector=detector)
        return [each.number for each in found.jumps if each.gap_touched]

    assert marked(jump.liftoff_s - 0.06) == []
    assert marked(jump.liftoff_s - 0.012) == [2]
    assert marked(jump.apex_s) == [2]
    assert marked(following.touchdown_s + 0.005) == [2]
    assert marked(following.touchdown_s + 0.05) == []


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize("leg", [True, False])
@pytest.mark.parametrize(("rate_hz", "sd_m"), [(100.0, 0.003), (1000.0, 0.005)])
def test_a_hop_of_any_height_is_a_flight(bed_log, emulator_log, detector, leg, rate_hz, sd_m):
    """Rises of 0.53 to 1.2 m, up to the rail at 1.5 m: above 0.58 m the fall comes later than 0.35 s."""
    for make in (bed_log, emulator_log):
        log = make(15, rate_hz=rate_hz, apex_m=(0.8, 1.45))
        found = jumps_of(log, measured(log, sd_m), detector=detector, leg=leg)
        assert [jump.number for jump in found.jumps if jump.undefined_reason is None] == list(range(1, 16))
        assert found.apex_times_s == pytest.approx(log.apex_s, abs=0.03)
        assert np.abs(height_errors(found, log)).max() < 0.02


@pytest.mark.parametrize("lift_s", [0.5, 0.7, 1.0, 1.5])
def test_a_hand_that_lifts_high_and_lets_go_is_no_flight(bed_log, lift_s):
    """After a misfire the robot is lifted by 0.6 m, held and dropped: higher than a hop, and slower."""
    log = bed_log(3, misfires=(2,))
    since = log.time_s - log.touchdown_s[1] - 0.6
    share = np.clip(since / lift_s, 0.0, 1.0)
    lifted = np.where((since > 0.0) & (since < lift_s + 0.3), 0.2 + 0.6 * share**2 * (3.0 - 2.0 * share), log.height_m)
    for detector in DETECTORS:
        found = jumps_of(log, measured(replace(log, height_m=lifted)), leg=False, detector=detector)
        says(found.jumps[1].undefined_reason, "not fall again")


def test_what_one_jump_says_does_not_depend_on_when_it_was(bed_log):
    log = bed_log(5)
    here, later = jumps_of(log), jumps_of(replace(log, time_s=log.time_s + 2.0**20))
    assert later.apex_heights_m == pytest.approx(here.apex_heights_m, abs=1e-9)
    assert later.apex_times_s - 2.0**20 == pytest.approx(here.apex_times_s, abs=1e-6)


def test_a_hand_that_throws_is_not_gravity(bed_log):
    """After a misfire the hand lifts, stops and lowers again: a maximum, but not a ballistic one."""
    log = bed_log(3, misfires=(2,))
    since = log.time_s - log.touchdown_s[1] - 0.6
    tossed = np.where((since > 0.0) & (since < 0.5), 0.2 + 0.11 * np.sin(np.pi * since / 0.5), log.height_m)
    noisy = measured(replace(log, height_m=tossed))
    robust, published = (jumps_of(log, noisy, leg=False, detector=name) for name in ("robust", "published"))
    says(robust.jumps[1].undefined_reason, "is not gravity")
    assert published.jumps[1].undefined_reason is None


def test_parameters_are_plain_numbers_and_belong_to_their_detector(bed_log):
    log = bed_log(2)
    for name, detector in DETECTORS.items():
        assert detector.name == name
        assert json.loads(json.dumps(asdict(detector.parameters)))
    wide = jumps_of(log, detector="published", parameters=PublishedParameters(window_samples=40))
    assert wide.smoothing_bias_m > 10.0 * jumps_of(log, detector="published").smoothing_bias_m
    with pytest.raises(InputRefused, match="PublishedParameters"):
        jumps_of(log, detector="published", parameters=RobustParameters())
    with pytest.raises(InputRefused, match="1 or more"):
        PublishedParameters(window_samples=0)
    with refuses(UnknownName, "'robust'"):
        jumps_of(log, detector="robost")
    with pytest.raises(InputRefused, match="rest length"):
        find_jumps([0.0, 1.0], [0.3, 0.3], rest_length_m=0.0)


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize(
    "height_m", [[], [0.3], [0.3] * 50, [math.nan] * 50, [0.0] * 50, [0.3, 0.1] * 25, list(np.linspace(0.5, 0.1, 50))]
)
def test_logs_without_a_jump_have_none(detector, height_m):
    found = find_jumps(np.arange(len(height_m)) / 300.0, height_m, rest_length_m=REST_LENGTH_M, detector=detector)
    assert len(found.with_apex) == 0


@given(
    st.lists(st.sampled_from([0.0, 0.1, 0.2, 0.26, 0.28, 0.3, 0.35, 0.46, 2.0, math.nan]), min_size=1, max_size=40),
    st.integers(1, 30),
    st.sampled_from(sorted(DETECTORS)),
    st.booleans(),
)
def test_whatever_a_log_holds_the_jumps_are_consistent(levels, held, detector, leg):
    height = np.repeat(levels, held)
    time_s = np.arange(height.size) / 300.0
    leg_m = np.where(np.isnan(height), np.nan, np.minimum(np.nan_to_num(height), 0.27)) if leg else None
    found = find_jumps(time_s, height, rest_length_m=REST_LENGTH_M, leg_length_m=leg_m, detector=detector)
    for number, jump in enumerate(found.jumps, 1):
        assert jump.number == number
        for value in (jump.apex_s, jump.apex_height_m, jump.touchdown_s, jump.liftoff_s, jump.flight_time_s):
            assert isinstance(value, Undefined) or math.isfinite(value)
        assert isinstance(jump.apex_s, Undefined) == isinstance(jump.apex_height_m, Undefined)
