"""Real numbers as integers: a number `x` is held as the integer nearest below `x * 2**bits`.

Every quantity of a jump lies between 1e-12 and 1e6 in SI units, so an absolute precision of `2**-bits` is all that is
needed, and sums of products on Python's integers are ten times as fast as on floating-point numbers of that length.
"""

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from math import ceil
from typing import Any

import mpmath

# Digits lost between the last bit and a result: event times, divisions by small masses, thousands of steps.
GUARD_DIGITS = 22


@dataclass(frozen=True, slots=True)
class FixedPoint:
    """Conversions to and from integers scaled by `2**bits`."""

    bits: int

    @classmethod
    def for_digits(cls, digits: int) -> "FixedPoint":
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
