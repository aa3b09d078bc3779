"""The ends of computations: a number that no double is large enough for is `Undefined`, never infinite or NaN.

Doubles reach from 5e-324 to 1.8e308. Sums, squares and quotients of values from both ends of that range leave it, and
each number of a result may do so by itself: what is asked here is asked of each where it is rounded, and nowhere else.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined

Interval = tuple[float, float]
Number = float | Fraction
QUANTILE_BEYOND_DOUBLES = Undefined("Student's quantile at this level is too large for a double")


def to_double(value: Number) -> float:
    """Return the nearest double; infinite where there is none that large."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def times_power(value: float, exponent: int) -> float:
    """Return value * 2**exponent; infinite where there is no double that large."""
    try:
        return math.ldexp(value, exponent)
    except OverflowError:
        return math.copysign(math.inf, value)


def finite(value: Number, what: str) -> float | Undefined:
    """Return a number as a double, or that it is too large for one."""
    number = to_double(value)
    return number if math.isfinite(number) else Undefined(f"{what} is too large for a double")


def finite_pair(low: Number, high: Number) -> Interval | Undefined:
    """Return the ends of an interval as doubles, or that one is too large."""
    ends = to_double(low), to_double(high)
    return ends if all(map(math.isfinite, ends)) else Undefined("an end of the interval is too large for a double")


def interval_about(middle: Fraction, quantile: float, se: Fraction) -> Interval | Undefined:
    """Return middle -/+ quantile * se as doubles, or that the quantile or an end is too large."""
    if math.isinf(quantile):
        return QUANTILE_BEYOND_DOUBLES
    half = Fraction(quantile) * se
    return finite_pair(middle - half, middle + half)


def as_interval(low: float | Undefined, high: float | Undefined) -> Interval | Undefined:
    """Return two ends as an interval, or why one of them is undefined."""
    if isinstance(low, Undefined):
        return low
    return high if isinstance(high, Undefined) else (low, high)


def refuse_beyond(what: str, numbers: Iterable[Number]) -> None:
    """Raise `InputRefused` where a number has no double of its size: for results that are whole or nothing."""
    for number in numbers:
        double = to_double(number)
        if not math.isfinite(double):
            raise InputRefused(f"{what} exceeds 1.8e308: change units.")
        if double == 0.0 and number:
            raise InputRefused(f"{what} falls below 5e-324: change units.")
