"""Taylor series of the solution of a differential equation, one coefficient after the other.

A tape lists the operations of a right-hand side. Given the state at one instant and a step `h`, it finds the
coefficients of every quantity in powers of `t / h` by the recurrences of truncated power series (Moore 1966, Interval
Analysis, ch. 11; Jorba and Zou 2005, Experimental Mathematics 14). They are integers scaled by `2**bits`; single
numbers are rational.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from math import ceil, comb, floor, isqrt
from operator import mul
from typing import Any, NamedTuple

import mpmath

# Digits lost between the last bit and a result: event times, divisions by small masses, thousands of steps.
GUARD_DIGITS = 22
# The last coefficients may be this many bits above the last one kept: that much is lost to rounding anyway.
ROUNDING_BITS = 8
# A leading coefficient of at most this many bits is rounding: the guard starts at a zero that was just landed on.
ZERO_BITS = 40
# Halvings after which two crossings count as one tangency.
MAXIMUM_HALVINGS = 80

State = dict[str, Fraction]
Scalar = Fraction | int
Coefficient = Callable[[int, list[int]], int]
"""Gives the coefficient of an order from those of lower orders."""


def bits_for(digits: int) -> int:
    """Bits whose last one lies `GUARD_DIGITS` decimal places under the last of `digits`."""
    return ceil((digits + GUARD_DIGITS) * 3.3219280949)


def evaluate(bits: int, function: Callable[..., Any], *arguments: Fraction) -> Fraction:
    """An mpmath function of rational arguments, to more than `bits`."""
    with mpmath.workprec(bits + 40):
        found = function(*(mpmath.mpf(argument.numerator) / argument.denominator for argument in arguments))
        return Fraction(int(mpmath.floor(mpmath.ldexp(found, bits + 40))), 1 << (bits + 40))


class Tape:
    """The operations of one right-hand side, in the order in which they are written down."""

    def __init__(self, bits: int, order: int) -> None:
        self.bits, self.order = bits, order
        self.operations: list[tuple[list[int], Coefficient]] = []
        self._states: list[tuple[Series, Series]] = []

    def fixed(self, value: Scalar) -> int:
        """The integer that stands for a rational number."""
        return floor(value * (1 << self.bits))

    def series(self, value: Scalar) -> Series:
        """A quantity with a known value now; without a rate, given by `follow`, it does not change."""
        return Series(self, [self.fixed(value)] + [0] * self.order)

    def follow(self, state: Series, rate: Series) -> None:
        """Let `rate` be the derivative in time of `state`."""
        self._states.append((state, rate))

    def integral(self, value: Scalar, rate: Series) -> Series:
        """The integral of `rate` from now on, plus `value`."""
        total = self.series(value)
        self.follow(total, rate)
        return total

    def run(self, step: int) -> float:
        """Fill every series in powers of `t / step`; returns the part of the step (at most 1) over which they hold.

        They hold as far as the last coefficients of every state stay below the rounding of the first.
        """
        for k in range(self.order + 1):
            for terms, coefficient in self.operations:
                terms[k] = coefficient(k, terms)
            for state, rate in self._states if k < self.order else ():
                state.terms[k + 1] = ((step * rate.terms[k]) >> self.bits) // (k + 1)
        reach = 1.0
        for state, _ in self._states:
            for k in range(max(1, self.order - 2), self.order + 1):
                excess = abs(state.terms[k]).bit_length() - ROUNDING_BITS
                if excess > 0:
                    reach = min(reach, 2.0 ** (-excess / k))
        return reach


class Series:
    """One quantity on a tape: its coefficients, filled by the tape's `run`."""

    def __init__(self, tape: Tape, terms: list[int]) -> None:
        self.tape, self.terms = tape, terms

    def _made(self, coefficient: Coefficient) -> Series:
        """A series whose coefficient `k` this gives, of those before it."""
        out = self.tape.series(0)
        self.tape.operations.append((out.terms, coefficient))
        return out

    def __add__(self, other: Series | Scalar) -> Series:
        a, b = self.terms, (other if isinstance(other, Series) else self.tape.series(other)).terms
        return self._made(lambda k, _: a[k] + b[k])

    def __neg__(self) -> Series:
        a = self.terms
        return self._made(lambda k, _: -a[k])

    def __sub__(self, other: Series | Scalar) -> Series:
        a, b = self.terms, (other if isinstance(other, Series) else self.tape.series(other)).terms
        return self._made(lambda k, _: a[k] - b[k])

    def __mul__(self, other: Series | Scalar) -> Series:
        a, bits = self.terms, self.tape.bits
        if isinstance(other, Series):
            b = other.terms
            return self._made(lambda k, _: sum(map(mul, a[: k + 1], b[k::-1])) >> bits)
        factor = self.tape.fixed(other)
        return self._made(lambda k, _: (factor * a[k]) >> bits)

    def __radd__(self, other: Scalar) -> Series:
        return self + other

    def __rsub__(self, other: Scalar) -> Series:
        return -self + other

    def __rmul__(self, other: Scalar) -> Series:
        return self * other

    def __truediv__(self, divisor: Series) -> Series:
        """ZeroDivisionError where the divisor begins with 0."""
        a, b, bits = self.terms, divisor.terms, self.tape.bits

        def coefficient(k: int, out: list[int]) -> int:
            known: int = sum(map(mul, b[1 : k + 1], out[k - 1 :: -1])) if k else 0
            return ((a[k] << bits) - known) // b[0]

        return self._made(coefficient)

    def root(self) -> Series:
        """The square root; ValueError where the series begins below 0."""
        a, bits = self.terms, self.tape.bits

        def coefficient(k: int, out: list[int]) -> int:
            if not k:
                return isqrt(a[0] << bits)
            known: int = sum(map(mul, out[1:k], out[k - 1 : 0 : -1]))
            return ((a[k] << bits) - known) // (2 * out[0])

        return self._made(coefficient)

    def at(self, moment: int) -> int:
        """The value at `moment`, in units of the step."""
        total, bits = 0, self.tape.bits
        for coefficient in reversed(self.terms):
            total = ((total * moment) >> bits) + coefficient
        return total


