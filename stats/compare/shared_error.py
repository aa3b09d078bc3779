"""Errors that several values have in common (the passive-drain fit, thesis 5.1.4), carried from runs to claims.

A drain line errs in its level and in its slope. Both errors are the same for every run corrected with that line; what
they make of a run's joules depends on its duration and its jumps. So a value carries a signed standard error for each
independent term, and a linear combination of values carries the same combination of the terms: in a mean they stay
whatever the number of runs, in a difference at equal durations and jumps they cancel, and in nothing are they counted
as scatter between runs.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.checks import as_level
from stats.compare.summary import Summary, describe
from stats.results import Result
from stats.scatter import Value, finite
from stats.tails import satterthwaite_df, t_quantile

CANCELLED = 1e-9
"""What is left of two equal terms after their difference is rounding, not error."""


@dataclass(frozen=True, slots=True)
class SharedError:
    """What one value takes from errors that it has in common with others.

    `terms` holds signed standard errors by (fit, term), in the value's unit; the terms are independent of each other.
    `df` holds the degrees of freedom of each fit, which all its terms were estimated with. Raises `InputRefused` for
    what is not finite, and for a term of a fit without degrees of freedom.
    """

    terms: Mapping[tuple[str, str], float] = field(default_factory=dict)
    df: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the numbers."""
        for fit, df in self.df.items():
            if not df > 0.0:
                raise InputRefused(f"the degrees of freedom of {fit} are {df!r}: give a number above 0.")
        for fit, term in self.terms:
            if fit not in self.df:
                raise InputRefused(f"there are no degrees of freedom of {fit} {term}: give them beside its errors.")
        if not math.isfinite(self.se):
            raise InputRefused(f"the shared error {dict(self.terms)} has no finite standard error.")

    @property
    def se(self) -> float:
        """The standard error of all terms together."""
        return math.hypot(*self.terms.values())

    @property
    def degrees_of_freedom(self) -> float:
        """Those of the fit; of several fits after Welch and Satterthwaite; infinite where there is no error."""
        variances, se = dict.fromkeys(self.df, 0.0), self.se or 1.0  # only proportions count
        for (fit, _term), value in self.terms.items():
            variances[fit] += (value / se) ** 2
        return satterthwaite_df([(variance, self.df[fit]) for fit, variance in variances.items()])

    def times(self, factor: float) -> SharedError:
        """Return the error of `factor` times the value; raises `InputRefused` for a factor that is not finite."""
        return SharedError({term: factor * value for term, value in self.terms.items()}, self.df)

    def minus(self, other: SharedError) -> SharedError:
        """Return the error of the difference of two values; terms that cancel but for rounding are 0.

        Raises `InputRefused` for one fit with two numbers of degrees of freedom.
        """
        df = degrees_of_fits([self, other])
        terms = {}
        for term in dict.fromkeys([*self.terms, *other.terms]):
            one, two = self.terms.get(term, 0.0), other.terms.get(term, 0.0)
            terms[term] = 0.0 if math.isclose(one, two, rel_tol=CANCELLED) else one - two
        return SharedError(terms, df)


def degrees_of_fits(errors: Iterable[SharedError]) -> dict[str, float]:
    """Return the degrees of freedom of all fits; raises `InputRefused` where two errors differ about one fit."""
    found: dict[str, float] = {}
    for error in errors:
        for fit, df in error.df.items():
            if found.setdefault(fit, df) != df:
                raise InputRefused(
                    f"{fit} has {found[fit]:g} degrees of freedom in one shared error and {df:g} in another: errors of "
                    "one fit have the same, and two fits need two names."
                )
    return found


def shared_of_mean(errors: Sequence[SharedError]) -> SharedError:
    """Return the error of the mean of values that carry these: the mean of each term.

    Raises `InputRefused` for one fit with two numbers of degrees of freedom.
    """
    if len(errors) == 1:
        return errors[0]
    terms: dict[tuple[str, str], list[float]] = {}
    df = degrees_of_fits(errors)
    for error in errors:
        for term, value in error.terms.items():
            terms.setdefault(term, []).append(value)
    return SharedError({term: math.fsum(values) / len(errors) for term, values in terms.items()}, df)


