"""What a fit says at one place, which may be as far from the data as doubles reach."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from data_schema.vocabulary import Undefined
from stats.exact.distributions import t_quantile
from stats.exact.finite import finite, finite_pair
from stats.lines.fit import EXACT
from stats.results import Result
from stats.wording import half_width, interval_text, number_text, with_unit


@dataclass(frozen=True, slots=True)
class Response(Result):
    """The fitted response at one place."""

    value: float | Undefined
    """In the unit of the response."""
    se: float | Undefined
    """Standard error of the mean response there, not of one more measurement; in the unit of the response."""
    ci: tuple[float, float] | Undefined
    """Student's interval of the mean response; undefined where the fit is exact."""
    level: float
    """Level of the interval."""
    df: int
    """Degrees of freedom of the fit."""
    extrapolated: bool
    """Whether a value lies outside its column's range."""

    def sentence(self, response: str = "the response", unit: str = "") -> str:
        """Return the response in words, with its interval, degrees of freedom, and whether it is extrapolated."""
        beyond = ", outside the range that was fitted" if self.extrapolated else ""
        return (
            f"{response} is {number_text(self.value, within=half_width(self.ci))}{with_unit(unit)} there "
            f"({interval_text(self.ci, self.level, unit)}, df = {self.df}{beyond})."
        )


def response_at(
    value: Fraction, se: Fraction | Undefined, level: float, df: int, *, extrapolated: bool, exact: bool
) -> Response:
    """Return a fitted value with Student's interval, each number rounded once; `exact` says that nothing is left."""
    shown = finite(value, "the response")
    if isinstance(se, Undefined):
        return Response(shown, se, se, level, df, extrapolated)
    half = Fraction(t_quantile(level, df)) * se
    ci = EXACT if exact else finite_pair(value - half, value + half)
    return Response(shown, finite(se, "the standard error"), ci, level, df, extrapolated)


def root_of_form(vector: Sequence[Fraction], covariance: Sequence[Sequence[float]]) -> Fraction:
    """Return the root of v'Cv for numbers of any size; the covariance keeps clear of the ends of the doubles."""
    largest = max(map(abs, vector), default=Fraction(0))
    if largest == 0:
        return Fraction(0)
    unit = Fraction(2) ** (largest.numerator.bit_length() - largest.denominator.bit_length())
    scaled = np.array([float(number / unit) for number in vector])
    return Fraction(math.sqrt(max(float(scaled @ np.array(covariance) @ scaled), 0.0))) * unit
