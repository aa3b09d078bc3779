"""Numbers and words as people read them: digits by the uncertainty, units, intervals, p-values, counts, lists.

Display only. Also a run's log as its figure draws it.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import median_low
from typing import Any

import numpy as np
from numpy.typing import NDArray

from data_schema.rounding import (
    SIGNIFICANT,
    decimals_for,
    decimals_of_end,
    df_text,
    error_of,
    fixed_text,
    known_error,
    statistic_text,
)
from data_schema.rounding import given_text as plain_given_text
from data_schema.rounding import level_text as level_in_percent
from data_schema.rounding import number_text as plain_number_text
from data_schema.rounding import p_text as plain_p_text
from data_schema.vocabulary import Undefined
from reports.numbers import Number, SignificanceTest, Value

MINUS = "\u2212"
NO_BREAK = "\u00a0"
DASH = "\u2013"
EQUALS = f"{NO_BREAK}={NO_BREAK}"

SAVINGS = "savings"
"""What the page calls the part of the control's value that a treatment saves."""
BESIDE = ("quantity", "measured", "simulated", "published")
"""Heads of a study's table of what was measured beside what the simulator gives and what the thesis says."""

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

    parts = {name: getattr(number, name) for name in ("value", "se", "shared_se", "ci_low", "ci_high")}
    scaled: dict[str, Any] = {name: part * factor for name, part in parts.items() if isinstance(part, int | float)}
    return dataclasses.replace(number, unit=unit, **scaled)


def unit_slug(unit: str) -> str:
    """Write a unit so that it can end a field's name: "kg/s" -> "kg_s"."""
    return {"%": "percent"}.get(unit) or re.sub(r"[^a-z0-9]+", "_", unit.lower()).strip("_")


SUPERSCRIPTS = dict(
    zip("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079", strict=True)
)
"""What an exponent is written with."""
_POWER = re.compile(r"(\d)e([+-]?\d+)")
_MINUS = re.compile(r"(?<![\w.)+-])-(?=\.?\d)")


def true_minus(text: str) -> str:
    """Set the true minus signs of a sentence or cell; hyphens of dates and names stay."""
    return _MINUS.sub(MINUS, text)


def typeset(text: str) -> str:
    """Set a number's text as a page has it: true minus signs, no line breaks, powers of ten."""
    if "e" in text:
        text = _POWER.sub(lambda found: f"{found[1]} × 10{_raised(int(found[2]))}", text)
    return text.replace("-", MINUS).replace("inf", "\u221e").replace(" ", NO_BREAK)


def _raised(exponent: int) -> str:
    return "".join(SUPERSCRIPTS[each] for each in str(exponent))


def decimal_text(value: float, places: int) -> str:
    """Write a number with so many decimals and a true minus sign; "-0.00" becomes "0.00"."""
    return typeset(fixed_text(value, places))


def general_text(value: float, digits: int = SIGNIFICANT) -> str:
    """Write a number with so many significant digits, without exponent where it is of ordinary size."""
    return typeset(plain_number_text(value, digits))


def given_text(value: float) -> str:
    """Write a number as a person gave it."""
    return typeset(plain_given_text(value))


def _spread(number: Number) -> float | None:
    """Return the error that decides the digits: the standard error, else that of the interval; None for neither."""
    errors = [float(number.se)] if isinstance(number.se, int | float) else []
    errors += [error_of(number.interval)] if number.interval is not None else []
    return next(filter(known_error, errors), None)


def places_of(number: Number) -> int | None:
    """Return the decimals that suit a number in its shown unit, None where it has no uncertainty."""
    spread = _spread(as_shown(number))
    return None if spread is None else decimals_for(spread)


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
    return general_text(value) if places is None else decimal_text(value, places)


def with_unit(text: str, unit: str) -> str:
    """Put the unit after a number's text; the unit "1" is not written."""
    return text if unit in ("", "1") else f"{text}{NO_BREAK}{unit}"


def interval_text(number: Number, places: int | None = None, *, unit: bool = True) -> str:
    """Write the confidence interval as "8.1 to 21.9 %"; empty where the number has none."""
    shown = as_shown(number)
    if shown.interval is None:
        return "" if shown.ci_low is None else value_text(shown.ci_low)
    places = places_of(number) if places is None else places
    ends = (value_text(end, None if places is None else decimals_of_end(end, places)) for end in shown.interval)
    text = " to ".join(ends)
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
    """Write a p-value: "p = .023", "p < .001"; `name=False` leaves "p = " out, for a table's column."""
    if isinstance(p, Undefined):
        return f"{f'p{NO_BREAK}' if name else ''}undefined: {p.reason}"
    return typeset(plain_p_text(p, name=name))