def first_rise(guard: Series, reach: int) -> int | None:
    """The least moment in `[0, reach]` (units of the step) from which `guard` is positive; None if it is not.

    A guard that is positive at the start, or zero there and rising, gives 0. Intervals are halved until the
    coefficients show either that no zero lies in one or that the guard is monotone in it. Raises ArithmeticError if it
    touches zero without crossing.
    """
    bits = guard.tape.bits
    scaled: list[int] = []
    power = 1 << bits
    for coefficient in guard.terms:
        scaled.append((coefficient * power) >> bits)
        power = (power * reach) >> bits
    start = next((k for k, value in enumerate(scaled) if abs(value) >> ZERO_BITS), None)
    if start is None:
        return None
    if scaled[start] > 0:
        return 0
    bracket = _rising_interval(scaled[start:], 0, 0)
    if bracket is None:
        return None
    place, halvings = bracket
    low, high = (place * reach) >> halvings, ((place + 1) * reach) >> halvings
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if guard.at(middle) > 0 else (middle, high)
    return high


def _rising_interval(coefficients: list[int], place: int, halvings: int) -> tuple[int, int] | None:
    """Where a polynomial over [0, 1] first rises through zero: `place` and `halvings` of a half of a half of it."""
    first, rest = coefficients[0], coefficients[1:]
    if abs(first) > sum(map(abs, rest)):
        return None
    slope = abs(rest[0]) - sum(k * abs(value) for k, value in enumerate(rest[1:], start=2))
    if slope > 0:
        return (place, halvings) if first <= 0 < sum(coefficients) else None
    if halvings == MAXIMUM_HALVINGS:
        raise ArithmeticError("a guard touches zero without crossing it: the outcome is not decided at this precision")
    left = [value >> k for k, value in enumerate(coefficients)]
    found = _rising_interval(left, 2 * place, halvings + 1)
    if found is not None:
        return found
    right = [sum(comb(k, j) * left[k] for k in range(j, len(left))) for j in range(len(left))]
    return _rising_interval(right, 2 * place + 1, halvings + 1)


class Advance(NamedTuple):
    """How far a step came: in time, what stopped it, and whether it came to its end."""

    elapsed: Fraction
    fired: str | None
    complete: bool


def advance(
    tape: Tape, state: State, moving: Mapping[str, Series], guards: Mapping[str, Series], step: Fraction
) -> Advance:
    """Carry `state` forward along `moving` by at most `step`; of two guards at one instant the first named wins.

    A guard that is positive from the start on fires at once, with nothing elapsed.
    """
    bits, one, step_units = tape.bits, 1 << tape.bits, tape.fixed(step)
    reach = tape.run(step_units)
    moment = one if reach >= 1 else int(reach * 2**50) << (bits - 50)
    fired = None
    for name, guard in guards.items():
        rise = first_rise(guard, moment)
        if rise is not None and (rise < moment or fired is None):
            moment, fired = rise, name
            if not rise:
                break
    if moment:
        for name, series in moving.items():
            state[name] = Fraction(series.at(moment) if moment != one else sum(series.terms), one)
    return Advance(Fraction((moment * step_units) >> bits, one), fired, fired is None and moment == one)
