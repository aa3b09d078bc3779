"""What is a sample of numbers, and the sentence that refuses what is none."""

import math
from decimal import Decimal

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from data_schema.errors import InputRefused
from stats.checks import as_level, as_number, as_sample
from tests.helpers.wording import refuses


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ([1.0, np.nan, np.inf], "the sample holds 2 of 3 values that are NaN or infinite, the first at position 2"),
        ([[1.0, 2.0]], "2 dimensions"),
        ([10**400, 1], "1 of 2"),
        ((x for x in [1.0, 2.0]), "a list of real numbers"),
        ({"x": 1.0}, "a list of real numbers"),
        (pd.DataFrame({"x": [1.0]}), "2 dimensions"),
        (5.0, "0 dimensions"),
    ],
)
def test_what_is_no_sample_is_refused_with_what_to_give_instead(values, sentence):
    with refuses(InputRefused, "the sample", sentence):
        as_sample("the sample", values)


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
    with refuses(InputRefused, "1", "3 values"):
        as_sample("x", [1.0, math.nan, math.inf], missing="drop")


@pytest.mark.parametrize(
    ("ask", "values", "said"),
    [
        (lambda value: as_number("the duration", value, low=0.0), (-1.0, np.nan, np.inf), "at least 0"),
        (lambda value: as_number("a length", value, above=0.0), (0.0,), "greater than 0"),
        (lambda value: as_level("level", value), (0.0, 1.0, 95.0, np.nan), "between"),
    ],
)
def test_numbers_out_of_bounds_are_refused(ask, values, said):
    assert as_number("a length", 0.0, low=0.0) == 0.0
    for value in values:
        with refuses(InputRefused, said):
            ask(value)
