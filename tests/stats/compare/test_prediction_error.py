"""Errors of predictions over the interquartile range of what was measured."""

import math

import numpy as np
import pytest

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.compare.agreement import rmse_over_iqr
from tests.helpers.wording import refuses

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
