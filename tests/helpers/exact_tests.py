"""Tests of means in rational arithmetic on the doubles given, with tails by mpmath: the truth for other tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import mpmath
from numpy.typing import NDArray

from tests.helpers.exact_fit import exact, exact_fit

DIGITS = 50

Values = Sequence[Any] | NDArray[Any]


@dataclass(frozen=True)
class ExactT:
    t: float
    df: float
    p: Any
    """An mpf: it may be far below the smallest double."""
    difference: Fraction
    se: Any
    hedges_g: float


def moments(values: Values) -> tuple[int, Fraction, Fraction]:
    """Return n, mean and sum of squared deviations."""
    numbers = [exact(value) for value in values]
    mean = sum(numbers, Fraction(0)) / len(numbers)
    return len(numbers), mean, sum(((x - mean) ** 2 for x in numbers), Fraction(0))


def t_test(a: Values, b: Values, *, pooled: bool) -> ExactT:
    """Return Student's (pooled) or Welch's test of two groups, one of which scatters."""
    (n_a, mean_a, ss_a), (n_b, mean_b, ss_b) = moments(a), moments(b)
    pooled_variance = (ss_a + ss_b) / (n_a + n_b - 2)
    df = Fraction(n_a + n_b - 2)
    variance = pooled_variance * (Fraction(1, n_a) + Fraction(1, n_b))
    if not pooled:
        part_a, part_b = ss_a / (n_a - 1) / n_a, ss_b / (n_b - 1) / n_b
        variance = part_a + part_b
        df = variance**2 / (part_a**2 / (n_a - 1) + part_b**2 / (n_b - 1))
    difference = mean_a - mean_b
    with mpmath.workdps(DIGITS):
        half = mpf(df) / 2
        factor = mpmath.exp(mpmath.loggamma(half) - mpmath.loggamma(half - 0.5)) / mpmath.sqrt(half) if pooled else 1
        se = mpmath.sqrt(mpf(variance))
        return ExactT(
            t=float(mpf(difference) / se),
            df=float(df),
            p=t_tail(difference**2 / variance, df),
            difference=difference,
            se=se,
            hedges_g=float(factor * mpf(difference) / mpmath.sqrt(mpf(pooled_variance))),
        )


def interval(a: Values, b: Values, *, pooled: bool, level: float = 0.95) -> tuple[float, float]:
    """Return the interval of the difference of means."""
    found = t_test(a, b, pooled=pooled)
    with mpmath.workdps(DIGITS):
        tail = 1 - mpmath.mpf(repr(level))
        quantile = mpmath.findroot(
            lambda t: t_tail_of(t * t, mpmath.mpf(found.df)) - tail, (1.0, 20.0), solver="anderson", tol=1e-60
        )
        middle = mpf(found.difference)
        return float(middle - quantile * found.se), float(middle + quantile * found.se)


def one_way(groups: Mapping[str, Values]) -> tuple[float, Any]:
    """Return F of a one-way analysis of variance and its p."""
    parts = [moments(values) for values in groups.values()]
    n, k = sum(size for size, _, _ in parts), len(parts)
    grand = sum((size * mean for size, mean, _ in parts), Fraction(0)) / n
    between = sum((size * (mean - grand) ** 2 for size, mean, _ in parts), Fraction(0))
    within = sum((squares for _, _, squares in parts), Fraction(0))
    f = between / (k - 1) / (within / (n - k))
    return float(f), f_tail(f, k - 1, n - k)


def welch_one_way(groups: Mapping[str, Values]) -> tuple[float, Any]:
    """Return F of Welch's analysis of variance and its p; a constant group's variance is 1e-200 of the others'."""
    with mpmath.workdps(600):
        parts = []
        for values in groups.values():
            n, mean, squares = moments(values)
            variance = mpf(squares) / (n - 1) if squares else mpmath.mpf(10) ** -200
            parts.append((n, mpf(mean), n / variance))
        total = sum(weight for _, _, weight in parts)
        k = len(parts)
        grand = sum(weight * mean for _, mean, weight in parts) / total
        above = sum(weight * (mean - grand) ** 2 for _, mean, weight in parts) / (k - 1)
        doubt = sum((1 - weight / total) ** 2 / (n - 1) for n, _, weight in parts)
        f = above / (1 + 2 * (k - 2) * doubt / (k * k - 1))
        df = (k * k - 1) / (3 * doubt)
    with mpmath.workdps(DIGITS):
        f, df = +f, +df
        p = mpmath.betainc(df / 2, mpmath.mpf(k - 1) / 2, 0, df / (df + (k - 1) * f), regularized=True)
        return float(f), p


