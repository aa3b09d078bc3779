"""Taylor series of the solution of a differential equation, one coefficient after the other.

A tape lists the operations of a right-hand side. Given the state at one instant and a step `h`, it finds the
coefficients of every quantity in powers of `t / h` by the recurrences of truncated power series (Moore 1966, Interval
Analysis, ch. 11; Jorba and Zou 2005, Experimental Mathematics 14).
"""

from collections.abc import Callable, Sequence
from math import isqrt
from operator import mul

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
