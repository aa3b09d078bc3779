"""A line through the origin: its slope, and the interval over groups with errors that all share."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.stats

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.compare.shared_error import SharedError
from stats.lines.regression import slope_through_origin


def test_equal_designs_give_the_mean_of_the_groups_slopes() -> None:
    x, slopes = [45.0, 57.0, 63.0, 67.0], [1.05, 1.07, 1.04, 1.08]
    curve = [1.02, 1.0, 0.99, 1.0]  # the same miss in each group is no scatter
    y = [slope * one * bent for slope in slopes for one, bent in zip(x, curve, strict=True)]
    found = slope_through_origin(x * 4, y, np.repeat(range(4), 4).tolist())
    squares = sum(one * one for one in x)
    of_groups = [slope * sum(b * a * a for a, b in zip(x, curve, strict=True)) / squares for slope in slopes]
    assert found.slope == pytest.approx(np.mean(of_groups))
    assert found.se == pytest.approx(scipy.stats.sem(of_groups))
    half = scipy.stats.t.ppf(0.975, 3) * scipy.stats.sem(of_groups)
    assert found.ci == pytest.approx((found.slope - half, found.slope + half))
    assert (found.groups, found.n, found.shared_se) == (4, 16, 0.0)


def test_an_error_that_all_x_share_widens_the_interval() -> None:
    x, y = (
        np.array([45.0, 57.0, 63.0, 67.0] * 3),
        np.array([48.0, 60.0, 67.0, 72.0, 47.0, 61.0, 66.0, 71.0, 47.5, 60.5, 67.0, 71.0]),
    )
    days = np.repeat(range(3), 4).tolist()
    shared = [SharedError({("drain", "level"): 0.3}, {"drain": 6.0})] * 12
    alone, both = slope_through_origin(x, y, days), slope_through_origin(x, y, days, shared)
    step = 1e-6
    moved = slope_through_origin(x + 0.3 * step, y, days).slope - alone.slope
    assert both.shared_se == pytest.approx(abs(moved) / step, rel=1e-4)
    assert not isinstance(both.ci, Undefined)
    assert not isinstance(alone.ci, Undefined)
    assert both.ci[0] < alone.ci[0] < alone.ci[1] < both.ci[1]


def test_a_single_group_has_no_interval() -> None:
    found = slope_through_origin([2.0, 4.0], [3.0, 6.1], ["one", "one"])
    assert found.slope == pytest.approx((6.0 + 24.4) / 20.0)
    assert isinstance(found.ci, Undefined)


def test_points_on_the_line_have_an_interval_without_width() -> None:
    assert slope_through_origin([1.0, 2.0], [2.0, 4.0], [0, 1]).ci == (2.0, 2.0)


def test_what_has_no_slope_is_refused() -> None:
    with pytest.raises(InputRefused, match="no slope"):
        slope_through_origin([0.0, 0.0], [1.0, 2.0], [0, 1])
    with pytest.raises(InputRefused, match="as many"):
        slope_through_origin([1.0], [1.0, 2.0], [0, 1])
    assert math.isfinite(slope_through_origin([1.0], [1.0], [0]).slope)
