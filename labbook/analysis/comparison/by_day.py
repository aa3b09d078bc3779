"""The same comparisons with the day as a random effect: runs of one day have that day in common.

What a difference by day takes from errors that its values share: each value's own, by its weight in the difference.

The difference is linear in the values once it is known how much more days differ than values: least squares after each
day's mean is taken off in part, wholly where the day is held fixed. Where every day holds every condition equally often
the weights are those of plain means; elsewhere days with few values of one condition count for less.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Remark, Undefined
from labbook.analysis.comparison.comparing import fingerprints_of_days, fingerprints_of_sides
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.results.codec import Algorithm, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache
from reports.numbers import Number
from stats.compare.shared_error import SharedError, SharedTest, difference_with_shared, shared_of_mean
from stats.compare.two_sample import TwoSample
from stats.days.blocked import blocked_by_day
from stats.days.blocked_result import BlockedByDay, Contrast, ExactTest, MixedModel
from stats.exact.numbers import as_interval

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


@dataclass(frozen=True, slots=True)
class DayComparison(StoredResult):
    """A comparison with the day as a random effect: treatment less control over so many days.

    The test is exact on what `counted` names, with `held` fixed, or the mixed model where `counted` is None.
    `confounding` and `notes` as `stats.days.BlockedByDay` has them.
    """

    t: Number
    p: Number
    difference: Number
    day_sd: Number
    run_sd: Number
    days: int
    counted: str | None
    held: str
    confounding: Remark | None
    notes: tuple[Remark, ...]


ALGORITHM = Algorithm("comparison_by_day", 10, DayComparison)

CONTROL, TREATED = "the control", "the treatment"


def compare_by_day(
    cache: ResultCache, pairs: Sequence[Pair], quantity: Outcome, scope: Mapping[str, Any], alpha: float
) -> list[DayComparison]:
    """Ensure y ~ condition + (1 | day) over the runs of every pair, in order; intervals have level 1 - alpha.

    Numbers are those that `BlockedByDay` states: of the exact test where the design is balanced; "method" names which.
    The spreads of days and of runs are the mixed model's.
    """
    return cache.ensure(
        [
            Request(
                ALGORITHM,
                {"quantity": str(quantity), "family": pair.family, "label": pair.label, **scope},
                (*fingerprints_of_sides(pair), *fingerprints_of_days(pair)),
                {"alpha": alpha},
                lambda pair=pair: _compared(pair, quantity, alpha),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


def _compared(pair: Pair, quantity: Outcome, alpha: float) -> DayComparison:
    sides = ((CONTROL, pair.a), (TREATED, pair.b))
    rows = [(item, name) for name, side in sides for condition in side for item in condition.runs]
    names, days = [name for _item, name in rows], [item.run.day for item, _name in rows]
    found = blocked_by_day([item.value for item, _name in rows], names, days, control=CONTROL, level=1.0 - alpha)
    (contrast,) = found.contrasts
    unit, n = quantity.unit, found.n
    leading = found.leading()
    ratio = day_ratio(found, leading)
    shared = shared_by_day(contrast, ratio, names, days, [item.shared for item, _name in rows])
    shared_se = shared.se if quantity.shares_error or shared.se else None
    test = difference_with_shared(contrast.t, contrast.df, contrast.p, contrast.interval, shared, found.level)
    return DayComparison(
        t=Number(test.t, "1", df=test.df, n=n),
        p=Number(test.p, "1", df=test.df, n=n),
        difference=Number(
            contrast.difference, unit, contrast.se, shared_se, test.ci_low, test.ci_high, found.level, df=test.df, n=n
        ),
        day_sd=Number(_root(found.day_variance), unit, n=found.n_days),
        run_sd=Number(_root(found.residual_variance), unit, n=n),
        days=found.n_days,
        counted=leading.unit if isinstance(leading, ExactTest) else None,
        held=leading.block if isinstance(leading, ExactTest) else "",
        confounding=found.confounding,
        notes=found.notes,
    )


def _root(variance: float | Undefined) -> float | Undefined:
    return variance if isinstance(variance, Undefined) else math.sqrt(variance)


_T = TypeVar("_T", TwoSample, Contrast)


def add_shared_error(test: TwoSample, shared: SharedError) -> TwoSample:
    """Add what is left of a shared error in mean(a) - mean(b) to both tests and intervals."""
    if shared.se == 0.0:
        return test
    level = 1.0 - test.alpha
    chosen = difference_with_shared(test.t, test.df, test.p, test.difference_ci, shared, level)
    welch = difference_with_shared(test.welch_t, test.welch_df, test.welch_p, test.welch_ci, shared, level)
    return _changed(_changed(test, chosen, "", "difference_ci"), welch, "welch_", "welch_ci")


def add_shared_error_by_day(
    found: BlockedByDay, conditions: Sequence[str], days: Sequence[str], errors: Sequence[SharedError]
) -> BlockedByDay:
    """Add to each contrast what is left of the errors of its values, each by its own weight in that contrast.

    Conditions, days and errors are those of the values compared. The F-tests leave the shared error out. Raises
    `AssertionError` where values with runs within days share an error, as no values of a book do.
    """

    if not any(error.se > 0.0 for error in errors):
        return found

    def of(test: ExactTest | MixedModel) -> tuple[Contrast, ...]:
        ratio = day_ratio(found, test)
        return tuple(added(each, shared_by_day(each, ratio, conditions, days, errors)) for each in test.contrasts)

    def added(contrast: Contrast, left: SharedError) -> Contrast:
        if left.se == 0.0:
            return contrast
        test = difference_with_shared(contrast.t, contrast.df, contrast.p, contrast.interval, left, found.level)
        return _changed(contrast, test, "", "interval")

    exact = found.exact
    if isinstance(exact, ExactTest):
        exact = replace(exact, contrasts=of(exact))
    mixed = replace(found.mixed, contrasts=of(found.mixed))
    paired = tuple(added(each, shared_by_day_means(each, conditions, days, errors)) for each in found.paired)
    return replace(found, mixed=mixed, exact=exact, paired=paired)


def _changed(result: _T, test: SharedTest, prefix: str, interval: str) -> _T:
    """Return the result with this test in the fields that begin with the prefix."""
    found: dict[str, Any] = {"t": test.t, "df": test.df, "p": test.p, "log10_p": test.log10_p}
    known = {field.name for field in fields(result)}
    changes = {f"{prefix}{name}": value for name, value in found.items() if f"{prefix}{name}" in known}
    return replace(result, **{**changes, interval: as_interval(test.ci_low, test.ci_high)})
