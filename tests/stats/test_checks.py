import numpy as np
import pytest

from data_schema.errors import InputRefused
from stats.checks import as_level, as_number, as_values


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ([1.0, np.nan, np.inf], "2 of 3 values that are NaN or infinite, the first at position 2"),
        ([[1.0, 2.0]], "2 dimensions"),
        (["one"], "not a number"),
        ([1.0, None], "NaN"),
    ],
)
def test_values_that_are_no_sample_are_refused_with_a_sentence(values, sentence):
    with pytest.raises(InputRefused, match=sentence) as refusal:
        as_values("the sample", values)
    assert str(refusal.value).startswith("the sample")


def test_any_real_type_becomes_float64():
    for values in (np.array([1, 2], dtype=np.int8), np.array([1, 2], dtype=np.float32), (1, 2), [True, 2]):
        assert as_values("x", values).dtype == np.float64


@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf])
def test_numbers_out_of_bounds_are_refused(value):
    with pytest.raises(InputRefused, match="at least 0"):
        as_number("the duration", value, low=0.0)


def test_zero_is_not_above_zero():
    assert as_number("a length", 0.0, low=0.0) == 0.0
    with pytest.raises(InputRefused, match="greater than 0"):
        as_number("a length", 0.0, above=0.0)


@pytest.mark.parametrize("level", [0.0, 1.0, 95.0, np.nan])
def test_a_level_is_a_probability(level):
    with pytest.raises(InputRefused, match="between 0 and 1"):
        as_level("level", level)
