"""Columns of a regression, whatever their type: as whole numbers of one unit, exactly; and which of them do not fit.

Whole numbers, time stamps and decimals are taken as they are, before anything is rounded: seconds or nanoseconds since
1970 cost a slope no digit (W16), while a least-squares solver given the same column as doubles loses all of them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, date, timedelta
from decimal import Decimal
from fractions import Fraction
from numbers import Rational
from operator import lshift, mul
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused
from stats.checks import as_values
from stats.exact.numbers import Floats
from stats.lines.fit import INTERCEPT, ExactFit

_TICKS_PER_SECOND = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9, "ps": 10**12, "fs": 10**15, "as": 10**18}


_ROUNDING = Fraction(2) ** -98
"""A column no further than the root of this share of its size from the span of the others differs by rounding only."""
_FOLLOWS = Fraction(1, 10_000)
"""A column this close to the span of the others, as a share of its squares, follows them (VIF 10 000)."""
_LEAST = 5e-324


@dataclass(frozen=True, slots=True)
class Column:
    """Each value is its count times the unit."""

    name: str
    counts: list[int]
    """Shape (n,)."""
    unit: Fraction
    exact: bool
    """Whether the values are whole ticks or decimals, which no rounding has touched."""

    @property
    def constant(self) -> bool:
        """Whether all values are equal."""
        return min(self.counts) == max(self.counts)

    @property
    def lowest(self) -> float:
        """The least value."""
        return float(min(self.counts) * self.unit)

    @property
    def highest(self) -> float:
        """The largest value."""
        return float(max(self.counts) * self.unit)

    def squares(self, *, centred: bool) -> Fraction:
        """Return the sum of squares of the counts, about their mean or about 0."""
        plain: int = sum(map(mul, self.counts, self.counts))
        return plain - Fraction(sum(self.counts) ** 2, len(self.counts)) * centred

    def direction(self, *, centred: bool) -> Floats:
        """Return the counts, about their mean or as they are, scaled to length 1."""
        n, total = len(self.counts), sum(self.counts)
        exact = [n * count - total for count in self.counts] if centred else self.counts
        shift = max(max(map(abs, exact)).bit_length() - 1000, 0)
        values = np.array([float(value >> shift) if shift else float(value) for value in exact])
        values = values / np.max(np.abs(values), initial=_LEAST)
        return np.asarray(values / np.linalg.norm(values))


def as_column(name: str, values: ArrayLike) -> Column:
    """Return numbers, time stamps or durations of shape (n,), n at least 1, exactly; times in seconds (since 1970).

    Raises `InputRefused` for anything that is not one real number or moment per entry.
    """
    array = np.asarray(values)
    kind = array.dtype.kind
    if kind == "c":
        raise InputRefused(f"{name} holds complex numbers: give real ones.")
    if kind == "b":  # a dummy variable
        array, kind = array.astype(np.int64), "i"
    if kind in "mM":
        return _of_moments(name, array)
    if array.ndim == 1 and array.size and kind in "iuO":
        exact = _as_fractions(array)
        if exact is not None:
            return _of_fractions(name, exact)
    return _of_doubles(name, as_values(name, array))


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


def _of_doubles(name: str, values: NDArray[np.float64]) -> Column:
    """Return doubles as whole numbers of the largest power of two, at most 1, that all of them are multiples of."""
    fractions, exponents = np.frexp(values)
    whole = np.ldexp(fractions, 53).astype(np.int64)
    zeros = np.maximum(np.frexp((whole & -whole).astype(np.float64))[1] - 1, 0)
    lowest = np.where(whole == 0, 0, exponents - 53 + zeros)
    finest = min(int(lowest.min()), 0)
    shifts = (lowest - finest).tolist()
    return Column(name, list(map(lshift, (whole >> zeros).tolist(), shifts)), Fraction(1, 2**-finest), exact=False)


def _of_fractions(name: str, values: list[Fraction]) -> Column:
    try:
        float(min(values)), float(max(values))
    except OverflowError as error:
        raise InputRefused(f"{name} holds a number beyond 1.8e308: give smaller numbers.") from error
    finest = math.lcm(*{value.denominator for value in values})
    counts = [value.numerator * (finest // value.denominator) for value in values]
    return Column(name, counts, Fraction(1, finest), exact=True)


def _of_moments(name: str, array: NDArray[Any]) -> Column:
    if array.ndim != 1 or not array.size:
        as_values(name, np.empty(array.shape))  # refuses it
    if np.isnat(array).any():
        raise InputRefused(f"{name} holds moments that are missing (NaT): leave them out before calling.")
    unit, step = np.datetime_data(array.dtype)
    if step != 1 or unit not in _TICKS_PER_SECOND:
        unit = unit if unit in _TICKS_PER_SECOND else "s"
        array = array.astype(f"{array.dtype.kind}8[{unit}]")
    return Column(name, array.astype(np.int64).tolist(), Fraction(1, _TICKS_PER_SECOND[unit]), exact=True)


def _as_fractions(array: NDArray[np.generic]) -> list[Fraction] | None:
    """Return whole numbers, decimals or fractions exactly; None when something else is among them."""
    entries = array.tolist()
    if not all(isinstance(entry, Rational | Decimal) for entry in entries):
        return None
    if not all(entry.is_finite() for entry in entries if isinstance(entry, Decimal)):
        return None
    return [Fraction(entry) for entry in entries]


_UNITS = {"M": "s since 1970 UTC", "m": "s"}
"""By numpy's kind of type: moments and durations."""


