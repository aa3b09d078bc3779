"""One column of a regression, whatever its type: centred exactly, scaled by a power of two, as a double-double.

Whole numbers, time stamps and decimals are centred before they are rounded: seconds or nanoseconds since 1970 cost a
slope no digit (W16), while a least-squares solver given the same column loses all of them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, date, timedelta
from decimal import Decimal
from fractions import Fraction
from numbers import Rational
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused
from stats.checks import as_values
from stats.exact.error_free import Floats, Pair, dyadic_sum, scaled, two_sum

_TICKS_PER_SECOND = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9, "ps": 1e12, "fs": 1e15, "as": 1e18}

_MOST_IN_COMMON, _MOST_LEFT = 2**1000, 2**50


@dataclass(frozen=True, slots=True)
class Column:
    """value = (centre + 2**exponent * (high + low)) / ticks_per_unit, exactly."""

    name: str
    high: Floats
    """Shape (n,), largest magnitude between 1/2 and 1 (0 for a column of zeros)."""
    low: Floats | None
    """None when the centring was exact in one double, as it mostly is."""
    centre: float
    """About the mean, or the middle of the range; 0 when not centred. In ticks."""
    exponent: int
    ticks_per_unit: float
    """1, or the ticks per second of a time stamp: its unit is the second (since 1970)."""
    constant: bool
    """Whether all values are equal."""
    exact: bool
    """Whether the values are whole ticks or decimals, which no rounding has touched."""
    lowest: float
    highest: float
    """Range of the values."""
    fractions: tuple[Fraction, ...] | None = None
    """The values themselves, where doubles need not hold them."""

    def exactly(self, places: Sequence[int] | None = None) -> list[Fraction]:
        """Return the values at some places, or at all, in ticks, as rational numbers."""
        places = range(self.high.size) if places is None else places
        if self.fractions is not None:
            return [self.fractions[place] for place in places]
        unit = Fraction(2) ** self.exponent
        centre = (Fraction(self.centre) / unit).as_integer_ratio()
        pairs = zip(*(part[list(places)].tolist() for part in self.pair), strict=True)
        return [dyadic_sum([high.as_integer_ratio(), low.as_integer_ratio(), centre], unit) for high, low in pairs]

    @property
    def centre_scaled(self) -> float:
        """The centre in the scale of `high` (a power of two, so that nothing is rounded)."""
        return math.ldexp(self.centre, -self.exponent)

    @property
    def pair(self) -> Pair:
        """High and low part."""
        return self.high, np.zeros_like(self.high) if self.low is None else self.low


def as_column(name: str, values: ArrayLike, *, centred: bool = True, at_middle: bool = False) -> Column:
    """Return numbers or time stamps of shape (n,), n at least 1, as a column about its mean (or middle, or 0).

    Raises `InputRefused` for anything that is not one real number or moment per entry.
    """
    array = np.asarray(values)
    kind = array.dtype.kind
    if kind == "c":
        raise InputRefused(f"{name} holds complex numbers: give real ones.")
    if kind == "b":  # a dummy variable
        array, kind = array.astype(np.int64), "i"
    if kind in "mM":
        return _of_moments(name, array, centred, at_middle)
    if array.ndim == 1 and array.size:
        if kind in "iu" and int(array.min()) > -(2**62) and int(array.max()) < 2**62:
            return _of_integers(name, array.astype(np.int64), 1.0, centred, at_middle)
        if kind in "Ou":
            exact = _as_fractions(array)
            if exact is not None:
                return _of_fractions(name, exact, centred, at_middle)
        if kind == "f":
            return _of_floats(name, array.astype(np.float64, copy=False), centred, at_middle)
    return _of_floats(name, as_values(name, array), centred, at_middle)


def as_response(values: ArrayLike, *, centred: bool = True) -> Column:
    """Return what is fitted, y, as `as_column` does, moments in seconds: its unit is that of every result."""
    column = as_column("y", values, centred=centred)
    if column.ticks_per_unit == 1.0:
        return column
    ticks = Fraction(column.ticks_per_unit)
    return _of_fractions("y", [value / ticks for value in column.exactly()], centred, at_middle=False)


def as_ticks(values: Any) -> Any:
    """Return moments and durations of any kind (Python's, pandas' with a time zone or as periods) as numpy's.

    What holds no moments comes back as it is. Raises `InputRefused` for moments with and without a time zone together.
    """
    if hasattr(values, "to_timestamp") and hasattr(values, "freq"):  # periods count from their start
        values = values.to_timestamp()
    if type(getattr(values, "dtype", None)).__name__ == "DatetimeTZDtype":
        zoned = values.dt if hasattr(values, "dt") else values
        return np.asarray(zoned.tz_convert(None))
    try:
        array = np.asarray(values)
    except ValueError:
        return values  # who takes it refuses it
    entries = array.tolist() if array.dtype.kind == "O" and array.ndim == 1 else []
    if entries and all(isinstance(entry, timedelta) for entry in entries):
        return np.array([e.to_timedelta64() if hasattr(e, "to_timedelta64") else np.timedelta64(e) for e in entries])
    if not entries or not all(isinstance(entry, date) for entry in entries):
        return values
    zones = {getattr(entry, "tzinfo", None) is None for entry in entries}
    if len(zones) > 1:
        raise InputRefused("moments with and without a time zone stand together: give datetime64 values, or one kind.")
    if zones == {False}:
        entries = [entry.astimezone(UTC).replace(tzinfo=None) for entry in entries]
    # pandas keeps nanoseconds that a plain conversion would cut off.
    return np.array([e.to_datetime64() if hasattr(e, "to_datetime64") else np.datetime64(e) for e in entries])


def _of_floats(name: str, values: Floats, centred: bool, at_middle: bool) -> Column:
    lowest, highest = float(values.min()), float(values.max())
    if not math.isfinite(lowest) or not math.isfinite(highest):
        as_values(name, values)  # says how many and where
    before = math.frexp(max(-lowest, highest))[1]
    if abs(before) < 300:
        before = 0  # the sum cannot overflow: spare the pass
    else:
        values = scaled(values, -before)
    centre = 0.0
    if centred:
        low, high = math.ldexp(lowest, -before), math.ldexp(highest, -before)
        centre = 0.5 * low + 0.5 * high if at_middle else float(values.sum()) / values.size
        centre = min(max(centre, low), high)
    if centre == 0.0:
        return _scaled(name, values, None, 0.0, before, 1.0, (lowest, highest))
    return _scaled(name, *two_sum(values, -centre), centre, before, 1.0, (lowest, highest))


def _of_integers(name: str, values: NDArray[np.int64], ticks_per_unit: float, centred: bool, at_middle: bool) -> Column:
    lowest, highest = int(values.min()), int(values.max())
    centre = 0
    if centred:
        middle = (lowest + highest) // 2
        about = middle if at_middle else lowest + round(float((values - lowest).astype(np.float64).mean()))
        centre = int(float(about))  # a whole number that is also a double
    from_centre = values - centre
    high = from_centre.astype(np.float64)
    low = (from_centre - high.astype(np.int64)).astype(np.float64)
    ends = lowest / ticks_per_unit, highest / ticks_per_unit
    return _scaled(name, high, low, float(centre), 0, ticks_per_unit, ends, exact=True, constant=lowest == highest)


def _of_fractions(name: str, values: list[Fraction], centred: bool, at_middle: bool) -> Column:
    lowest, highest = min(values), max(values)
    try:
        ends = float(lowest), float(highest)
    except OverflowError as error:
        raise InputRefused(f"{name} holds a number beyond 1.8e308: give smaller numbers.") from error
    centre = float((lowest + highest) / 2 if at_middle else sum(values) / len(values)) if centred else 0.0
    from_centre = [value - Fraction(centre) for value in values]
    largest, spread = max(map(abs, from_centre)), highest - lowest
    # A centre is rounded to a double and what it leaves to two: both must leave digits of how the values differ.
    if centre and spread and (abs(centre) > spread * _MOST_IN_COMMON or largest > spread * _MOST_LEFT):
        raise InputRefused(f"{name} varies too little beside what its values have in common: take that off first.")
    before = largest.numerator.bit_length() - largest.denominator.bit_length() if largest else 0
    before = before if abs(before) > 900 else 0  # no double is small or large enough
    unit = Fraction(2) ** before
    high = [float(value / unit) for value in from_centre]
    low = [float(value / unit - Fraction(near)) for value, near in zip(from_centre, high, strict=True)]
    middle, constant = float(Fraction(centre) / unit), lowest == highest
    column = _scaled(name, np.array(high), np.array(low), middle, before, 1.0, ends, exact=True, constant=constant)
    return replace(column, fractions=tuple(values))


def _of_moments(name: str, array: NDArray[Any], centred: bool, at_middle: bool) -> Column:
    """Time stamps and durations, in seconds (since 1970)."""
    if array.ndim != 1 or not array.size:
        return _of_floats(name, as_values(name, np.empty(array.shape)), centred, at_middle)
    if np.isnat(array).any():
        raise InputRefused(f"{name} holds moments that are missing (NaT): leave them out before calling.")
    unit, step = np.datetime_data(array.dtype)
    if step != 1 or unit not in _TICKS_PER_SECOND:
        unit = unit if unit in _TICKS_PER_SECOND else "s"
        array = array.astype(f"{array.dtype.kind}8[{unit}]")
    ticks = array.astype(np.int64)
    if not -(2**62) < int(ticks.min()) <= int(ticks.max()) < 2**62:
        raise InputRefused(f"{name} holds moments too far from 1970 for their unit: use a coarser unit.")
    return _of_integers(name, ticks, _TICKS_PER_SECOND[unit], centred, at_middle)


def _as_fractions(array: NDArray[np.generic]) -> list[Fraction] | None:
    """Return big whole numbers, decimals or fractions exactly; None when something else is among them."""
    entries = array.tolist()
    if not all(isinstance(entry, Rational | Decimal) for entry in entries):
        return None
    if not all(entry.is_finite() for entry in entries if isinstance(entry, Decimal)):
        return None
    return [Fraction(entry) for entry in entries]


def _scaled(
    name: str,
    high: Floats,
    low: Floats | None,
    centre: float,
    before: int,
    ticks_per_unit: float,
    ends: tuple[float, float],
    *,
    exact: bool = False,
    constant: bool | None = None,
) -> Column:
    """Scale what was centred; `before` is the power of two already taken out."""
    if low is not None and not low.any():
        low = None
    shift = math.frexp(max(-float(high.min()), float(high.max())))[1]
    if shift:
        high = scaled(high, -shift)
        low = None if low is None else scaled(low, -shift)
    return Column(
        name,
        high,
        low,
        math.ldexp(centre, before),
        before + shift,
        ticks_per_unit,
        ends[0] == ends[1] if constant is None else constant,
        exact,
        *ends,
    )


_UNITS = {"M": "s since 1970 UTC", "m": "s"}
"""By numpy's kind of type: moments and durations."""


def time_unit(values: Any) -> str | None:
    """Return "s since 1970 UTC" for moments, "s" for durations, and None for numbers."""
    first = values[:1] if isinstance(values, Sequence) else values  # of a list, no more than what tells the type
    return _UNITS.get(np.asarray(first).dtype.kind)


def time_units(columns: Mapping[str, Any]) -> tuple[str, ...]:
    """Return "start in s since 1970 UTC" or "duration in s" of each column that was given as time."""
    units = {name: time_unit(values) for name, values in columns.items()}
    return tuple(f"{name} in {unit}" for name, unit in units.items() if unit is not None)
