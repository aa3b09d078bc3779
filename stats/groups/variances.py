"""Whether groups scatter alike: the F-test of two, and Bartlett's, Levene's and Brown and Forsythe's tests of several.

F and Bartlett hold their level for normal values only (0.18 instead of 0.05 for Student's t with 5 degrees of freedom,
n = 30); Levene's test, on distances from the means, does better, and Brown and Forsythe's, on distances from the
medians, stays below 0.05 in all five distributions tried, far below where groups have 3 to 5 values
(docs/statistics/error_rates.csv). Constant groups have no test: nothing comes from 0/0.

Each distance from the middle of a group is taken to twice double accuracy: equal ones come out equal, whatever rounding
makes of the middle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from data_schema.reasons import Reason
from data_schema.rounding import interval_text, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, Sample, as_groups, as_level, as_sample
from stats.compare.summary import AS_A_AND_B, Names, pair_of_names, too_small
from stats.exact.numbers import (
    Floats,
    Moments,
    exact_sum,
    finite,
    finite_pair,
    moments,
    out_of_range,
    to_120_bits,
)
from stats.exact.tails import Tail, chi2_upper, f_two_sided, f_upper
from stats.results import Result, missing_text, plural

_FEW = 50
"""Values up to which fractions take no time that anybody notices."""


def from_mean(sample: Sample) -> Sample:
    """Return how far the values, at least 1, lie from their mean."""
    return _distances(sample, exact_sum(sample.values, sample.rest) / sample.values.size)


def from_median(sample: Sample) -> Sample:
    """Return how far the values, at least 1, lie from their median."""
    values, n = sample.values, sample.values.size
    rest = np.zeros(n) if sample.rest is None else sample.rest
    middle = np.lexsort((rest, values))[(n - 1) // 2 : n // 2 + 1]
    return _distances(sample, exact_sum(values[middle], rest[middle]) / middle.size)


def _distances(sample: Sample, middle: Fraction) -> Sample:
    values, rest = sample.values, sample.rest
    if values.size > _FEW:
        return _distances_of_many(values, rest, middle)
    more = [0.0] * values.size if rest is None else rest.tolist()
    exact = [abs(Fraction(a) + Fraction(b) - middle) for a, b in zip(values.tolist(), more, strict=True)]
    near = list(map(float, exact))
    left = [float(number - Fraction(double)) for number, double in zip(exact, near, strict=True)]
    return Sample(np.array(near), np.array(left), 0)


def _distances_of_many(values: Floats, rest: Floats | None, middle: Fraction) -> Sample:
    """Return the distances as sums of two doubles: what each subtraction loses is a double (Knuth's two-sum)."""
    near = float(middle)
    away = values - near
    back = away - values
    lost = (values - (away - back)) - (near + back)
    left = lost - float(middle - Fraction(near))
    if rest is not None:
        left = left + rest
    double = away + left
    left = left - (double - away)
    return Sample(np.abs(double), np.where(double < 0.0, -left, left), 0)


Interval = tuple[float, float]

_FAR_OUTSIDE = 1e-4
_NO_RATIO = Undefined(Reason.NO_RATIO_OF_VARIANCES)


@dataclass(frozen=True, slots=True)
class VarianceTest(Result):
    """A test of equal variances."""

    test: str
    """"F", "Bartlett", "Levene" or "Brown-Forsythe"."""
    groups: tuple[str, ...]
    """Names of the k groups, as given; shape (k,)."""
    group_ns: tuple[int, ...]
    """Their sizes, shape (k,)."""
    statistic: float | Undefined
    """F, or Bartlett's chi-squared; dimensionless."""
    df: tuple[int, ...]
    """Degrees of freedom: of numerator and denominator, shape (2,), or of chi-squared, shape (1,)."""
    p: float | Undefined
    """Two-sided for F of two groups."""
    log10_p: float | Undefined
    """Decimal logarithm of p, right below 1e-300, too."""
    ratio_ci: Interval | Undefined = _NO_RATIO
    """Interval of var(first) / var(second), of the F-test."""
    level: float = 0.95
    """Level of the interval."""
    missing: int = 0
    """How many values were left out as NaN."""

    def sentence(self) -> str:
        """Return the test in words: statistic, degrees of freedom, p, n."""
        sizes = f"({plural(len(self.groups), 'group')}, n = {sum(self.group_ns)}{missing_text(self.missing)})"
        if isinstance(self.p, Undefined):
            return f"{self.test} test of equal variances {sizes}: none, because {self.p.reason}."
        sign = "chi-squared" if self.test == "Bartlett" else "F"
        ratio = f", ratio of variances {interval_text(self.ratio_ci, self.level)}" if self.test == "F" else ""
        return (
            f"{self.test} test of equal variances {sizes}: {statistic_text(sign, self.statistic, self.df)}, "
            f"{p_text(self.p)}{ratio}."
        )


def f_test(
    a: ArrayLike,
    b: ArrayLike,
    level: float = 0.95,
    missing: Missing = "refuse",
    *,
    names: Names = AS_A_AND_B,
) -> VarianceTest:
    """Compare the variances of two groups, shapes (n_a,) and (n_b,), by their ratio; as R's `var.test`.

    `names` are what the groups are called where something is undefined or refused.
    Raises `InputRefused` for infinite values, and for NaN unless `missing` is "drop".
    """
    level = as_level("level", level)
    names = pair_of_names(names)
    first, second = (as_sample(f"group {name}", x, missing) for name, x in zip(names, (a, b), strict=True))
    of_a, of_b = moments(first.values, first.rest), moments(second.values, second.rest)
    ratio, tail = variance_ratio(of_a, of_b, names)
    sizes, df = (of_a.n, of_b.n), (of_a.n - 1, of_b.n - 1)
    left_out = first.missing + second.missing
    f = ratio if isinstance(ratio, Undefined) else finite(ratio, "the ratio")
    if isinstance(tail, Undefined) or isinstance(ratio, Undefined):
        none = tail if isinstance(tail, Undefined) else Undefined(Reason.NO_RATIO)
        return VarianceTest("F", names, sizes, f, df, none, none, none, level, left_out)
    outside = (1.0 - level) / 2.0
    low = Fraction(float(special.fdtri(df[1], df[0], outside)))
    # 1 - outside loses the digits of a little one; the quantile there is 1 over that of the other ratio.
    if outside < _FAR_OUTSIDE:
        high = 1 / Fraction(float(special.fdtri(*df, outside)))
    else:
        high = Fraction(float(special.fdtri(df[1], df[0], 1.0 - outside)))
    ends = finite_pair(ratio * low, ratio * high)
    return VarianceTest("F", names, sizes, f, df, tail.p, tail.log10_p, ends, level, left_out)


def bartlett(groups: Mapping[str, ArrayLike] | Sequence[ArrayLike], missing: Missing = "refuse") -> VarianceTest:
    """Return Bartlett's test; every group needs 2 values. Raises `InputRefused` as `f_test` does."""
    samples = _samples(groups, missing)
    parts = {name: moments(sample.values, sample.rest) for name, sample in samples.items()}
    sizes = tuple(part.n for part in parts.values())
    degrees, left_out = len(parts) - 1, _missing(samples)
    reason = _no_variances(parts)
    if reason is not None:
        return VarianceTest("Bartlett", tuple(parts), sizes, reason, (degrees,), reason, reason, missing=left_out)
    dfs = [part.n - 1 for part in parts.values()]
    pooled = sum((part.exact_sum_squares for part in parts.values()), Fraction(0)) / sum(dfs)
    # The sum of df * (v - 1) over all v = variance / pooled is 0, so that no two large logarithms cancel.
    summed = math.fsum(
        df * _excess_over_log(part.exact_variance / pooled) for df, part in zip(dfs, parts.values(), strict=True)
    )
    correction = 1 + (sum(Fraction(1, df) for df in dfs) - Fraction(1, sum(dfs))) / (3 * degrees)
    statistic = Fraction(summed) / correction
    tail = chi2_upper(statistic, degrees)
    return VarianceTest(
        "Bartlett", tuple(parts), sizes, float(statistic), (degrees,), tail.p, tail.log10_p, missing=left_out
    )


def levene(groups: Mapping[str, ArrayLike] | Sequence[ArrayLike], missing: Missing = "refuse") -> VarianceTest:
    """Return Levene's test: ANOVA of the distances from the means. Raises `InputRefused` as `f_test` does."""
    return _of_spreads("Levene", _samples(groups, missing), from_mean)


def brown_forsythe(groups: Mapping[str, ArrayLike] | Sequence[ArrayLike], missing: Missing = "refuse") -> VarianceTest:
    """Return Brown and Forsythe's test: ANOVA of the distances from the medians. Raises as `f_test` does."""
    return brown_forsythe_of(_samples(groups, missing))


def brown_forsythe_of(samples: Mapping[str, Sample]) -> VarianceTest:
    """Return Brown and Forsythe's test of checked samples."""
    return _of_spreads("Brown-Forsythe", samples, from_median)


def variance_ratio(a: Moments, b: Moments, names: Names = AS_A_AND_B) -> tuple[Fraction | Undefined, Tail | Undefined]:
    """Return var(a) / var(b) and its two-sided tail, from the moments of two groups."""
    small = too_small(a, b, names)
    if small is not None:
        return small, small
    if b.constant:
        if a.constant:
            return Undefined(Reason.RATIO_OF_ZEROS), Undefined(Reason.GROUPS_CONSTANT)
        group = f"group {names[1]}"
        return Undefined(Reason.RATIO_BY_ZERO, group=group), Undefined(Reason.GROUP_CONSTANT, group=group)
    if a.constant:
        return Fraction(0), Undefined(Reason.GROUP_CONSTANT, group=f"group {names[0]}")
    ratio = to_120_bits(a.exact_variance / b.exact_variance)
    return ratio, f_two_sided(ratio, a.n - 1, b.n - 1)


def _excess_over_log(ratio: Fraction) -> float:
    """Return v - 1 - ln v, which is 0 or more, without cancellation near 1."""
    from mpmath import mp

    with mp.workprec(240):
        whole = mp.mpf(ratio.numerator) / ratio.denominator
        excess = ratio - 1
        more = mp.mpf(excess.numerator) / excess.denominator
        return float(more - (mp.log(whole) if whole < 0.5 else mp.log1p(more)))


def _samples(groups: Mapping[str, ArrayLike] | Sequence[ArrayLike], missing: Missing) -> dict[str, Sample]:
    return {name: as_sample(f"group {name!r}", values, missing) for name, values in as_groups(groups).items()}


def _missing(samples: Mapping[str, Sample]) -> int:
    return sum(sample.missing for sample in samples.values())


def _no_variances(parts: Mapping[str, Moments]) -> Undefined | None:
    if len(parts) < 2:
        return Undefined(Reason.FEWER_THAN_TWO_GROUPS)
    for name, part in parts.items():
        if part.n < 2:
            return Undefined(Reason.TOO_FEW_FOR_VARIANCE, group=f"group {name!r}", n=part.n)
        if part.constant:
            return Undefined(Reason.GROUP_CONSTANT, group=f"group {name!r}")
    return None


def _in_range(samples: Mapping[str, Sample]) -> list[Sample]:
    """Return the samples, in another unit where their differences could overflow or lose bits."""
    away = out_of_range(np.concatenate([sample.values for sample in samples.values()]))
    if not away:
        return list(samples.values())
    return [
        Sample(np.ldexp(each.values, -away), None if each.rest is None else np.ldexp(each.rest, -away), each.missing)
        for each in samples.values()
    ]


def _of_spreads(test: str, samples: Mapping[str, Sample], spread: Callable[[Sample], Sample]) -> VarianceTest:
    names, sizes = tuple(samples), tuple(sample.values.size for sample in samples.values())
    df = (max(len(names) - 1, 0), sum(sizes) - len(names))
    reason: Undefined | None = None
    if len(names) < 2:
        reason = Undefined(Reason.FEWER_THAN_TWO_GROUPS)
    for name, size in zip(names, sizes, strict=True):
        if size < 2:
            reason = Undefined(Reason.TOO_FEW_FOR_SCATTER, group=f"group {name!r}", n=size)
    if reason is None and all(size == 2 for size in sizes):
        reason = Undefined(Reason.DISTANCES_EQUAL)
    if reason is None:
        spreads = [spread(sample) for sample in _in_range(samples)]
        parts = [moments(one.values, one.rest) for one in spreads]
        within = sum((part.exact_sum_squares for part in parts), Fraction(0))
        if within == 0:
            reason = Undefined(Reason.SPREADS_EQUAL)
    if reason is not None:
        return VarianceTest(test, names, sizes, reason, df, reason, reason, missing=_missing(samples))
    grand = sum((part.n * part.exact_mean for part in parts), Fraction(0)) / sum(sizes)
    between = sum((part.n * (part.exact_mean - grand) ** 2 for part in parts), Fraction(0))
    f = to_120_bits((between / df[0]) / (within / df[1])) if between else Fraction(0)
    tail = f_upper(f, *df)
    return VarianceTest(test, names, sizes, finite(f, "F"), df, tail.p, tail.log10_p, missing=_missing(samples))
