"""The trend of the emulator's savings over the apex: of groups on the same days it is that of each day's savings."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats as scipy_stats

from labbook.studies.emulator import savings_trend
from stats.days.decision import Contrast, contrast_by_day

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


def test_a_trend_over_groups_of_the_same_days_is_that_of_each_day() -> None:
    rng, x = np.random.default_rng(5), {"a": 30.0, "b": 41.0, "c": 45.0, "d": 48.0}
    groups = {name: campaign(rng, saving, 5) for name, saving in zip(x, (0.05, 0.2, 0.1, 0.1), strict=True)}
    found = savings_trend(groups, x, 3.0)
    assert found is not None
    assert found.groups == tuple(groups)
    assert isinstance(found.slope.ci, tuple)
    savings = [100.0 * (1.0 - one.ratio) for one in groups.values()]
    assert found.slope.value == pytest.approx(scipy_stats.linregress([*x.values()], savings).slope)
    assert found.middle == pytest.approx((41.0, np.mean(savings)))
    departs = [[100.0 * departs for _day, departs in one.relative_departures] for one in groups.values()]
    se = scipy_stats.sem([scipy_stats.linregress([*x.values()], of_day).slope for of_day in zip(*departs, strict=True)])
    assert found.slope.se == pytest.approx(se)
    half = scipy_stats.t.ppf(0.975, 4) * se
    assert found.slope.ci == pytest.approx((found.slope.value - half, found.slope.value + half))  # type: ignore[operator]
    half = scipy_stats.t.ppf(0.95, 4) * 18.0 * se
    assert found.change.ci == pytest.approx((18.0 * found.slope.value - half, 18.0 * found.slope.value + half))  # type: ignore[operator]
    assert found.change.equivalent is False
    wide = savings_trend(groups, x, 300.0)
    assert wide is not None
    assert wide.change.equivalent is True
    assert savings_trend({name: groups[name] for name in "ab"}, x, 3.0) is None
    assert savings_trend(groups, dict.fromkeys(x, 1.0), 3.0) is None