def degrees_text(df: tuple[Value, ...]) -> str:
    """Write degrees of freedom with one decimal, and none where it would be 0: 64 and 63.99998 are both "64"."""
    return f",{NO_BREAK}".join(value_text(entry) if isinstance(entry, Undefined) else df_text(entry) for entry in df)


def significance_text(test: SignificanceTest, *, name: bool = True) -> str:
    """Write a test: "Welch t(18.2) = −3.41, p = .003"; one that does not exist gives its reason once.

    The letter follows from the degrees of freedom: t has one, F two. `name=False` leaves the test's name out.
    """
    letter = "t" if len(test.df) == 1 else "F"
    called = test.name.removesuffix(letter).strip() if name else ""
    title = f"{NO_BREAK.join(called.split())} " if called else ""  # a narrow screen breaks the line before the letter
    if isinstance(test.statistic, Undefined):
        return f"{title}{letter} {value_text(test.statistic)}"
    one_sided = "one-sided " if test.one_sided else ""
    return f"{title}{typeset(statistic_text(letter, test.statistic, test.df))}, {one_sided}{p_text(test.p)}"


def count_text(count: int, noun: str, plural: str = "") -> str:
    """Write a count with its noun: "1 run", "12 runs"."""
    return f"{count}{NO_BREAK}{noun if count == 1 else plural or noun + 's'}"


def sentence_start(text: str) -> str:
    """Write the first letter as a capital and leave the others as they are, and a symbol ("d = 186 kg/s") too."""
    symbol = text[1:].lstrip(f" {NO_BREAK}").startswith("=")
    return text if symbol else text[:1].upper() + text[1:]


def in_sentence(title: str) -> str:
    """Return a title as it stands within a sentence: "Foot size" as "foot size", but "PWM duty" and "K" as they are."""
    first = title.split(" ", 1)[0]
    return title if len(first) < 2 or first[1:] != first[1:].lower() else f"{title[:1].lower()}{title[1:]}"


def list_text(words: Sequence[str]) -> str:
    """Join words as a sentence does: "a, b and c"."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} and {words[-1]}"


_UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"))


def plain_number(value: float) -> str:
    """Return a number as text, powers of ten in their shortest form."""
    mantissa, exponent = f"{value:e}".split("e")
    short = f"{float(mantissa):g}e{int(exponent)}"
    return short if len(short) <= len(f"{value:g}") else f"{value:g}"


def time_text(seconds: float) -> str:
    """Return a time with the unit that suits it, to three digits."""
    if seconds >= 100.0:
        return f"{seconds:.0f} s"
    size, unit = next(((size, unit) for size, unit in _UNITS if seconds >= 0.9995 * size), _UNITS[-1])
    return f"{seconds / size:.3g} {unit}"


@dataclass(frozen=True, slots=True)
class LogJump:
    """One detected jump; times in s from the log's start, None where an event was not found.

    `excluded` is the reason why the jump is not used, "" where it is: a rule of the protocol or a person's verdict.
    `at_s` is where a jump without an apex stands, such as a misfire, and `apex_height_m` is None then.
    """

    number: int
    at_s: float
    apex_height_m: float | None
    touchdown_s: float | None = None
    lift_off_s: float | None = None
    excluded: str = ""
    misfire: bool = False


@dataclass(frozen=True, slots=True)
class LogGap:
    """A stretch without samples: dropped packets, a pause of the logger, or a restart between two logs.

    Where `length_known` is false nobody knows how long it was: its times begin again there.
    """

    start_s: float
    end_s: float
    kind: str
    length_known: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class RunLog:
    """A run's log: `time_s` and `body_height_m` are arrays of shape (n_samples,), the jumps in order of time.

    `leg_length_m` has the same shape, NaN where it was not recorded; None where it nowhere was. `panel_jump` is the
    number of the jump shown enlarged; None takes the first that is used.
    """

    run: str
    title: str
    time_s: NDArray[np.float64]
    body_height_m: NDArray[np.float64]
    jumps: tuple[LogJump, ...] = ()
    gaps: tuple[LogGap, ...] = ()
    panel_jump: int | None = None
    leg_length_m: NDArray[np.float64] | None = None
