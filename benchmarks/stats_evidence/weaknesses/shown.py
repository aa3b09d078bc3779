"""W22 and W27: numbers rounded away, signs dropped, and a definition left unsaid."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np

from benchmarks.stats_evidence.weaknesses.case import Number, Question, Weakness
from benchmarks.stats_evidence.weaknesses.peers import numpy, pg, pingouin, scipy, scipy_stats
from stats.compare.two_sample import compare_two
from stats.groups.residuals import QUARTILES, rmse_over_iqr
from tests.helpers.exact_tests import interval, t_test

HIGH_A = [0.1502, 0.1489, 0.1511, 0.1496]
HIGH_B = [0.1503, 0.1516, 0.1499, 0.1508]
EIGHT = (1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 9.5, 12.0)

PLACES: dict[str, Callable[[Fraction], Fraction]] = {
    "linear": lambda q: q * 7,
    "hazen": lambda q: q * 8 - Fraction(1, 2),
    "median_unbiased": lambda q: q * Fraction(25, 3) - Fraction(2, 3),
    "weibull": lambda q: q * 9 - 1,
}
"""Hyndman and Fan's definitions 7, 5, 8 and 6 for eight values, counted from 0."""


def iqr(definition: str) -> float:
    """Return the interquartile range of the eight values in exact arithmetic."""

    def quantile(q: Fraction) -> Fraction:
        place = PLACES[definition](q)
        below = int(place)
        low, high = Fraction(EIGHT[below]), Fraction(EIGHT[below + 1])
        return low + (place - below) * (high - low)

    return float(quantile(Fraction(3, 4)) - quantile(Fraction(1, 4)))


def _end(place: int) -> Question:
    return Question(
        f"{('lower', 'upper')[place]} end of the interval of the difference",
        Number(lambda: interval(HIGH_A, HIGH_B, pooled=True)[place], "exact arithmetic, mpmath"),
        lambda: compare_two(HIGH_A, HIGH_B, route="student").difference_ci[place],  # type: ignore[index]
        (pg("ttest", lambda: pingouin().ttest(HIGH_A, HIGH_B)["CI95"].iloc[0][place], 0.0),),
    )


def _quartiles(definition: str) -> Question:
    others = (
        numpy("quantile", lambda: np.quantile(EIGHT, 0.75) - np.quantile(EIGHT, 0.25), 5.625),
        scipy("iqr", lambda: scipy_stats().iqr(EIGHT), 5.625),
    )
    return Question(
        f"quartiles {definition.replace('_', '-')}",
        Number(lambda: iqr(definition), "definition"),
        lambda: rmse_over_iqr(EIGHT, EIGHT, definition=definition).iqr,
        () if definition == "linear" else others,
        digits=4,
    )


CASES = (
    Weakness(
        "W22",
        "jump heights in metres, the first group lower",
        f"{', '.join(map(str, HIGH_A))} and {', '.join(map(str, HIGH_B))}; made for this table",
        (
            _end(0),
            _end(1),
            Question(
                "effect size, which is below 0",
                Number(lambda: t_test(HIGH_A, HIGH_B, pooled=True).hedges_g, "exact arithmetic, mpmath"),
                lambda: compare_two(HIGH_A, HIGH_B).hedges_g,
                (pg("ttest, d", lambda: pingouin().ttest(HIGH_A, HIGH_B)["cohen_d"].iloc[0], 0.835),),
            ),
        ),
    ),
    Weakness(
        "W27",
        "the interquartile range of eight values, by definition",
        ", ".join(f"{value:g}" for value in EIGHT),
        tuple(_quartiles(definition) for definition in QUARTILES),
    ),
)
