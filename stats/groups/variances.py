"""Whether groups scatter alike: the ratio of two variances, and Bartlett's, Levene's and Brown and Forsythe's tests.

F and Bartlett hold their level for normal values only; Levene's test, on distances from the means, does better, and
Brown and Forsythe's, on distances from the medians, stays below its level, far below where groups have 3 to 5 values.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from data_schema.reasons import Reason
from data_schema.rounding import p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_groups, as_sample
from stats.results import Result, missing_text, plural
from stats.scatter import Floats, Group, Groups, finite, read_groups, scale_of
from stats.tails import f_two_sided, f_upper

_ROUNDING = 8.0 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True, slots=True)
class VarianceTest(Result):
    """A test of equal variances."""

    test: str
    """"Bartlett", "Levene" or "Brown-Forsythe"."""
    groups: tuple[str, ...]
    """Names of the k groups that hold values, as given; shape (k,)."""
    group_ns: tuple[int, ...]
    """Their sizes, shape (k,)."""
    statistic: float | Undefined
    """F, or Bartlett's chi-squared; dimensionless."""
    df: tuple[int, ...]
    """Degrees of freedom: of numerator and denominator, shape (2,), or of chi-squared, shape (1,)."""
    p: float | Undefined
    """The chance of a statistic so large where all groups scatter alike."""
    missing: int = 0
    """How many values were left out as NaN."""

    def sentence(self) -> str:
        """Return the test in words: statistic, degrees of freedom, p, n."""
        sizes = f"({plural(len(self.groups), 'group')}, n = {sum(self.group_ns)}{missing_text(self.missing)})"
        if isinstance(self.p, Undefined):
            return f"{self.test} test of equal variances {sizes}: none, because {self.p.reason}."
        sign = "chi-squared" if self.test == "Bartlett" else "F"
        return (
            f"{self.test} test of equal variances {sizes}: {statistic_text(sign, self.statistic, self.df)}, "
            f"{p_text(self.p)}."
        )


def variance_ratio(a: Group, b: Group) -> tuple[float | Undefined, float | Undefined]:
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


def bartlett(groups: Mapping[str, ArrayLike] | Sequence[ArrayLike], missing: Missing = "refuse") -> VarianceTest:
    """Return Bartlett's test of samples of shape (n_i,); every group needs 2 values.

    Raises `InputRefused`, naming the group, for infinite values, and for NaN unless `missing` is "drop".
    """
    read = read_groups(groups, missing)
    degrees = max(len(read.filled) - 1, 0)
    none = _too_few(read, Reason.TOO_FEW_FOR_VARIANCE)
    if none is None:
        constant = next((group for group in read.filled if group.constant), None)
        none = None if constant is None else Undefined(Reason.GROUP_CONSTANT, group=f"group {constant.name!r}")
    if none is not None:
        return VarianceTest("Bartlett", read.names, read.sizes, none, (degrees,), none, read.missing)
    dfs = np.array(read.sizes) - 1.0
    ratios = np.array([group.variance for group in read.filled]) / (read.squares_within / dfs.sum())
    # The sum of df * (v - 1) over all ratios v is 0, so that no two large logarithms cancel
    summed = math.fsum((dfs * (ratios - 1.0 - np.log(ratios))).tolist())
    statistic = summed / (1.0 + (math.fsum(1.0 / dfs) - 1.0 / dfs.sum()) / (3.0 * degrees))
    p = float(special.chdtrc(degrees, statistic))
    return VarianceTest("Bartlett", read.names, read.sizes, statistic, (degrees,), p, read.missing)


def levene(groups: Mapping[str, ArrayLike] | Sequence[ArrayLike], missing: Missing = "refuse") -> VarianceTest:
    """Return Levene's test: ANOVA of the distances from the means. Raises `InputRefused` as `bartlett` does."""
    return _of_distances("Levene", groups, missing, lambda values: float(values.mean()))


def brown_forsythe(groups: Mapping[str, ArrayLike] | Sequence[ArrayLike], missing: Missing = "refuse") -> VarianceTest:
    """Return Brown and Forsythe's test: ANOVA of the distances from the medians. Raises as `bartlett` does."""
    return _of_distances("Brown-Forsythe", groups, missing, lambda values: float(np.median(values)))


def _too_few(read: Groups, reason: Reason) -> Undefined | None:
    """Return why groups have no scatter to compare."""
    if len(read.filled) + len(read.empty) < 2:
        return Undefined(Reason.FEWER_THAN_TWO_GROUPS)
    if read.empty:
        return Undefined(reason, group=f"group {read.empty[0]!r}", n=0)
    small = next((group for group in read.filled if group.n < 2), None)
    return None if small is None else Undefined(reason, group=f"group {small.name!r}", n=small.n)


def _of_distances(
    test: str,
    groups: Mapping[str, ArrayLike] | Sequence[ArrayLike],
    missing: Missing,
    middle: Callable[[Floats], float],
) -> VarianceTest:
    given = {name: as_sample(f"group {name!r}", values, missing) for name, values in as_groups(groups).items()}
    left_out = sum(sample.missing for sample in given.values())
    scale = scale_of(*(sample.values for sample in given.values()))
    distances = {name: _distances(scale.scaled(sample.values), middle) for name, sample in given.items()}
    read = replace(read_groups(distances), missing=left_out)
    df = (max(len(read.filled) - 1, 0), read.df_within)
    none = _too_few(read, Reason.TOO_FEW_FOR_SCATTER)
    if none is None and all(n == 2 for n in read.sizes):
        none = Undefined(Reason.DISTANCES_EQUAL)
    if none is None and read.squares_within == 0.0:
        none = Undefined(Reason.SPREADS_EQUAL)
    if none is not None:
        return VarianceTest(test, read.names, read.sizes, none, df, none, left_out)
    f = (read.squares_between / df[0]) / (read.squares_within / df[1])
    return VarianceTest(test, read.names, read.sizes, finite(f, "F"), df, f_upper(f, *df), left_out)


def _distances(scaled: Floats, middle: Callable[[Floats], float]) -> Floats:
    """Return how far values, shape (n,), lie from the middle of their group; distances equal but for rounding alike."""
    if not scaled.size:
        return scaled
    away = np.abs(scaled - middle(scaled))
    return np.full_like(away, away[0]) if np.ptp(away) <= _ROUNDING * np.abs(scaled).max() else away
