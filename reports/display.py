"""Numbers as people read them: digits by the uncertainty, units, intervals, p-values. Display only."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from statistics import median_low

from data_schema.rounding import level_text as level_in_percent
from data_schema.rounding import on_its_side
from data_schema.vocabulary import Undefined
from reports.numbers import Number, SignificanceTest, Value

MINUS = "\u2212"
NO_BREAK = "\u00a0"
DASH = "\u2013"
EQUALS = f"{NO_BREAK}={NO_BREAK}"

_SHOWN_UNITS = {"m": ("mm", 1000.0), "s": ("ms", 1000.0)}
"""Stored unit -> unit shown and its factor: apex heights are stored in m and differ by millimetres."""


def shown_unit(unit: str) -> tuple[str, float]:
    """Return the unit a report shows for a stored one, and the factor to it."""
    return _SHOWN_UNITS.get(unit, (unit, 1.0))


def as_shown(number: Number) -> Number:
    """Return the number in the unit it is shown in."""
    unit, factor = shown_unit(number.unit)
    if factor == 1.0:
        return number

    def scaled(value: Value | None) -> Value | None:
        return value * factor if isinstance(value, int | float) else value

    value = number.value if isinstance(number.value, Undefined) else number.value * factor
    return dataclasses.replace(
        number,
        value=value,
        unit=unit,
        se=scaled(number.se),
        shared_se=scaled(number.shared_se),
        ci_low=scaled(number.ci_low),
        ci_high=scaled(number.ci_high),
    )


def decimal_text(value: float, places: int) -> str:
    """Write a number with so many decimals and a true minus sign; "-0.00" becomes "0.00"."""
    if math.isinf(value):
        return f"{MINUS if value < 0 else ''}\u221e"
    text = f"{value:.{places}f}"
    if float(text) == 0.0:
        text = text.lstrip("-")
    return text.replace("-", MINUS)


def general_text(value: float, digits: int = 4) -> str:
    """Write a number with so many significant digits, without exponent where it is of ordinary size."""
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(value))) if math.isfinite(value) else 0
    if -5 < exponent < 7:
        text = decimal_text(value, max(0, digits - 1 - exponent))
        return text.rstrip("0").rstrip(".") if "." in text else text
    mantissa, power = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa} × 10^{int(power)}".replace("-", MINUS)


def decimals_for(uncertainty: float) -> int:
    """Return how many decimals show this uncertainty with two significant digits."""
    if not math.isfinite(uncertainty) or uncertainty <= 0:
        return 0
    rounded = float(f"{uncertainty:.1e}")
    return max(0, 1 - math.floor(math.log10(rounded)))


def _spread(number: Number) -> float | None:
    """Return the uncertainty that decides the digits: the SE, else a quarter of the interval."""
    if isinstance(number.se, int | float) and 0 < number.se < math.inf:
        return float(number.se)
    if isinstance(number.ci_low, int | float) and isinstance(number.ci_high, int | float):
        width = float(number.ci_high - number.ci_low)
        return width / 4 if 0 < width < math.inf else None
    return None


def places_of(number: Number) -> int | None:
    """Return the decimals that suit a number in its shown unit, None where it has no uncertainty."""
    spread = _spread(as_shown(number))
    return None if spread is None else decimals_for(spread)


def _places_of_size(size: float) -> int:
    """Return the decimals that give a number of this size three significant digits."""
    return max(0, 2 - math.floor(math.log10(size))) if 0 < size < math.inf else 0


def common_places(numbers: Iterable[Number | None], default: int = 2) -> int:
    """Return one number of decimals for a column: that of its median uncertainty."""
    places = [place for number in numbers if number is not None and (place := places_of(number)) is not None]
    return median_low(places) if places else default


def value_text(value: Value | None, places: int | None = None) -> str:
    """Write a bare value; `Undefined` reads "undefined: reason", None is a dash."""
    if value is None:
        return DASH
    if isinstance(value, Undefined):
        return f"undefined: {value.reason}"
    return general_text(value, 3) if places is None else decimal_text(value, places)


def with_unit(text: str, unit: str) -> str:
    """Put the unit after a number's text; the unit "1" is not written."""
    return text if unit in ("", "1") else f"{text}{NO_BREAK}{unit}"


