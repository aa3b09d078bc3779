"""A comparison with what is left of a shared error says the same of its test as `SharedTest` does."""

from __future__ import annotations

import math

import pytest

from labbook.analysis.comparison.by_day import add_shared_error
from stats.compare.shared_error import NORMAL, SharedError, difference_with_shared
from stats.compare.two_sample import compare_two

TREATED, CONTROL = [50.1, 51.2, 49.0, 50.4], [44.0, 45.2, 43.1, 44.4]


@pytest.mark.parametrize(("se", "df"), [(0.5, 4.0), (3.0, 12.0), (1e200, math.inf)])
def test_t_df_p_its_logarithm_and_the_ends_are_those_of_the_shared_test(se: float, df: float) -> None:
    plain, error = compare_two(TREATED, CONTROL), SharedError({("drain", "level"): se}, {"drain": df})
    found = add_shared_error(plain, error)
    expected = difference_with_shared(plain.welch_t, plain.welch_df, plain.welch_p, plain.welch_ci, error)
    assert (found.welch_t, found.welch_df, found.welch_p) == (expected.t, expected.df, expected.p)
    assert found.welch_log10_p == expected.log10_p
    assert found.welch_ci == (expected.ci_low, expected.ci_high)
    assert isinstance(found.welch_p, float)
    assert found.welch_log10_p == pytest.approx(math.log10(found.welch_p), rel=1e-12, abs=1e-15)


def test_a_normal_t_has_a_p_and_its_logarithm() -> None:
    found = add_shared_error(
        compare_two(TREATED, CONTROL), SharedError({("drain", "level"): 1e200}, {"drain": math.inf})
    )
    assert found.df is NORMAL
    assert isinstance(found.log10_p, float)
