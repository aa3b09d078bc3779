"""What shuffling and redrawing the values of two groups says."""

from __future__ import annotations

import math
from dataclasses import dataclass

from data_schema.vocabulary import Undefined
from stats.results import Result
from stats.wording import counted, half_width, interval_text, missing_text, number_text, p_text, with_unit


def _log10(p: float | Undefined) -> float | Undefined:
    return p if isinstance(p, Undefined) else math.log10(p)


def _within(n_days: int | Undefined) -> str:
    return "" if isinstance(n_days, Undefined) else f" within {counted(n_days, 'day')}"


def _sizes(found: Permutation | Bootstrap) -> str:
    """Return the numbers of values, and how many of them are of days that only one group has."""
    sizes = f"n = {found.n_a} and {found.n_b}"
    if isinstance(found.difference, Undefined) or not (found.unused_a or found.unused_b):
        return sizes
    return f"{sizes}, of which {found.unused_a} and {found.unused_b} are of days of one group only and not used"


@dataclass(frozen=True, slots=True)
class Permutation(Result):
    """Group a against group b by shuffling the labels within each day."""

    n_a: int
    """Number of values of group a."""
    n_b: int
    """Number of values of group b."""
    n_days: int | Undefined
    """Number of days that hold both groups."""
    difference: float | Undefined
    """a minus b within days, in the unit of the values."""
    p: float | Undefined
    """Two-sided: share of arrangements whose difference is at least as large either way."""
    p_greater: float | Undefined
    """Share of arrangements whose difference is at least the one found."""
    p_less: float | Undefined
    """Share of arrangements whose difference is at most the one found."""
    exact: bool
    """Whether all arrangements were counted."""
    arrangements: int
    """How many arrangements were counted or drawn."""
    seed: int | Undefined
    """Seed of the draws; undefined where all arrangements were counted."""
    missing: int = 0
    """Values left out because they or their day were missing."""
    unused_a: int = 0
    """How many of the n_a values are of days that group b lacks: they enter nothing."""
    unused_b: int = 0
    """How many of the n_b values are of days that group a lacks: they enter nothing."""

    @property
    def log10_p(self) -> float | Undefined:
        """Decimal logarithm of `p`, which counts at least one arrangement."""
        return _log10(self.p)

    @property
    def log10_p_greater(self) -> float | Undefined:
        """Decimal logarithm of `p_greater`."""
        return _log10(self.p_greater)

    @property
    def log10_p_less(self) -> float | Undefined:
        """Decimal logarithm of `p_less`."""
        return _log10(self.p_less)

    def sentence(self, a: str = "a", b: str = "b", unit: str = "") -> str:
        """Return the test in words: difference, p, how many arrangements, n."""
        where = _sizes(self)
        if isinstance(self.p, Undefined):
            return f"No permutation test of {a} and {b} ({where}): {self.p.reason}."
        within = _within(self.n_days)
        how = (
            f"all {self.arrangements} arrangements" if self.exact else counted(self.arrangements, "random arrangement")
        )
        return (
            f"{a} minus {b}{within} is {number_text(self.difference)}{with_unit(unit)}, permutation test over {how}, "
            f"{p_text(self.p)} ({where}{missing_text(self.missing)})."
        )


@dataclass(frozen=True, slots=True)
class Bootstrap(Result):
    """Interval of the difference of group a and group b by redrawing values within each day and group."""

    n_a: int
    """Number of values of group a."""
    n_b: int
    """Number of values of group b."""
    n_days: int | Undefined
    """Number of days that hold both groups."""
    difference: float | Undefined
    """a minus b within days, in the unit of the values."""
    se: float | Undefined
    """Standard deviation of the redrawn differences, in the unit of the values."""
    interval: tuple[float, float] | Undefined
    """Studentised (bootstrap-t), in the unit of the values."""
    bca_interval: tuple[float, float] | Undefined
    """Bias-corrected and accelerated, for comparison: a stated 95 % covers 82, 87, 92 and 94 % for 3, 5, 10 and 25
    normal values a group."""
    percentile_interval: tuple[float, float] | Undefined
    """Plain percentiles, for comparison; a stated 95 % covers 81, 88 and 92 % for 3, 5 and 10 normal values a group."""
    level: float
    """Level of the intervals."""
    resamples: int
    """How many times the values were redrawn."""
    seed: int
    """Seed of the draws: the same seed gives the same digits."""
    missing: int = 0
    """Values left out because they or their day were missing."""
    unused_a: int = 0
    """How many of the n_a values are of days that group b lacks: they enter nothing."""
    unused_b: int = 0
    """How many of the n_b values are of days that group a lacks: they enter nothing."""

    def sentence(self, a: str = "a", b: str = "b", unit: str = "") -> str:
        """Return the difference and its interval in words."""
        where = _sizes(self)
        if isinstance(self.difference, Undefined):
            return f"No bootstrap of {a} and {b} ({where}): {self.difference.reason}."
        difference = number_text(self.difference, within=half_width(self.interval))
        text = f"{a} minus {b} is {difference}{with_unit(unit)}"
        if isinstance(self.interval, Undefined):
            return f"{text} ({where}); no bootstrap interval, because {self.interval.reason}."
        return (
            f"{text} ({interval_text(self.interval, self.level, unit)} by studentised bootstrap"
            f"{_within(self.n_days)}, {self.resamples} draws, "
            f"seed {self.seed}; {where}{missing_text(self.missing)})."
        )
