"""The order of runs within days: whether it favours one side of a comparison, and values adjusted for a drift.

A drift over the day (battery, bed, warmth) passes for an effect where controls come first. Under a random order every
choice of places for the treated runs of a day is equally likely, so the sum of their positions, about its expectation
and over all shared days, has an exact distribution (van Elteren 1960, with positions for ranks). It weighs days as the
contrast within days does, n m / (n + m).

A drift is adjusted for by the slope of least squares of values on positions, with an effect of each day and side and
of each condition. The slope is uncorrelated with the means of days and sides, so the adjusted difference has the errors
of both: that of the slope is an error in common of all runs (`SharedError`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import Labels, as_labels, as_values
from stats.compare.shared_error import SharedError
from stats.scatter import Floats

SLOPE = ("position", "slope")
"""Fit and term of the error that adjusted values have in common."""
_MOST_STEPS = 10**8
"""Of the exact distribution of one day; with more, as of a day of 150 runs, that of the sum is normal to .001."""
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class PositionsCompared:
    """Mean positions in the day of both sides within shared days, and how a random order would differ as much."""

    control: float
    treated: float
    p: float
    """Two-sided: the share of random orders of the runs of each day whose means lie as far apart, or farther."""


def compare_positions(positions: Sequence[int], treated: Sequence[bool], days: Labels) -> PositionsCompared | Undefined:
    """Compare the positions in the day of control and treated runs, shape (n,), within the days that hold both.

    `days` labels what is compared within, such as a day and a group. Undefined where none holds both sides.
    """
    at, side = np.asarray(positions, np.int64), np.asarray(treated, np.bool_)
    labels = np.array(as_labels("days", days))
    shared = [(at[own], side[own]) for day in dict.fromkeys(labels) for own in [labels == day]]
    shared = [(of_day, sides) for of_day, sides in shared if sides.any() and not sides.all()]
    if not shared:
        return Undefined(Reason.NO_SHARED_DAY)
    weights = np.array([sides.sum() * (~sides).sum() / sides.size for _of_day, sides in shared])
    means = np.array([(of_day[~sides].mean(), of_day[sides].mean()) for of_day, sides in shared])
    control, ahead = (weights @ means / weights.sum()).tolist()
    return PositionsCompared(
        control,
        ahead,
        _p([(of_day, int(sides.sum())) for of_day, sides in shared], abs(float(weights @ (means[:, 1] - means[:, 0])))),
    )


def _p(days: Sequence[tuple[NDArray[np.int64], int]], off: float) -> float:
    """Return how often the treated runs' positions, summed over the days, are `off` or more from their expectation."""
    spans = [int(of_day.max() - of_day.min()) for of_day, _n in days]
    if max(of_day.size * n * n * span for (of_day, n), span in zip(days, spans, strict=True)) > _MOST_STEPS:
        variance = math.fsum(n * (of_day.size - n) / of_day.size * float(of_day.var(ddof=1)) for of_day, n in days)
        return float(2.0 * special.ndtr(-off / math.sqrt(variance)))
    shares, expected = np.ones(1), 0.0
    for of_day, n in days:
        from_first = of_day - of_day.min()
        shares = np.convolve(shares, _shares_of_sums(from_first, n))
        expected += n * float(from_first.mean())
    far = np.abs(np.arange(shares.size) - expected) >= off - _ROUNDING * max(1.0, off)
    return min(1.0, float(shares[far].sum()))


def _shares_of_sums(places: NDArray[np.int64], n: int) -> Floats:
    """Return the share of all choices of n places with each sum, from 0."""
    most = int(np.sort(places)[-n:].sum())
    shares = np.zeros((n + 1, most + 1))
    shares[0, 0] = 1.0
    for seen, place in enumerate(places.tolist()):
        left = places.size - seen
        taken = (n - np.arange(n)) / left  # chance to choose this place, by how many were chosen before
        before = shares[:-1, : most + 1 - place] * np.clip(taken, 0.0, 1.0)[:, None]
        shares *= 1.0 - np.clip((n - np.arange(n + 1)) / left, 0.0, 1.0)[:, None]
        shares[1:, place:] += before
    return np.asarray(shares[n])


@dataclass(frozen=True, slots=True)
class AdjustedForPosition:
    """Values as at the mean position of their day, with the error that they have in common by the slope's."""

    values: tuple[float, ...]
    shared: tuple[SharedError, ...]
    slope: float
    """In the unit of the values for one place later in the day."""
    slope_se: float
    df: float


def adjust_for_position(
    values: ArrayLike, positions: Sequence[int], treated: Sequence[bool], days: Labels, conditions: Labels
) -> AdjustedForPosition | Undefined:
    """Return values, shape (n,), less the common slope times their position about the mean of their day.

    `days` is as in `compare_positions`; `conditions` labels what is pooled on a side. Undefined where no day has two
    runs of a side at positions that conditions leave free, or no degree of freedom is left.
    """
    y, at = as_values("values", values), np.asarray(positions, np.float64)
    day = _codes(days)
    cell = 2 * day + np.asarray(treated, np.int64)
    level = _codes(conditions)
    columns = np.column_stack([at, level[:, None] == np.arange(level.max() + 1)]).astype(np.float64)
    within = columns - _means(columns, cell)
    position, levels = within[:, 0], within[:, 1:]
    basis, sizes, _rows = np.linalg.svd(levels, full_matrices=False)
    basis = basis[:, sizes > _ROUNDING * max(1.0, float(sizes.max()))]
    free = position - basis @ (basis.T @ position)
    df = y.size - np.unique(cell).size - basis.shape[1] - 1
    squares = float(free @ free)
    if df < 1 or squares <= _ROUNDING * max(1.0, float(position @ position)):
        return Undefined(Reason.POSITION_NOT_FREE)
    slope = float(free @ y) / squares
    about = y - _means(y[:, None], cell)[:, 0]
    left = about - basis @ (basis.T @ about) - slope * free
    se = math.sqrt(float(left @ left) / df / squares)
    off = at - _means(at[:, None], day)[:, 0]
    fits = {SLOPE[0]: float(df)}
    return AdjustedForPosition(
        tuple((y - slope * off).tolist()),
        tuple(SharedError({SLOPE: -se * each}, fits) for each in off.tolist()),
        slope,
        se,
        float(df),
    )


def _codes(labels: Labels) -> NDArray[np.int64]:
    words = as_labels("labels", labels)
    places = {word: place for place, word in enumerate(dict.fromkeys(words))}
    return np.array([places[word] for word in words], np.int64)


def _means(columns: Floats, of: NDArray[np.int64]) -> Floats:
    """Return for each row the mean of the rows of its label."""
    sums = np.zeros((int(of.max()) + 1, columns.shape[1]))
    np.add.at(sums, of, columns)
    return np.asarray((sums / np.maximum(np.bincount(of), 1)[:, None])[of])
