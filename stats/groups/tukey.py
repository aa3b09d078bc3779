"""All pairs of several groups at once: Tukey and Kramer for equal scatter, Games and Howell for unequal.

Both compare each difference of means with the studentized range, so that the chance of any false alarm among all pairs
is alpha: exactly for Tukey at equal n, less at unequal n (Kramer), nearly for Games and Howell.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import Literal

from numpy.typing import ArrayLike

from data_schema.errors import unknown_name
from data_schema.rounding import alpha_beside, error_of, interval_text, number_text, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level
from stats.exact.distributions import exact_df
from stats.exact.error_free import exact_root, shortened
from stats.exact.finite import Number, finite
from stats.exact.tails import Tail
from stats.groups.groups import Group, Groups, read_groups
from stats.groups.studentized_range import range_criticals, range_tails
from stats.results import Result
from stats.wording import missing_text, with_unit

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
    difference: float | Undefined
    """mean(a) - mean(b), in the values' unit."""
    difference_ci: tuple[float, float] | Undefined
    """Simultaneous: all intervals of the family cover together at its level."""
    q: float | Undefined
    """The studentized range: |difference| over its standard error, times the square root of 2."""
    df: float | Undefined
    """Degrees of freedom of the scatter: all groups' (Tukey) or the pair's (Games and Howell)."""
    p: float | Undefined
    """Adjusted for all pairs; 0.0 below 1e-308, where `log10_p` goes on."""
    log10_p: float | Undefined
    """Decimal logarithm of p, right at any size."""


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
            f"{statistic_text('q', pair.q, (len(self.groups), pair.df))}, {p_text(pair.p, alpha_beside(self.level))}"
        )


def compare_all_pairs(
    groups: Mapping[str, ArrayLike] | Sequence[ArrayLike],
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
    error_of = _pooled_error(read) if variances == "equal" else _own_error
    pairs = list(combinations(read.filled, 2))
    found = [Undefined(_empty(read)) if read.empty else _standardised(a, b, error_of(a, b)) for a, b in pairs]
    tests = iter(_tests([one for one in found if isinstance(one, _Standardised)], len(read.filled), 1.0 - level))
    compared = [
        _untested(read, a, b, one) if isinstance(one, Undefined) else _tested(read, a, b, one, next(tests))
        for (a, b), one in zip(pairs, found, strict=True)
    ]
    tukey = "Tukey" if len(set(read.sizes)) < 2 else "Tukey-Kramer"
    method = tukey if variances == "equal" else "Games-Howell"
    return AllPairs(method, read.names, read.sizes, tuple(compared), level, read.missing)


@dataclass(frozen=True, slots=True)
class _Error:
    """The squared standard error of a difference of means in scaled units, and its degrees of freedom."""

    squared: Fraction
    df: float


def _empty(read: Groups) -> str:
    return f"group {read.empty[0]!r} is empty, and the family without it would be another: leave it out"


def _pooled_error(read: Groups) -> Callable[[Group, Group], _Error | Undefined]:
    df, squares = read.df_within, read.squares_within

    def error(a: Group, b: Group) -> _Error | Undefined:
        if df < 1:
            return Undefined("no group has more than one value, so that nothing measures the scatter")
        if squares == 0:
            return Undefined("no group has any scatter")
        return _Error(squares / df * (Fraction(1, a.n) + Fraction(1, b.n)), float(df))

    return error


def _own_error(a: Group, b: Group) -> _Error | Undefined:
    for group in (a, b):
        if group.n < 2:
            return Undefined(f"group {group.name!r} has a single value, and its variance needs at least 2")
    part_a, part_b = a.exact_mean_variance, b.exact_mean_variance
    squared = part_a + part_b
    if squared == 0:
        return Undefined("neither group has any scatter")
    return _Error(squared, float(exact_df([(part_a, a.n - 1), (part_b, b.n - 1)])))


def _untested(read: Groups, a: Group, b: Group, why: Undefined) -> PairDifference:
    shown = read.in_unit(a.exact_mean - b.exact_mean)
    return PairDifference(a.name, b.name, a.n, b.n, shown, why, why, why, why, why)


@dataclass(frozen=True, slots=True)
class _Standardised:
    """A difference of means over its standard error, both in scaled units."""

    difference: Fraction
    se: Fraction
    """Of the studentized range: the difference's over the square root of 2."""
    q: Number
    df: float


def _standardised(a: Group, b: Group, error: _Error | Undefined) -> _Standardised | Undefined:
    if isinstance(error, Undefined):
        return error
    difference, se = a.exact_mean - b.exact_mean, exact_root(error.squared / 2)
    return _Standardised(difference, se, shortened(abs(difference) / se), error.df)


def _tests(given: list[_Standardised], k: int, alpha: float) -> list[tuple[float, Tail]]:
    """Return the critical q and the tail of each difference, all of one family, integrated together."""
    dfs = tuple(dict.fromkeys(one.df for one in given))
    criticals = dict(zip(dfs, range_criticals(alpha, k, dfs), strict=True))
    tails = range_tails([one.q for one in given], k, [one.df for one in given])
    return [(criticals[one.df], tail) for one, tail in zip(given, tails, strict=True)]


def _tested(read: Groups, a: Group, b: Group, one: _Standardised, test: tuple[float, Tail]) -> PairDifference:
    critical, tail = test
    half = Fraction(critical) * one.se
    return PairDifference(
        a=a.name,
        b=b.name,
        n_a=a.n,
        n_b=b.n,
        difference=read.in_unit(one.difference),
        difference_ci=read.pair_in_unit(one.difference - half, one.difference + half),
        q=finite(one.q, "q"),
        df=one.df,
        p=tail.p,
        log10_p=tail.log10_p,
    )
