"""The difference of two groups' savings: its interval covers the true one as often as it claims."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats as scipy_stats

from data_schema.vocabulary import Undefined
from stats.compare.shared_error import SharedError
from stats.days.decision import Contrast, contrast_by_day
from stats.days.overall import difference_of_savings

DAYS = [f"2021-03-{day:02d}" for day in range(1, 6)]


def campaign(rng: np.random.Generator, saving: float, days: int) -> Contrast:
    """A group's runs: so many of each condition a day, days in common, a tenth of scatter between runs."""
    of_day = rng.normal(0.0, 3.0, days)
    control, treated = (
        40.0 * share + np.repeat(of_day, runs) * share + rng.normal(0.0, 4.0, days * runs)
        for share, runs in ((1.0, 3), (1.0 - saving, 5))
    )
    return contrast_by_day(
        treated, control, days_treated=list(np.repeat(DAYS[:days], 5)), days_control=list(np.repeat(DAYS[:days], 3))
    )


@pytest.mark.parametrize("days", [2, pytest.param(5, marks=pytest.mark.soak)])
def test_its_interval_covers_and_the_smaller_saving_seldom_counts_as_the_larger(days: int) -> None:
    rng, n = np.random.default_rng([17, days]), 600
    truth, covered, wrong = 100.0 * (0.15 - 0.15), 0, 0
    for _ in range(n):
        found = difference_of_savings(campaign(rng, 0.15, days).savings(0.90), campaign(rng, 0.15, days).savings(0.90))
        assert isinstance(found.ci, tuple)
        covered += found.ci[0] <= truth <= found.ci[1]
        wrong += found.ci[0] > 0.0  # "larger" holds at alpha = 0.05
    band = scipy_stats.binom.ppf([0.0005, 0.9995], n, [0.90, 0.90])
    assert covered >= band[0]
    assert wrong <= scipy_stats.binom.ppf(0.9995, n, 0.05)


def test_errors_add_and_a_difference_of_the_same_is_nothing() -> None:
    rng = np.random.default_rng(3)
    one, other = (campaign(rng, saving, 5).savings(0.95) for saving in (0.2, 0.1))
    found = difference_of_savings(one, other)
    back = difference_of_savings(other, one)
    assert isinstance(one.value, float)
    assert isinstance(other.value, float)
    assert isinstance(one.se, float)
    assert isinstance(other.se, float)
    assert found.value == one.value - other.value
    assert found.se == math.hypot(one.se, other.se)
    assert isinstance(found.ci, tuple)
    assert isinstance(back.ci, tuple)
    assert found.ci == pytest.approx((-back.ci[1], -back.ci[0]), rel=1e-12)
    assert found.df == back.df
    half = scipy_stats.t.ppf(0.975, found.df) * found.se
    assert found.ci[1] - found.ci[0] == pytest.approx(2 * half, rel=1e-9)


def test_what_is_shared_widens_and_what_cannot_be_told_of_one_cannot_be_told_of_both() -> None:
    values: NDArray[np.float64] = np.array([40.0, 42.0, 38.0, 41.0])
    alone = contrast_by_day(0.9 * values, values)
    shared = contrast_by_day(
        0.9 * values,
        values,
        shared_treated=[SharedError({("fit", "level"): 2.0}, {"fit": 4})] * 4,
        shared_control=[SharedError({("fit", "level"): 2.0}, {"fit": 4})] * 4,
    )
    plain, wide = (difference_of_savings(each.savings(), alone.savings()) for each in (alone, shared))
    assert isinstance(plain.ci, tuple)
    assert isinstance(wide.ci, tuple)
    assert wide.ci[0] < plain.ci[0]
    apart = contrast_by_day(0.9 * values, values, days_treated=["a"] * 4, days_control=["b"] * 4)
    unknown = difference_of_savings(alone.savings(), apart.savings())
    assert isinstance(unknown.ci, Undefined)
    assert unknown.value == pytest.approx(0.0, abs=1e-9)