def interval_text(number: Number, places: int | None = None, *, unit: bool = True) -> str:
    """Write the confidence interval as "8.1 to 21.9 %"; empty where the number has none."""
    shown = as_shown(number)
    if shown.ci_low is None or shown.ci_high is None:
        return ""
    for end in (shown.ci_low, shown.ci_high):
        if isinstance(end, Undefined):
            return f"undefined: {end.reason}"
    places = places_of(number) if places is None else places
    if places is None:
        places = _places_of_size(max(abs(end) for end in (shown.ci_low, shown.ci_high) if isinstance(end, int | float)))
    text = f"{value_text(shown.ci_low, places)} to {value_text(shown.ci_high, places)}"
    return with_unit(text, shown.unit) if unit else text


def level_text(number: Number) -> str:
    """Write the confidence level as "95 % CI"."""
    return f"{level_in_percent(number.ci_level).replace(' ', NO_BREAK)} CI"


def number_text(number: Number) -> str:
    """Write a number in full: "16.31 ± 0.42 J (SE; 95 % CI 15.36 to 17.26 J; n = 10)"."""
    shown, places = as_shown(number), places_of(number)
    if isinstance(shown.value, Undefined):
        return value_text(shown.value)
    text, remarks = value_text(shown.value, places), []
    if isinstance(shown.se, int | float):
        text += f"{NO_BREAK}±{NO_BREAK}{value_text(shown.se, places)}"
        remarks.append("SE")
    if isinstance(shown.shared_se, int | float) and shown.shared_se > 0:
        remarks.append(f"shared by all runs ±{NO_BREAK}{with_unit(value_text(shown.shared_se, places), shown.unit)}")
    if interval := interval_text(number):
        remarks.append(f"{level_text(number)} {interval}")
    if number.n is not None:
        remarks.append(f"n{EQUALS}{number.n}")
    text = with_unit(text, shown.unit)
    return f"{text} ({'; '.join(remarks)})" if remarks else text


def p_text(p: Value, *, name: bool = True) -> str:
    """Write a p-value: "p = .023", "p < .001"; `name=False` leaves "p = " out, for a table's column.

    No p is rounded onto a usual level or past it: .0503 keeps four digits.
    """
    lead = f"p{NO_BREAK}" if name else ""
    if isinstance(p, Undefined):
        return f"{lead}undefined: {p.reason}"
    if p < 0.001:
        return f"{lead}<{NO_BREAK}.001"
    if p > 0.999:
        return f"{lead}>{NO_BREAK}.999"
    digits = on_its_side(p, (f"{p:.{places}f}" for places in range(3, 18))).removeprefix("0")
    return f"p{EQUALS}{digits}" if name else digits


def degrees_text(df: tuple[Value, ...]) -> str:
    """Write degrees of freedom with one decimal, and none where it would be 0: 64 and 63.99998 are both "64"."""
    return f",{NO_BREAK}".join(
        value_text(entry) if isinstance(entry, Undefined) else decimal_text(entry, 1).removesuffix(".0") for entry in df
    )


def significance_text(test: SignificanceTest, *, name: bool = True) -> str:
    """Write a test: "Welch t(18.2) = −3.41, p = .003"; one that does not exist gives its reason once.

    The letter follows from the degrees of freedom: t has one, F two. `name=False` leaves the test's name out.
    """
    letter = "t" if len(test.df) == 1 else "F"
    called = test.name.removesuffix(letter).strip() if name else ""
    title = NO_BREAK.join([*called.split(), letter])
    if isinstance(test.statistic, Undefined):
        return f"{title} {value_text(test.statistic)}"
    return f"{title}({degrees_text(test.df)}){EQUALS}{decimal_text(test.statistic, 2)}, {p_text(test.p)}"
