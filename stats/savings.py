"""Savings (CE - AD) / CE as a ratio of means, with Fieller's interval (thesis 4.3.2 and 5.2.1).

With C the mean of the control, T that of the treated runs and rho = T / C, the savings are S = 1 - rho.

*Scatter.* For the true rho, T - rho C has mean 0 and variance Var(T) + rho^2 Var(C), with Var(C) = s_C^2 / n_C.
Fieller's interval holds all rho with (T - rho C)^2 <= t^2 Var(T - rho C), t Student's quantile.

*Shared additive errors.* Joules a jump are 3.6 V (Q - P) / n; the passive charge P comes from one line, so its errors
(of level and slope) are common to all runs. Where the means carry c_k e_k and t_k e_k with independent e_k of standard
error 1, Var(C) gains the sum of c_k^2, Var(T) that of t_k^2, their covariance is the sum of c_k t_k, and

    Var(T - rho C) = Var(T) + rho^2 Var(C) + sum of (t_k - rho c_k)^2.

With equal durations and jumps c_k = t_k and the last term is (s_shared S)^2: the errors cancel in C - T and stay in
the denominator alone, dS/de = -(C - T) / C^2 = -S / C. They are no part of the scatter: more runs do not make them
smaller.

*Shared scale error.* A wrong reference voltage multiplies C and T alike and leaves S as it is.

With m = 1 where the fit has enough degrees of freedom and more where it has few (`stats.shared_error.joint`), Fieller's
interval holds all rho with

    (T - rho C)^2 <= t^2 (Var(T) + rho^2 Var(C) + m times the sum of (t_k - rho c_k)^2),

t and m taken at the estimate; it is computed as Fieller's interval of S = (C - T) / C, which is the same and cancels
less. The delta interval beside it is S -/+ t times the root of that variance over C.
A mean of ratios of single pairs is biased and not offered.
Coverage at n = 5 and a coefficient of variation of 0.2: Fieller 0.956, delta 0.950 (20 000 simulated samples). Beside
both stands the delta interval of log(T / C), which no noise takes beyond 100 %.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from numpy.typing import ArrayLike

from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level, as_number, as_pair
from stats.groups import read_groups
from stats.results import Result
from stats.shared_error import SharedError, joint
from stats.wording import interval_text, missing_text, number_text


@dataclass(frozen=True, slots=True)
class Savings(Result):
    """Savings of the treated against the control runs, in percent of the control's mean."""

    n_control: int
    """Number of control runs."""
    n_treated: int
    """Number of treated runs."""
    control_mean: float | Undefined
    """C, in the unit of the values."""
    treated_mean: float | Undefined
    """T, in the unit of the values."""
    percent: float | Undefined
    """100 (C - T) / C; negative where the treated runs cost more."""
    percent_ci: tuple[float, float] | Undefined
    """Fieller's interval, scatter and shared error together."""
    delta_ci: tuple[float, float] | Undefined
    """The delta interval, for comparison."""
    log_ci: tuple[float, float] | Undefined
    """The delta interval of log(T / C) brought back to percent, for comparison; never beyond 100 %."""
    se_percent: float | Undefined
    """Standard error from the scatter between runs (delta method)."""
    shared_se_percent: float | Undefined
    """Standard error from the shared additive error alone."""
    df: float | Undefined
    """Welch and Satterthwaite's degrees of freedom over both scatters."""
    level: float
    """Level of the intervals."""
    scale_relative_se: float
    """Relative standard error common to all runs as a factor; it cancels and is in no number here."""
    missing: int
    """How many values were left out as NaN."""

    def sentence(self, control: str = "the control", treated: str = "the treated runs") -> str:
        """Return the savings in words, with interval and n."""
        sizes = f"(n = {self.n_treated} against {self.n_control})"
        if isinstance(self.percent, Undefined):
            return f"The savings of {treated} against {control} {sizes} are undefined: {self.percent.reason}."
        interval = interval_text(self.percent_ci, self.level, "%")
        if isinstance(self.percent_ci, Undefined):
            interval += f", because {self.percent_ci.reason}"
        else:
            interval += ", Fieller"
        return (
            f"{treated} used {number_text(abs(self.percent), 3)} % {'less' if self.percent >= 0 else 'more'} "
            f"than {control} (savings {number_text(self.percent, 3)} %, "
            f"{interval}) {sizes}{missing_text(self.missing)}."
        )


