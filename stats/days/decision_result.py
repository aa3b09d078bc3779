"""What a contrast by shared days gives: an estimate with interval and test, and two one-sided tests within bounds."""

from __future__ import annotations

from dataclasses import dataclass

from data_schema.vocabulary import Undefined
from stats.exact.tails import t_upper


@dataclass(frozen=True, slots=True)
class Estimate:
    """An estimate with its interval and the test that it is 0, in the unit of the values or in percent."""

    value: float | Undefined
    se: float | Undefined
    """Without errors in common."""
    shared_se: float | Undefined
    """What it takes from errors in common with others."""
    ci: tuple[float, float] | Undefined
    level: float
    t: float | Undefined
    df: float | Undefined
    p: float | Undefined
    """Two-sided."""
    log10_p: float | Undefined


@dataclass(frozen=True, slots=True)
class Bounded:
    """Two one-sided tests that an estimate lies above `low` and below `high`, and its interval of level 1 - 2 alpha."""

    value: float | Undefined
    low: float
    high: float
    ci: tuple[float, float] | Undefined
    alpha: float
    t_low: float | Undefined
    p_low: float | Undefined
    t_high: float | Undefined
    p_high: float | Undefined
    df: float | Undefined
    p: float | Undefined
    """The larger of both."""
    equivalent: bool | Undefined
    """Whether p is at most alpha; the interval lies within the bounds just then."""


def bounded(
    value: float | Undefined,
    bounds: tuple[float, float],
    ci: tuple[float, float] | Undefined,
    alpha: float,
    t: tuple[float, float],
    df: float,
) -> Bounded:
    """Return two one-sided tests from their t at the lower and the upper bound."""
    p_low, p_high = t_upper(t[0], df).p, t_upper(-t[1], df).p
    p = max(p_low, p_high)
    equivalent = p <= alpha and not isinstance(ci, Undefined)
    return Bounded(value, *bounds, ci, alpha, t[0], p_low, t[1], p_high, df, p, equivalent)


def no_estimate(why: Undefined, level: float, value: float | Undefined) -> Estimate:
    """Return an estimate without interval and test."""
    return Estimate(value, why, why, why, level, why, why, why, why)


def not_bounded(why: Undefined, bounds: tuple[float, float], alpha: float, value: float | Undefined) -> Bounded:
    """Return what there is where nothing is tested against bounds."""
    return Bounded(value, *bounds, why, alpha, why, why, why, why, why, why, why)
