"""The power of an equivalence test whose bounds are shares of the control's mean, which the study has to estimate too.

`stats.equivalence` tests a bound of delta as mean(a) - (1 + delta) mean(b), with Var(a) + (1 + delta)^2 Var(b). Given
both estimated variances and the mean of b, it rejects where the mean of a lies between two numbers; that chance is
integrated over the other three, which are independent. Checked against the test itself on drawn values.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import special

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.checks import as_count, as_level, as_number
from stats.distributions import t_upper_quantile
from stats.finite import to_double
from stats.power import Power

Floats = NDArray[np.float64]

_NODES = 48
FAR = 1e9
"""Standard deviations."""
_LEAST_ALPHA, _LARGEST_CRITICAL = 1e-100, 1e6
"""scipy's quantile of t is right from there on, and nothing that it is multiplied by reaches FAR."""


def power_percent_equivalence(
    difference: float, control_mean: float, sd: float, low: float, high: float, n_a: int, n_b: int, alpha: float = 0.05
) -> Power:
    """Return the power of Welch's two one-sided tests, of a against b, at bounds in percent of the mean of b.

    `difference`, mean(a) - mean(b), `control_mean` and `sd` (of both groups) are in the unit of the values. Raises
    `InputRefused` for numbers that no study has.
    """
    sd, mean = as_number("sd", sd, above=0.0), as_number("the control's mean", control_mean, above=0.0)
    difference = as_number("difference", difference)
    low = as_number("low", low, above=-100.0)
    high, alpha = as_number("high", high, above=low), as_level("alpha", alpha)
    if alpha >= 0.5:
        raise InputRefused(f"alpha is {alpha!r}: give a number below 0.5 for an equivalence test.")
    sizes = as_count("n_a", n_a), as_count("n_b", n_b)
    truth = to_double(100 * Fraction(difference) / Fraction(mean))
    test = (
        f"Welch's equivalence test (TOST) between {low:g} and {high:g} % of the control's mean, itself estimated and "
        f"{mean:g} in truth, for a difference of {difference:g} at sd {sd:g}"
    )
    never = None
    if not low < truth < high:
        never = f"the true difference of {truth:g} % does not lie between the bounds {low:g} and {high:g} %"
    if min(sizes) < 2:
        return Power(test, sizes, alpha, Undefined("each group needs at least 2 values for its variance"), never)
    if alpha < _LEAST_ALPHA or t_upper_quantile(alpha, min(sizes) - 1) > _LARGEST_CRITICAL:
        few = Undefined("alpha is too small for the quadrature over estimated variances")
        return Power(test, sizes, alpha, few, never)
    bounds = tuple(
        _Bound(1.0 + end / 100.0, _in_sds(_share(end) * Fraction(mean) - Fraction(difference), sd))
        for end in (low, high)
    )
    return Power(test, sizes, alpha, _power(bounds, _in_sds(Fraction(mean), sd), *sizes, alpha), never)


class _Bound(NamedTuple):
    """A bound: what the control's mean is multiplied by, and how far the bound lies above the true difference, in
    standard deviations.
    """

    factor: float
    above: float


def _share(percent: float) -> Fraction:
    return Fraction(percent) / 100


def _in_sds(distance: Fraction, sd: float) -> float:
    """Return a distance in standard deviations; what is farther than any estimate comes counts as just that far."""
    return min(max(to_double(distance / Fraction(sd)), -FAR), FAR)


def _power(bounds: Iterable[_Bound], mean: float, n_a: int, n_b: int, alpha: float) -> float:
    """Integrate, with standard deviations of 1."""
    (of_a, weights_a), (of_b, weights_b), (z, weights_z) = _variances(n_a - 1), _variances(n_b - 1), _normal()
    part_a, part_b = of_a[:, None] / n_a, of_b[None, :] / n_b
    error_b = z[None, None, :] / np.sqrt(n_b)
    ends = []
    for (factor, above), side in zip(bounds, (1.0, -1.0), strict=True):
        of_control = factor**2 * part_b
        variance = part_a + of_control
        df = variance**2 / (part_a**2 / (n_a - 1) + of_control**2 / (n_b - 1))
        margin = -special.stdtrit(df, alpha) * np.sqrt(variance)
        ends.append(above + factor * error_b + side * margin[:, :, None])
    lower, upper = (special.ndtr(end * np.sqrt(n_a)) for end in ends)
    # Without a control's mean that can be told from 0 the test shows nothing.
    known = mean + error_b > (-special.stdtrit(n_b - 1, alpha) * np.sqrt(part_b))[:, :, None]
    inside = np.where(known, np.maximum(0.0, upper - lower), 0.0)
    return min(1.0, float(np.einsum("ijk,i,j,k", inside, weights_a, weights_b, weights_z)))


def _variances(df: int) -> tuple[Floats, Floats]:
    """Return nodes and weights over an estimated variance with these degrees of freedom whose truth is 1."""
    at, weights = _uniform()
    return 2.0 * special.gammaincinv(df / 2.0, at) / df, weights


def _normal() -> tuple[Floats, Floats]:
    at, weights = _uniform()
    return special.ndtri(at), weights


@functools.cache
def _uniform() -> tuple[Floats, Floats]:
    """Return nodes and weights from 0 to 1 that lie close at both ends, where quantiles run away."""
    nodes, weights = (np.asarray(part) for part in np.polynomial.legendre.leggauss(_NODES))
    angle = np.pi / 4.0 * (nodes + 1.0)
    return np.sin(angle) ** 2, weights * np.pi / 4.0 * np.sin(2.0 * angle)
