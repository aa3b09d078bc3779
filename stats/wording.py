"""Numbers in sentences: rounding happens here and nowhere else.

A number keeps at least so many significant digits that what is said of it can be read from them: two digits of its
standard error, of half its interval or of the difference it is a part of. It never has more than a double holds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal

from data_schema.rounding import level_text, on_its_side
from data_schema.vocabulary import Undefined

SMALLEST_P = 0.0001
"""Below it a p-value is only said to be smaller."""
_HELD = 15
"""Significant digits of which a double holds every one."""
_MOST = 17
"""Significant digits that tell every double from every other."""


def number_text(value: float | Undefined, digits: int = 4, within: float = 0.0) -> str:
    """Return a number with `digits` significant digits, or "undefined"; 12345 stays 12345, never 1.2e+04.

    Where `within` is not 0, the number has as many more digits as show two of that: of an error or a difference, in
    the unit of the value.
    """
    if isinstance(value, Undefined):
        return "undefined"
    text = f"{value:.{max(digits, _digits_within(value, within))}g}"
    if "e" in text and 1e-4 <= abs(value) < 1e15:
        text = f"{value:.0f}"
    return "0" if text == "-0" else text


def _digits_within(value: float, within: float) -> int:
    """Return how many significant digits of a number show two of `within`, at most those that the double has."""
    if value == 0.0 or not 0.0 < within < math.inf or not math.isfinite(value):
        return 0
    held = len(Decimal(repr(float(value))).as_tuple().digits)
    return min(_exponent(value) - _exponent(within) + 2, held)


def _exponent(value: float) -> int:
    """Return the power of ten of the first digit of a number that is not 0."""
    return Decimal(float(value)).adjusted()


def half_width(interval: tuple[float, float] | Undefined) -> float:
    """Return half of an interval, by which the number beside it has its digits; 0 where it is undefined."""
    return 0.0 if isinstance(interval, Undefined) else interval[1] / 2.0 - interval[0] / 2.0


def share_text(share: float | Undefined, digits: int) -> str:
    """Return a share of 1, such as R squared: as many digits as tell it from 1 where it is not."""
    return number_text(share, digits, 0.0 if isinstance(share, Undefined) else 1.0 - share)


def df_text(df: float | Undefined) -> str:
    """Return degrees of freedom: 64 for 64.0, 20.9 for 20.93."""
    if isinstance(df, Undefined):
        return "undefined"
    return f"{df:.0f}" if math.isclose(df, round(df), rel_tol=1e-9) or df >= 1e4 else f"{df:.1f}"


def estimate_texts(values: Sequence[float], se: float) -> list[str]:
    """Return an estimate and its ends with the decimals that their standard error is worth: two digits of it.

    Three digits where there is no error, and never more than a double holds of the largest value.
    """
    largest = max(map(abs, values))
    if largest == 0.0 or not math.isfinite(largest):
        return [number_text(value) for value in values]
    known = 0.0 < se < math.inf
    decimals = 1 - _exponent(se) if known else max(3, 2 - _exponent(largest))
    decimals = max(0, min(decimals, _HELD - 1 - _exponent(largest)))
    if largest >= 1e15 or decimals > _MOST:
        return [number_text(value, 3, se if known else 0.0) for value in values]
    return [f"{value:.{decimals}f}" for value in values]


def bounded_texts(
    value: float, interval: tuple[float, float] | Undefined, se: float, level: float, unit: str = ""
) -> tuple[str, str]:
    """Return an estimate and "95 % CI 1.23 to 4.56 J" with the decimals that their standard error is worth."""
    name = f"{level_text(level)} CI"
    if isinstance(interval, Undefined):
        return estimate_texts([value], se)[0], f"{name} undefined"
    estimate, low, high = estimate_texts([value, *interval], se)
    return estimate, f"{name} {low} to {high}{with_unit(unit)}"


def p_text(p: float | Undefined, log10_p: float | Undefined | None = None, alpha: float = SMALLEST_P) -> str:
    """Return "p = 0.023", "p < 0.0001", with its logarithm "p = 10^-2476.7" below 1e-300, or "p undefined".

    Two digits, and as many more as show on which side of the usual levels and of `alpha` it lies: "p = 0.0503".
    """
    if isinstance(p, Undefined):
        return "p undefined"
    if isinstance(log10_p, float) and log10_p < -300.0:
        return f"p = 10^{log10_p:.1f}"
    smallest = min(SMALLEST_P, alpha)
    if p < smallest:
        return f"p < {smallest:g}"
    return f"p = {on_its_side(p, (f'{p:.{digits}g}' for digits in range(2, _MOST + 1)), alpha)}"


def interval_text(interval: tuple[float, float] | Undefined, level: float, unit: str = "") -> str:
    """Return "95 % CI 1.2 to 3.4 J", or "95 % CI undefined"; two digits of its half at least."""
    name = f"{level_text(level)} CI"
    if isinstance(interval, Undefined):
        return f"{name} undefined"
    low, high = (number_text(end, within=half_width(interval)) for end in interval)
    return f"{name} {low} to {high}{with_unit(unit)}"


def counted(number: int, what: str) -> str:
    """Return "1 day" or "3 days"."""
    return f"{number} {what}{'' if number == 1 else 's'}"


def with_unit(unit: str) -> str:
    """Return the unit with the space that belongs before it."""
    return f" {unit}" if unit else ""


def missing_text(*missing: int) -> str:
    """Return ", 3 missing left out", or nothing where none were."""
    return f", {sum(missing)} missing left out" if any(missing) else ""