def weighted_sum(errors: Sequence[SharedError], weights: Sequence[float]) -> SharedError:
    """Return the error of a weighted sum; the weights sum to 1."""
    n = len(errors)
    terms: dict[tuple[str, str], list[float]] = {}
    for error, weight in zip(errors, weights, strict=True):
        for term, value in error.terms.items():
            terms.setdefault(term, []).append(weight * n * value)
    return SharedError({term: math.fsum(values) / n for term, values in terms.items()}, degrees_of_fits(errors))


ENOUGH_DEGREES = 4.0
"""Degrees of freedom of a fit (six idle runs) from which Welch and Satterthwaite's approximation holds."""


def joined_half_width(se: float, df: float, shared: SharedError, level: float) -> float:
    """Return the half width of an interval of an estimate that scatters by `se` (with df) and has a shared error.

    With enough degrees of freedom in the fit there is one quantile, after Welch and Satterthwaite over both parts, but
    no less than the scatter alone has. With fewer that covers too rarely (90 % at a stated 95 % for three idle runs
    whose error dominates), so the shared error keeps the quantile of its own degrees of freedom: half widths in
    quadrature cover 95 to 99 %.
    """
    own_df, unit = shared.degrees_of_freedom, math.hypot(se, shared.se) or 1.0
    if se == 0.0:
        return t_quantile(level, own_df) * shared.se
    alone = t_quantile(level, df) * se
    if own_df < ENOUGH_DEGREES:
        return math.hypot(alone, t_quantile(level, own_df) * shared.se)
    together = satterthwaite_df([((se / unit) ** 2, df), ((shared.se / unit) ** 2, own_df)])
    return max(alone, t_quantile(level, together) * unit)


def joined_variance(one: SharedError, other: SharedError, level: float, df: float) -> float:
    """Return the covariance that two values take from errors in common, as it counts beside a quantile of `df`.

    A fit of fewer than four degrees of freedom keeps the quantile of its own: its part counts by the square of the
    ratio of the quantiles.
    """
    quantile = t_quantile(level, df)
    total = 0.0
    for (fit, term), value in one.terms.items():
        more = (t_quantile(level, one.df[fit]) / quantile) ** 2 if one.df[fit] < ENOUGH_DEGREES else 1.0
        total += more * value * other.terms.get((fit, term), 0.0)
    return total


@dataclass(frozen=True, slots=True)
class SharedSummary(Result):
    """A mean with its scatter and the error it shares with other means, in the unit of the values."""

    scatter: Summary
    """What the values alone say; its interval leaves the shared error out."""
    shared_se: float
    """Standard error that the mean shares with others, in the unit of the values."""
    ci_low: Value
    """Lower end of the interval of both errors together, in the unit of the values."""
    ci_high: Value
    """Its upper end, in the unit of the values."""
    level: float
    """Level of the interval."""


def describe_shared(values: ArrayLike, shared: SharedError, level: float = 0.95) -> SharedSummary:
    """Summarise values of shape (n,) whose mean carries the error `shared`.

    The shared error does not shrink with more values and is no part of their scatter; where the mean itself is claimed,
    both bound it. Raises `InputRefused` for values that are missing or infinite, or a level outside 0 to 1.
    """
    level = as_level("level", level)
    scatter = describe(values, level)
    mean, se = scatter.mean, scatter.se
    if isinstance(mean, Undefined) or isinstance(se, Undefined) or not (se or shared.se):
        return SharedSummary(scatter, shared.se, scatter.ci_low, scatter.ci_high, level)
    half = joined_half_width(se, scatter.n - 1.0, shared, level)
    low, high = (finite(end, "an end of the interval") for end in (mean - half, mean + half))
    return SharedSummary(scatter, shared.se, low, high, level)
