"""The words after --over: `b_ad=0:300:31`, `foot_radius=0.02,0.03`, `k_sh=1:1e4:5:log`; to sample, `b_ad=0:300`."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from data_schema.errors import UsageError
from simulator.sweep.axis import Axis, Row, axis, quantity
from simulator.sweep.design import MOST_ROWS, Range

LOGARITHMIC = "log"
GRID_FORM = "NAME=LOW:HIGH:COUNT (a fourth part, log, spaces the values evenly in the logarithm), or NAME=VALUE,VALUE"
SAMPLE_FORM = "NAME=LOW:HIGH, or NAME=LOW:HIGH:log"


def axes_of(words: Sequence[str], effects: Collection[str]) -> tuple[Axis, ...]:
    """Return the axes of a grid, for a scene with these effects; raises `UsageError` for words without a meaning."""
    found = []
    for word in words:
        name, values = _parted(word, GRID_FORM)
        found.append(axis(quantity(name, effects), _spaced(word, values) if ":" in values else _listed(word, values)))
    return tuple(found)


def ranges_of(words: Sequence[str], effects: Collection[str]) -> tuple[Range, ...]:
    """Return the ranges to sample, for a scene with these effects; raises `UsageError` for words without a meaning."""
    found = []
    for word in words:
        name, values = _parted(word, SAMPLE_FORM)
        low, high, rest, logarithmic = _ends(word, values, SAMPLE_FORM)
        if rest:
            raise UsageError(f"--over {word} does not say which range to sample: write {SAMPLE_FORM}.")
        found.append(Range(quantity(name, effects), low, high, logarithmic))
    return tuple(found)


def _parted(word: str, form: str) -> tuple[str, str]:
    name, _, values = (part.strip() for part in word.partition("="))
    if not name or not values:
        raise UsageError(f"--over {word!r} does not name a parameter and its values: write {form}.")
    return name, values


def _spaced(word: str, values: str) -> Row:
    low, high, rest, logarithmic = _ends(word, values, GRID_FORM)
    digits = rest[0].lstrip("0") if len(rest) == 1 and rest[0].isdecimal() else ""
    if digits in ("", "1"):
        raise UsageError(f"--over {word} does not say how many values there are, 2 or more: write {GRID_FORM}.")
    if len(digits) > len(str(MOST_ROWS)) or int(digits) > MOST_ROWS:
        raise UsageError(f"--over {word} asks for {digits} values: sweep at most {MOST_ROWS} scenes.")
    count = int(digits)
    return np.geomspace(low, high, count) if logarithmic else np.linspace(low, high, count)


def _listed(word: str, values: str) -> Row:
    numbers = [_number(word, part, GRID_FORM) for part in values.split(",")]
    for number in numbers:
        if numbers.count(number) > 1:
            raise UsageError(f"--over {word} has {number:g} more than once: leave the others out.")
    return np.array(numbers)


def _ends(word: str, values: str, form: str) -> tuple[float, float, list[str], bool]:
    """Return both ends of a range, what stands behind them, and whether it is logarithmic."""
    parts = [part.strip() for part in values.split(":")]
    logarithmic = parts[-1] == LOGARITHMIC
    if logarithmic:
        parts.pop()
    if len(parts) < 2:
        raise UsageError(f"--over {word} is no range: write {form}.")
    low, high = _number(word, parts[0], form), _number(word, parts[1], form)
    if not low < high:
        raise UsageError(f"--over {word} begins at {low:g} and ends at {high:g}: give the smaller end first.")
    if logarithmic and low <= 0.0:
        raise UsageError(f"--over {word} begins at {low:g}, which has no logarithm: begin above 0, or leave out log.")
    return low, high, parts[2:], logarithmic


def _number(word: str, text: str, form: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise UsageError(f"--over {word} has {text.strip()!r} where a finite number belongs: write {form}.")
    return number
