"""The first instant at which a guard, given as a power series, rises above zero: none is missed, none found twice."""

from math import comb

from benchmarks.reference_simulator.power_series import Series, derivative_at, value_at

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
