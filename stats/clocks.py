"""Two records of one run by two clocks: touchdowns of a leg, the line between the clocks, and how far to smooth.

A touchdown is seen by a force plate as a sudden force (`stats.force_plate`) and by the robot as a leg that begins to
yield (thesis 3.2.2). What both have seen gives the offset and the drift of one clock against the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.force_plate import crossing_s
from stats.lines.regression import fit_linear
from stats.scatter import Floats, Interval

LEAST_TOUCHDOWNS = 5
"""With fewer common touchdowns neither their pairs nor the quality of the fit can be determined."""
_STANDING_SHARE = 0.3
"""Of the range of lengths: a leg that is shorter than its flight length by this much has touched down."""
_ONSET_SHARE = 0.05
"""Of the range: the yielding is read at this deflection and the double of it."""
_FLIGHT_S = (0.08, 0.03)
"""The leg's length in flight is its median over this time before it has yielded by a third: from, to."""
_PAIRED_S = 0.06
"""Touchdowns further apart are not the same: a tenth of a hop, and what clocks drift by in a minute at 1000 ppm."""
_LARGEST_RESIDUAL_S = 0.005
_RIVAL = 3.0
"""Another pairing has to fit so much worse, by the standard deviation of what it leaves, over its pairs."""
_RIVAL_SHARE = 0.5
_SIZE_SHARE, _SIZE_SDS = 0.8, 1.2816
"""So much of normal errors is smaller than so many standard deviations."""
_FAR = 5.0
"""Standard deviations beyond which a touchdown was misread, and is left out of the line."""


@dataclass(frozen=True, slots=True)
class Clocks:
    """The line between two clocks: second = at_zero_s + (1 + drift) * first.

    `at_zero_s` has its interval in `at_zero_ci`, `drift` (dimensionless) in `drift_ci`; `residual_sd_s` is what the
    line leaves of the touchdowns, `n` their number and `left_out` that of pairs that were misread.
    """

    at_zero_s: float
    at_zero_ci: Interval | Undefined
    drift: float
    drift_ci: Interval | Undefined
    residual_sd_s: float
    n: int
    left_out: int

    def second_s(self, first_s: ArrayLike) -> Floats:
        """Return what the second clock shows when the first shows `first_s`, shape (n,)."""
        first = np.asarray(first_s, np.float64)
        return np.asarray(self.at_zero_s + first + self.drift * first)


def leg_touchdowns(time_s: ArrayLike, length_m: ArrayLike) -> Floats:
    """Return when a leg began to yield after each flight, by the clock of its log; shape (touchdowns,).

    The line through the deflections of 5 and 10 % of the range of lengths is extended back to the length in flight.
    Touchdowns beside missing samples are left out.

    Parameters
    ----------
    time_s : (n,) times of the samples, rising
    length_m : (n,) distance from hip to foot
    """
    time, length = np.asarray(time_s, np.float64), np.asarray(length_m, np.float64)
    low, high = np.quantile(length, [0.02, 0.98])
    span, step_s = high - low, float(np.median(np.diff(time)))
    short = length < high - _STANDING_SHARE * span
    found = []
    for at in np.flatnonzero(short[1:] & ~short[:-1]) + 1:
        begin, end = np.searchsorted(time, [time[at] - _FLIGHT_S[0], time[at] - _FLIGHT_S[1]])
        if end - begin < 2 or np.diff(time[begin : at + 1]).max() > 1.5 * step_s:
            continue
        deflection = float(np.median(length[begin:end])) - length[begin : at + 1]
        once, twice = (_last_rise(time[begin : at + 1], deflection, times * _ONSET_SHARE * span) for times in (1, 2))
        found.append(2.0 * once - twice)
    return np.array(found)


def _last_rise(time: Floats, values: Floats, level: float) -> float:
    """Return when the values last rose above a level."""
    below = int(np.flatnonzero(values <= level)[-1])
    return float(time[-1]) if below == values.size - 1 else crossing_s(time, values, level, below + 1)


