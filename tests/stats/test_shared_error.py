"""The interval of a mean that carries a shared error."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.shared_error import SharedError, describe_shared, shared_of_mean
from stats.summary import describe


def level_error(se: float, df: float = math.inf) -> SharedError:
    return SharedError({("drain", "level"): se}, {"drain": df})


def test_without_a_shared_error_it_is_the_plain_interval() -> None:
    values = [40.1, 41.7, 39.2, 42.0]
    plain, shared = describe(values), describe_shared(values, SharedError())
    assert (shared.ci_low, shared.ci_high) == pytest.approx((plain.ci_low, plain.ci_high), rel=1e-14)
    assert shared.df == pytest.approx(3.0)


def test_the_shared_error_stays_with_any_number_of_values() -> None:
    rng = np.random.default_rng(5)
    few, many = (describe_shared(rng.normal(40, 1, n), level_error(0.5)) for n in (10, 100_000))
    width = [float(s.ci_high) - float(s.ci_low) for s in (few, many)]  # type: ignore[arg-type]
    assert width[1] == pytest.approx(2 * 1.959964 * 0.5, rel=1e-3)
    assert width[0] > width[1]


def test_it_covers_at_its_level_when_all_values_share_one_error() -> None:
    rng = np.random.default_rng(11)
    covered = 0
    for _ in range(4000):
        shared_se, shared_df = 0.6, 4
        estimate_of_se = shared_se * np.sqrt(rng.chisquare(shared_df) / shared_df)
        values = rng.normal(40, 1.5, 10) + rng.normal(0, shared_se)
        interval = describe_shared(values, level_error(float(estimate_of_se), shared_df))
        assert not isinstance(interval.ci_low, Undefined)
        assert not isinstance(interval.ci_high, Undefined)
        covered += interval.ci_low <= 40 <= interval.ci_high
    assert 0.94 <= covered / 4000 <= 0.965


def test_one_value_has_a_reason() -> None:
    assert isinstance(describe_shared([40.0], level_error(0.5)).ci_low, Undefined)


ERRORS = st.builds(
    lambda level, slope: SharedError({("drain", "level"): level, ("drain", "slope"): slope}, {"drain": 4.0}),
    st.floats(-10, 10),
    st.floats(-10, 10),
)


@given(st.lists(ERRORS, min_size=1, max_size=5), st.lists(ERRORS, min_size=1, max_size=5))
def test_means_and_differences_are_those_of_the_gradient(one: list[SharedError], two: list[SharedError]) -> None:
    """Against the variance of the linear combination, g' C g with C = 1."""
    terms = [("drain", "level"), ("drain", "slope")]
    gradient = np.mean([[e.terms[t] for t in terms] for e in one], axis=0)
    gradient -= np.mean([[e.terms[t] for t in terms] for e in two], axis=0)
    found = shared_of_mean(one).minus(shared_of_mean(two))
    assert found.se == pytest.approx(float(np.sqrt(gradient @ gradient)), rel=1e-9, abs=1e-7)


def test_what_is_alike_cancels_exactly_and_other_fits_do_not() -> None:
    third = shared_of_mean([level_error(0.1)] * 3)  # its mean differs from 0.1 in the last digit
    assert level_error(0.1).minus(third).se == 0.0
    other = SharedError({("another robot's drain", "level"): 0.4}, {"another robot's drain": 9.0})
    both = level_error(0.3, 4.0).minus(other)
    assert both.se == pytest.approx(0.5)
    assert both.degrees_of_freedom == pytest.approx(0.25**2 / (0.09**2 / 4 + 0.16**2 / 9))
    assert level_error(0.3, 4.0).degrees_of_freedom == pytest.approx(4.0)
    assert SharedError().degrees_of_freedom == math.inf


def test_what_is_no_error_is_refused() -> None:
    with pytest.raises(InputRefused, match="shared error drain level"):
        level_error(math.nan)
    with pytest.raises(InputRefused, match="degrees of freedom of drain"):
        level_error(0.5, 0.0)
