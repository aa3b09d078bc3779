"""Student's, Welch's and the F-test over many studies at once: plain formulas, which tests hold to the library's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from benchmarks.stats_evidence.sizes.design import Floats
from benchmarks.stats_evidence.sizes.method import LEVEL


@dataclass(frozen=True, slots=True)
class Estimate:
    """A difference with its standard error and degrees of freedom, each of shape (runs,)."""

    difference: Floats
    se: Floats
    df: Floats

    @property
    def p(self) -> Floats:
        """Two-sided."""
        return np.asarray(2.0 * special.stdtr(self.df, -np.abs(self.difference / self.se)))

    @property
    def p_below_zero(self) -> Floats:
        """One-sided, small where the difference lies far below 0."""
        return np.asarray(special.stdtr(self.df, self.difference / self.se))

    @property
    def ends(self) -> tuple[Floats, Floats]:
        """The interval of level 0.95."""
        half = -special.stdtrit(self.df, (1.0 - LEVEL) / 2.0) * self.se
        return self.difference - half, self.difference + half


def flat(values: Floats) -> Floats:
    """Return all values of a study in one row, days put together."""
    return np.asarray(values.reshape(len(values), -1))


def variance(values: Floats) -> Floats:
    """Return the sample variance of each study, shape (runs,)."""
    return np.asarray(np.var(values, axis=1, ddof=1))


def student(a: Floats, b: Floats, weight: float = 1.0) -> Estimate:
    """Return mean(a) - weight mean(b) with a pooled variance."""
    n_a, n_b = a.shape[1], b.shape[1]
    pooled = ((n_a - 1) * variance(a) + (n_b - 1) * variance(b)) / (n_a + n_b - 2)
    difference = a.mean(axis=1) - weight * b.mean(axis=1)
    se = np.sqrt(pooled * (1.0 / n_a + weight * weight / n_b))
    return Estimate(difference, se, np.full(len(a), n_a + n_b - 2.0))


def welch(a: Floats, b: Floats, weight: float = 1.0) -> Estimate:
    """Return mean(a) - weight mean(b), each with a variance of its own."""
    part_a, part_b = variance(a) / a.shape[1], weight * weight * variance(b) / b.shape[1]
    squared = part_a + part_b
    df = squared**2 / (part_a**2 / (a.shape[1] - 1) + part_b**2 / (b.shape[1] - 1))
    return Estimate(a.mean(axis=1) - weight * b.mean(axis=1), np.sqrt(squared), df)


def f_p(a: Floats, b: Floats) -> Floats:
    """Return the two-sided p of the F-test."""
    ratio, df = variance(a) / variance(b), (a.shape[1] - 1, b.shape[1] - 1)
    return np.asarray(2.0 * np.minimum(special.fdtr(*df, ratio), special.fdtrc(*df, ratio)))


def f_then_t(a: Floats, b: Floats) -> Estimate:
    """Return Student's estimate where the F-test at 0.05 finds no difference of variances, else Welch's."""
    equal = f_p(a, b) >= 1.0 - LEVEL
    one, other = student(a, b), welch(a, b)
    return Estimate(one.difference, np.where(equal, one.se, other.se), np.where(equal, one.df, other.df))


def anova_f(groups: list[Floats]) -> tuple[Floats, int, int]:
    """Return F of one-way analysis of variance, shape (runs,), and its degrees of freedom."""
    k, n = len(groups), sum(group.shape[1] for group in groups)
    means = np.stack([group.mean(axis=1) for group in groups])
    sizes = np.array([group.shape[1] for group in groups])[:, None]
    grand = (sizes * means).sum(axis=0) / n
    between = (sizes * (means - grand) ** 2).sum(axis=0) / (k - 1)
    within = sum((group.shape[1] - 1) * variance(group) for group in groups) / (n - k)
    return np.asarray(between / within), k - 1, n - k