def align_clocks(first_s: ArrayLike, second_s: ArrayLike, level: float = 0.95) -> Clocks:
    """Find the line between two clocks that both timed the same touchdowns.

    Which belong together is not known: every offset is tried, and that with most pairs within 60 ms and least
    scatter is taken. The errors of touchdowns are independent, so that the line is fitted by least squares.

    Parameters
    ----------
    first_s, second_s : (n,) and (m,) touchdowns by either clock, rising; either may lack some
    level : of the intervals

    Raises
    ------
    InputRefused where fewer than half of the touchdowns, or than five, pair; where they scatter by more than 5 ms; and
    where another pairing fits nearly as well, as it does when equal hops are cut at both ends.
    """
    first, second = np.asarray(first_s, np.float64), np.asarray(second_s, np.float64)
    fewer = min(first.size, second.size)
    tried = [] if fewer < LEAST_TOUCHDOWNS else _pairings(first, second)
    if not tried or tried[0][1].shape[1] < max(LEAST_TOUCHDOWNS, fewer / 2):
        most = tried[0][1].shape[1] if tried else 0
        raise InputRefused(
            f"of {first.size} touchdowns on the plate and {second.size} of the leg only {most} pair: record both from "
            "before the first hop to after the last"
        )
    spread_s, pairs = tried[0]
    if spread_s > _LARGEST_RESIDUAL_S:
        raise InputRefused(
            f"the touchdowns of plate and leg differ by {spread_s * 1e3:.1f} ms from one line: check the rates of both "
            "records"
        )
    if len(tried) > 1 and tried[1][0] / tried[1][1].shape[1] < _RIVAL * spread_s / pairs.shape[1]:
        raise InputRefused(
            "the hops are so equal that plate and leg fit as well one hop further: record both from before the first "
            "hop, or tap the foot on the plate at uneven times"
        )
    near = np.abs(_residuals(*pairs)) <= max(_FAR * spread_s, 1e-9)
    fit = fit_linear(pairs[1, near] - pairs[0, near], {"first": pairs[0, near]}, level=level)
    (at_zero_s, drift), (at_zero_ci, drift_ci) = fit.coefficients, fit.intervals()
    _errors, residual_sd_s = fit.spread("the line between the clocks")
    return Clocks(at_zero_s, at_zero_ci, drift, drift_ci, residual_sd_s, fit.n, pairs.shape[1] - fit.n)


def _pairings(first: Floats, second: Floats) -> list[tuple[float, Floats]]:
    """Return pairings that differ, as (scatter, pairs of shape (2, n)), the best first.

    Those with less than half as many pairs as the largest are left out.
    """
    every = np.unique(np.round((second[:, np.newaxis] - first) / (_PAIRED_S / 2.0)))
    counts = np.array([_pairs(first, second, offset * _PAIRED_S / 2.0).shape[1] for offset in every])
    found: list[tuple[float, Floats, float]] = []
    for place in np.argsort(-counts, kind="stable"):
        if counts[place] < max(_RIVAL_SHARE * counts.max(), LEAST_TOUCHDOWNS):
            break
        offset_s = float(every[place]) * _PAIRED_S / 2.0
        if any(abs(offset_s - other) <= _PAIRED_S for _, _, other in found):
            continue
        pairs = _pairs(first, second, offset_s)
        for _ in range(2):
            pairs = _pairs(first, second, float(np.median(pairs[1] - pairs[0])))
        offset_s = float(np.median(pairs[1] - pairs[0]))
        if all(abs(offset_s - other) > _PAIRED_S for _, _, other in found):
            # A fifth may be misread; of a pairing that is one hop off it is enough that a fifth of the hops differ.
            spread_s = float(np.quantile(np.abs(_residuals(*pairs)), _SIZE_SHARE)) / _SIZE_SDS
            found.append((spread_s, pairs, offset_s))
    most = max((pairs.shape[1] for _, pairs, _ in found), default=0)
    found = [one for one in found if one[1].shape[1] >= _RIVAL_SHARE * most]
    return [(spread_s, pairs) for spread_s, pairs, _ in sorted(found, key=lambda one: one[0] / one[1].shape[1])]


def _pairs(first: Floats, second: Floats, offset_s: float) -> Floats:
    """Return the touchdowns of the first and the nearest of the second within 60 ms, shape (2, pairs)."""
    after = np.clip(np.searchsorted(second, first + offset_s), 1, second.size - 1)
    nearest = np.where(
        np.abs(second[after] - first - offset_s) < np.abs(second[after - 1] - first - offset_s), after, after - 1
    )
    near = np.abs(second[nearest] - first - offset_s) < _PAIRED_S
    return np.stack([first[near], second[nearest[near]]])


def _residuals(first: Floats, second: Floats) -> Floats:
    """Return what Theil and Sen's line leaves, which single misread touchdowns do not turn."""
    apart = second - first
    place, other = np.triu_indices(first.size, 1)
    drift = float(np.median((apart[other] - apart[place]) / (first[other] - first[place])))
    left = apart - drift * first
    return np.asarray(left - np.median(left))


def moving_average(values: ArrayLike, window: int) -> Floats:
    """Return the centred moving average over `window` samples, an odd number; beyond the ends they repeat."""
    from scipy.ndimage import uniform_filter1d

    return np.asarray(uniform_filter1d(np.asarray(values, np.float64), window, mode="nearest"))


def corner(windows: Sequence[int], differences: Sequence[float]) -> int:
    """Return the window at the corner of a curve that falls and flattens: the one furthest below the line of its ends.

    `differences`, as long as `windows`, are the sums of absolute differences between the profile smoothed with each
    window and that with the one before. Both axes count from end to end, so that the corner depends on no unit, but on
    the windows that are tried.
    """
    across, up = np.asarray(windows, np.float64), np.asarray(differences, np.float64)
    line = up[0] + (up[-1] - up[0]) * (across - across[0]) / (across[-1] - across[0])
    return windows[int(np.argmax(line - up))]
