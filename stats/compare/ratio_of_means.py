"""Intervals of the share S = (C - T) / C of two means that have scatter and errors in common, in exact fractions.

With rho = T / C, T - rho C has mean 0 for the true rho; its variance and what it leads to stand in `compare.savings`.
Fractions are rounded once, at the ends: means and errors of any sizes may stand beside each other.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from data_schema.vocabulary import Undefined
from stats.compare.shared_error import CANCELLED, Joint, SharedError, joints
from stats.exact.error_free import exact_root, shortened
from stats.exact.finite import Interval, finite_pair
from stats.exact.welch_satterthwaite import exact_df
from stats.groups.groups import Group

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
        return shortened(self.treated.exact_mean / self.mean)

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
            return Undefined("the control's mean is not distinguishable from 0 at this level")
        middle = bottom * top - squared * covariance
        root = exact_root(middle * middle - quadratic * (top * top - squared * top_variance))
        return finite_pair(100 * (middle - root) / quadratic, 100 * (middle + root) / quadratic)

    def log_interval(self, half: Fraction) -> Interval | Undefined:
        """Return the percent where log(rho) -/+ half / rho ends."""
        rho = self.rho
        if rho <= 0:
            return Undefined("the treated mean is not positive and has no logarithm")
        spread = half / rho
        # A ratio that could be anything from almost 0 to beyond all doubles bounds nothing.
        if spread > _LARGEST_LOG:
            return Undefined("the treated mean is not distinguishable from 0 at this level")
        middle = _log(rho, -self.saved / self.mean)
        if middle + float(spread) > _LARGEST_LOG:
            return Undefined("an end of the interval is too large for a double")
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
