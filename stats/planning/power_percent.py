"""The power of an equivalence test whose bounds are shares of the control's mean, which the study has to estimate too.

`compare.equivalence` tests a bound of delta as mean(a) - (1 + delta) mean(b), with Var(a) + (1 + delta)^2 Var(b). Given
both estimated variances it rejects where both means lie between two lines that cross: a chance in closed form, smooth
in the pooled variance, over which it is integrated, and over the share that a has in it. Right to 1e-9, and checked
against the test itself on drawn values.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from scipy import special

from data_schema.reasons import Reason
from data_schema.rounding import given_text, number_text
from data_schema.vocabulary import Remark, Undefined
from stats.checks import as_count, as_number
from stats.exact.numbers import Floats, to_double
from stats.exact.quadrature import Rows
from stats.exact.tails import df_of_arrays, t_upper_quantile, t_upper_quantiles
from stats.planning.estimated_scatter import mean_over_scale, mean_over_share
from stats.planning.power import Power, alpha_of_equivalence, assumed_text

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
        below = [_below_line(line[cut], slope, at) for line, slope in ((low, slope_low), (high, slope_high))]
        inside[cut] = np.where(at > _REACH, 0.0, below[1] - below[0])
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
    high, alpha = as_number("high", high, above=low), alpha_of_equivalence(alpha)
    sizes = as_count("n_a", n_a), as_count("n_b", n_b)
    truth = to_double(100 * Fraction(difference) / Fraction(mean))
    test = (
        f"Welch's equivalence test (TOST) between {given_text(low)} and {given_text(high)} % of the control's mean, "
        f"itself estimated and {assumed_text(mean, sd)} in truth, for a difference of "
        f"{assumed_text(difference, sd)} at sd {number_text(sd)}"
    )
    never = None
    if not low < truth < high:
        bounds = f"{low:g} and {high:g}"  # each may be infinite
        never = Remark(Reason.NOT_BETWEEN_PERCENT, percent=f"{truth:g}", bounds=bounds)
    if min(sizes) < 2:
        return Power(test, sizes, alpha, Undefined(Reason.TWO_EACH_FOR_VARIANCE), never)
    if alpha < _LEAST_ALPHA or t_upper_quantile(alpha, min(sizes) - 1) > _LARGEST_CRITICAL:
        few = Undefined(Reason.ALPHA_TOO_SMALL)
        return Power(test, sizes, alpha, few, never)
    factors = 1.0 + low / 100.0, 1.0 + high / 100.0
    above = [_in_sds(Fraction(end) / 100 * Fraction(mean) - Fraction(difference), sd) for end in (low, high)]
    power = _power(factors, (above[0], above[1]), _in_sds(Fraction(mean), sd), sizes, alpha)
    return Power(test, sizes, alpha, power, never)


def _in_sds(distance: Fraction, sd: float) -> float:
    """Return a distance in standard deviations; what is farther than any estimate comes counts as just that far."""
    return min(max(to_double(distance / Fraction(sd)), -FAR), FAR)


def _power(
    factors: tuple[float, float], above: tuple[float, float], mean: float, sizes: tuple[int, int], alpha: float
) -> float:
    """Integrate, with standard deviations of 1, over the share that a has in the sums of squares.

    Of the low and the high bound, `factors` are what the control's mean is multiplied by, and `above` is how far the
    bound lies above the true difference.
    """
    (n_a, n_b), df_a, df_b = sizes, sizes[0] - 1.0, sizes[1] - 1.0
    root_a, root_b = math.sqrt(n_a), math.sqrt(n_b)
    slopes = factors[0] * root_a / root_b, factors[1] * root_a / root_b
    tail = Fraction(alpha)
    quantile_b = t_upper_quantile(tail, df_b)

    def of_shares(share_a: Floats, share_b: Floats) -> Floats:
        part_a, part_b = (
            share * (df_a + df_b) / df / n for share, df, n in ((share_a, df_a, n_a), (share_b, df_b, n_b))
        )
        # For a pooled scale U of 1: how far the difference has to lie above the low and below the high bound, and the
        # control's mean above 0, without which the test shows nothing.
        from_low, from_high = (
            t_upper_quantiles(tail, df_of_arrays(part_a, of_control, df_a, df_b)) * np.sqrt(part_a + of_control)
            for factor in factors
            for of_control in [factor**2 * part_b]
        )
        least = quantile_b * np.sqrt(part_b)
        both = from_low + from_high
        # Where U takes each bound, the point at which they meet, and the least mean to the middle of what they scatter
        # by.
        turns = [-above[0] / from_low, above[1] / from_high, (above[1] - above[0]) / both, mean / least]
        widths = [
            math.hypot(1.0 / root_a, factors[0] / root_b) / from_low,
            math.hypot(1.0 / root_a, factors[1] / root_b) / from_high,
            (factors[1] - factors[0]) / root_b / both,
            1.0 / root_b / least,
        ]

        def inside(u: Floats, rows: Rows) -> Floats:
            return between_lines(
                root_a * (above[0] + u * from_low[rows, None]),
                root_a * (above[1] - u * from_high[rows, None]),
                *slopes,
                root_b * (u * least[rows, None] - mean),
            )

        return mean_over_scale(inside, sum(sizes) - 2.0, np.stack(turns, 1), np.stack(widths, 1))

    return min(1.0, mean_over_share(of_shares, df_a, df_b))
