"""Bias of predictions by group: a worked example, what sharing an error means, and the joint test."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats as scipy_stats

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.compare.bias import PredictedLevel, bias_of_group, joint_bias

HIGH = [PredictedLevel(40.0, 0.6, 45.0, 1.0), PredictedLevel(42.0, 0.8, 46.0, 2.0)]
LOW = [PredictedLevel(38.0, 0.3, 36.0, 1.0), PredictedLevel(39.0, 0.4, 38.0, 1.4)]
ERRORS = st.floats(0.01, 10.0)
LEVELS = st.lists(
    st.builds(PredictedLevel, st.floats(-50.0, 50.0), ERRORS, st.floats(-50.0, 50.0), ERRORS), min_size=1, max_size=5
)


def test_the_bias_of_a_group_by_hand():
    found = bias_of_group(HIGH)
    assert (found.bias, found.levels) == (4.5, 2)
    assert found.measured_se == pytest.approx(0.5, rel=1e-15)  # sqrt(0.36 + 0.64) / 2
    assert found.predicted_se == 1.5  # not sqrt(1 + 4) / 2: the assumed inputs are the same
    half = 1.959963984540054 * math.sqrt(0.25 + 2.25)
    assert found.interval == pytest.approx((4.5 - half, 4.5 + half), rel=1e-15)
    assert found.differs
    assert not found.agrees_only_by_assumed


def test_an_agreement_that_assumed_inputs_buy():
    found = bias_of_group(LOW)
    assert found.bias == -1.5
    assert found.interval_of_measured[1] < 0.0 < found.interval[1]
    assert not found.differs
    assert found.agrees_only_by_assumed


def test_an_error_shared_by_measured_means_is_not_averaged_out():
    found = bias_of_group([PredictedLevel(1.0, 0.0, 1.0, 0.0, 0.3)] * 9)
    assert found.measured_se == pytest.approx(0.3)


def test_the_joint_test_by_hand_and_solved_as_it_stands():
    groups = [bias_of_group(HIGH), bias_of_group(LOW)]
    bias, own, shared = np.array([4.5, -1.5]), np.array([0.5, 0.25]), np.array([1.5, 1.2])
    expected = bias @ np.linalg.solve(np.diag(own**2) + np.outer(shared, shared), bias)
    # Sherman and Morrison: 81 + 36 - (27 - 28.8)^2 / (1 + 9 + 23.04)
    assert expected == pytest.approx(117.0 - 1.8**2 / 33.04, rel=1e-12)
    found = joint_bias(groups)
    assert found.chi_squared == pytest.approx(expected, rel=1e-12)
    assert found.df == 2
    assert found.p == pytest.approx(scipy_stats.chi2.sf(expected, 2), rel=1e-9)
    assert found.tau == 1.0


def test_the_order_of_groups_is_told():
    def group(measured, predicted):
        return bias_of_group([PredictedLevel(measured, 1.0, predicted, 1.0)])

    assert joint_bias([group(1, 3), group(2, 2), group(3, 1)]).tau == -1.0
    assert joint_bias([group(1, 1), group(2, 3), group(3, 2)]).tau == pytest.approx(1 / 3)
    assert joint_bias([group(1, 1), group(2, 1)]).tau == 0.0
    assert joint_bias([group(1, 1)]).tau is None


def test_without_errors_of_their_own_there_is_no_joint_test():
    found = joint_bias([bias_of_group([PredictedLevel(1.0, 0.0, 2.0, 0.1)])])
    assert isinstance(found.p, Undefined)
    assert isinstance(found.chi_squared, Undefined)


@pytest.mark.parametrize("level", [PredictedLevel(math.nan, 1.0, 1.0, 1.0), PredictedLevel(1.0, -1.0, 1.0, 1.0)])
def test_what_is_no_number_is_refused(level):
    with pytest.raises(InputRefused, match="is no level to compare"):
        bias_of_group([level])


def test_nothing_is_refused():
    with pytest.raises(InputRefused, match="without levels"):
        bias_of_group([])
    with pytest.raises(InputRefused, match="without groups"):
        joint_bias([])


@given(LEVELS)
def test_levels_in_another_order_or_twice_keep_the_bias_and_what_is_assumed(levels):
    once, twice = bias_of_group(levels), bias_of_group([*reversed(levels), *levels])
    assert twice.bias == pytest.approx(once.bias, abs=1e-9)
    assert twice.predicted_se == pytest.approx(once.predicted_se)
    assert twice.measured_se == pytest.approx(once.measured_se / math.sqrt(2.0))
    assert once.interval[0] <= once.interval_of_measured[0] <= once.interval_of_measured[1] <= once.interval[1]


@given(st.lists(LEVELS, min_size=1, max_size=4), st.floats(0.001, 1000.0))
def test_the_joint_test_does_not_depend_on_the_unit(groups, factor):
    def scaled(each):
        return PredictedLevel(
            *(factor * value for value in (each.measured, each.measured_se, each.predicted, each.predicted_se))
        )

    one = joint_bias([bias_of_group(levels) for levels in groups])
    other = joint_bias([bias_of_group([scaled(each) for each in levels]) for levels in groups])
    assert other.chi_squared == pytest.approx(one.chi_squared, rel=1e-6, abs=1e-6)
