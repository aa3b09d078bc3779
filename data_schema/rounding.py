"""How numbers of results are written in sentences, tables and figures: the one rule, for display only.

- A number whose error is known has the decimals that show two significant digits of that error: of a standard error, or
  of a quarter of its interval; so have the ends of the interval, but for up to three more where one would be
  written as 0. Any other number has three significant digits.
- p has three decimals and no zero before the point, "p = .023", and "p < .001" below; it has more where fewer would put
  it on, or past, a level that it is compared with.
- t and F have two decimals, their degrees of freedom one at most.

What is stated by a person or counted is no measurement: it is written as it was given.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal

from data_schema.vocabulary import Undefined

Value = float | Undefined

SIGNIFICANT = 3
"""Significant digits of a number of which no error is known."""
SMALLEST_P = 0.001
"""A smaller p-value is written as less than this, one above 1 - `SMALLEST_P` as more than that."""
USUAL_ALPHAS = (0.1, 0.05, 0.025, 0.02, 0.01, 0.005, 0.001)
"""What p-values are compared with: no p is rounded onto one of these, or past it."""
_STATISTIC_DECIMALS = 2
_HELD = 15
"""Significant digits of which a double holds every one."""
_MOST_DECIMALS = 12
"""Numbers that need more are written with a power of ten."""
_LEVEL_TOLERANCE = Decimal("1e-6")
"""Share of a level's distance to 0 or 100 % by which it may be rounded."""


def decimals_for(error: float) -> int:
    """Return how many decimals show two significant digits of an error; 0 for one that is not known."""
    if not known_error(error):
        return 0
    return max(0, 1 - _exponent(float(f"{error:.1e}")))


def known_error(error: float) -> bool:
    """Tell whether this is an error that a number can be rounded by."""
    return 0.0 < error < math.inf


def error_of(interval: tuple[float, float] | Undefined) -> float:
    """Return the error that an interval stands for, a quarter of its width; 0 where it is undefined."""
    return 0.0 if isinstance(interval, Undefined) else interval[1] / 4.0 - interval[0] / 4.0


def fixed_text(value: float, decimals: int) -> str:
    """Write a number with so many decimals, at most the digits that a double holds; "-0.00" becomes "0.00"."""
    if not math.isfinite(value):
        return f"{value:g}"
    leading = _exponent(value)
    decimals = min(decimals, _HELD - 1 - leading)
    if decimals < 0 or decimals > _MOST_DECIMALS:
        return f"{value or 0.0:.{max(1, leading + 1 + decimals) if decimals > 0 else _HELD}g}"
    text = f"{value:.{decimals}f}"
    return text.lstrip("-") if float(text) == 0.0 else text


def number_text(value: Value, digits: int = SIGNIFICANT, error: float = 0.0) -> str:
    """Write a number with the decimals that its error justifies, or with `digits` significant ones without an error.

    "undefined" where there is none. 12345 stays 12345, never 1.23e+04.
    """
    if isinstance(value, Undefined):
        return "undefined"
    if known_error(error):
        return fixed_text(value, decimals_for(error))
    text = f"{value:.{digits}g}"
    if "e" in text and 1e-4 <= abs(value) < 1e15:
        text = f"{value:.0f}"
    return "0" if text == "-0" else text


def given_text(value: Value) -> str:
    """Write a number as a person gave it: a bound, a gain, a duration."""
    return number_text(value, _HELD)


def interval_text(
    interval: tuple[float, float] | Undefined, level: float, unit: str = "", error: float | None = None
) -> str:
    """Return "95 % CI 1.2 to 3.4 J", or "95 % CI undefined"; `error` is the standard error where that is known."""
    name = f"{level_text(level)} CI"
    if isinstance(interval, Undefined):
        return f"{name} undefined"
    error = error_of(interval) if error is None else error
    low, high = (end_text(end, error) for end in interval)
    return f"{name} {low} to {high}{f' {unit}' if unit else ''}"


def end_text(end: Value, error: float) -> str:
    """Write an end of an interval with the decimals that the error justifies, more where it would be written as 0."""
    if isinstance(end, Undefined) or not known_error(error):
        return number_text(end)
    return fixed_text(end, decimals_of_end(end, decimals_for(error)))


def decimals_of_end(end: float, decimals: int) -> int:
    """Return the decimals of an end of an interval: as given, or up to three more where it would be written as 0."""
    return next((each for each in range(decimals, decimals + 4) if round(end, each) or not end), decimals)


def df_text(df: Value) -> str:
    """Write degrees of freedom: 64 for 64.0 and for 63.99998, 20.9 for 20.93."""
    return "undefined" if isinstance(df, Undefined) else fixed_text(df, 1).removesuffix(".0")


def statistic_text(letter: str, statistic: Value, df: Sequence[Value]) -> str:
    """Write a statistic: "t(18.2) = -3.41", "F(4, 45) = 1.32", "z = 2.10"; or "t undefined"."""
    if isinstance(statistic, Undefined):
        return f"{letter} undefined"
    degrees = f"({', '.join(map(df_text, df))})" if df else ""
    return f"{letter}{degrees} = {fixed_text(statistic, _STATISTIC_DECIMALS)}"


def p_text(p: Value, alpha: float = SMALLEST_P, *, name: bool = True) -> str:
    """Write a p-value: "p = .023", "p < .001", "p > .999"; `name=False` leaves "p = " out, for a table.

    No p is rounded onto `alpha` or a usual level, or past it: .0503 keeps four digits.
    """
    if isinstance(p, Undefined):
        return "p undefined" if name else "undefined"
    smallest = min(SMALLEST_P, alpha)
    if p < smallest:
        sign, digits = "<", _p_digits(smallest)
    elif p > 1.0 - SMALLEST_P:
        sign, digits = ">", _p_digits(1.0 - SMALLEST_P)
    else:
        sign, digits = "=", _same_side_text(p, alpha)
    if not name:
        return digits if sign == "=" else f"{sign} {digits}"
    return f"p {sign} {digits}"


def _p_digits(p: float) -> str:
    return f"{Decimal(repr(float(p))):f}".removeprefix("0")


def _same_side_text(p: float, alpha: float) -> str:
    """Write p with as few decimals, three or more, as leave it on its side of each level, or exactly on it."""
    levels = (*USUAL_ALPHAS, alpha)
    texts = (f"{p:.{places}f}" for places in range(3, 18))
    return next(
        (text.removeprefix("0") for text in texts if all(_side(float(text), at) == _side(p, at) for at in levels)),
        _p_digits(p),
    )


def _side(p: float, alpha: float) -> int:
    return (p > alpha) - (p < alpha)


def alpha_of_level(level: float) -> float:
    """Return 1 - level of the decimal that a level is written as: 0.1 for 0.9, which in doubles is a little less."""
    return float(1 - Decimal(repr(float(level))))


def level_text(level: float) -> str:
    """Return a level in percent: "95 %", or "99.99999 %" with the digits that tell it from 0 and from 100 %."""
    percent = 100 * Decimal(repr(float(level)))
    tolerance = _LEVEL_TOLERANCE * min(percent, 100 - percent)
    decimals = 0
    while abs(round(percent, decimals) - percent) > tolerance:
        decimals += 1
    return f"{round(percent, decimals):f} %"


def _exponent(value: float) -> int:
    """Return the power of ten of the first digit of a number; 0 for 0."""
    return Decimal(float(value)).adjusted() if value else 0
