"""The t-test of two samples that share a large offset, as heights in counts or times since 1970 do."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pingouin
import scipy.special
import scipy.stats
from mpmath import mpf
from numpy.typing import NDArray
from statsmodels.stats.weightstats import ttest_ind

from benchmarks.stats_evidence.digits.lre import Program, Row, row, tried, worst
from stats.compare.two_sample import compare_two

Floats = NDArray[np.float64]
Found = tuple[float, float]
"""t and p of Student's test."""

SEED = 2
OFFSETS = ("0", "1e3", "1e6", "1e9", "1e12", "1e14", "1e15")
DRAWINGS, SIZE, SHIFT = 20, 20, 1.0
DIGITS = 50


def _labbook(a: Floats, b: Floats) -> Any:
    found = compare_two(a, b, route="student")
    return found.t, found.p


def _scipy(a: Floats, b: Floats) -> Found:
    found = scipy.stats.ttest_ind(a, b)
    return float(found.statistic), float(found.pvalue)


def _statsmodels(a: Floats, b: Floats) -> Found:
    t, p, _df = ttest_ind(a, b)
    return float(t), float(p)


def _pingouin(a: Floats, b: Floats) -> Found:
    row = pingouin.ttest(a, b, correction=False).iloc[0]
    return float(row["T"]), float(row["p_val"])


def _numpy(a: Floats, b: Floats) -> Found:
    squares = ((a - a.mean()) ** 2).sum() + ((b - b.mean()) ** 2).sum()
    return _tested(float(a.mean() - b.mean()), float(squares), a.size, b.size)


def _textbook(a: Floats, b: Floats) -> Found:
    squares = sum(sum(x * x for x in values) - sum(values) ** 2 / len(values) for values in (a.tolist(), b.tolist()))
    return _tested(sum(a.tolist()) / a.size - sum(b.tolist()) / b.size, squares, a.size, b.size)


def _tested(difference: float, squares: float, n_a: int, n_b: int) -> Found:
    df = n_a + n_b - 2
    t = difference / math.sqrt(squares / df * (1.0 / n_a + 1.0 / n_b))
    return t, float(2.0 * scipy.special.stdtr(df, -abs(t)))


PROGRAMS: dict[str, Program] = {
    "labbook": _labbook,
    "scipy ttest_ind": _scipy,
    "statsmodels ttest_ind": _statsmodels,
    "pingouin ttest": _pingouin,
    "numpy, two passes": _numpy,
    "textbook": _textbook,
}


def rows() -> Iterator[Row]:
    """Return the digits of Student's t and of its p at each offset, the worst of all drawings."""
    for offset in OFFSETS:
        pairs = _pairs(float(offset))
        right = [_exact(a, b) for a, b in pairs]
        for program, function in PROGRAMS.items():
            found = [tried(function, a, b) or (math.nan, math.nan) for a, b in pairs]
            for place, quantity in enumerate(("t", "p of t")):
                score = worst((both[place] for both in found), (both[place] for both in right))
                yield row(quantity, f"offset {offset}", program, score)


def _pairs(offset: float) -> list[tuple[Floats, Floats]]:
    rng = np.random.default_rng(SEED)
    drawn = rng.normal(0.0, 1.0, (DRAWINGS, 2, SIZE))
    return [(a + SHIFT + offset, b + offset) for a, b in drawn]


def _exact(a: Floats, b: Floats) -> tuple[mpf, mpf]:
    """Return t and p of exactly these doubles, in rational arithmetic to the last root."""
    means, squares = [], Fraction(0)
    for values in (a, b):
        numbers = [Fraction(value) for value in values.tolist()]
        mean = sum(numbers, Fraction(0)) / len(numbers)
        means.append(mean)
        squares += sum(((number - mean) ** 2 for number in numbers), Fraction(0))
    df = a.size + b.size - 2
    squared = (means[0] - means[1]) ** 2 / (squares / df * (Fraction(1, a.size) + Fraction(1, b.size)))
    with mpmath.workdps(DIGITS):
        size = mpf(squared.numerator) / squared.denominator
        t = mpmath.sign(mpf((means[0] - means[1]).numerator)) * mpmath.sqrt(size)
        p = mpmath.betainc(mpf(df) / 2, mpf(1) / 2, 0, df / (df + size), regularized=True)
    return t, p
