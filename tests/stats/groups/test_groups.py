import math
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.compare.summary import read_groups
from tests.helpers.wording import refuses


def test_means_are_exact_and_differences_rounded_once():
    read = read_groups({"a": [1e15 + 0.125, 1e15, 1e15], "b": [1e15, 1e15, 1e15 + 0.25]})
    a, b = read.filled
    exact = (Fraction(1, 8) - Fraction(1, 4)) / 3
    assert read.in_unit(a.exact_mean - b.exact_mean) == float(exact)
    assert read.means == (1e15, 1e15 + 0.125)
    assert (read.names, read.sizes, read.df_within) == (("a", "b"), (3, 3), 4)


@pytest.mark.parametrize("exponent", [-900, -600, 0, 600, 1000])
def test_moments_do_not_depend_on_the_unit(exponent):
    values = {"a": [3.0, 1.0, 4.0], "b": [1.0, 5.0]}
    one, other = read_groups(values), read_groups({k: np.ldexp(v, exponent) for k, v in values.items()})
    assert other.exponent == one.exponent + exponent
    assert other.filled == one.filled
    assert other.means == tuple(math.ldexp(mean, exponent) for mean in one.means)


def test_squares_beyond_all_doubles_say_so():
    read = read_groups({"a": np.ldexp([1.0, 2.0], -600), "b": np.ldexp([1.0, 3.0], -600)})
    assert isinstance(read.in_squared_unit(read.squares_within), Undefined)
    assert read.in_squared_unit(Fraction(0)) == 0.0


def test_constants_and_groups_without_values():
    read = read_groups({"a": [0.1] * 3, "b": [], "c": [0.1] * 7})
    assert read.empty == ("b",)
    assert all(group.constant and group.exact_mean_variance == 0 for group in read.filled)
    assert read.filled[0].exact_mean == read.filled[1].exact_mean
    assert read_groups({}).df_within == 0


def test_missing_values_are_refused_or_counted():
    with pytest.raises(InputRefused, match="group 'b'"):
        read_groups({"a": [1.0], "b": [math.nan]})
    assert read_groups({"a": [1.0, 2.0], "b": [math.nan, 3.0]}, "drop").missing == 1


TABLE = pd.DataFrame({"gain": [400, 400, 0, 0], "foot": list("sbsb"), "joules": [1.0, 2.0, 4.0, 7.0]})


@pytest.mark.parametrize(
    ("groups", "names"),
    [
        (TABLE.groupby("gain")["joules"], ("0", "400")),
        (TABLE["joules"].groupby(TABLE["gain"]), ("0", "400")),
        (TABLE.groupby(["foot"])["joules"], ("b", "s")),
        (TABLE.groupby(["gain", "foot"])["joules"], ("0, b", "0, s", "400, b", "400, s")),
        ([("CE", [1.0, 2.0]), ("AD", [3.0])], ("CE", "AD")),
        ({"CE": [1.0, 2.0], "AD": [3.0]}.items(), ("CE", "AD")),
        ([(1.0, 2.0), (3.0, 4.0)], ("1", "2")),
        (pd.DataFrame({"CE": [1.0], "AD": [3.0]}), ("CE", "AD")),
    ],
)
def test_groups_come_by_name_as_pandas_groups_them_or_in_a_list(groups, names):
    assert read_groups(groups).names == names


def test_groups_that_are_no_samples_are_refused():
    with refuses(InputRefused, "groups are called", "'CE'"):
        read_groups([("CE", [1.0]), ("CE", [2.0])])
    with refuses(InputRefused, "'0'", "'joules'"):
        read_groups(TABLE.groupby("gain")[["joules"]])
