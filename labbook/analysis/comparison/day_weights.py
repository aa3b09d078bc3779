"""What a difference by day takes from errors that its values share: each value's own, by its weight in the difference.

The difference is linear in the values once it is known how much more days differ than values: least squares after each
day's mean is taken off in part, wholly where the day is held fixed. Where every day holds every condition equally often
the weights are those of plain means; elsewhere days with few values of one condition count for less.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from data_schema.vocabulary import Undefined
from stats.compare.shared_error import SharedError, shared_of_mean
from stats.days.blocked_result import BlockedByDay, Contrast, ExactTest, MixedModel

Floats = NDArray[np.float64]

_FIXED = 1e12
"""Variance of days over that of values from which a day counts as held fixed."""


def shared_by_day(
    contrast: Contrast, ratio: float, conditions: Sequence[str], days: Sequence[str], errors: Sequence[SharedError]
) -> SharedError:
    """Return the error of a contrast of values with these conditions, days and errors; `ratio` is that of `day_ratio`.

    Runs within days are no part of it (`day_ratio` refuses them): values that share an error are one a run.
    """
    if not any(error.se > 0.0 for error in errors):
        return shared_of_mean(errors)
    return _weighed(difference_weights(contrast, ratio, conditions, days), errors)


def shared_by_day_means(
    contrast: Contrast, conditions: Sequence[str], days: Sequence[str], errors: Sequence[SharedError]
) -> SharedError:
    """Return the error of a contrast of the means of the days that hold both conditions (`BlockedByDay.paired`)."""
    of, day = np.array(conditions), np.array(days)
    weights = np.zeros(of.size)
    shared = set(days) & set(day[of == contrast.condition]) & set(day[of == contrast.control])
    for each in shared:
        for name, sign in ((contrast.condition, 1.0), (contrast.control, -1.0)):
            own = (of == name) & (day == each)
            weights[own] = sign / (len(shared) * np.count_nonzero(own))
    return _weighed(weights, errors)


def _weighed(weights: Floats, errors: Sequence[SharedError]) -> SharedError:
    gained, lost = (
        shared_of_mean([error.times(weight * len(errors)) for error, weight in zip(errors, side, strict=True)])
        for side in (np.maximum(weights, 0.0).tolist(), np.maximum(-weights, 0.0).tolist())
    )
    return gained.minus(lost)  # both sum to the same weight, so that what all values share cancels


def day_ratio(found: BlockedByDay, test: ExactTest | MixedModel) -> float:
    """Return how much more days vary than values in a test of a comparison.

    Raises `AssertionError` where runs within days are in the comparison: weights by days alone would not be its own.
    """
    if not isinstance(found.n_runs, Undefined):
        raise AssertionError(
            f"{found.n_runs} runs within days are in a comparison whose values share an error, which is weighed by "
            "days: compare one value a run."
        )
    if isinstance(test, MixedModel):
        return found.day_ratio
    return _FIXED if test.block == "day" else 0.0


def difference_weights(contrast: Contrast, ratio: float, conditions: Sequence[str], days: Sequence[str]) -> Floats:
    """Return the weight of every value in the contrast, shape (n,), where days vary `ratio` times as much as values."""
    names = [contrast.control, *sorted(set(conditions) - {contrast.control})]
    of = np.array(conditions)
    columns = np.column_stack([np.ones(of.size), *(of == name for name in names[1:])]).astype(np.float64)
    day = np.unique(np.array(days), return_inverse=True)[1].ravel()
    counts = np.bincount(day)
    left = 1.0 / np.sqrt(1.0 + ratio * counts)  # of a day's mean

    def freed(rows: Floats) -> Floats:
        """Take off what days account for; symmetric."""
        means = np.zeros((counts.size, rows.shape[1]))
        np.add.at(means, day, rows)
        return np.asarray(rows - ((1.0 - left) / counts)[day, None] * means[day])

    design = freed(columns)
    sizes = np.linalg.norm(design, axis=0)
    inverse = np.linalg.pinv(design / sizes) / sizes[:, None]
    return np.asarray(freed(inverse[names.index(contrast.condition)][:, None])[:, 0])
