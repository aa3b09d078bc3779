"""All pairs of several groups at once: Tukey and Kramer for equal scatter, Games and Howell for unequal.

Both compare each difference of means with the studentized range, so that the chance of any false alarm among all pairs
is alpha: exactly for Tukey at equal n, less at unequal n (Kramer), nearly for Games and Howell.

For k standard normals with largest value z the range exceeds w with the chance

    k times the integral of phi(z) (Phi(z)^(k-1) - (Phi(z) - Phi(z - w))^(k-1)) dz,

whose integrand is positive and is computed without a difference of nearly equal numbers. For k = 2 the range is the
square root of 2 times |t|.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from data_schema.errors import unknown_name
from data_schema.reasons import Reason
from data_schema.rounding import alpha_of_level, error_of, interval_text, number_text, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level
from stats.compare.summary import Group, Groups, read_groups
from stats.exact.numbers import Floats, Number, exact_root, finite, to_120_bits
from stats.exact.quadrature import (
    FAR,
    Rows,
    critical_values,
    log_means_over_scale,
    log_sum,
    log_upper_of_any,
    steepness_of_largest,
)
from stats.exact.tails import Tail, exact_df, t_two_sided
from stats.results import Result, missing_text, with_unit

_REACH = 9.6
"""How far from the middle of the range its largest value counts."""
_LOG_ROOT_2PI = 0.5 * math.log(2.0 * math.pi)


def log_range_chance(w: Floats, k: int) -> Floats:
    """Return the logarithm of the chance that the range of k standard normals exceeds each w, any shape.

    That is the studentized range where the standard deviation is known; it is integrated over the largest value.
    """
    step = min(0.2, 0.25 / steepness_of_largest(k))  # errs by less than 1e-14 of the chance for k up to a million
    z = w[..., None] / 2.0 + np.arange(-math.ceil(_REACH / step), math.ceil(_REACH / step) + 1) * step
    log_a, log_b = special.log_ndtr(z), special.log_ndtr(z - w[..., None])
    ratio = np.minimum(log_b - log_a, 0.0)
    with np.errstate(divide="ignore"):
        share = np.log(-np.expm1((k - 1) * np.log1p(-np.exp(ratio))))
    # Where the ratio is too small for a double, the power's first term is all of it.
    share = np.where(ratio < -600.0, math.log(k - 1) + ratio, share)
    terms = (k - 1) * log_a - 0.5 * z * z + share
    return np.asarray(np.minimum(log_sum(terms) + math.log(k * step) - _LOG_ROOT_2PI, 0.0))


def range_tail(q: Number, k: int, df: float) -> Tail:
    """Return P(Q > q) of the studentized range of k means with df degrees of freedom (df may be infinite)."""
    return range_tails((q,), k, (df,))[0]


def range_tails(qs: Sequence[Number], k: int, dfs: Sequence[float]) -> tuple[Tail, ...]:
    """Return `range_tail` of many q, each with its own df, integrated together."""
    near = _log_uppers(np.array([float(min(q, FAR)) for q in qs]), k, np.array(dfs, dtype=np.float64)).tolist()
    return tuple(_tail(q, k, df, log_near) for q, df, log_near in zip(qs, dfs, near, strict=True))


def range_critical(tail: float, k: int, df: float) -> float:
    """Return the q that the studentized range exceeds with chance `tail`."""
    return range_criticals(tail, k, (df,))[0]


@lru_cache(maxsize=256)
def range_criticals(tail: float, k: int, dfs: tuple[float, ...]) -> tuple[float, ...]:
    """Return `range_critical` of each of many degrees of freedom, searched together."""

    df, root = np.array(dfs, dtype=np.float64), math.sqrt(2.0)
    criticals = critical_values(
        lambda t, rows: _log_uppers(root * t, k, df[rows]), tail, df, k * (k - 1) // 2, two_sided=True
    )
    return tuple((root * criticals).tolist())


def _tail(q: Number, k: int, df: float, log_near: float) -> Tail:
    """Return the tail at q, `log_near` being its logarithm at q or, before that, at `FAR`."""
    if q > 0 and k == 2 and math.isfinite(df):
        return t_two_sided(exact_root(Fraction(q) ** 2 / 2), df)
    log_p = log_upper_of_any(lambda _near: log_near, q, df)
    return Tail(math.exp(log_p), log_p / math.log(10.0))


def _log_uppers(q: Floats, k: int, df: Floats) -> Floats:
    """Return log P(Q > q) of each q with its own df, both of shape (m,)."""
    found = np.zeros(q.shape)
    exact = np.isfinite(df) & (k == 2)
    for row in np.flatnonzero((q > 0.0) & exact):
        found[row] = math.log(10.0) * t_two_sided(math.sqrt(0.5) * float(q[row]), float(df[row])).log10_p
    sure = (q > 0.0) & np.isinf(df)
    found[sure] = log_range_chance(q[sure], k)
    rest = (q > 0.0) & ~exact & ~sure
    found[rest] = log_range_tails(q[rest], k, df[rest])
    return found


def log_range_tails(q: Floats, k: int, df: Floats) -> Floats:
    """Return log P(Q > q) of each positive q with its own finite df, by integration over the scale."""

    def log_chance(u: Floats, rows: Rows) -> Floats:
        return log_range_chance(q[rows, None] * np.exp(u), k)

    lowest = -np.log(np.maximum(q, 1.0)) - 3.0
    return log_means_over_scale(log_chance, df, lowest, steepness=steepness_of_largest(k))


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
            f"{statistic_text('q', pair.q, (len(self.groups), pair.df))}, {p_text(pair.p, alpha_of_level(self.level))}"
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
    found = [_empty(read) if read.empty else _standardised(a, b, error_of(a, b)) for a, b in pairs]
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


def _empty(read: Groups) -> Undefined:
    return Undefined(Reason.GROUP_EMPTY_OF_FAMILY, group=f"group {read.empty[0]!r}")


def _pooled_error(read: Groups) -> Callable[[Group, Group], _Error | Undefined]:
    df, squares = read.df_within, read.squares_within

    def error(a: Group, b: Group) -> _Error | Undefined:
        if df < 1:
            return Undefined(Reason.NO_GROUP_OF_TWO_TO_SCATTER)
        if squares == 0:
            return Undefined(Reason.NO_GROUP_SCATTERS)
        return _Error(squares / df * (Fraction(1, a.n) + Fraction(1, b.n)), float(df))

    return error


def _own_error(a: Group, b: Group) -> _Error | Undefined:
    for group in (a, b):
        if group.n < 2:
            return Undefined(Reason.SINGLE_NO_VARIANCE, group=f"group {group.name!r}")
    part_a, part_b = a.exact_mean_variance, b.exact_mean_variance
    squared = part_a + part_b
    if squared == 0:
        return Undefined(Reason.GROUPS_WITHOUT_SCATTER)
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
    return _Standardised(difference, se, to_120_bits(abs(difference) / se), error.df)


def _tests(given: list[_Standardised], k: int, alpha: float) -> list[tuple[float, Tail]]:
    """Return the critical q and the tail of each difference, all of one family, integrated together."""
    if not given:
        return []
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
