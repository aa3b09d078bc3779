"""Taylor series of the solution of a differential equation, one coefficient after the other.

A tape lists the operations of a right-hand side. Given the state at one instant and a step `h`, it finds the
coefficients of every quantity in powers of `t / h` by the recurrences of truncated power series (Moore 1966, Interval
Analysis, ch. 11; Jorba and Zou 2005, Experimental Mathematics 14).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from math import ceil, comb, isqrt
from operator import mul
from typing import Any

import mpmath

# Digits lost between the last bit and a result: event times, divisions by small masses, thousands of steps.
GUARD_DIGITS = 22


@dataclass(frozen=True, slots=True)
class FixedPoint:
    """Conversions to and from integers scaled by `2**bits`."""

    bits: int

    @classmethod
    def for_digits(cls, digits: int) -> FixedPoint:
        """A format whose last bit lies `GUARD_DIGITS` decimal places under the last of `digits`."""
        return cls(ceil((digits + GUARD_DIGITS) * 3.3219280949))

    @property
    def one(self) -> int:
        """The number 1."""
        return 1 << self.bits

    def of(self, value: Fraction | int) -> int:
        """The integer that stands for a rational number."""
        exact = Fraction(value)
        return (exact.numerator << self.bits) // exact.denominator

    def evaluate(self, function: Callable[..., Any], *arguments: Fraction) -> int:
        """The integer that stands for `function(*arguments)`, an mpmath function of rational arguments."""
        with mpmath.workprec(self.bits + 40):
            exact = [mpmath.mpf(argument.numerator) / argument.denominator for argument in arguments]
            return int(mpmath.floor(mpmath.ldexp(function(*exact), self.bits)))

    def multiply(self, left: int, right: int) -> int:
        """The product of two numbers."""
        return (left * right) >> self.bits

    def divide(self, left: int, right: int) -> int:
        """The quotient of two numbers; ZeroDivisionError where the divisor is 0."""
        return (left << self.bits) // right

    def decimal(self, value: int, digits: int) -> Decimal:
        """The number, rounded to `digits` significant digits."""
        return Context(prec=digits).divide(Decimal(value), Decimal(self.one))


State = dict[str, int]
Series = list[int]


class SeriesTape:
    """The operations of one right-hand side, in the order in which they are written down.

    Numbers are integers scaled by `2**bits`; a series is a list of `order + 1` coefficients, filled by `run`.
    """

    def __init__(self, bits: int, order: int) -> None:
        self.bits = bits
        self.order = order
        self._operations: list[Callable[[int], None]] = []
        self._states: list[tuple[Series, Series]] = []

    def constant(self, value: int) -> Series:
        """A series that does not change with time."""
        return [value] + [0] * self.order

    def state(self, value: int) -> Series:
        """A quantity with a known value now, whose rate is given later by `follow`."""
        return self.constant(value)

    def follow(self, state: Series, rate: Series) -> None:
        """Let `rate` be the derivative in time of `state`."""
        self._states.append((state, rate))

    def integral(self, value: int, rate: Series) -> Series:
        """The integral of `rate` from now on, plus `value`."""
        total = self.state(value)
        self.follow(total, rate)
        return total

    def combine(self, terms: Sequence[tuple[int, Series]], offset: int = 0) -> Series:
        """The sum of factor times series over `terms`, plus `offset`."""
        out, bits = self.constant(0), self.bits

        def fill(k: int) -> None:
            total = 0
            for factor, series in terms:
                total += factor * series[k]
            out[k] = total >> bits
            if not k:
                out[0] += offset

        self._operations.append(fill)
        return out

    def subtract(self, left: Series, right: Series) -> Series:
        """The difference of two series."""
        out = self.constant(0)

        def fill(k: int) -> None:
            out[k] = left[k] - right[k]

        self._operations.append(fill)
        return out

    def multiply(self, left: Series, right: Series) -> Series:
        """The product of two series."""
        out, bits = self.constant(0), self.bits

        def fill(k: int) -> None:
            out[k] = sum(map(mul, left[: k + 1], right[k::-1])) >> bits

        self._operations.append(fill)
        return out

    def divide(self, dividend: Series, divisor: Series) -> Series:
        """The quotient of two series; ZeroDivisionError where the divisor begins with 0."""
        out, bits = self.constant(0), self.bits

        def fill(k: int) -> None:
            known = sum(map(mul, divisor[1 : k + 1], out[k - 1 :: -1])) if k else 0
            out[k] = ((dividend[k] << bits) - known) // divisor[0]

        self._operations.append(fill)
        return out

    def square_root(self, square: Series) -> Series:
        """The square root of a series; ValueError where it begins below 0."""
        out, bits = self.constant(0), self.bits

        def fill(k: int) -> None:
            if not k:
                out[0] = isqrt(square[0] << bits)
                return
            known = sum(map(mul, out[1:k], out[k - 1 : 0 : -1]))
            out[k] = ((square[k] << bits) - known) // (2 * out[0])

        self._operations.append(fill)
        return out

    def run(self, step: int) -> float:
        """Fill every series in powers of `t / step`; returns the part of the step (at most 1) over which they hold.

        They hold as far as the last coefficients of every state stay below the rounding of the first.
        """
        bits, order = self.bits, self.order
        for k in range(order):
            for fill in self._operations:
                fill(k)
            for state, rate in self._states:
                state[k + 1] = ((step * rate[k]) >> bits) // (k + 1)
        for fill in self._operations:
            fill(order)
        reach = 1.0
        for state, _ in self._states:
            for k in range(max(1, order - 2), order + 1):
                excess = abs(state[k]).bit_length() - ROUNDING_BITS
                if excess > 0:
                    reach = min(reach, 2.0 ** (-excess / k))
        return reach


# The last coefficients may be this many bits above the last one kept: that much is lost to rounding anyway.
ROUNDING_BITS = 8


def value_at(series: Series, moment: int, bits: int) -> int:
    """The value of a series at `moment`, in units of the step."""
    total = 0
    for coefficient in reversed(series):
        total = ((total * moment) >> bits) + coefficient
    return total


def derivative_at(series: Series, moment: int, bits: int) -> int:
    """The derivative of a series with respect to `moment`, there."""
    total = 0
    for k in range(len(series) - 1, 0, -1):
        total = ((total * moment) >> bits) + k * series[k]
    return total


# A leading coefficient of at most this many bits is rounding: the guard starts at a zero that was just landed on.
ZERO_BITS = 40
# Halvings after which two crossings count as one tangency.
MAXIMUM_HALVINGS = 80


def first_rise(guard: Series, reach: int, bits: int) -> int | None:
    """The least moment in `[0, reach]` (units of the step) from which `guard` is positive; None if it is not.

    A guard that is positive at the start, or zero there and rising, gives 0. Intervals are halved until the
    coefficients show either that no zero lies in one or that the guard is monotone in it. Raises ArithmeticError if it
    touches zero without crossing.
    """
    scaled: Series = []
    power = 1 << bits
    for coefficient in guard:
        scaled.append((coefficient * power) >> bits)
        power = (power * reach) >> bits
    start = next((k for k, value in enumerate(scaled) if abs(value) >> ZERO_BITS), None)
    if start is None:
        return None
    if scaled[start] > 0:
        return 0
    bracket = _rising_interval(scaled[start:], 0)
    if bracket is None:
        return None
    low, high = ((position * reach) >> halvings for position, halvings in bracket)
    return _polish(guard, low, high, bits)


def _rising_interval(coefficients: Series, halvings: int) -> tuple[tuple[int, int], tuple[int, int]] | None:
    """Where in [0, 1] the polynomial first rises through zero, as two dyadic numbers `(n, m)` for `n / 2**m`."""
    first, rest = coefficients[0], coefficients[1:]
    if abs(first) > sum(map(abs, rest)):
        return None
    slope = abs(rest[0]) - sum(k * abs(value) for k, value in enumerate(rest[1:], start=2))
    if slope > 0:
        rises = first <= 0 < sum(coefficients)
        return ((0, 0), (1, 0)) if rises else None
    if halvings == MAXIMUM_HALVINGS:
        raise ArithmeticError("a guard touches zero without crossing it: the outcome is not decided at this precision")
    left = [value >> k for k, value in enumerate(coefficients)]
    found = _rising_interval(left, halvings + 1)
    if found is not None:
        return _placed(found, 0)
    right = [sum(comb(k, j) * left[k] for k in range(j, len(left))) for j in range(len(left))]
    found = _rising_interval(right, halvings + 1)
    return None if found is None else _placed(found, 1)


def _placed(bracket: tuple[tuple[int, int], tuple[int, int]], half: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """A bracket in one half of an interval as a bracket in the whole."""
    (low, low_bits), (high, high_bits) = bracket
    return (low + (half << low_bits), low_bits + 1), (high + (half << high_bits), high_bits + 1)


def _polish(guard: Series, low: int, high: int, bits: int) -> int:
    """The zero in a bracket in which the guard is monotone, by Newton's method kept inside it."""
    moment = (low + high) // 2
    for _ in range(4 * bits):
        value = value_at(guard, moment, bits)
        if value <= 0:
            low = moment
        else:
            high = moment
        slope = derivative_at(guard, moment, bits)
        following = moment - (value << bits) // slope if slope else low
        if not low < following < high:
            following = (low + high) // 2
        if abs(following - moment) <= 1:
            return following
        moment = following
    return moment


@dataclass(frozen=True, slots=True)
class Advance:
    """How far a step came: in time, what stopped it, and whether it came to its end."""

    elapsed: int
    fired: str | None
    complete: bool


def advance(
    tape: SeriesTape, state: State, moving: Mapping[str, Series], guards: Mapping[str, Series], step: int
) -> Advance:
    """Carry `state` forward along `moving` by at most `step`; of two guards at one instant the first named wins.

    A guard that is positive from the start on fires at once, with nothing elapsed.
    """
    bits = tape.bits
    one = 1 << bits
    reach = tape.run(step)
    moment = one if reach >= 1 else int(reach * 2**50) << (bits - 50)
    fired = None
    for name, guard in guards.items():
        rise = first_rise(guard, moment, bits)
        if rise is not None and (rise < moment or fired is None):
            moment, fired = rise, name
            if not rise:
                break
    if moment:
        for name, series in moving.items():
            state[name] = value_at(series, moment, bits) if moment != one else sum(series)
    return Advance((moment * step) >> bits, fired, fired is None and moment == one)


def setting(target: object, **values: object) -> Callable[[], None]:
    """An event that only changes attributes of `target`."""

    def event() -> None:
        for name, value in values.items():
            setattr(target, name, value)

    return event
