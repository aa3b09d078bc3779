"""One-way analysis of variance (thesis 5.2.1: joules a jump over the active-damping gain)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from numpy.typing import ArrayLike

from data_schema.vocabulary import Undefined
from stats.checks import as_values
from stats.distributions import f_upper_p
from stats.sums import common_shift, moments
from stats.wording import number_text, p_text


@dataclass(frozen=True, slots=True)
class Anova:
    """Whether the means of several groups differ by more than their scatter explains."""

    groups: tuple[str, ...]
    """Names of the groups that hold values, as given."""
    group_ns: tuple[int, ...]
    """Their sizes."""
    f: float | Undefined
    df_between: int
    df_within: int
    p: float | Undefined
    eta_squared: float | Undefined
    """Share of the total sum of squares that lies between the groups."""

    def sentence(self, what: str = "the groups") -> str:
        """Return the result in words: F, both degrees of freedom, p, eta squared, n."""
        n = sum(self.group_ns)
        if isinstance(self.f, Undefined):
            return f"No one-way ANOVA over {what} ({len(self.groups)} groups, n = {n}): {self.f.reason}."
        return (
            f"One-way ANOVA over {what}: F({self.df_between}, {self.df_within}) = {number_text(self.f)}, "
            f"{p_text(self.p)}, eta squared {number_text(self.eta_squared, 3)} ({len(self.groups)} groups, n = {n})."
        )


def one_way_anova(groups: Mapping[str, ArrayLike]) -> Anova:
    """Analyse groups of values, each of shape (n_i,), all in one unit; groups without a value are left out.

    F = (SS_between / (k - 1)) / (SS_within / (n - k)); sums are taken about one common median.
    Raises `InputRefused` for NaN or infinite values, naming the group.
    """
    samples = {name: as_values(f"group {name!r}", values) for name, values in groups.items()}
    samples = {name: sample for name, sample in samples.items() if sample.size}
    sizes = tuple(sample.size for sample in samples.values())
    df_between, df_within = max(len(samples) - 1, 0), sum(sizes) - len(samples)

    def without(reason: str, eta_squared: float | Undefined | None = None) -> Anova:
        none = Undefined(reason)
        return Anova(
            tuple(samples), sizes, none, df_between, df_within, none, none if eta_squared is None else eta_squared
        )

    if len(samples) < 2:
        return without("at least 2 groups with values are needed")
    shift = common_shift(*samples.values())
    parts = [moments(sample, shift) for sample in samples.values()]
    grand = math.fsum(part.n * part.offset for part in parts) / sum(sizes)
    between = math.fsum(part.n * (part.offset - grand) ** 2 for part in parts)
    within = math.fsum(part.sum_squares for part in parts)
    if all(part.offset == parts[0].offset for part in parts):
        between = 0.0  # equal means, whatever rounding makes of the grand mean
    total = between + within
    eta_squared = between / total if total > 0.0 else Undefined("all values are equal")
    if df_within < 1:
        return without("no group has more than one value, so that nothing measures the scatter", eta_squared)
    if within == 0.0:
        return without("no group has any scatter", eta_squared)
    f = (between / df_between) / (within / df_within)
    return Anova(tuple(samples), sizes, f, df_between, df_within, f_upper_p(f, df_between, df_within), eta_squared)
