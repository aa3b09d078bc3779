"""Errors that several values have in common (the passive-drain fit, thesis 5.1.4), carried from runs to claims.

A drain line errs in its level and in its slope. Both errors are the same for every run corrected with that line; what
they make of a run's joules depends on its duration and its jumps. So a value carries a signed standard error for each
independent term, and a linear combination of values carries the same combination of the terms: in a mean they stay
whatever the number of runs, in a difference at equal durations and jumps they cancel, and in nothing are they counted
as scatter between runs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from numpy.typing import ArrayLike

from data_schema.vocabulary import Undefined
from stats.checks import as_level, as_number
from stats.distributions import t_quantile
from stats.summary import Summary, describe

CANCELLED = 1e-9
"""What is left of two equal terms after their difference is rounding, not error."""


@dataclass(frozen=True, slots=True)
class SharedError:
    """What one value takes from errors that it has in common with others; raises `InputRefused` for what is no number.

    `terms` holds signed standard errors by (fit, term), in the value's unit; the terms are independent of each other.
    `df` holds the degrees of freedom of each fit, which all its terms were estimated with.
    """

    terms: Mapping[tuple[str, str], float] = field(default_factory=dict)
    df: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the numbers."""
        for (fit, term), value in self.terms.items():
            as_number(f"the shared error {fit} {term}", value)
            if self.df.get(fit) != math.inf:
                as_number(f"the degrees of freedom of {fit}", self.df.get(fit, 0.0), above=0.0)

    @property
    def se(self) -> float:
        """The standard error of all terms together."""
        return math.hypot(*self.terms.values())

    @property
    def degrees_of_freedom(self) -> float:
        """Those of the fit; of several fits after Welch and Satterthwaite; infinite where there is no error."""
        variances = dict.fromkeys(self.df, 0.0)
        for (fit, _term), value in self.terms.items():
            variances[fit] += value * value
        total = math.fsum(variances.values())
        if total == 0.0:
            return math.inf
        doubt = math.fsum((variance / total) ** 2 / self.df[fit] for fit, variance in variances.items())
        return 1.0 / doubt if doubt > 0.0 else math.inf

    def times(self, factor: float) -> SharedError:
        """Return the error of `factor` times the value."""
        return SharedError({term: factor * value for term, value in self.terms.items()}, self.df)

    def minus(self, other: SharedError) -> SharedError:
        """Return the error of the difference of two values; terms that cancel but for rounding are 0."""
        terms = {}
        for term in dict.fromkeys([*self.terms, *other.terms]):
            one, two = self.terms.get(term, 0.0), other.terms.get(term, 0.0)
            terms[term] = 0.0 if math.isclose(one, two, rel_tol=CANCELLED) else one - two
        return SharedError(terms, {**other.df, **self.df})


def shared_of_mean(errors: Sequence[SharedError]) -> SharedError:
    """Return the error of the mean of values that carry these: the mean of each term."""
    terms: dict[tuple[str, str], list[float]] = {}
    df: dict[str, float] = {}
    for error in errors:
        df |= error.df
        for term, value in error.terms.items():
            terms.setdefault(term, []).append(value)
    return SharedError({term: math.fsum(values) / len(errors) for term, values in terms.items()}, df)


@dataclass(frozen=True, slots=True)
class SharedSummary:
    """A mean with its scatter and the error it shares with other means, in the unit of the values."""

    scatter: Summary
    """What the values alone say; its interval leaves the shared error out."""
    shared_se: float
    ci_low: float | Undefined
    ci_high: float | Undefined
    df: float | Undefined
    """Welch and Satterthwaite's, over scatter and shared error."""
    level: float


def describe_shared(values: ArrayLike, shared: SharedError, level: float = 0.95) -> SharedSummary:
    """Summarise values of shape (n,) whose mean carries the error `shared`: variance s^2 / n + s_shared^2.

    The shared error does not shrink with more values and is no part of their scatter; where the mean itself is claimed,
    both bound it. Raises `InputRefused` for NaN or infinite values or a level outside 0 to 1.
    """
    level = as_level("level", level)
    scatter = describe(values, level)
    mean, se, shared_se = scatter.mean, scatter.se, shared.se
    if isinstance(mean, Undefined) or isinstance(se, Undefined):
        none = se if isinstance(se, Undefined) else Undefined("there is no value")
        return SharedSummary(scatter, shared_se, none, none, none, level)
    total = math.hypot(se, shared_se)
    if total == 0.0:
        return SharedSummary(scatter, shared_se, mean, mean, float(scatter.n - 1), level)
    df = 1.0 / ((se / total) ** 4 / (scatter.n - 1) + (shared_se / total) ** 4 / shared.degrees_of_freedom)
    half = t_quantile(level, df) * total
    return SharedSummary(scatter, shared_se, mean - half, mean + half, df, level)
