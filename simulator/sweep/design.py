"""Which scenes a sweep holds: every combination of the values of some axes, or a Sobol sample of their ranges.

In words, as after --over: `b_ad=0:300:31`, `foot_radius=0.02,0.03`, `k_sh=1:1e4:5:log`; to sample, `b_ad=0:300`.
"""

from __future__ import annotations

import hashlib
import math
import warnings
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from data_schema.errors import UsageError, unknown_name
from simulator.changes import WORDS
from simulator.compiled import Row
from simulator.declared import all_parameters

SAMPLE = "sample"
"""Name of the dimension of a Sobol sample."""
MOST_ROWS = 10**8
"""Most scenes in one sweep; its file would take 34 GB."""
LOGARITHMIC = "log"
GRID_FORM = "NAME=LOW:HIGH:COUNT (a fourth part, log, spaces the values evenly in the logarithm), or NAME=VALUE,VALUE"
SAMPLE_FORM = "NAME=LOW:HIGH, or NAME=LOW:HIGH:log"


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """What is swept: `coordinates` of a quantity and the `values` of the parameter read; both of shape (values,)."""

    name: str
    unit: str
    meaning: str
    parameter: str
    coordinates: Row
    values: Row


@dataclass(frozen=True, slots=True)
class Design:
    """Scenes in a fixed order; each is a row of values, one an axis.

    A grid holds every combination of the axes' values, and the last axis varies fastest. A sample, which has a `seed`,
    holds rows that each have values of their own: all its axes are as long as it.
    """

    axes: tuple[Axis, ...]
    seed: int | None = None

    @property
    def dims(self) -> dict[str, int]:
        """Dimensions of the result and their lengths: one an axis, or the sample's one."""
        if self.seed is not None:
            return {SAMPLE: len(self.axes[0].values)}
        return {swept.name: len(swept.values) for swept in self.axes}

    @property
    def row_count(self) -> int:
        """The number of scenes."""
        return math.prod(self.dims.values())

    @property
    def description(self) -> str:
        """How the rows were chosen, in words."""
        return "grid" if self.seed is None else f"Sobol sample, scrambled with seed {self.seed}"

    def dim_of(self, swept: Axis) -> str:
        """Return the dimension along which an axis varies."""
        return swept.name if self.seed is None else SAMPLE

    def rows(self, start: int, stop: int) -> Row:
        """Return the parameters of the rows from `start` to before `stop`, shape (rows, axes)."""
        numbers = np.arange(start, stop)
        places = [numbers] * len(self.axes)
        if self.seed is None:
            places = list(np.unravel_index(numbers, tuple(self.dims.values())))
        return np.column_stack([swept.values[place] for swept, place in zip(self.axes, places, strict=True)])

    def content_hash(self) -> str:
        """Return a hash of every value that is swept."""
        digest = hashlib.sha256()
        for swept in self.axes:
            digest.update(swept.parameter.encode() + b"\0" + swept.values.astype("<f8").tobytes())
        return digest.hexdigest()


def grid(words: Sequence[str], effects: Collection[str]) -> Design:
    """Return the grid that words ask for, in a scene with these effects.

    Raises `UsageError` for words without a meaning, and where nothing, too much or one parameter twice is swept.
    """
    axes = []
    for word in words:
        name, values = _parted(word, GRID_FORM)
        axes.append(_axis(name, _spaced(word, values) if ":" in values else _listed(word, values), effects))
    return _checked(Design(tuple(axes)))


def sobol(words: Sequence[str], effects: Collection[str], rows: int, seed: int) -> Design:
    """Return a scrambled Sobol sample (Owen 1998, as scipy has it) of the ranges that words ask for.

    The balance is best for 2^m rows. Raises `UsageError` as `grid` does.
    """
    return at_shares(words, effects, sobol_shares(max(1, len(words)), rows, seed), seed)


def sobol_shares(columns: int, rows: int, seed: int) -> Row:
    """Return a scrambled Sobol sample of the unit cube, shape (rows, columns); raises `UsageError` as `sobol` does."""
    from scipy.stats import qmc

    if not 1 <= rows <= MOST_ROWS:
        raise UsageError(f"a sample of {rows} scenes cannot be made: draw 1 to {MOST_ROWS} of them.")
    if seed < 0:
        raise UsageError(f"seed = {seed} is negative: give 0 or more.")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the help of --sobol says that 2^m rows balance best
        drawn: Row = qmc.Sobol(columns, scramble=True, seed=np.random.default_rng(seed)).random(rows)
    return drawn


def at_shares(words: Sequence[str], effects: Collection[str], shares: Row, seed: int) -> Design:
    """Return the sample at these shares, 0 to 1, of the ranges that words ask for; `shares` has shape (rows, words)."""
    axes = []
    for word, share in zip(words, shares.T, strict=False):
        name, values = _parted(word, SAMPLE_FORM)
        low, high, rest, logarithmic = _ends(word, values, SAMPLE_FORM)
        if rest:
            raise UsageError(f"--over {word} does not say which range to sample: write {SAMPLE_FORM}.")
        known = all_parameters().get(name)
        if known is not None and not known.low <= low < high <= known.high:
            raise UsageError(
                f"--over {word} goes outside what can be simulated: give {name} from {known.low:g} to {known.high:g}"
                f"{known.unit_text}."
            )
        drawn = low + (high - low) * share
        if logarithmic:
            drawn = np.exp(np.log(low) + (np.log(high) - np.log(low)) * share)
        axes.append(_axis(name, np.clip(drawn, low, high), effects))  # rounding may step over an end
    return _checked(Design(tuple(axes), seed))


def _axis(name: str, coordinates: Row, effects: Collection[str]) -> Axis:
    """Return the axis of a parameter or gain, in a scene with these effects."""
    if name not in WORDS:
        known = all_parameters()[name]
        return Axis(name, known.unit, known.meaning, name, coordinates, coordinates)
    word = WORDS[name]
    changes = [word.change(repr(number), frozenset(effects)) for number in coordinates.tolist()]
    values = np.array([one.number for one in changes], np.float64)
    return Axis(name, "1", word.swept, changes[0].subject, coordinates, values)


def _checked(design: Design) -> Design:
    if not design.axes:
        raise UsageError("a sweep needs something to sweep: give for example --over b_ad=0:300:31.")
    by_parameter: dict[str, list[str]] = {}
    for swept in design.axes:
        by_parameter.setdefault(swept.parameter, []).append(swept.name)
    for parameter, names in by_parameter.items():
        if len(names) > 1:
            both = " and ".join(dict.fromkeys(names))
            twice = f"{both} both sweep {parameter}" if both != names[0] else f"{both} is swept twice"
            raise UsageError(f"{twice}: sweep it by one --over.")
    if design.row_count > MOST_ROWS:
        raise UsageError(f"a sweep of {design.row_count} scenes cannot be made: sweep at most {MOST_ROWS} of them.")
    return design


def _parted(word: str, form: str) -> tuple[str, str]:
    name, _, values = (part.strip() for part in word.partition("="))
    if not name or not values:
        raise UsageError(f"--over {word!r} does not name a parameter and its values: write {form}.")
    if name in WORDS and (why := WORDS[name].not_swept):
        raise UsageError(f"{name} {why}")
    if name not in all_parameters() and name not in WORDS:
        raise unknown_name("parameter", name, (*all_parameters(), *(word for word in WORDS if WORDS[word].swept)))
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
