"""Comparisons of means that share an error: the tests of `stats` with what is left of it, as the report states them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any, TypeVar

from labbook.analysis.comparison.day_weights import day_ratio, shared_by_day, shared_by_day_means
from stats.compare.shared_error import SharedError, SharedTest, difference_with_shared
from stats.compare.two_sample import TwoSample
from stats.days.blocked_result import BlockedByDay, Contrast, ExactTest, MixedModel
from stats.exact.numbers import as_interval

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
