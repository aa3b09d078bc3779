"""How often conditions that do not differ are said to: over days that differ, by simulation."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats

from stats.compare.two_sample import compare_two
from stats.days.blocked import blocked_by_day
from stats.days.blocked_result import ExactTest
from tests.helpers.shared_days import crossed


def p_values(
    days: int, times: int, day_sd: float, own_days: bool, studies: int, holes: float = 0.0, effect: float = 0.0
) -> np.ndarray:
    """Return p of the mixed model, the exact test and a t-test of all values in each study, shape (studies, 3).

    `effect` is what the second condition differs by, in SDs of values.
    """
    rng = np.random.default_rng([days, times, round(10 * day_sd), own_days, round(10 * holes)])
    condition, day = crossed(2, days, times)
    kept = np.concatenate([np.arange(2 * times), 2 * times + np.flatnonzero(rng.random(day.size - 2 * times) >= holes)])
    condition, day = condition[kept], day[kept]
    if own_days:
        day = 2 * day + condition
    found = []
    for _ in range(studies):
        values = rng.normal(size=day.size) + rng.normal(0.0, day_sd, day.max() + 1)[day] + effect * condition
        result = blocked_by_day(values, condition, day)
        pooled = compare_two(values[condition == 0], values[condition == 1], route="student")
        exact = result.exact.p if isinstance(result.exact, ExactTest) else 1.0
        found.append((result.mixed.p, exact, pooled.p))
    return np.array(found)


def rejections(p: np.ndarray) -> list[float]:
    """Shares of studies that the mixed model, the exact test and the t-test reject."""
    return [float(share) for share in np.mean(p < 0.05, axis=0)]


def error(share: float, studies: int) -> float:
    """Three standard errors of a simulated share."""
    return 3.0 * (share * (1.0 - share) / studies) ** 0.5


def hold_the_level(p: np.ndarray) -> None:
    """Without an effect p is uniform, so that all studies bear witness and not those below 0.05 alone."""
    mixed, exact, _pooled = rejections(p)
    assert exact == pytest.approx(0.05, abs=error(0.05, len(p)))
    assert mixed == pytest.approx(0.05, abs=error(0.05, len(p)) + 0.01)
    for of_test in p.T[:2]:
        assert scipy.stats.kstest(of_test, "uniform").pvalue > 0.001


@pytest.mark.parametrize(
    ("days", "times"), [(1, 5), *(pytest.param(days, 3, marks=pytest.mark.soak) for days in (2, 6))]
)
def test_the_exact_test_holds_its_level(days, times):
    hold_the_level(p_values(days, times, 1.0, False, 100))


@pytest.mark.parametrize(("days", "times", "own_days", "effect"), [(2, 3, False, 5.0), (3, 10, True, 10.0)])
def test_an_effect_far_beyond_the_scatter_is_found(days, times, own_days, effect):
    assert rejections(p_values(days, times, 1.0, own_days, 15, effect=effect)) == [1.0, 1.0, 1.0]


def test_trials_pooled_over_days_err_where_day_means_do_not():
    """A t-test over all values of conditions on days of their own: 27 to 54 of 100 studies err without any effect."""
    p = p_values(3, 10, 1.0, True, 100)
    hold_the_level(p)
    pooled = rejections(p)[2]
    assert 0.27 - error(0.27, 100) < pooled < 0.54 + error(0.54, 100)


SIZES = [
    (2, 3, 0.0, False, 0.0, 0.0575),
    (2, 3, 1.0, False, 0.4, 0.0580),
    (3, 3, 0.0, False, 0.4, 0.0645),
    (6, 3, 0.0, False, 0.0, 0.0640),
    (6, 3, 1.0, False, 0.4, 0.0510),
    (2, 10, 0.0, True, 0.0, 0.0380),
    (3, 10, 0.3, True, 0.0, 0.0445),
    (6, 10, 1.0, True, 0.0, 0.0570),
]
"""Days, values of a condition a day, SD of days in SDs of values, days of their own, share left out; size measured of
the mixed model at 0.05, 2000 studies. Where days do not differ REML sets their variance to 0 in half of the studies."""


@pytest.mark.soak
@pytest.mark.parametrize(("days", "times", "day_sd", "own_days", "holes", "mixed_size"), SIZES)
def test_sizes_as_recorded(days, times, day_sd, own_days, holes, mixed_size):
    mixed, exact, _pooled = rejections(p_values(days, times, day_sd, own_days, 2000, holes))
    assert mixed == pytest.approx(mixed_size, abs=error(mixed_size, 2000))
    assert exact == pytest.approx(0.05, abs=error(0.05, 2000))