def time_unit(values: Any) -> str | None:
    """Return "s since 1970 UTC" for moments, "s" for durations, and None for numbers."""
    first = values[:1] if isinstance(values, Sequence) else values  # of a list only what its type is found from
    return _UNITS.get(np.asarray(first).dtype.kind)


def time_units(columns: Mapping[str, Any]) -> tuple[str, ...]:
    """Return "start in s since 1970 UTC" or "duration in s" of each column that was given as time."""
    units = {name: time_unit(values) for name, values in columns.items()}
    return tuple(f"{name} in {unit}" for name, unit in units.items() if unit is not None)


def named_columns(columns: Any) -> dict[str, ArrayLike]:
    """Return columns by their names; raises `InputRefused` where they have none."""
    if hasattr(columns, "columns"):  # a data frame
        columns = {str(name): columns[name] for name in columns.columns}
    if not isinstance(columns, Mapping):
        raise InputRefused('the columns have no names: give them by name, {"temperature": [...]}, or as a data frame.')
    return {name: as_ticks(values) for name, values in columns.items()}


def refuse_unfit(y: ArrayLike, columns: Mapping[str, ArrayLike], intercept: bool) -> int:
    """Return the number of values, after what does not fit together was refused."""
    n, p = int(np.size(y)), len(columns) + intercept
    if not columns or n < p:
        raise InputRefused(
            f"{p} coefficients were asked of {n} values of y: give at least one column and no fewer values than "
            "coefficients."
        )
    for name, values in columns.items():
        if np.shape(values) != np.shape(y):
            raise InputRefused(
                f"the column {name!r} has the shape {np.shape(values)} and y has {np.shape(y)}: give one value of "
                "each column for each of y."
            )
    if intercept and INTERCEPT in columns:
        raise InputRefused(f"a column is named {INTERCEPT!r}, as the constant that is fitted: name it otherwise.")
    return n


def refuse_unidentifiable(columns: Mapping[str, Column], intercept: bool) -> None:
    """Raise `InputRefused` for a column of zeros, and for a constant one beside an intercept."""
    for name, column in columns.items():
        if column.constant and (intercept or not any(column.counts)):
            what = "is constant beside an intercept" if intercept else "holds only zeros"
            raise InputRefused(f"the column {name!r} {what}: its coefficient is not identifiable, leave it out.")


def identifiable(
    exact: ExactFit | None,
    columns: Mapping[str, Column],
    directions: Sequence[Floats],
    spreads: Sequence[Fraction],
    skip: int,
) -> ExactFit:
    """Return a fit whose coefficients the columns determine; raises `InputRefused`, naming those that are collinear."""
    if exact is None or _follows(exact, list(columns.values()), spreads, skip):
        listed = quoted_list(_collinear(list(columns), directions))
        raise InputRefused(
            f"the columns {listed} are collinear to the last digit, so that "
            "their coefficients are not identifiable: leave one of them out."
        )
    return exact


def _follows(exact: ExactFit, columns: Sequence[Column], spreads: Sequence[Fraction], skip: int) -> bool:
    """Whether a column is no further from the span of the others than its values are rounded by.

    What rounding did to a column of doubles is a share of its values, not of what centring left of them. A column that
    itself varies by little more than that is what it says; one that follows others is not.
    """
    for place, (column, spread) in enumerate(zip(columns, spreads, strict=True), skip):
        distance = Fraction(exact.determinant, exact.adjugate[place][place])
        size = spread if column.exact else column.squares(centred=False)
        if distance <= max(min(_ROUNDING * size, _FOLLOWS * spread), _ROUNDING * spread):
            return True
    return False


def _collinear(names: Sequence[str], columns: Sequence[Floats]) -> list[str]:
    """Return the names of those with a share in the direction that the data do not fix."""
    share = np.abs(np.linalg.svd(np.array(columns).T)[2][-1])
    return [name for name, size in zip(names, share, strict=True) if size > 1e-8 * share.max()]


def quoted_list(names: list[str]) -> str:
    """Return names in quotes, as "'a', 'b' and 'c'"."""
    quoted = [repr(name) for name in names]
    return quoted[0] if len(quoted) == 1 else f"{', '.join(quoted[:-1])} and {quoted[-1]}"
