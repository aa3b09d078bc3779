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

With m = 1 where the fit has enough degrees of freedom and more where it has few (`stats.compare.shared_error.joints`),
Fieller's interval holds all rho with

    (T - rho C)^2 <= t^2 (Var(T) + rho^2 Var(C) + m times the sum of (t_k - rho c_k)^2),

t and m taken at the estimate; it is computed as Fieller's interval of S = (C - T) / C, which is the same and cancels
less. Where a fit of many degrees of freedom lowers t by more than its error adds, the interval without that error
(m = 0) is the wider: what is given holds both. The delta interval beside it is S -/+ t times the root of that variance
over C, the wider likewise.
A mean of ratios of single pairs is biased and not offered.
How often they cover stands in docs/statistics/error_rates.csv. Beside them stands the delta interval of log(T / C),
which no noise takes beyond 100 %.

All is computed in exact fractions, which are rounded once, at the ends: means and errors of any sizes may stand beside
each other.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from numpy.typing import ArrayLike

from data_schema.reasons import Reason
from data_schema.rounding import error_of, interval_text, number_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level, as_number, as_pair
from stats.compare.shared_error import CANCELLED, Joint, SharedError, as_shared, degrees_of_fits, joints
from stats.compare.summary import Group, Groups, Names, pair_of_names, read_groups
from stats.exact.numbers import QUANTILE_BEYOND_DOUBLES, Interval, exact_root, finite, finite_pair, to_120_bits
from stats.exact.tails import exact_df
from stats.results import Result, missing_text

Terms = Mapping[tuple[str, str], Fraction]
"""Signed standard errors by (fit, term)."""

_LARGEST_LOG = 700.0
"""Logarithm up to which a ratio bounds anything: doubles end at 709."""


@dataclass(frozen=True, slots=True)
class RatioOfMeans:
    """Both means with their variances and what errors in common make of each, in one unit."""

    control: Group
    treated: Group
    in_control: Terms
    in_treated: Terms

    @property
    def mean(self) -> Fraction:
        """C."""
        return self.control.exact_mean

    @property
    def saved(self) -> Fraction:
        """C - T."""
        return self.control.exact_mean - self.treated.exact_mean

    @property
    def rho(self) -> Fraction:
        """T / C."""
        return to_120_bits(self.treated.exact_mean / self.mean)

    @property
    def shared(self) -> Terms:
        """What T - rho C takes from the errors in common."""
        rho = self.rho
        return without({term: rho * value for term, value in self.in_control.items()}, self.in_treated)

    @property
    def scatter_parts(self) -> tuple[tuple[Fraction, int], tuple[Fraction, int]]:
        """The variances of T and of rho C with their degrees of freedom."""
        c, t = self.control, self.treated
        return (t.exact_mean_variance, t.n - 1), (self.rho**2 * c.exact_mean_variance, c.n - 1)

    @property
    def scatter(self) -> Fraction:
        """Var(T) + rho^2 Var(C)."""
        return sum((part for part, _df in self.scatter_parts), Fraction(0))

    @property
    def df(self) -> float:
        """Welch and Satterthwaite's degrees of freedom of the scatter, which is not 0."""
        return float(exact_df(self.scatter_parts))

    def joined(self, df: Mapping[str, float], level: float) -> tuple[Joint, ...]:
        """Return the ways in which scatter and errors in common join; `df` are the degrees of freedom of each fit."""
        shared = self.shared
        # Only their proportions count.
        unit = exact_root(self.scatter + squares(shared))
        parts = [(float(part / unit**2), float(part_df)) for part, part_df in self.scatter_parts]
        error = SharedError({term: float(value / unit) for term, value in shared.items()}, df)
        return joints(parts, error, level)

    def half_width(self, ways: Iterable[Joint]) -> Fraction:
        """Return the half width of the delta interval of S, the widest of all ways."""
        shared = squares(self.shared)
        squared = max(Fraction(way.quantile) ** 2 * (self.scatter + Fraction(way.more) * shared) for way in ways)
        return exact_root(squared) / self.mean

    def fieller(self, ways: Iterable[Joint]) -> Interval | Undefined:
        """Return Fieller's interval of S in percent, the least that holds those of all ways."""
        ends: list[float] = []
        for way in ways:
            interval = self._fieller(way)
            if isinstance(interval, Undefined):
                return interval
            ends += interval
        return min(ends), max(ends)

    def _fieller(self, both: Joint) -> Interval | Undefined:
        more, squared = Fraction(both.more), Fraction(both.quantile) ** 2
        of_difference = without(self.in_treated, self.in_control)
        variance_c, variance_t = self.control.exact_mean_variance, self.treated.exact_mean_variance
        top, bottom = self.saved, self.mean
        top_variance = variance_t + variance_c + more * squares(of_difference)
        bottom_variance = variance_c + more * squares(self.in_control)
        covariance = variance_c + more * sum(
            (value * of_difference[term] for term, value in self.in_control.items()), Fraction(0)
        )
        quadratic = bottom * bottom - squared * bottom_variance
        if quadratic <= 0:
            return Undefined(Reason.CONTROL_NEAR_ZERO)
        middle = bottom * top - squared * covariance
        root = exact_root(middle * middle - quadratic * (top * top - squared * top_variance))
        return finite_pair(100 * (middle - root) / quadratic, 100 * (middle + root) / quadratic)

    def log_interval(self, half: Fraction) -> Interval | Undefined:
        """Return the percent where log(rho) -/+ half / rho ends."""
        rho = self.rho
        if rho <= 0:
            return Undefined(Reason.TREATED_WITHOUT_LOGARITHM)
        spread = half / rho
        # A ratio that could be anything from almost 0 to beyond all doubles bounds nothing.
        if spread > _LARGEST_LOG:
            return Undefined(Reason.TREATED_NEAR_ZERO)
        middle = _log(rho, -self.saved / self.mean)
        if middle + float(spread) > _LARGEST_LOG:
            return Undefined(Reason.END_BEYOND_DOUBLES)
        low, high = (-100.0 * math.expm1(middle + side * float(spread)) for side in (1.0, -1.0))
        return low, high


