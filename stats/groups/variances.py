"""Whether groups scatter alike: the ratio of two variances, and Brown and Forsythe's test.

F holds its level for normal values only; Brown and Forsythe's test, on distances from the medians, stays below its
level, far below where groups have 3 to 5 values. Bartlett's and Levene's are `scipy.stats.bartlett` and `levene`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from data_schema.reasons import Reason
from data_schema.rounding import p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, Samples, as_groups, as_sample
from stats.results import Result, missing_text, plural
from stats.scatter import Floats, Group, Groups, Value, finite, read_groups, scale_of
from stats.tails import f_two_sided, f_upper

_ROUNDING = 8.0 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True, slots=True)
class VarianceTest(Result):
    """Brown and Forsythe's test of equal variances."""

    groups: tuple[str, ...]
    """Names of the k groups that hold values, as given; shape (k,)."""
    group_ns: tuple[int, ...]
    """Their sizes, shape (k,)."""
    statistic: Value
    """F, dimensionless."""
    df: tuple[int, int]
    """Degrees of freedom of numerator and denominator."""
    p: Value
    """The chance of a statistic so large where all groups scatter alike."""
    missing: int = 0
    """How many values were left out as NaN."""
    test: str = "Brown-Forsythe"

    def sentence(self) -> str:
        """Return the test in words: statistic, degrees of freedom, p, n."""
        sizes = f"({plural(len(self.groups), 'group')}, n = {sum(self.group_ns)}{missing_text(self.missing)})"
        head = f"{self.test} test of equal variances {sizes}"
        if isinstance(self.p, Undefined):
            return f"{head}: none, because {self.p.reason}."
        return f"{head}: {statistic_text('F', self.statistic, self.df)}, {p_text(self.p)}."


def variance_ratio(a: Group, b: Group) -> tuple[Value, Value]:
    """Return var(a) / var(b) and the two-sided p of the F-test, as R's `var.test`."""
    for group in (a, b):
        if group.n < 2:
            small = Undefined(Reason.TOO_FEW_FOR_VARIANCE, group=f"group {group.name}", n=group.n)
            return small, small
    if b.constant:
        if a.constant:
            return Undefined(Reason.RATIO_OF_ZEROS), Undefined(Reason.GROUPS_CONSTANT)
        name = f"group {b.name}"
        return Undefined(Reason.RATIO_BY_ZERO, group=name), Undefined(Reason.GROUP_CONSTANT, group=name)
    if a.constant:
        return 0.0, Undefined(Reason.GROUP_CONSTANT, group=f"group {a.name}")
    ratio = a.variance / b.variance
    return finite(ratio, "the ratio"), f_two_sided(ratio, a.n - 1, b.n - 1)


def brown_forsythe(groups: Samples, missing: Missing = "refuse") -> VarianceTest:
    """Return Brown and Forsythe's test of samples of shape (n_i,): ANOVA of the distances from the medians.

    Raises `InputRefused`, naming the group, for infinite values, and for NaN unless `missing` is "drop".
    """
    given = {name: as_sample(f"group {name!r}", values, missing) for name, values in as_groups(groups).items()}
    left_out = sum(sample.missing for sample in given.values())
    scale = scale_of(*(sample.values for sample in given.values()))
    read = read_groups({name: _distances(scale.scaled(sample.values)) for name, sample in given.items()})
    df = (max(len(read.filled) - 1, 0), read.df_within)
    none = _too_few(read)
    if none is None and all(n == 2 for n in read.sizes):
        none = Undefined(Reason.DISTANCES_EQUAL)
    if none is None and read.squares_within == 0.0:
        none = Undefined(Reason.SPREADS_EQUAL)
    if none is not None:
        return VarianceTest(read.names, read.sizes, none, df, none, left_out)
    f = (read.squares_between / df[0]) / (read.squares_within / df[1])
    return VarianceTest(read.names, read.sizes, finite(f, "F"), df, f_upper(f, *df), left_out)


def _too_few(read: Groups) -> Undefined | None:
    """Return why groups have no scatter to compare."""
    if len(read.filled) + len(read.empty) < 2:
        return Undefined(Reason.FEWER_THAN_TWO_GROUPS)
    if read.empty:
        return Undefined(Reason.TOO_FEW_FOR_SCATTER, group=f"group {read.empty[0]!r}", n=0)
    small = next((group for group in read.filled if group.n < 2), None)
    return None if small is None else Undefined(Reason.TOO_FEW_FOR_SCATTER, group=f"group {small.name!r}", n=small.n)


def _distances(scaled: Floats) -> Floats:
    """Return how far values, shape (n,), lie from the median of their group; distances equal but for rounding alike."""
    if not scaled.size:
        return scaled
    away = np.abs(scaled - np.median(scaled))
    return np.full_like(away, away[0]) if np.ptp(away) <= _ROUNDING * np.abs(scaled).max() else away
