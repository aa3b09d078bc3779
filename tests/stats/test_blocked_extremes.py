"""Values of any size by day: numbers that doubles can hold, or the reason why there are none; never NaN or infinity."""

from __future__ import annotations

import math
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from data_schema.errors import LabbookError
from data_schema.vocabulary import Undefined
from stats.days.blocked import blocked_by_day
from stats.days.blocked_result import ExactTest
from tests.helpers.wording import says

LARGEST, SMALLEST = np.finfo(np.float64).max, 5e-324
SUBNORMAL = st.integers(-(2**52), 2**52).map(lambda count: count * SMALLEST)
NEAR_THE_LARGEST = st.floats(0.9, 1.0).flatmap(lambda share: st.sampled_from([share * LARGEST, -share * LARGEST]))
MIXED = st.sampled_from([1e-310, -1e-310, 1e200, -1e200, 1.0, 0.0, 1e-160, 1e160, LARGEST, -LARGEST, SMALLEST])
ANY = st.floats(allow_nan=False, allow_infinity=False)
NUMBERS = st.sampled_from([SUBNORMAL, NEAR_THE_LARGEST, MIXED, ANY, st.sampled_from([1e308, -1e308, 1.5e308])])
Row = tuple[float, str, int, int]
ROWS = NUMBERS.flatmap(
    lambda value: st.lists(
        st.tuples(value, st.sampled_from("abc"), st.integers(0, 3), st.integers(0, 1)), min_size=1, max_size=24
    )
)


def floats_in(item: Any) -> list[float]:
    if isinstance(item, float):
        return [item]
    if is_dataclass(item) and not isinstance(item, Undefined):
        return [each for field in fields(item) for each in floats_in(getattr(item, field.name))]
    return [each for part in item for each in floats_in(part)] if isinstance(item, tuple) else []


def said(rows: list[Row], *, with_runs: bool, exponent: int = 0) -> Any:
    values, condition, day, run = zip(*rows, strict=True)
    return blocked_by_day(np.ldexp(np.array(values), exponent), condition, day, run if with_runs else None)


@given(ROWS, st.booleans())
@example(
    [(1e308, "a", 0, 0), (-1e308, "b", 0, 0), (1.5e308, "a", 1, 0), (-1.6e308, "b", 1, 0), (1e300, "b", 1, 0)], False
)
@example([(SMALLEST * (3 * i % 7), "ab"[i % 2], i // 4, i // 2 % 2) for i in range(16)], True)
@example([((1e-310, 1e200)[i % 3 == 0], "abc"[i % 3], i % 4, 0) for i in range(24)], False)
def test_every_number_is_finite_or_has_a_reason(rows, with_runs):
    try:
        found = said(rows, with_runs=with_runs)
    except LabbookError:
        return
    assert all(map(math.isfinite, floats_in(found)))
    assert not any(word in found.sentence("J").replace("undefined", "") for word in ("nan", "inf "))
    found.to_json()
    found.to_frame()


BALANCED = [(float(7 * i % 11 + 3 * (i % 2) + 5 * (i // 6)), "ab"[i % 2], i // 6, i // 2 % 3) for i in range(24)]
"""Whole numbers of at most five bits: exact in any unit."""


@pytest.mark.parametrize("exponent", [1018, -1074])
@pytest.mark.parametrize("with_runs", [False, True])
def test_the_ends_of_the_range_have_the_tests_of_its_middle(exponent, with_runs):
    """What has no unit stays; what has one is there where doubles are, and says so where they end."""
    middle, end = said(BALANCED, with_runs=with_runs), said(BALANCED, with_runs=with_runs, exponent=exponent)
    assert (end.mixed.f, end.mixed.df_within, end.mixed.p) == (middle.mixed.f, middle.mixed.df_within, middle.mixed.p)
    assert isinstance(end.exact, ExactTest)
    assert (end.exact.f, end.exact.p) == (middle.exact.f, middle.exact.p)
    assert end.contrasts[0].difference == math.ldexp(middle.contrasts[0].difference, exponent)
    assert middle.residual_variance > 0.0
    assert isinstance(end.residual_variance, Undefined)
    assert ("large" if exponent > 0 else "small") in end.residual_variance.reason


def test_a_difference_beyond_all_doubles_is_undefined_and_its_test_is_not():
    shares = [[(1.5, "a"), (1.6, "a"), (-1.4, "b"), (-1.5, "b")], [(1.5, "a"), (1.6, "a"), (-1.4, "b"), (-1.7, "b")]]
    rows = [(share * 1e308, name, day, 0) for day in (0, 1) for share, name in shares[day]]
    found = said(rows, with_runs=False)
    scaled = said(rows, with_runs=False, exponent=-600)
    (contrast,), (other,) = found.contrasts, scaled.contrasts
    assert (contrast.t, contrast.p) == (other.t, other.p)
    assert isinstance(contrast.difference, Undefined)
    assert isinstance(contrast.interval, Undefined)
    says(contrast.difference.reason, "too large for")
    assert contrast.se == math.ldexp(other.se, 600)
    assert isinstance(found.exact.contrasts[0].difference, Undefined)
    assert [each.estimate for each in found.conditions] == [math.ldexp(e.estimate, 600) for e in scaled.conditions]
