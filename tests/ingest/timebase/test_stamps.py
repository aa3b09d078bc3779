"""Rates of quantised clocks, gaps, and comparing rates."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.model import FloatArray, IntArray
from ingest.timebase.axis import Timebase, burst_starts, from_bursts, from_stamps


def stamps(n: int, rate_hz: float) -> FloatArray:
    """Whole milliseconds, as a microcontroller stamps packets."""
    return np.asarray(np.floor(np.arange(n) * 1000.0 / rate_hz) / 1000.0, dtype=np.float64)


def ordinals(n: int) -> IntArray:
    return np.arange(n, dtype=np.int64)


def by_ticks(seconds: FloatArray) -> Timebase:
    starts = burst_starts(seconds)
    assert starts is not None
    return from_bursts(seconds, ordinals(len(seconds)), starts)


@pytest.mark.parametrize("rate_hz", [300.0, 333.0, 1000 / 3, 250.0, 204.0, 1000.0])
def test_whole_milliseconds_still_give_the_rate(rate_hz: float) -> None:
    seconds = stamps(216_000, rate_hz)
    axis = from_stamps(seconds, ordinals(len(seconds)))
    assert axis.rate_hz == pytest.approx(rate_hz, rel=1e-5)
    assert axis.gaps == ()


@given(st.sampled_from([300.0, 1000 / 3]), st.sets(st.integers(5, 994), max_size=12))
def test_every_dropped_packet_is_in_a_gap(rate_hz: float, dropped: set[int]) -> None:
    seconds = np.delete(stamps(1000, rate_hz), sorted(dropped))
    axis = from_stamps(seconds, ordinals(len(seconds)))
    assert sum(gap.samples_missing for gap in axis.gaps) == len(dropped)
    assert all(gap.kind == "dropped" and gap.samples_expected == gap.samples_missing for gap in axis.gaps)
    for gap in axis.gaps:
        inside = [k for k in dropped if gap.start_s < stamps(1000, rate_hz)[k] < gap.start_s + gap.length_s]
        assert len(inside) == gap.samples_missing
    assert axis.rate_hz == pytest.approx(rate_hz, rel=2e-3)


def test_a_long_hole_is_a_pause_and_left_out_of_the_rate() -> None:
    seconds = np.concatenate([stamps(3000, 300.0), 25.0 + stamps(3000, 300.0)])
    axis = from_stamps(seconds, ordinals(6000))
    (gap,) = axis.gaps
    assert gap.kind == "pause"
    assert gap.length_s == pytest.approx(25.0 - seconds[2999])
    assert gap.samples_missing == pytest.approx(300 * gap.length_s, abs=2)
    assert axis.rate_hz == pytest.approx(300.0, rel=1e-3)


def test_a_late_sample_that_is_made_up_for_is_no_gap() -> None:
    seconds = np.arange(1000, dtype=np.float64) * 0.005
    seconds[500] += 0.0045  # steps of 9.5 and 0.5 ms instead of 5 and 5
    assert from_stamps(seconds, ordinals(1000)).gaps == ()


@pytest.mark.parametrize("rate_hz", [1100, 1200, 1300, 1400, 1500, 1700, 1900, 2500, 3000, 7000])
@pytest.mark.parametrize("tick", [np.floor, np.rint])
def test_samples_faster_than_the_tick_of_their_clock_are_counted(rate_hz: int, tick: Callable[..., FloatArray]) -> None:
    """1300 to 1500 Hz in whole milliseconds were refused, 1700 Hz became 2000 Hz with losses, 1100 Hz 1000 Hz."""
    seconds = tick(np.arange(6000) * 1000 / rate_hz + 1e-9) / 1000
    axis = by_ticks(seconds)
    assert axis.rate_hz == pytest.approx(rate_hz, rel=1e-6)
    assert axis.gaps == ()
    lossy = by_ticks(np.delete(seconds, range(3000, 3020)))
    assert lossy.rate_hz == pytest.approx(rate_hz, rel=1e-3)
    assert sum(gap.samples_missing for gap in lossy.gaps) == pytest.approx(20, abs=1)
    assert lossy.gaps[0].start_s == pytest.approx(3000 / rate_hz, abs=2e-3)


def test_the_digits_of_a_printed_stamp_invent_no_loss() -> None:
    """Six digits are whole milliseconds until 999.999 s and hundredths of a second from there on."""
    axis = by_ticks(np.array([float(f"{998 + k / 1000:g}") for k in range(4000)]))
    assert (axis.rate_hz, axis.gaps) == (pytest.approx(1000.0, rel=1e-6), ())
