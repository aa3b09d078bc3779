import math

import numpy as np
import pytest

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.groups.residuals import rmse_over_iqr
from tests.helpers.wording import refuses, says

EIGHT = np.array([1.0, 2.5, 3.0, 4.5, 6.0, 7.25, 9.0, 12.0])


def test_w25_whole_numbers_of_16_bits():
    """Others: nan, from squares that overflow."""
    measured = np.array([100, -200, 300, 32000], dtype=np.int16)
    predicted = np.array([250, -50, 130, -32000], dtype=np.int16)
    found = rmse_over_iqr(measured, predicted)
    assert found.rmse == pytest.approx(math.sqrt((150**2 + 150**2 + 170**2 + 64000**2) / 4), rel=1e-15)
    small = rmse_over_iqr(measured[:3], predicted[:3])
    assert small.rmse == pytest.approx(math.sqrt((150**2 + 150**2 + 170**2) / 3), rel=1e-15)


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
        assert (found.quartile_low, found.quartile_high) == pytest.approx(tuple(np.quantile(values, [0.25, 0.75])))


def test_a_perfect_prediction_and_a_constant_measurement():
    assert rmse_over_iqr(EIGHT, EIGHT).ratio == 0.0
    constant = rmse_over_iqr([0.1] * 4, [0.1, 0.2, 0.1, 0.1])
    assert isinstance(constant.ratio, Undefined)
    assert constant.iqr == 0.0
    assert constant.rmse == pytest.approx(0.05)
    says(constant.sentence(), "because the measured")
    assert rmse_over_iqr([0.0], [0.0]).rmse == 0.0


def test_the_thesis_ratio_follows_from_its_line():
    """Thesis 3.2.2: the estimate is 1.35 times the measured cost, RMSE/IQR = 0.63."""
    rng = np.random.default_rng(0)
    estimate = rng.normal(30.0, 5.0, 400)
    scattered = 1.35 * estimate + rng.normal(0.0, 1.0, 400) * 0.63 * 1.349 * 5.0
    found = rmse_over_iqr(scattered / 1.35, estimate)
    assert found.ratio == pytest.approx(0.63 / 1.35, rel=0.25)


def test_the_sentence_states_definition_and_n():
    sentence = rmse_over_iqr(EIGHT, EIGHT + 1.0).sentence("the cost", "J")
    says(sentence, "of the cost", "1 J", "quartiles", "n = 8")


def test_wrong_input_is_refused():
    with refuses(InputRefused, "8 measured", "7 predicted"):
        rmse_over_iqr(EIGHT, EIGHT[:7])
    with pytest.raises(InputRefused, match="0 measured"):
        rmse_over_iqr([], [])
    with refuses(InputRefused, "predicted values holds", "1", "8"):
        rmse_over_iqr(EIGHT, np.append(EIGHT[:7], np.nan))
