"""Autocorrelation: how much one value says about the next ones of a series."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.rounding import number_text
from data_schema.vocabulary import Undefined
from stats.checks import as_count, as_sample
from stats.exact.sums import deviations, sum_of_products
from stats.lines.complete import complete_rows
from stats.results import Result
from stats.wording import counted


@dataclass(frozen=True, slots=True)
class Autocorrelation(Result):
    """How alike values are that lie so many places apart."""

    r: float | Undefined
    """Sum of products of deviations from the one mean, over the sum of their squares (NIST's definition); -1 to 1."""
    lag: int
    """How many places apart."""
    n: int
    """Number of values."""

    def sentence(self) -> str:
        """Return the autocorrelation in words."""
        if isinstance(self.r, Undefined):
            return f"No autocorrelation at lag {self.lag} (n = {self.n}): {self.r.reason}."
        return f"The autocorrelation at lag {self.lag} is {number_text(self.r)} (n = {self.n})."


def autocorrelation(values: ArrayLike, lag: int = 1) -> Autocorrelation:
    """Return the autocorrelation of a series, shape (n,), at a lag in samples.

    A value that is missing would be a gap in the series: NaN is refused, as infinite values are, and a lag that is no
    whole number of at least 0 (`InputRefused`).
    """
    lag = as_count("the lag", lag)
    _without, gaps = complete_rows([values], "drop")
    if gaps:
        raise InputRefused(
            f"the series has gaps at {gaps} of {np.size(values)} places, and a lag counts places: give a stretch "
            "without gaps."
        )
    series = as_sample("the series", values)
    n = series.values.size
    if n <= lag:
        few = Undefined(f"the series has {counted(n, 'value')} and a lag of {lag} needs at least {lag + 1}")
        return Autocorrelation(few, lag, n)
    about = deviations(series.values, series.rest)
    pair = (about.high, about.low)
    squares = sum_of_products(pair, pair)
    if squares == 0:
        return Autocorrelation(Undefined("the series is constant"), lag, n)
    early = (about.high[: n - lag], about.low[: n - lag])
    late = (about.high[lag:], about.low[lag:])
    return Autocorrelation(float(sum_of_products(early, late) / squares), lag, n)
