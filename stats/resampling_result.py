"""What shuffling and redrawing the values of two groups says."""

from __future__ import annotations

from dataclasses import dataclass

from data_schema.vocabulary import Undefined
from stats.wording import interval_text, number_text, p_text, with_unit


@dataclass(frozen=True, slots=True)
class Permutation:
    """Group a against group b by shuffling the labels within each day."""

    n_a: int
    n_b: int
    n_days: int | Undefined
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

    def sentence(self, a: str = "a", b: str = "b", unit: str = "") -> str:
        """Return the test in words: difference, p, how many arrangements, n."""
        where = f"n = {self.n_a} and {self.n_b}"
        if isinstance(self.p, Undefined):
            return f"No permutation test of {a} and {b} ({where}): {self.p.reason}."
        within = "" if isinstance(self.n_days, Undefined) else f" within {self.n_days} days"
        how = f"all {self.arrangements} arrangements" if self.exact else f"{self.arrangements} random arrangements"
        return (
            f"{a} minus {b}{within} is {number_text(self.difference)}{with_unit(unit)}, permutation test over {how}, "
            f"{p_text(self.p)} ({where})."
        )


@dataclass(frozen=True, slots=True)
class Bootstrap:
    """Interval of the difference of group a and group b by redrawing values within each day and group."""

    n_a: int
    n_b: int
    n_days: int | Undefined
    difference: float | Undefined
    """a minus b within days, in the unit of the values."""
    se: float | Undefined
    """Standard deviation of the redrawn differences."""
    interval: tuple[float, float] | Undefined
    """Bias-corrected and accelerated (BCa)."""
    percentile_interval: tuple[float, float] | Undefined
    """Plain percentiles, which cover too rarely in small groups (0.87 to 0.90 at a stated 0.95)."""
    level: float
    resamples: int
    seed: int

    def sentence(self, a: str = "a", b: str = "b", unit: str = "") -> str:
        """Return the difference and its interval in words."""
        where = f"n = {self.n_a} and {self.n_b}"
        if isinstance(self.difference, Undefined):
            return f"No bootstrap of {a} and {b} ({where}): {self.difference.reason}."
        text = f"{a} minus {b} is {number_text(self.difference)}{with_unit(unit)}"
        if isinstance(self.interval, Undefined):
            return f"{text} ({where}); no bootstrap interval, because {self.interval.reason}."
        return (
            f"{text} ({interval_text(self.interval, self.level, unit)} by BCa bootstrap within days, "
            f"{self.resamples} draws, seed {self.seed}; {where})."
        )
