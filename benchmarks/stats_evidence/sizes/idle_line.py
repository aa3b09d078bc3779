"""One line through idle runs, which all runs of a study are corrected with, and how its error joins their scatter.

Idle runs are equidistant in their durations. The control's runs last as long as their mean and the treated ones as
long as the longest: the error of the line's level cancels in the difference, that of its slope does not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from benchmarks.stats_evidence.sizes.design import Floats
from benchmarks.stats_evidence.sizes.method import LEVEL
from stats.compare.shared_error import ENOUGH_DEGREES, SharedError
from stats.lines.passive_drain import fit_passive_drain

SHORTEST, OF_CONTROL, LONGEST = 0.5, 1.0, 1.5
"""Durations of idle runs from and to, and that of the control's runs; the treated ones last longest."""


@dataclass(frozen=True, slots=True)
class Line:
    """The line through the idle runs of each study; arrays of shape (runs,)."""

    level: Floats
    slope: Floats
    level_se: Floats
    slope_se: Floats
    df: int

    def at(self, duration: float) -> Floats:
        """Return what is taken off a run of a duration; the true line is 0."""
        return np.asarray(self.level + self.slope * (duration - OF_CONTROL))

    def terms(self, duration: float) -> Floats:
        """Return the standard errors of level and slope there, shape (2, runs)."""
        return np.stack([self.level_se, self.slope_se * (duration - OF_CONTROL)])


def _durations(idle: int) -> Floats:
    return np.linspace(SHORTEST, LONGEST, idle)


def line_of(idle: Floats) -> Line:
    """Return the lines through idle runs, shape (runs, idle runs)."""
    n = idle.shape[1]
    about = _durations(n) - OF_CONTROL
    level, slope = idle.mean(axis=1), idle @ about / (about @ about)
    left = idle - level[:, None] - slope[:, None] * about
    sd = np.sqrt((left**2).sum(axis=1) / (n - 2))
    return Line(level, slope, sd / np.sqrt(n), sd / np.sqrt(about @ about), n - 2)


@dataclass(frozen=True, slots=True)
class Way:
    """One of the ways in which scatter and the line's error join; arrays of shape (runs,)."""

    df: Floats
    more: Floats
    """How much more the line's variance counts than the scatter's."""

    @property
    def quantile(self) -> Floats:
        """Student's two-sided quantile of the level."""
        return np.asarray(-special.stdtrit(self.df, (1.0 - LEVEL) / 2.0))


def ways(variance: Floats, df: Floats, shared: Floats, own_df: int) -> tuple[Way, ...]:
    """Return the ways in which a variance and that of the line's error, of `own_df` degrees of freedom, may join."""
    alone = Way(df, np.zeros_like(variance))
    if own_df < ENOUGH_DEGREES:
        ratio = Way(np.full_like(df, own_df), alone.more).quantile / alone.quantile
        return (Way(df, ratio**2),)
    together = (variance + shared) ** 2 / (variance**2 / df + shared**2 / own_df)
    return alone, Way(together, np.ones_like(variance))


def half_width(variance: Floats, df: Floats, shared: Floats, own_df: int) -> Floats:
    """Return the widest half width of all ways."""
    squared = [way.quantile**2 * (variance + way.more * shared) for way in ways(variance, df, shared, own_df)]
    return np.asarray(np.sqrt(np.max(squared, axis=0)))


def corrected(idle: Floats, *runs: tuple[Floats, float]) -> tuple[list[Floats], list[SharedError]]:
    """Return runs less the line at their duration, and what each group's mean takes from its error."""
    line = fit_passive_drain(_durations(idle.size), idle)
    at = [(line.at(duration).charge_mah, line.error_terms_mah(duration)) for _values, duration in runs]
    errors = [
        SharedError({("drain", name): value for name, value in terms.items()}, {"drain": line.df})
        for _charge, terms in at
    ]
    return [values - charge for (values, _duration), (charge, _terms) in zip(runs, at, strict=True)], errors