def additive(values: Values, condition: Sequence[int], day: Sequence[int]) -> tuple[int, float, Any]:
    """Return the error's degrees of freedom, F and p of the conditions, days held fixed: y = condition + day."""
    days = [[float(each == level) for each in day] for level in sorted(set(day))[1:]]
    levels = sorted(set(condition))
    conditions = [[float(each == level) for each in condition] for level in levels[1:]]
    whole, without = exact_fit(values, days + conditions), exact_fit(values, days)
    df = len(values) - len(days) - len(levels)
    f = (without.ss_residual - whole.ss_residual) / (len(levels) - 1) / (whole.ss_residual / df)
    return df, float(f), f_tail(f, len(levels) - 1, df)


def t_tail(t_squared: Fraction, df: Fraction) -> Any:
    """Return the two-sided tail of Student's t."""
    with mpmath.workdps(DIGITS):
        return t_tail_of(mpf(t_squared), mpf(df))


def t_tail_of(t_squared: Any, df: Any) -> Any:
    """Return the two-sided tail of Student's t at mpmath's present precision."""
    return mpmath.betainc(df / 2, mpmath.mpf(1) / 2, 0, df / (df + t_squared), regularized=True)


def f_tail(f: Fraction, df_between: int, df_within: int) -> Any:
    """Return the upper tail of F."""
    with mpmath.workdps(DIGITS):
        above, below = mpmath.mpf(df_between), mpmath.mpf(df_within)
        return mpmath.betainc(below / 2, above / 2, 0, below / (below + above * mpf(f)), regularized=True)


def mpf(value: Fraction) -> Any:
    """Return a fraction at mpmath's present precision."""
    return mpmath.mpf(value.numerator) / value.denominator


def log10_bayes_factor(t: float, n_a: int, n_b: int, r: float) -> float:
    """Return log10 of the JZS Bayes factor by its definition, over g in log scale; n_b = 0 for one sample."""
    with mpmath.workdps(30):
        size = mpmath.mpf(n_a) * n_b / (n_a + n_b) if n_b else mpmath.mpf(n_a)
        df = n_a + n_b - 2 if n_b else n_a - 1
        half, square = mpmath.mpf(df + 1) / 2, mpmath.mpf(t) ** 2 / df

        def log_part(u: Any) -> Any:
            g = mpmath.exp(u)
            wide = 1 + size * g * mpmath.mpf(r) ** 2
            return (
                -mpmath.log(wide) / 2
                - half * mpmath.log(1 + square / wide)
                - u / 2
                - 1 / (2 * g)
                - mpmath.log(2 * mpmath.pi) / 2
                + half * mpmath.log(1 + square)
            )

        grid = [mpmath.mpf(k) / 2 for k in range(-20, 120)]
        peak = max(grid, key=log_part)
        top = log_part(peak)
        points = [peak + step for step in (-12, -6, -3, -1, 0, 1, 3, 6, 12, 25, 50, 100)]
        total = mpmath.quad(lambda u: mpmath.exp(log_part(u) - top), points)
        return float((top + mpmath.log(total)) / mpmath.log(10))


def dunnett_tail(t: Any, n_control: int, n_treated: Sequence[int], df: int, step: float) -> Any:
    """Return the two-sided chance that any of several treatments' |t| exceeds `t`, by the trapezoidal rule.

    `step` is that of the control's mean and, over sqrt(2 df), of log s; 25 digits are worked with, and 0.25 leaves 16.
    """
    with mpmath.workdps(25):
        shares = [mpmath.mpf(n) / (n + n_control) for n in n_treated]
        h, points = mpmath.mpf(step), int(11 / step)
        normal = [(k * h, mpmath.npdf(k * h) * (2 if k else 1) * h) for k in range(points + 1)]
        total = mass = mpmath.mpf(0)
        for number in range(-int(1.6 * points), points + 1):
            u = number * h / mpmath.sqrt(2 * df)
            density = mpmath.exp(df * (u - mpmath.expm1(2 * u) / 2))
            if density < 1e-24:
                continue
            inner = mpmath.mpf(0)
            for y, weight in normal:
                inside = mpmath.mpf(1)
                for share in shares:
                    below, above = (
                        (t * mpmath.exp(u) + side * mpmath.sqrt(share) * y) / mpmath.sqrt(2 * (1 - share))
                        for side in (-1, 1)
                    )
                    inside *= (mpmath.erf(below) + mpmath.erf(above)) / 2
                inner += weight * (1 - inside)
            total += density * inner
            mass += density
        return total / mass
