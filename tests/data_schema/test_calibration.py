"""The line through what a sensor shows at known values, against numpy's least squares."""

from __future__ import annotations

import math
import sys
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.calibration import Calibration, line_through
from data_schema.errors import InputRefused
from tests.helpers.wording import refuses

NUMBERS = st.floats(-1e4, 1e4).map(lambda value: round(value, 3))


def se_at(line: Calibration, raw: float) -> float:
    return math.hypot(*(slope * raw + level for slope, level in line.errors))


def exact_se_at(raw: list[float], value: list[float], at: float) -> tuple[float, float]:
    """Standard error of a fitted line by rational arithmetic, and by what share of an error of residuals it shifts."""
    x, y, place = [*map(Fraction, raw)], [*map(Fraction, value)], Fraction(at)
    x_mean, y_mean = sum(x) / len(x), sum(y) / len(y)
    spread = sum((one - x_mean) ** 2 for one in x)
    slope = sum((one - x_mean) * (other - y_mean) for one, other in zip(x, y, strict=True)) / spread
    squares = sum((other - y_mean - slope * (one - x_mean)) ** 2 for one, other in zip(x, y, strict=True))
    leverage = Fraction(1, len(x)) + (place - x_mean) ** 2 / spread
    df = len(x) - 2
    return math.sqrt(squares / df * leverage), math.sqrt(leverage * len(x) / df)


@given(
    raw=st.lists(NUMBERS, min_size=3, max_size=8, unique=True),
    scale=st.floats(0.01, 10.0),
    offset=NUMBERS,
    scatter=st.lists(st.floats(-1.0, 1.0), min_size=8, max_size=8),
    at=NUMBERS,
)
def test_line_and_its_errors_are_those_of_least_squares(
    raw: list[float], scale: float, offset: float, scatter: list[float], at: float
) -> None:
    value = [scale * one + offset + left for one, left in zip(raw, scatter, strict=False)]
    line = line_through(raw, value)
    if np.ptp(raw) < 1.0 or not line.errors:
        return
    slope, level = np.polyfit(raw, value, 1)
    assert (line.scale, line.offset) == pytest.approx((slope, level), rel=1e-6, abs=1e-6)
    expected, share = exact_se_at(raw, value, at)
    most = max(map(abs, value)) + abs(line.scale) * max(map(abs, raw))
    assert abs(se_at(line, at) - expected) <= 1e-9 * expected + 8.0 * sys.float_info.epsilon * most * share
    assert line.df == len(raw) - 2


def test_two_points_err_as_their_known_values_do() -> None:
    line = line_through([812.0, 3071.0], [0.20, 0.85], 0.001)
    assert line.scale == pytest.approx(0.65 / 2259, rel=1e-12)
    assert line.scale * 812 + line.offset == pytest.approx(0.20, rel=1e-12)
    assert (se_at(line, 812.0), se_at(line, 3071.0)) == pytest.approx((0.001, 0.001), rel=1e-12)
    assert se_at(line, (812.0 + 3071.0) / 2) == pytest.approx(0.001 / math.sqrt(2), rel=1e-12)
    assert line.df is None
    assert line_through([812.0, 3071.0], [0.20, 0.85]).errors == ()


@pytest.mark.parametrize(
    ("raw", "value", "fact"),
    [
        ([1.0], [2.0], "two points"),
        ([1.0, 2.0], [2.0], "1 known"),
        ([3.0, 3.0], [1.0, 2.0], "3"),
        ([1.0, 2.0], [4.0, 4.0], "4"),
    ],
)
def test_what_is_no_line_is_refused(raw: list[float], value: list[float], fact: str) -> None:
    with refuses(InputRefused, fact):
        line_through(raw, value)
