"""Residuals of groups, their normal quantiles, and the band that normal residuals keep."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats as scipy_stats

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.groups.anova import one_way_anova
from stats.groups.residuals import normal_quantiles, residuals_of_groups, rmse_over_iqr
from tests.helpers.wording import refuses


def test_residuals_of_groups_are_values_less_their_mean_with_the_scatter_of_the_anova():
    groups = {"a": [1.0, 2.0, 6.0], "b": [10.0, 14.0], "c": [], "d": [7.0]}
    found = residuals_of_groups(groups)
    assert found.values == pytest.approx((-2.0, -1.0, 3.0, -2.0, 2.0, 0.0))
    assert found.fitted == pytest.approx((3.0, 3.0, 3.0, 12.0, 12.0, 7.0))
    assert found.df == 3
    del groups["c"]
    assert found.sd == pytest.approx(one_way_anova(groups).residual_sd, rel=1e-15)
    far = residuals_of_groups({name: [1e15 + value for value in values] for name, values in groups.items()})
    assert far.values == pytest.approx(found.values, rel=1e-14)
    assert far.sd == pytest.approx(found.sd, rel=1e-14)


@given(st.integers(1, 60))
def test_expected_values_are_the_medians_of_order_statistics(n):
    found = normal_quantiles(residuals_of_groups({"a": [0.0] * n, "b": [-1.0, 1.0]}))
    place = np.arange(1, n + 3)
    medians = scipy_stats.beta(place, n + 3 - place).median()
    assert scipy_stats.norm.cdf(found.expected) == pytest.approx(medians, abs=1e-9)
    assert found.observed == (-1.0, *(0.0,) * n, 1.0)


@pytest.mark.soak
@pytest.mark.parametrize("sizes", [(25,), (3, 3, 3), (5, 20)])
def test_the_band_holds_as_many_residuals_of_normal_values_as_it_says(sizes):
    rng = np.random.default_rng(11)
    inside = []
    for _ in range(600):
        groups = {str(number): rng.normal(number, 2.0, n) for number, n in enumerate(sizes)}
        found = normal_quantiles(residuals_of_groups(groups), 0.9)
        inside.append(np.mean((np.array(found.low) <= found.observed) & (found.observed <= np.array(found.high))))
        assert np.all(np.less_equal(found.low, found.middle) & np.less_equal(found.middle, found.high))
    assert np.mean(inside) == pytest.approx(0.9, abs=4 * np.std(inside) / math.sqrt(600) + 0.003)


@pytest.mark.parametrize(
    ("groups", "why"),
    [
        ({"a": [1.0], "b": [3.0]}, None),
        ({"a": [1.0, 1.0], "b": [2.0, 2.0]}, Reason.RESIDUALS_ZERO),
        ({"a": [1.0, 2.5]}, Reason.ONE_SHAPE),
        ({}, None),
    ],
)
def test_what_has_no_band_says_why(groups: dict[str, list[float]], why: Reason | None) -> None:
    found = normal_quantiles(residuals_of_groups(groups))
    for number in (found.low, found.high):
        assert isinstance(number, Undefined)
        assert why is None or number.code is why


def test_no_values_have_no_residual_sd() -> None:
    assert residuals_of_groups({}).sd == Undefined(Reason.NO_VALUE)


def test_a_level_that_takes_too_many_draws_has_no_band():
    residuals = residuals_of_groups([np.arange(10_000.0)])
    assert isinstance(normal_quantiles(residuals, 1.0 - 1e-4).low, Undefined)
    assert not isinstance(normal_quantiles(residuals_of_groups([np.arange(25.0)]), 1.0 - 1e-4).low, Undefined)


EIGHT = np.array([1.0, 2.5, 3.0, 4.5, 6.0, 7.25, 9.0, 12.0])


def test_w25_whole_numbers_of_16_bits():
    """Others: nan, from squares that overflow."""
    measured, predicted = np.array([100, -200, 300, 32000], np.int16), np.array([250, -50, 130, -32000], np.int16)
    exact = math.sqrt((150**2 + 150**2 + 170**2 + 64000**2) / 4)
    assert rmse_over_iqr(measured, predicted).rmse == pytest.approx(exact, rel=1e-15)


@pytest.mark.parametrize("size", [1e200, 1e300, 1.7e308, 1e-200, 2.0**-1060])
def test_w25_numbers_whose_squares_leave_the_range_of_doubles(size):
    """Others: inf (1.6e200 is the truth at 1e200), or 0 at the other end."""
    measured, predicted = size * np.array([0.2, 0.4, 0.6, 1.0]), size * np.array([-0.2, 0.5, 1.0, -0.9])
    found, unit = rmse_over_iqr(measured, predicted), rmse_over_iqr(measured / size, predicted / size)
    tolerance = 1e-14 if size > 1e-300 else 1e-4
    assert found.rmse / size == pytest.approx(unit.rmse, rel=tolerance)
    assert found.ratio == pytest.approx(unit.ratio, rel=tolerance)


def test_quartiles_are_numpys() -> None:
    for values in (EIGHT, EIGHT[:2], EIGHT[:1], EIGHT[:5]):
        found = rmse_over_iqr(values, values + 1.0)
        assert found.iqr == pytest.approx(np.subtract(*np.quantile(values, [0.75, 0.25])))


def test_a_perfect_prediction_and_a_constant_measurement():
    assert rmse_over_iqr(EIGHT, EIGHT).ratio == 0.0
    constant = rmse_over_iqr([0.1] * 4, [0.1, 0.2, 0.1, 0.1])
    assert isinstance(constant.ratio, Undefined)
    assert constant.iqr == 0.0
    assert constant.rmse == pytest.approx(0.05)


def test_wrong_input_is_refused():
    with refuses(InputRefused, "8 measured", "7 predicted"):
        rmse_over_iqr(EIGHT, EIGHT[:7])
    with pytest.raises(InputRefused, match="0 measured"):
        rmse_over_iqr([], [])
    with refuses(InputRefused, "predicted values holds", "1", "8"):
        rmse_over_iqr(EIGHT, np.append(EIGHT[:7], np.nan))
