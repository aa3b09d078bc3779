"""What of a height signal is no measurement: dropouts, spikes, rails, held values; and the clock's rate."""

import numpy as np
import pytest

from data_schema.errors import InputRefused
from stats.apexes.cleaning import CleaningParameters, clean_signal, gaps_in_time, sampling_interval

NO_GAPS = np.empty((0, 2))


def cleaned(time_s, height_m, gaps=NO_GAPS, leg_m=None):
    return clean_signal(time_s, height_m, leg_m, np.asarray(gaps, dtype=float), CleaningParameters())


def swing(rate_hz=300.0, seconds=4.0, noise_m=0.001, seed=0):
    time_s = np.arange(0.0, seconds, 1.0 / rate_hz)
    height_m = 0.3 + 0.1 * np.sin(2 * np.pi * 1.5 * time_s)
    return time_s, height_m + np.random.default_rng(seed).normal(0.0, noise_m, time_s.size)


def test_dropouts_rails_and_missing_values_are_left_out():
    time_s, height_m = swing()
    clean = cleaned(time_s, height_m, leg_m=time_s.copy())
    assert np.array_equal(clean.height_m, height_m)
    assert clean.noise_sd_m == pytest.approx(0.001, rel=0.1)
    assert clean.interval_s == pytest.approx(1.0 / 300.0)
    bad = {10: 0.0, 50: np.nan, 90: 5.0, 130: np.inf, 170: -1.0}
    for at, value in bad.items():
        height_m[at] = value
    signal = cleaned(time_s, height_m, leg_m=time_s.copy())
    assert np.array_equal(signal.time_s, np.delete(time_s, list(bad)))
    assert np.array_equal(signal.leg_m, signal.time_s)


def test_spikes_are_left_out_and_little_else():
    time_s, height_m = swing(seconds=20.0)
    rng = np.random.default_rng(1)
    spikes = rng.choice(time_s.size, time_s.size // 50, replace=False)
    height_m[spikes] += rng.choice([-1.0, 1.0], spikes.size) * rng.uniform(0.02, 0.2, spikes.size)
    kept = np.isin(time_s, cleaned(time_s, height_m).time_s)
    assert kept[spikes].mean() < 0.02
    assert np.delete(kept, spikes).mean() > 0.995


def test_a_dropout_to_a_plausible_height_is_enclosed_by_its_steps():
    """40 ms at 0.1 m, which no rail shows: six peaks to a plain peak finder."""
    time_s, height_m = swing()
    out = slice(300, 312)
    height_m[out] = 0.1
    assert np.array_equal(cleaned(time_s, height_m).time_s, np.delete(time_s, out))


def test_a_held_value_inside_a_gap_is_no_measurement():
    time_s, height_m = swing()
    signal = cleaned(time_s, height_m, [[time_s[99], time_s[110] - time_s[99]]])
    assert np.isin(time_s[99:111], signal.time_s).tolist() == [True, *[False] * 10, True]


def test_a_clock_of_whole_milliseconds_still_has_its_rate():
    time_s = np.arange(60_000) * 1000 // 300 / 1000.0
    assert sampling_interval(time_s) == pytest.approx(1.0 / 300.0, rel=1e-4)
    assert gaps_in_time(time_s).size == 0
    assert np.array_equal(gaps_in_time(np.delete(time_s, slice(100, 103))), [[0.33, pytest.approx(0.013)]])


@pytest.mark.parametrize(
    ("time_s", "height_m", "leg_m", "gaps", "sentence"),
    [
        ([0.0, 1.0], [0.3], None, NO_GAPS, r"time \(2,\), body height \(1,\)"),
        ([0.0, 1.0], [0.3, 0.3], [0.2], NO_GAPS, "leg length"),
        ([0.0, 0.0], [0.3, 0.3], None, NO_GAPS, "does not increase"),
        ([0.0, np.nan], [0.3, 0.3], None, NO_GAPS, "not finite"),
        ([0.0, 1.0], [0.3, 0.3], None, np.zeros((1, 3)), "one row"),
    ],
)
def test_arrays_that_do_not_fit_together_are_refused(time_s, height_m, leg_m, gaps, sentence):
    leg = None if leg_m is None else np.array(leg_m)
    with pytest.raises(InputRefused, match=sentence):
        clean_signal(np.array(time_s), np.array(height_m), leg, gaps, CleaningParameters())