def percent_savings(
    control: ArrayLike,
    treated: ArrayLike,
    *,
    shared_in_control: SharedError | None = None,
    shared_in_treated: SharedError | None = None,
    scale_relative_se: float = 0.0,
    level: float = 0.95,
    missing: Missing = "refuse",
    names: tuple[str, str] = ("control", "treated"),
) -> Savings:
    """Return 100 (C - T) / C of two samples of run values, shapes (n_c,) and (n_t,), in one unit (joules a jump).

    The shared errors, in that unit, are what each group's mean takes from errors common to runs of both (the drain
    fit). `scale_relative_se` is that of a common factor (the reference voltage): it cancels. Derivation at the top of
    this module. `names` are what both groups are called where something is undefined or refused. Raises `InputRefused`
    for infinite values, for NaN unless `missing` is "drop", for a negative scale error, a level outside 0 to 1 or one
    name for both groups.
    """
    level = as_level("level", level)
    scale_relative_se = as_number("scale_relative_se", scale_relative_se, low=0.0)
    in_control, in_treated = shared_in_control or SharedError(), shared_in_treated or SharedError()
    # Scaled by one power of two: squares stay within the range of doubles, no digit changes.
    read = read_groups(as_pair(names, control, treated), missing)
    means = dict(zip(read.names, read.means, strict=True))
    sizes = dict(zip(read.names, read.sizes, strict=True))
    unknown = Undefined(f"group {' and group '.join(read.empty)} is empty")
    result = Savings(
        n_control=sizes.get(names[0], 0),
        n_treated=sizes.get(names[1], 0),
        control_mean=means.get(names[0], unknown),
        treated_mean=means.get(names[1], unknown),
        percent=unknown,
        percent_ci=unknown,
        delta_ci=unknown,
        log_ci=unknown,
        se_percent=unknown,
        shared_se_percent=unknown,
        df=unknown,
        level=level,
        scale_relative_se=scale_relative_se,
        missing=read.missing,
    )
    if read.empty:
        return result
    of_c, of_t = read.filled
    c, t = of_c.mean, of_t.mean
    if c <= 0.0:
        none = Undefined("the control's mean is not positive, so that there is nothing to save a share of")
        return replace(_without_interval(result, none), percent=none, se_percent=none, shared_se_percent=none)

    in_control, in_treated = (
        error.times(math.ldexp(1.0, min(-read.exponent, 1023))) for error in (in_control, in_treated)
    )
    saved = of_c.minus(of_t)
    rho, percent = t / c, 100.0 * saved / c
    shared = in_treated.minus(in_control.times(rho))
    result = replace(result, percent=percent, shared_se_percent=100.0 * shared.se / c)
    if of_c.n < 2 or of_t.n < 2:
        single = of_c if of_c.n < 2 else of_t
        none = Undefined(f"group {single.name} has a single run and so no scatter")
        return replace(_without_interval(result, none), se_percent=none)
    variance_c, variance_t = of_c.mean_variance, of_t.mean_variance
    scatter_part = variance_t + rho * rho * variance_c
    result = replace(result, se_percent=100.0 * math.sqrt(scatter_part) / c)
    if scatter_part == 0.0:
        return _without_interval(result, Undefined("neither group has any scatter"))

    parts = ((variance_t, of_t.n - 1), (rho * rho * variance_c, of_c.n - 1))
    df = 1.0 / math.fsum((part / scatter_part) ** 2 / part_df for part, part_df in parts)
    both = joint(parts, shared, level)
    half = both.quantile * math.sqrt(scatter_part + both.more * shared.se**2) / c
    delta = (percent - 100.0 * half, percent + 100.0 * half)
    of_difference = in_control.minus(in_treated)
    covariance = math.fsum(value * of_difference.terms[term] for term, value in in_control.terms.items())
    share = _fieller(
        (saved, variance_t + variance_c + both.more * of_difference.se**2),
        (c, variance_c + both.more * in_control.se**2),
        variance_c + both.more * covariance,
        both.quantile,
    )
    interval = share if isinstance(share, Undefined) else (100.0 * share[0], 100.0 * share[1])
    return replace(result, percent_ci=interval, delta_ci=delta, log_ci=_log_interval(saved / c, half), df=df)


def _without_interval(result: Savings, why: Undefined) -> Savings:
    return replace(result, percent_ci=why, delta_ci=why, log_ci=why, df=why)


def _log_interval(share: float, half: float) -> tuple[float, float] | Undefined:
    """Return percent savings where log(rho) -/+ half / rho ends, rho = 1 - share."""
    rho = 1.0 - share
    if rho <= 0.0:
        return Undefined("the treated mean is not positive and has no logarithm")
    # A ratio that could be anything from almost 0 to beyond all doubles bounds nothing.
    if half / rho > 700.0:
        return Undefined("the treated mean is not distinguishable from 0 at this level")
    low, high = (-100.0 * math.expm1(math.log1p(-share) + side * half / rho) for side in (1.0, -1.0))
    return low, high


def _fieller(
    numerator: tuple[float, float], denominator: tuple[float, float], covariance: float, quantile: float
) -> tuple[float, float] | Undefined:
    """Return the interval of a ratio of means, each given with its variance."""
    (top, top_variance), (bottom, bottom_variance) = numerator, denominator
    squared = quantile * quantile
    quadratic = bottom * bottom - squared * bottom_variance
    if quadratic <= 0.0:
        return Undefined("the control's mean is not distinguishable from 0 at this level")
    middle = bottom * top - squared * covariance
    # The discriminant with its equal terms taken off on paper: means that hardly differ keep their digits.
    spread = bottom * bottom * top_variance - 2.0 * bottom * top * covariance + top * top * bottom_variance
    rest = bottom_variance * top_variance - covariance * covariance
    root = quantile * math.sqrt(max(spread - squared * rest, 0.0))
    return (middle - root) / quadratic, (middle + root) / quadratic
