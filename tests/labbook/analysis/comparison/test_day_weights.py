"""What a difference by day takes from shared errors: every value's own, by its weight in that difference."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.actions.report_command import state_report
from labbook.analysis.comparison.by_day import (
    CONTROL,
    TREATED,
    add_shared_error_by_day,
    compare_by_day,
    day_ratio,
    difference_weights,
    shared_by_day,
    shared_by_day_means,
)
from labbook.analysis.comparison.comparing import shared_error_of_side
from labbook.analysis.comparison.comparisons import Compared
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.results.result_cache import ResultCache
from labbook.presenting.report.content import MadeReport
from stats.compare.shared_error import SharedError, difference_with_shared
from stats.days.blocked import blocked_by_day
from stats.days.blocked_result import BlockedByDay, ExactTest
from tests.helpers.books import ADA, DAYS, small_book
from tests.helpers.wording import refuses

Rows = list[tuple[str, str, float]]

designs = st.lists(
    st.tuples(st.sampled_from("ABC"), st.sampled_from("wxyz"), st.floats(-3.0, 3.0).map(lambda x: round(x, 3))),
    min_size=6, max_size=24,
).filter(lambda rows: len({name for name, _day, _value in rows}) > 1)  # fmt: skip
"""Condition, day and value of each run."""


def compared(rows: Rows) -> BlockedByDay:
    names, days, values = zip(*rows, strict=True)
    return blocked_by_day(values, names, days, control=names[0])


def generalised(rows: Rows, found: BlockedByDay) -> NDArray[np.float64]:
    """Weights of all conditions' means by the covariance written out: (X' V^-1 X)^-1 X' V^-1."""
    names, days, _values = (np.array(column) for column in zip(*rows, strict=True))
    day = 0.0 if isinstance(found.day_variance, Undefined) else found.day_variance
    assert not isinstance(found.residual_variance, Undefined)
    covariance = found.residual_variance * np.eye(len(rows)) + day * (days[:, None] == days[None, :])
    design = np.array([names == one.condition for one in found.conditions], float).T
    weighed = np.linalg.solve(covariance, design).T
    return np.asarray(np.linalg.solve(weighed @ design, weighed))


@given(designs)
def test_the_weights_are_those_of_the_difference_that_is_stated(rows: Rows) -> None:
    found = compared(rows)
    names, days, values = zip(*rows, strict=True)
    stated = [(contrast, day_ratio(found, found.mixed)) for contrast in found.mixed.contrasts]
    if isinstance(found.exact, ExactTest):
        stated += [(contrast, day_ratio(found, found.exact)) for contrast in found.exact.contrasts]
    for contrast, ratio in stated:
        weights = difference_weights(contrast, ratio, names, days)
        assert weights @ np.array(values) == pytest.approx(contrast.difference, rel=1e-7, abs=1e-7)
        assert sum(weights) == pytest.approx(0.0, abs=1e-9)


@given(designs, st.lists(st.floats(-2.0, 2.0), min_size=24, max_size=24))
def test_the_error_is_the_same_sum_of_the_values_errors_for_every_contrast(rows: Rows, sizes: Sequence[float]) -> None:
    found = compared(rows)
    if isinstance(found.residual_variance, Undefined) or 0.0 < found.residual_variance < 1e-6:
        return
    names, days, _values = zip(*rows, strict=True)
    errors = [SharedError({("fit", "level"): size}, {"fit": 8.0}) for size, _row in zip(sizes, rows, strict=False)]
    weights = generalised(rows, found)
    for place, contrast in enumerate(found.mixed.contrasts, 1):
        left = shared_by_day(contrast, day_ratio(found, found.mixed), names, days, errors)
        expected = (weights[place] - weights[0]) @ np.array(sizes[: len(rows)])
        assert left.se == pytest.approx(abs(expected), abs=1e-6)
        with_error = add_shared_error_by_day(found, names, days, errors).mixed.contrasts[place - 1]
        alone = difference_with_shared(contrast.t, contrast.df, contrast.p, contrast.interval, left, found.level)
        assert (with_error.t, with_error.df, with_error.p) == (alone.t, alone.df, alone.p)


@given(designs, st.lists(st.floats(-2.0, 2.0).map(lambda x: round(x, 2)), min_size=24, max_size=24))
def test_the_error_of_day_means_is_what_it_does_to_their_difference(rows: Rows, sizes: Sequence[float]) -> None:
    names, days, values = zip(*rows, strict=True)
    moved = compared([(*of, value + size) for (*of, value), size in zip(rows, sizes, strict=False)])  # type: ignore[misc]
    errors = [SharedError({("fit", "level"): size}, {"fit": 8.0}) for size, _row in zip(sizes, values, strict=False)]
    for before, after in zip(compared(rows).paired, moved.paired, strict=True):
        if not isinstance(before.difference, Undefined) and not isinstance(after.difference, Undefined):
            left = shared_by_day_means(before, names, days, errors)
            assert left.se == pytest.approx(abs(after.difference - before.difference), abs=1e-8)