def in_unit(error: SharedError, exponent: int) -> Terms:
    """Return an error's terms in units of 2**exponent."""
    unit = Fraction(2) ** exponent
    return {term: Fraction(value) / unit for term, value in error.terms.items()}


def without(one: Terms, other: Terms) -> Terms:
    """Return other - one of each term; 0 where they cancel but for rounding (`SharedError.minus`)."""
    left = {}
    for term in dict.fromkeys([*other, *one]):
        a, b = other.get(term, Fraction(0)), one.get(term, Fraction(0))
        left[term] = a - b if abs(a - b) > Fraction(CANCELLED) * max(abs(a), abs(b)) else Fraction(0)
    return left


def squares(terms: Terms) -> Fraction:
    """Return the variance of all terms together."""
    return sum((value * value for value in terms.values()), Fraction(0))


def _log(ratio: Fraction, less_one: Fraction) -> float:
    """Return the logarithm of a positive ratio of any size; `less_one` is what it exceeds 1 by."""
    if abs(less_one) < Fraction(1, 2):
        return math.log1p(float(less_one))
    exponent = ratio.numerator.bit_length() - ratio.denominator.bit_length()
    return math.log(float(ratio / Fraction(2) ** exponent)) + exponent * math.log(2.0)


_IN_SENTENCES = {"control": "the control", "treated": "the treated runs"}


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
    """100 (C - T) / C, in percent; negative where the treated runs cost more."""
    percent_ci: tuple[float, float] | Undefined
    """Fieller's interval, scatter and shared error together."""
    delta_ci: tuple[float, float] | Undefined
    """The delta interval, for comparison."""
    log_ci: tuple[float, float] | Undefined
    """The delta interval of log(T / C) brought back to percent, for comparison; never beyond 100 %."""
    se_percent: float | Undefined
    """Standard error from the scatter between runs (delta method), in percentage points."""
    shared_se_percent: float | Undefined
    """Standard error from the shared additive error alone, in percentage points."""
    df: float | Undefined
    """Welch and Satterthwaite's degrees of freedom over both scatters."""
    level: float
    """Level of the intervals."""
    scale_relative_se: float
    """Relative standard error common to all runs as a factor; it cancels and is in no number here."""
    missing: int
    """How many values were left out as NaN."""
    names: Names = ("control", "treated")
    """What control and treated runs are called in reasons and in the sentence."""

    @property
    def shown(self) -> bool | Undefined:
        """Whether a difference is shown: whether 0 does not lie within `percent_ci`."""
        return (
            self.percent_ci
            if isinstance(self.percent_ci, Undefined)
            else not self.percent_ci[0] < 0.0 < self.percent_ci[1]
        )

    def sentence(self, control: str | None = None, treated: str | None = None, confounded_with: str = "") -> str:
        """Return the savings in words, with interval and n: no more than the interval bears out.

        `confounded_with` is what they cannot be told from, such as "a difference between days": then no saving
        is claimed.
        """
        own = (_IN_SENTENCES.get(name, name) for name in self.names)
        control, treated = (given or name for given, name in zip((control, treated), own, strict=True))
        sizes = f"(n = {self.n_treated} against {self.n_control})"
        if isinstance(self.percent, Undefined):
            return f"The savings of {treated} against {control} {sizes} are undefined: {self.percent.reason}."
        error = error_of(self.percent_ci)
        estimate = f"{number_text(self.percent, error=error)} %"
        interval = interval_text(self.percent_ci, self.level, "%")
        if isinstance(self.percent_ci, Undefined):
            interval += f", because {self.percent_ci.reason}"
        else:
            interval += ", Fieller"
        end = f"{sizes}{missing_text(self.missing)}."
        if confounded_with:
            return (
                f"No saving of {treated} against {control} can be told from {confounded_with}: the estimate is "
                f"{estimate} ({interval}) {end}"
            )
        if self.percent == 0.0:
            return f"The means of {treated} and {control} are equal (savings {estimate}, {interval}) {end}"
        if isinstance(self.percent_ci, Undefined):
            return (
                f"The savings of {treated} against {control} cannot be bounded: the best estimate is "
                f"{estimate} ({interval}) {end}"
            )
        if not self.shown:
            return (
                f"No difference between {treated} and {control} is shown: the estimated savings are "
                f"{estimate} ({interval}) {end}"
            )
        return (
            f"The mean of {treated} is {number_text(abs(self.percent), error=error)} % "
            f"{'below' if self.percent > 0.0 else 'above'} that of {control} (savings {estimate}, {interval}) {end}"
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
    names: Names = ("control", "treated"),
) -> Savings:
    """Return 100 (C - T) / C of two samples of run values, shapes (n_c,) and (n_t,), in one unit (joules a jump).

    The shared errors, in that unit, are what each group's mean takes from errors common to runs of both (the drain
    fit). `scale_relative_se` is that of a common factor (the reference voltage): it cancels. Derivation at the top of
    this module. `names` are what both groups are called in the sentence, and where something is undefined or refused.
    Raises `InputRefused` for infinite values, for NaN unless `missing` is "drop", for a negative scale error, a level
    outside 0 to 1, one name for both groups, what is no `SharedError`, or two that differ about a fit they share.

    >>> found = percent_savings([42.1, 39.8, 44.0, 41.2], [36.9, 38.2, 35.1, 37.7])
    >>> round(found.percent, 1), [round(end, 1) for end in found.percent_ci]
    (11.5, [5.2, 17.3])
    """
    level = as_level("level", level)
    scale_relative_se = as_number("scale_relative_se", scale_relative_se, low=0.0)
    in_control, in_treated = (
        SharedError() if shared is None else as_shared(name, shared)
        for name, shared in (("shared_in_control", shared_in_control), ("shared_in_treated", shared_in_treated))
    )
    df_of_fits = degrees_of_fits([in_control, in_treated])
    names = pair_of_names(names)
    read = read_groups(as_pair(names, control, treated), missing)
    result = replace(_described(read, names, level, scale_relative_se), names=names)
    if read.empty:
        return result
    of_c, of_t = read.filled
    if of_c.exact_mean <= 0:
        none = Undefined(Reason.NOTHING_TO_SAVE)
        return replace(_without_interval(result, none), percent=none, se_percent=none, shared_se_percent=none)
    ratio = RatioOfMeans(of_c, of_t, *(in_unit(error, read.exponent) for error in (in_control, in_treated)))
    result = replace(
        result,
        percent=finite(100 * ratio.saved / ratio.mean, "the share"),
        shared_se_percent=finite(100 * exact_root(squares(ratio.shared)) / ratio.mean, "the standard error"),
    )
    if of_c.n < 2 or of_t.n < 2:
        single = of_c if of_c.n < 2 else of_t
        none = Undefined(Reason.SINGLE_RUN, group=f"group {single.name}")
        return replace(_without_interval(result, none), se_percent=none)
    result = replace(result, se_percent=finite(100 * exact_root(ratio.scatter) / ratio.mean, "the standard error"))
    if ratio.scatter == 0:
        if of_c.constant:
            return _without_interval(result, Undefined(Reason.GROUPS_WITHOUT_SCATTER))
        return _without_interval(result, Undefined(Reason.ALL_TREATED_ZERO))
    return _with_intervals(result, ratio, df_of_fits)


