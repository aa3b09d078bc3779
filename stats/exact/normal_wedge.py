"""Chance that two independent normal values fall between two lines that cross, by Owen's T function (Owen 1956)."""

from __future__ import annotations

import math

import numpy as np
from scipy import special

from stats.exact.quadrature import Floats

_REACH = 9.0
"""Standard deviations beyond which a normal probability is 0 or 1 to double precision."""
_BESIDE_ZERO = 1e-300


def between_lines(low: Floats, high: Floats, slope_low: float, slope_high: float, least: Floats) -> Floats:
    """Return P(low + slope_low Z <= X <= high + slope_high Z, Z >= least), right to 1e-14.

    X and Z are independent standard normal values; slope_low < slope_high, both positive, so that the lines have
    nothing between them below the Z where they cross.
    """
    least = np.maximum(least, (low - high) / (slope_high - slope_low))
    ends = low / math.hypot(1.0, slope_low), high / math.hypot(1.0, slope_high)
    inside = special.ndtr(ends[1]) - special.ndtr(ends[0])
    cut = least > -_REACH
    if cut.any():
        at = least[cut]
        kept = [_below_line(line[cut], slope, at) for line, slope in ((low, slope_low), (high, slope_high))]
        inside[cut] = np.where(at > _REACH, 0.0, kept[1] - kept[0])
    return np.asarray(np.maximum(inside, 0.0))


def _below_line(line: Floats, slope: float, least: Floats) -> Floats:
    """Return P(X <= line + slope Z, Z >= least), up to a part that depends on `least` alone."""
    line, k = _not_zero(line), _not_zero(-least)
    h = line / math.hypot(1.0, slope)
    with np.errstate(over="ignore"):  # infinity is an angle, too
        over_h = k * (1.0 + slope * slope) / line - slope
        over_k = line / k - slope
    opposite = np.where((h < 0.0) != (k < 0.0), 0.5, 0.0)
    return np.asarray(special.ndtr(h) / 2.0 - special.owens_t(h, over_h) - special.owens_t(k, over_k) - opposite)


def _not_zero(values: Floats) -> Floats:
    return np.where(np.abs(values) < _BESIDE_ZERO, _BESIDE_ZERO, values)
