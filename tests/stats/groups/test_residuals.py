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
from stats.groups.residuals import normal_quantiles, residuals_of_groups
from tests.helpers.wording import refuses, says


def test_residuals_of_groups_are_values_less_their_mean_with_the_scatter_of_the_anova():
    groups = {"a": [1.0, 2.0, 6.0], "b": [10.0, 14.0], "c": [], "d": [7.0]}
    found = residuals_of_groups(groups)
    assert found.values == pytest.approx((-2.0, -1.0, 3.0, -2.0, 2.0, 0.0))
    assert found.fitted == pytest.approx((3.0, 3.0, 3.0, 12.0, 12.0, 7.0))
    assert found.df == 3
    del groups["c"]
    assert found.sd == pytest.approx(one_way_anova(groups).residual_sd, rel=1e-15)


def test_an_offset_costs_no_digit():
    near = residuals_of_groups({"a": [0.0, 1.0, 5.0], "b": [2.0, 4.0]})
    far = residuals_of_groups({"a": [1e15, 1e15 + 1, 1e15 + 5], "b": [1e15 + 2, 1e15 + 4]})
    assert far.values == pytest.approx(near.values, rel=1e-14)
    assert far.sd == pytest.approx(near.sd, rel=1e-14)


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


def test_single_values_have_no_scatter_and_no_band():
    found = normal_quantiles(residuals_of_groups({"a": [1.0], "b": [3.0]}))
    assert isinstance(found.low, Undefined)
    assert isinstance(found.sd, Undefined)
    says(found.sd.reason, "no group has")


def test_sentences_of_residuals_and_of_their_order():
    groups = {"a": [1.0, 3.0, 5.0], "b": [2.0, 4.0, 9.0]}
    residuals = residuals_of_groups(groups)
    assert residuals.values == (-2.0, 0.0, 2.0, -3.0, -1.0, 4.0)
    says(residuals.sentence(), "residuals reach from", "-3", "2.92", "df = 4", "n = 6")
    order = normal_quantiles(residuals, 0.5)
    outside = sum(
        not low <= value <= high for value, low, high in zip(order.observed, order.low, order.high, strict=True)
    )
    assert order.outside == outside > 0
    says(order.sentence(), outside, "6 residuals", "50 %", "3 do")
    table = order.to_frame()
    assert list(table["observed"]) == sorted(residuals.values)
    assert list(residuals.to_frame()["fitted"]) == [3.0, 3.0, 3.0, 5.0, 5.0, 5.0]


def test_residuals_that_are_all_0_tell_nothing_of_their_distribution():
    none = normal_quantiles(residuals_of_groups({"a": [1.0, 1.0], "b": [2.0, 2.0]}))
    assert none.low == none.high == none.outside == Undefined(Reason.RESIDUALS_ZERO)
    says(none.sentence(), "4 residuals", "0")


def test_no_values_have_no_residuals_and_say_so():
    empty = residuals_of_groups({})
    assert empty.sd == Undefined(Reason.NO_VALUE)
    says(empty.sentence(), "no residuals", "n = 0")
    says(normal_quantiles(empty).sentence(), "0 residuals")
    with refuses(InputRefused, "residuals_of_groups"):
        normal_quantiles([1.0, 2.0, 3.0])


def test_one_degree_of_freedom_leaves_residuals_one_shape():
    """Their band would have no width, and rounding would decide what lies outside it."""
    residuals = residuals_of_groups({"a": [1.0, 2.5]})
    assert residuals.df == 1
    assert normal_quantiles(residuals).outside == Undefined(Reason.ONE_SHAPE)


@pytest.mark.soak
@pytest.mark.parametrize(("n", "level"), [(25, 0.95), (10, 0.999), (200, 0.99)])
def test_as_many_lie_outside_as_the_sentence_says_do_on_average(n, level):
    rng = np.random.default_rng(n)
    outside = [normal_quantiles(residuals_of_groups([rng.normal(size=n)]), level).outside for _ in range(200)]
    assert np.mean(outside) == pytest.approx((1.0 - level) * n, abs=4.0 * np.std(outside) / math.sqrt(200) + 1e-3)


def test_what_was_left_out_is_told_beside_the_band_too():
    residuals = residuals_of_groups({"a": [1.0, 2.0, math.nan, 5.0], "b": [1.0, 2.0]}, missing="drop")
    assert (residuals.missing, normal_quantiles(residuals).missing) == (1, 1)
    says(normal_quantiles(residuals).sentence(), "5 residuals", "1 missing")


def test_a_level_that_takes_too_many_draws_has_no_band():
    residuals = residuals_of_groups([np.arange(10_000.0)])
    assert isinstance(normal_quantiles(residuals, 1.0 - 1e-4).low, Undefined)
    assert not isinstance(normal_quantiles(residuals_of_groups([np.arange(25.0)]), 1.0 - 1e-4).low, Undefined)
