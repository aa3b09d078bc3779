"""Upper tail of the largest of several t-statistics that share a control and a standard deviation (Dunnett).

With the control's mean known (y, a standard normal) and the standard deviation known (s) the comparisons are
independent. With lambda_i = sqrt(n_i / (n_i + n_control)) and r_i^2 = 1 - lambda_i^2 the largest |T| exceeds c with the
chance 1 - product over i of (1 - t_i), t_i = Phi(-(c s - lambda_i y) / r_i) + Phi(-(c s + lambda_i y) / r_i); for the
largest T the first term alone. That is integrated over y and s by rules that gain digits exponentially: the same digits
at every call, and tails as small as they are.
"""

from __future__ import annotations

import math
from collections import Counter
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import special

from stats.over_scale import critical_value, log_mean_over_scale, log_sum

_Floats = NDArray[np.float64]

_REACH = 9.5
"""Standard deviations beyond which a normal adds nothing to 16 digits."""
_FARTHEST = 300.0
"""With a known standard deviation tails end here, at e**-45000; beyond they only fall on."""
_LOG_ROOT_2PI = 0.5 * math.log(2.0 * math.pi)


def largest_log_upper(c: float, n_control: int, n_treated: tuple[int, ...], df: float, *, two_sided: bool) -> float:
    """Return log P(max |T_i| > c), or log P(max T_i > c), for groups of these sizes against one control."""
    if two_sided and c <= 0.0:
        return 0.0
    counts = Counter(n_treated)
    squared = np.array([n / (n + n_control) for n in counts])
    times = np.array(list(counts.values()), dtype=np.float64)
    return log_mean_over_scale(lambda s: _known_scale(c * s, squared, times, two_sided), df, c)


@lru_cache(maxsize=1024)
def largest_critical(tail: float, n_control: int, n_treated: tuple[int, ...], df: float, *, two_sided: bool) -> float:
    """Return the c that the largest statistic exceeds with chance `tail`."""
    return critical_value(lambda c: largest_log_upper(c, n_control, n_treated, df, two_sided=two_sided), tail, 2.5)


def _known_scale(c: _Floats, squared: _Floats, times: _Floats, two_sided: bool) -> _Floats:
    """Return the logarithm of the chance at each c, shape (m,); `squared` holds lambda^2, each `times` over."""
    beyond = np.maximum(c, _FARTHEST)
    c = np.minimum(c, _FARTHEST)
    slopes, roots = np.sqrt(squared), np.sqrt(1.0 - squared)
    nearest, farthest = float(slopes.min()) * c, float(slopes.max()) * c
    start = np.maximum(np.minimum(nearest, farthest) - _REACH, 0.0 if two_sided else -_REACH)
    length = np.max(np.maximum(farthest, 0.0) + _REACH - start)
    # Phi rises over the width r / lambda of the largest group: steps must resolve that.
    steepest = float(slopes.max() / roots.min())
    points = math.ceil(length / (0.35 / math.sqrt(1.0 + steepest * steepest))) + 1
    step = length / (points - 1)
    y = start[:, None] + step * np.arange(points)
    log_tails = []
    for slope, root in zip(slopes, roots, strict=True):
        log_tail = special.log_ndtr((slope * y - c[:, None]) / root)
        if two_sided:
            log_tail = np.logaddexp(log_tail, special.log_ndtr((-slope * y - c[:, None]) / root))
        log_tails.append(np.minimum(log_tail, 0.0))
    with np.errstate(divide="ignore"):
        none = sum(count * np.log1p(-np.exp(tail)) for count, tail in zip(times, log_tails, strict=True))
        any_of_them = np.log(-np.expm1(none))
    # Where all are too small for a double, the chance of any is their sum.
    rare = log_sum(np.stack([tail + math.log(count) for count, tail in zip(times, log_tails, strict=True)], axis=-1))
    any_of_them = np.where(rare < -600.0, rare, any_of_them)
    terms = any_of_them - 0.5 * y * y
    if two_sided:
        # The integrand is even in y: half of it is enough, with half a weight where the half begins.
        terms[:, 0] -= np.where(start > 0.0, 0.0, math.log(2.0))
        terms += math.log(2.0)
    found = log_sum(terms) + math.log(step) - _LOG_ROOT_2PI
    return np.minimum(found + (_FARTHEST * _FARTHEST - beyond * beyond) / 2.0, 0.0)
