"""What is swept: a quantity, the values it takes, and the parameter that the simulator reads.

In words, as after --over: `b_ad=0:300:31`, `foot_radius=0.02,0.03`, `k_sh=1:1e4:5:log`; to sample, `b_ad=0:300`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError, unknown_name
from simulator.changes import WORDS
from simulator.declared import all_parameters

Row = NDArray[np.float64]
MOST_ROWS = 10**8
"""Most scenes in one sweep; its file would take 34 GB."""
LOGARITHMIC = "log"
GRID_FORM = "NAME=LOW:HIGH:COUNT (a fourth part, log, spaces the values evenly in the logarithm), or NAME=VALUE,VALUE"
SAMPLE_FORM = "NAME=LOW:HIGH, or NAME=LOW:HIGH:log"
GAINS = {
    "gain": "extension gain of the leg's controller",
    "damping_gain": "active-damping gain of the leg's controller",
}
"""Words that stand for one parameter each, in other units: `simulator.changes` has their conversion."""


NOT_SWEPT = {
    "flight": "switches effects and cannot be swept: give it with --set, in a sweep of its own for each of soft, held "
    "and massless.",
    "contact": "switches an effect and cannot be swept: give it with --set, in a sweep of its own for each of "
    "once_risen and at_the_print.",
    "drop_height": "depends on the leg's rest length and cannot be swept: give it with --set, or sweep initial_height, "
    "the foot's height at the start.",
    "jumps": "is a dimension of every result and cannot be swept: give it with --set, and the result holds all jumps "
    "up to that number.",
}
"""Words that stand for no parameter, why that is and what to do instead."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """Something that can be swept; `to_parameter` turns a value of it into one of the parameter read."""

    name: str
    unit: str
    meaning: str
    parameter: str
    to_parameter: Callable[[float], float] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """A quantity with its values, and those of its parameter; both of shape (values,)."""

    quantity: Quantity
    coordinates: Row
    values: Row

    @property
    def name(self) -> str:
        """Name of the quantity."""
        return self.quantity.name

    @property
    def parameter(self) -> str:
        """Name of the parameter that the simulator reads."""
        return self.quantity.parameter


@dataclass(frozen=True, slots=True)
class Range:
    """A quantity to be sampled between two values, evenly or evenly in its logarithm."""

    quantity: Quantity
    low: float
    high: float
    logarithmic: bool = False


def quantity(name: str, effects: Collection[str]) -> Quantity:
    """Return what a word after --over names, in a scene with these effects; raises `UsageError` for other words."""
    known = all_parameters()
    if name in known:
        return Quantity(name, known[name].unit, known[name].meaning, name)
    if name in GAINS:
        on = frozenset(effects)
        (parameter,) = WORDS[name]("1", on).values

        def to_parameter(number: float) -> float:
            return WORDS[name](repr(float(number)), on).values[parameter]

        return Quantity(name, "1", GAINS[name], parameter, to_parameter)
    if name in NOT_SWEPT:
        raise UsageError(f"{name} {NOT_SWEPT[name]}")
    raise unknown_name("parameter", name, (*known, *GAINS))


def axis(swept: Quantity, coordinates: Row) -> Axis:
    """Return the axis of a quantity at these values."""
    coordinates = np.asarray(coordinates, dtype=np.float64)
    if swept.to_parameter is None:
        return Axis(swept, coordinates, coordinates)
    return Axis(swept, coordinates, np.array([swept.to_parameter(number) for number in coordinates.tolist()]))


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
