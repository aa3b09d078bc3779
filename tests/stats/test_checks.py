import math
import re
from decimal import Decimal

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from data_schema.errors import InputRefused
from stats.checks import as_level, as_number, as_sample, as_values
from tests.helpers.wording import refuses


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


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ((x for x in [1.0, 2.0]), "the sample is a generator: give a list of its numbers, for example list(numbers)."),
        ({1.0, 2.0}, "the sample is a set: give a list of its numbers, for example list(numbers)."),
        ({"x": 1.0}, "the sample is a dict: give a list of its numbers, for example list(numbers.values())."),
        ({"x": 1.0}.values(), "the sample is a dict_values: give a list of its numbers, for example list(numbers)."),
        (
            pd.DataFrame({"x": [1.0]}),
            "the sample is a table with the column 'x' where one list .* give a column, .*'x'",
        ),
        (pd.DataFrame({"x": [1.0], "y": [2.0]}), "the sample is a table with 2 columns .* for example df['x']."),
        (pd.DataFrame(), "the sample is a table with 0 columns where one list of numbers is allowed: give a column."),
        (5.0, "the sample is a single value: give a list of numbers."),
    ],
)
def test_what_is_no_list_is_refused_with_what_to_give_instead(values, sentence):
    with pytest.raises(InputRefused, match=re.escape(sentence).replace(r"\.\*", ".*")):
        as_sample("the sample", values)


def test_any_real_type_becomes_float64():
    for values in (np.array([1, 2], dtype=np.int8), np.array([1, 2], dtype=np.float32), (1, 2), [True, 2]):
        assert as_values("x", values).dtype == np.float64


@pytest.mark.parametrize(
    "values",
    [
        [True, False],
        np.array([True, False]),
        np.array([1.0, True, "x"], dtype=object),
        np.array([1.0, True], dtype=object),
        ["1", "2"],
        [1 + 2j],
        np.array(["2020-01-01"], dtype="datetime64[s]"),
        [[1.0], [1.0, 2.0]],
        pd.Series([True, False]),
    ],
)
def test_truth_values_text_complex_numbers_and_times_are_no_numbers(values):
    with pytest.raises(InputRefused, match="not a number"):
        as_sample("x", values)


@pytest.mark.parametrize(
    "values",
    [
        [1.0, math.nan, 3.0],
        [1, None, 3],
        [Decimal(1), Decimal("NaN"), Decimal(3)],
        [1, pd.NaT, 3],
        pd.Series([1, pd.NA, 3], dtype="Int64"),
        pd.Series([1.0, np.nan, 3.0]),
        np.ma.masked_array([1, 77, 3], mask=[False, True, False]),
        xr.DataArray(np.array([1.0, np.nan, 3.0], dtype=np.float32)),
    ],
)
def test_missing_values_of_all_kinds_are_refused_or_counted(values):
    with refuses(InputRefused, "1", "3 values", "2"):
        as_sample("x", values)
    found = as_sample("x", values, missing="drop")
    assert np.array_equal(found.values, [1.0, 3.0])
    assert found.missing == 1


def test_infinite_values_are_refused_where_missing_ones_are_dropped():
    with refuses(InputRefused, "1", "3 values"):
        as_sample("x", [1.0, math.nan, math.inf], missing="drop")


@pytest.mark.parametrize("value", [10**400])
def test_numbers_too_large_for_a_double_are_refused_as_such(value):
    with pytest.raises(InputRefused, match=r"beyond 1\.8e308"):
        as_sample("x", [value, 1])


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
    with refuses(InputRefused, "between", "0", "1"):
        as_level("level", level)
