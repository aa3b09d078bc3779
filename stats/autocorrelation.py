"""Autocorrelation: how much one value says about the next ones of a series."""

from __future__ import annotations

from numpy.typing import ArrayLike

from data_schema.vocabulary import Undefined
from stats.checks import as_count, as_sample
from stats.sums import deviations, sum_of_products


def autocorrelation(values: ArrayLike, lag: int = 1) -> float | Undefined:
    """Return the autocorrelation of a series, shape (n,), at a lag in samples.

    NIST's definition: the sum of products of deviations from the one mean, over the sum of their squares.
    Raises `InputRefused` for NaN or infinite values and for a lag that is no whole number of at least 0.
    """
    lag = as_count("the lag", lag)
    series = as_sample("the series", values)
    n = series.values.size
    if n <= lag:
        return Undefined(f"the series has {n} values and a lag of {lag} needs at least {lag + 1}")
    about = deviations(series.values, series.rest)
    pair = (about.high, about.low)
    squares = sum_of_products(pair, pair)
    if squares == 0:
        return Undefined("the series is constant")
    early = (about.high[: n - lag], about.low[: n - lag])
    late = (about.high[lag:], about.low[lag:])
    return float(sum_of_products(early, late) / squares)
