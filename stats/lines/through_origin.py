"""The slope of a line through the origin, of values that come in groups (days) whose errors they share."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import as_level, as_values
from stats.compare.shared_error import SharedError, joined


@dataclass(frozen=True, slots=True)
class SlopeThroughOrigin:
    """y = slope * x, with what groups scatter by and what all x have in common.

    `se` is that of the scatter between groups, `shared_se` that of the errors that the x share; the interval `ci` holds
    both. `groups` is their number, `n` that of the values.
    """

    slope: float
    se: float | Undefined
    shared_se: float
    ci: tuple[float, float] | Undefined
    level: float
    groups: int
    n: int


def slope_through_origin(
    x: ArrayLike, y: ArrayLike, groups: Sequence[Hashable], shared: Sequence[SharedError] = (), level: float = 0.95
) -> SlopeThroughOrigin:
    """Fit y = slope * x by least squares; only groups are independent of each other.

    The standard error is that of the slope's scatter between groups, sqrt(G / (G - 1) sum of s_g^2) / sum(x^2), with
    s_g = sum of x * residual in the group, and Student's interval has G - 1 degrees of freedom. For groups that have
    the same x this is the mean of their slopes with its interval: a curve that all of them follow is no scatter.
    Errors of x make the slope smaller by their variance over the mean square of x, 0.02 % where they are 1.5 %.

    Parameters
    ----------
    x, y : (n,) values in one unit each
    groups : (n,) the group of each value, such as its day; each value its own where nothing is shared
    shared : (n,) errors that the x have in common with each other, where there are any
    level : of the interval

    Raises
    ------
    InputRefused for lengths that differ, no values, and x that are all 0.
    """
    across, up, level = as_values("the values of x", x), as_values("the values of y", y), as_level("level", level)
    if not across.size == up.size == len(groups) or (shared and len(shared) != across.size):
        raise InputRefused(f"there are {across.size} x, {up.size} y and {len(groups)} groups: give as many of each.")
    squares = float(across @ across) if across.size else 0.0
    if not squares > 0.0:
        raise InputRefused("no x differs from 0, and a line through the origin has no slope: give others.")
    slope = float(across @ up) / squares
    pulls = (up - 2.0 * slope * across) / squares
    error = SharedError()
    for pull, one in zip(pulls.tolist(), shared, strict=bool(shared)):
        error = error.minus(one.times(-pull))
    names = list(dict.fromkeys(groups))
    if len(names) < 2:
        none = Undefined(Reason.SINGLE_NO_SCATTER, unit="run")
        return SlopeThroughOrigin(slope, none, error.se, none, level, len(names), across.size)
    scores = across * (up - slope * across)
    of_groups = np.bincount([names.index(group) for group in groups], scores)
    df = len(names) - 1
    se = float(np.sqrt(len(names) / df * (of_groups @ of_groups)) / squares)
    ci: tuple[float, float] = (slope, slope)
    if se or error.se:
        _both, half, exponent = joined(se, df, error, level)
        ci = slope - float(np.ldexp(half, exponent)), slope + float(np.ldexp(half, exponent))
    return SlopeThroughOrigin(slope, se, error.se, ci, level, len(names), across.size)
