"""How far two methods differ, of the same things: mean difference and limits of agreement (Bland and Altman 1986)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from data_schema.errors import InputRefused
from stats.checks import as_level
from stats.exact.tails import t_quantile

FEWEST = 3
"""Differences whose scatter says something about the next one."""


@dataclass(frozen=True, slots=True)
class LimitsOfAgreement:
    """In the unit of the differences: their mean, and the limits between which 95 % of further ones are expected.

    Each has its standard error and a Student interval with n - 1 degrees of freedom at `level`.
    """

    mean: float
    se: float
    ci: tuple[float, float]
    low: float
    low_ci: tuple[float, float]
    high: float
    high_ci: tuple[float, float]
    limit_se: float
    n: int
    level: float


def limits_of_agreement(differences: Sequence[float], level: float = 0.95) -> LimitsOfAgreement:
    """Return the mean difference and the limits of agreement.

    Parameters
    ----------
    differences : (n,) one method less the other, of n things, each counted once
    level : of the intervals, and the share that the limits should hold

    Raises
    ------
    InputRefused
        With fewer than three differences, or one that is not finite.

    Source: Bland and Altman (1986), The Lancet 327, 307; the standard error of a limit as there.

    >>> found = limits_of_agreement([1.0, 2.0, 3.0])
    >>> f"{found.mean:.2f}, {found.low:.2f} to {found.high:.2f}"
    '2.00, 0.04 to 3.96'
    """
    values, level = np.asarray(differences, dtype=np.float64), as_level("level", level)
    n = values.size
    if n < FEWEST or not np.isfinite(values).all():
        raise InputRefused(f"limits of agreement need at least {FEWEST} finite differences: {n} were given.")
    sd, z = float(values.std(ddof=1)), NormalDist().inv_cdf(0.5 + level / 2.0)
    t = t_quantile(level, n - 1)
    mean, se = float(values.mean()), sd / math.sqrt(n)
    limit_se = sd * math.sqrt(1.0 / n + z**2 / (2.0 * (n - 1)))

    def interval(value: float, error: float) -> tuple[float, float]:
        return value - t * error, value + t * error

    low, high = mean - z * sd, mean + z * sd
    return LimitsOfAgreement(
        mean, se, interval(mean, se), low, interval(low, limit_se), high, interval(high, limit_se), limit_se, n, level
    )