def _described(read: Groups, names: tuple[str, str], level: float, scale_relative_se: float) -> Savings:
    """Return what is known before any share is formed, everything else undefined."""
    means, sizes = (dict(zip(read.names, each, strict=True)) for each in (read.means, read.sizes))
    none = Undefined(Reason.GROUP_EMPTY, group=f"group {''.join(read.empty[:1])}")
    return Savings(
        n_control=int(sizes.get(names[0], 0)),
        n_treated=int(sizes.get(names[1], 0)),
        control_mean=means.get(names[0], none),
        treated_mean=means.get(names[1], Undefined(Reason.GROUP_EMPTY, group=f"group {names[1]}")),
        percent=none,
        percent_ci=none,
        delta_ci=none,
        log_ci=none,
        se_percent=none,
        shared_se_percent=none,
        df=none,
        level=level,
        scale_relative_se=scale_relative_se,
        missing=read.missing,
    )


def _with_intervals(result: Savings, ratio: RatioOfMeans, df_of_fits: Mapping[str, float]) -> Savings:
    ways = ratio.joined(df_of_fits, result.level)
    if not all(math.isfinite(way.quantile) and math.isfinite(way.more) for way in ways):
        return _without_interval(result, QUANTILE_BEYOND_DOUBLES)
    half = ratio.half_width(ways)
    middle = ratio.saved / ratio.mean
    return replace(
        result,
        percent_ci=ratio.fieller(ways),
        delta_ci=finite_pair(100 * (middle - half), 100 * (middle + half)),
        log_ci=ratio.log_interval(half),
        df=ratio.df,
    )


def _without_interval(result: Savings, why: Undefined) -> Savings:
    return replace(result, percent_ci=why, delta_ci=why, log_ci=why, df=why)
