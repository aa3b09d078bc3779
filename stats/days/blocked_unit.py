"""The way back from scaled values to those given: what no double can hold there is `Undefined`."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from data_schema.vocabulary import Undefined
from stats.exact.finite import Number


@dataclass(frozen=True, slots=True)
class Unit:
    """What values are counted from and in, once as many powers of two are taken out that their squares are doubles."""

    shift: Fraction
    """What they are counted from, in units of 2**shift_exponent."""
    shift_exponent: int
    exponent: int
    """They are in units of 2**exponent."""

    def value(self, scaled: Number, what: str) -> float | Undefined:
        """Return a value in the unit of the values given; `what` it is stands in the reason."""
        return _rounded(self._exact(scaled), what)

    def values(self, low: float, high: float) -> tuple[float, float] | Undefined:
        """Return an interval of values."""
        return _interval(self._exact(low), self._exact(high))

    def difference(self, scaled: Number, what: str) -> float | Undefined:
        """Return a difference of values."""
        return _rounded(_times(scaled, self.exponent), what)

    def differences(self, low: float, high: float) -> tuple[float, float] | Undefined:
        """Return an interval of differences."""
        return _interval(_times(low, self.exponent), _times(high, self.exponent))

    def spread(self, scaled: float, what: str, power: int = 1) -> float | Undefined:
        """Return a standard error, or a variance (`power` 2): 0 only where it is 0 and not for being small."""
        found = _rounded(_times(scaled, power * self.exponent), what)
        if found == 0.0 < scaled:
            return Undefined(f"{what} is too small for a double: give the values in a smaller unit")
        return found

    def scaled(self, value: Fraction) -> Fraction:
        """Return a value in the unit given as it is counted here."""
        return (value / Fraction(2) ** self.shift_exponent - self.shift) * Fraction(2) ** (
            self.shift_exponent - self.exponent
        )

    def _exact(self, scaled: Number) -> Fraction:
        return _times(self.shift, self.shift_exponent) + _times(scaled, self.exponent)


def _times(value: Number, exponent: int) -> Fraction:
    return Fraction(value) * Fraction(2) ** exponent


def _rounded(value: Fraction, what: str) -> float | Undefined:
    try:
        return float(value)
    except OverflowError:
        return Undefined(f"{what} is too large for a double: give the values in a larger unit")


def _interval(low: Fraction, high: Fraction) -> tuple[float, float] | Undefined:
    first, last = (_rounded(end, "an end of the interval") for end in (low, high))
    if isinstance(first, Undefined):
        return first
    return last if isinstance(last, Undefined) else (first, last)