def test_an_error_that_all_values_share_alike_cancels_in_every_design() -> None:
    rows = [("A", "w", 1.0), ("A", "w", 1.2), ("B", "w", 2.1), ("A", "x", 0.4), ("B", "x", 1.7), ("B", "x", 1.4)]
    found = compared(rows)
    names, days, _values = zip(*rows, strict=True)
    errors = [SharedError({("fit", "level"): 0.7}, {"fit": 8.0})] * len(rows)
    assert shared_by_day(found.mixed.contrasts[0], day_ratio(found, found.mixed), names, days, errors).se == 0.0
    assert add_shared_error_by_day(found, names, days, errors) == found


@pytest.mark.parametrize("exponent", [700, 0, -560])
def test_the_error_is_in_the_unit_of_the_values_however_large_or_small_they_are(exponent: int) -> None:
    """Also where the variances are no doubles any more."""
    rows = [
        ("A", "w", 1.0), ("A", "w", 1.2), ("B", "w", 2.1), ("A", "x", 0.4), ("B", "x", 1.1), ("B", "x", 1.4),
        ("A", "y", 3.0), ("B", "z", 4.4), ("B", "z", 3.9),
    ]  # fmt: skip
    sizes = [0.3, 0.1, 0.2, 0.9, 0.4, 0.4, 0.2, 0.6, 0.5]

    def left(unit: float) -> float:
        found = compared([(name, day, value * unit) for name, day, value in rows])
        assert isinstance(found.day_variance, Undefined) == (unit != 1.0)
        names, days, _values = zip(*rows, strict=True)
        errors = [SharedError({("fit", "level"): size * unit}, {"fit": 8.0}) for size in sizes]
        return shared_by_day(found.mixed.contrasts[0], day_ratio(found, found.mixed), names, days, errors).se

    assert compared(rows).day_ratio > 0.0
    assert left(2.0**exponent) == pytest.approx(left(1.0) * 2.0**exponent, rel=1e-12)


def test_values_with_runs_within_days_that_share_an_error_are_no_comparison_of_weights_by_day() -> None:
    rows = [
        ("A", "w", "1", 1.0),
        ("B", "w", "1", 1.9),
        ("A", "w", "2", 0.4),
        ("B", "w", "2", 1.7),
        ("B", "w", "2", 2.0),
    ]
    names, days, runs, values = zip(*rows, strict=True)
    found = blocked_by_day(values, names, days, runs)
    assert isinstance(found.exact, ExactTest)
    assert found.exact.block == "run"
    assert add_shared_error_by_day(found, names, days, [SharedError()] * len(rows)) == found
    errors = [SharedError({("fit", "level"): 0.1 * place}, {"fit": 8.0}) for place in range(len(rows))]
    with refuses(AssertionError, "compare one value"):
        add_shared_error_by_day(found, names, days, errors)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> MadeReport:
    """A report of a design that is not balanced: each side lacks a run of another day."""
    with small_book(tmp_path_factory.mktemp("unbalanced")).open() as book:
        return state_report(book, "foot == small and run != r006 and run != r010", ADA, lambda _step: None)


@pytest.fixture
def cache(tmp_path: Path) -> Iterator[ResultCache]:
    """A result cache of a book of its own, where nothing is stored yet."""
    with small_book(tmp_path).open() as book, book.reading() as connection:
        yield ResultCache(connection)


def test_in_a_report_each_runs_error_counts_by_its_weight_in_the_difference_by_day(
    made: MadeReport, cache: ResultCache
) -> None:
    """Three times the error on the first day, as of runs of another length: the sides have other shares of it."""
    item: Compared = next(one for one in made.analysis.compared if one.quantity is Outcome.JOULES and one.by_day)

    def apart(one: ConditionValues) -> ConditionValues:
        first = DAYS[0].isoformat()
        runs = [replace(run, shared=run.shared.times(3.0 if run.run.day == first else 1.0)) for run in one.runs]
        return replace(one, runs=tuple(runs))

    pair = replace(item.pair, a=tuple(map(apart, item.pair.a)), b=tuple(map(apart, item.pair.b)))
    (row,) = compare_by_day(cache, [pair], Outcome.JOULES, {"trial": 1}, 0.05)
    runs = [(name, run) for name, side in ((CONTROL, pair.a), (TREATED, pair.b)) for one in side for run in one.runs]
    rows = [(name, run.run.day, run.value) for name, run in runs]
    found = compared(rows)
    assert row.counted is None
    control, treated = generalised(rows, found)
    terms = {term: [run.shared.terms[term] for _name, run in runs] for term in runs[0][1].shared.terms}
    expected = np.hypot.reduce([float((treated - control) @ np.array(errors)) for errors in terms.values()])
    difference = row.difference
    assert difference.shared_se == pytest.approx(expected)
    by_plain_means = shared_error_of_side(pair.b).minus(shared_error_of_side(pair.a)).se
    assert abs(by_plain_means - expected) > 0.1 * expected
    assert difference.ci_high - difference.ci_low > np.ptp(found.contrasts[0].interval)  # type: ignore[operator]
