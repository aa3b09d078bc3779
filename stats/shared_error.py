"""The interval of a mean whose values share one error beside their scatter (the passive-drain fit, thesis 5.1.4).

The shared error does not shrink with more runs and is no part of their scatter; it is stated apart. Where the mean
itself is claimed, both bound it: variance s^2 / n + s_shared^2, with Welch and Satterthwaite's degrees of freedom.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from numpy.typing import ArrayLike

from data_schema.vocabulary import Undefined
from stats.checks import as_level, as_number
from stats.distributions import t_quantile
from stats.summary import Summary, describe


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


def describe_shared(
    values: ArrayLike, *, shared_se: float, shared_df: float = math.inf, level: float = 0.95
) -> SharedSummary:
    """Summarise values of shape (n,) that carry one common error of standard error `shared_se`, `shared_df` its df.

    Raises `InputRefused` for NaN or infinite values, a negative error or a level outside 0 to 1.
    """
    level = as_level("level", level)
    shared_se = as_number("shared_se", shared_se, low=0.0)
    scatter = describe(values, level)
    mean, se = scatter.mean, scatter.se
    if isinstance(mean, Undefined) or isinstance(se, Undefined):
        none = se if isinstance(se, Undefined) else Undefined("there is no value")
        return SharedSummary(scatter, shared_se, none, none, none, level)
    total = math.hypot(se, shared_se)
    if total == 0.0:
        return SharedSummary(scatter, shared_se, mean, mean, float(scatter.n - 1), level)
    df = 1.0 / ((se / total) ** 4 / (scatter.n - 1) + (shared_se / total) ** 4 / shared_df)
    half = t_quantile(level, df) * total
    return SharedSummary(scatter, shared_se, mean - half, mean + half, df, level)
