"""All pairs of several groups at once: Tukey and Kramer for equal scatter, Games and Howell for unequal.

Both compare each difference of means with the studentized range, so that the chance of any false alarm among all pairs
is alpha: exactly for Tukey at equal n, less at unequal n (Kramer), nearly for Games and Howell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from typing import Literal

from data_schema.errors import unknown_name
from data_schema.reasons import Reason
from data_schema.rounding import alpha_of_level, error_of, interval_text, number_text, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, Samples, as_level
from stats.results import Result, missing_text, with_unit
from stats.scatter import Group, Groups, Interval, Value, read_groups
from stats.tails import satterthwaite_df, t_two_sided, t_upper_quantile

Variances = Literal["equal", "unequal"]
VARIANCES: tuple[Variances, ...] = ("equal", "unequal")
"""Tukey and Kramer with one pooled variance, or Games and Howell with each pair's own."""


@dataclass(frozen=True, slots=True)
class PairDifference(Result):
    """One pair of groups among all, mean(a) - mean(b) in the values' unit."""

    a: str
    """Name of the first group."""
    b: str
    """Name of the second group."""
    n_a: int
    """Number of values of group a."""
    n_b: int
    """Number of values of group b."""
    difference: Value
    """mean(a) - mean(b), in the values' unit."""
    difference_ci: Interval | Undefined
    """Simultaneous: all intervals of the family cover together at its level."""
    q: Value
    """The studentized range: |difference| over its standard error, times the square root of 2."""
    df: Value
    """Degrees of freedom of the scatter: all groups' (Tukey) or the pair's (Games and Howell)."""
    p: Value
    """Adjusted for all pairs."""


@dataclass(frozen=True, slots=True)
class AllPairs(Result):
    """Every pair of groups, in the order given."""

    method: str
    """"Tukey" (equal n), "Tukey-Kramer" or "Games-Howell"."""
    groups: tuple[str, ...]
    """Names of the k groups that hold values, as given; shape (k,)."""
    group_ns: tuple[int, ...]
    """Their sizes, shape (k,)."""
    pairs: tuple[PairDifference, ...]
    """(first, second), (first, third) and so on; shape (k (k - 1) / 2,)."""
    level: float
    """Simultaneous level of the intervals."""
    missing: int
    """How many values were left out as NaN."""

    def rows(self) -> tuple[PairDifference, ...]:
        """Return the pairs, for `to_frame`."""
        return self.pairs

    def sentence(self, unit: str = "") -> str:
        """Return the pairs in words: each difference with its simultaneous interval and adjusted p."""
        if not self.pairs:
            return f"No pairs to compare ({self._sizes()})."
        return f"{self.head_text()}: {'; '.join(self.pair_text(pair, unit) for pair in self.pairs)}."

    def head_text(self) -> str:
        """Return what the sentence begins with: the method, how many groups and values."""
        return f"All pairs by {self.method}, simultaneous ({self._sizes()})"

    def pair_text(self, pair: PairDifference, unit: str = "") -> str:
        """Return one of the pairs in words, as it stands in the sentence."""
        return (
            f"{pair.a} minus {pair.b} {number_text(pair.difference, error=error_of(pair.difference_ci))}"
            f"{with_unit(unit)} ({self._test(pair, unit)})"
        )

    def _sizes(self) -> str:
        return f"{len(self.groups)} groups, n = {sum(self.group_ns)}{missing_text(self.missing)}"

    def _test(self, pair: PairDifference, unit: str) -> str:
        if isinstance(pair.q, Undefined):
            return f"no test, because {pair.q.reason}"
        return (
            f"{interval_text(pair.difference_ci, self.level, unit)}, "
            f"{statistic_text('q', pair.q, (len(self.groups), pair.df))}, {p_text(pair.p, alpha_of_level(self.level))}"
        )


def compare_all_pairs(
    groups: Samples,
    *,
    variances: Variances = "equal",
    level: float = 0.95,
    missing: Missing = "refuse",
) -> AllPairs:
    """Compare all pairs of groups of values, each of shape (n_i,), all in one unit.

    Raises `InputRefused`, naming the group, for infinite values, and for NaN unless `missing` is "drop"; `UnknownName`
    for other variances.
    """
    if variances not in VARIANCES:
        raise unknown_name("assumption on variances", variances, VARIANCES)
    level = as_level("level", level)
    read = read_groups(groups, missing)
    pairs = tuple(_compared(read, a, b, variances, level) for a, b in combinations(read.filled, 2))
    tukey = "Tukey" if len(set(read.sizes)) < 2 else "Tukey-Kramer"
    method = tukey if variances == "equal" else "Games-Howell"
    return AllPairs(method, read.names, read.sizes, pairs, level, read.missing)


def _compared(read: Groups, a: Group, b: Group, variances: Variances, level: float) -> PairDifference:
    difference = a.mean - b.mean
    shown = read.scale.length(difference)
    error = _error(read, a, b, variances)
    if isinstance(error, Undefined):
        return PairDifference(a.name, b.name, a.n, b.n, shown, error, error, error, error)
    squared, df = error
    se, k = math.sqrt(squared / 2.0), len(read.filled)
    q, half = abs(difference) / se, _range_quantile(1.0 - level, k, df) * se
    ci = read.scale.interval(difference - half, difference + half)
    return PairDifference(a.name, b.name, a.n, b.n, shown, ci, q, df, _range_upper(q, k, df))


def _range_upper(q: float, k: int, df: float) -> float:
    """Return P(Q >= q) of the studentized range of k means; of two it is sqrt(2) times |t|."""
    if k == 2:
        return t_two_sided(q / math.sqrt(2.0), df)
    from scipy.stats import studentized_range  # takes a second to load

    return float(studentized_range.sf(q, k, df))


@lru_cache(maxsize=256)
def _range_quantile(tail: float, k: int, df: float) -> float:
    """Return the q that the range exceeds with chance `tail`, by a tenth of the integrals of scipy's `ppf`.

    It lies between what it is for two means and what Bonferroni allows for all pairs.
    """
    low = math.sqrt(2.0) * t_upper_quantile(tail / 2.0, df)
    if k == 2:
        return low
    from scipy.optimize import brentq

    high = math.sqrt(2.0) * t_upper_quantile(tail / (k * (k - 1)), df)
    return float(brentq(lambda q: _range_upper(q, k, df) - tail, low, high, rtol=1e-13))


def _error(read: Groups, a: Group, b: Group, variances: Variances) -> tuple[float, float] | Undefined:
    """Return the squared standard error of a difference in the groups' scale, and its degrees of freedom."""
    if read.empty:
        return Undefined(Reason.GROUP_EMPTY_OF_FAMILY, group=f"group {read.empty[0]!r}")
    if variances == "equal":
        if read.df_within < 1:
            return Undefined(Reason.NO_GROUP_OF_TWO_TO_SCATTER)
        if read.squares_within == 0.0:
            return Undefined(Reason.NO_GROUP_SCATTERS)
        return read.squares_within / read.df_within * (1.0 / a.n + 1.0 / b.n), float(read.df_within)
    for group in (a, b):
        if group.n < 2:
            return Undefined(Reason.SINGLE_NO_VARIANCE, group=f"group {group.name!r}")
    if a.constant and b.constant:
        return Undefined(Reason.GROUPS_WITHOUT_SCATTER)
    parts = [(group.mean_variance, group.n - 1.0) for group in (a, b)]
    return a.mean_variance + b.mean_variance, satterthwaite_df(parts)
