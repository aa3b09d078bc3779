"""Which scenes a sweep holds: every combination of the values of some axes, or a Sobol sample of their ranges."""

from __future__ import annotations

import hashlib
import math
import warnings
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError
from simulator.sweep.axes import MOST_ROWS, Axis, Quantity, Range, Row, axis

SAMPLE = "sample"
"""Name of the dimension of a Sobol sample."""


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
        places = self._places(start, stop)
        return np.column_stack([swept.values[place] for swept, place in zip(self.axes, places, strict=True)])

    def part(self, parameters: Collection[str]) -> Design:
        """Return the design of these parameters' axes alone: each combination of their values is one of its rows."""
        return Design(tuple(swept for swept in self.axes if swept.parameter in parameters), self.seed)

    def rows_in_part(self, parameters: Collection[str], start: int, stop: int) -> NDArray[np.int64]:
        """Return which row of `part(parameters)` each of the rows from `start` to before `stop` has, shape (rows,)."""
        places = self._places(start, stop)
        if self.seed is not None:
            return places[0]
        chosen = [place for swept, place in zip(self.axes, places, strict=True) if swept.parameter in parameters]
        return np.ravel_multi_index(tuple(chosen), tuple(self.part(parameters).dims.values()))

    def _places(self, start: int, stop: int) -> Sequence[NDArray[np.int64]]:
        """Return, for each axis, the place of its value in each row."""
        numbers = np.arange(start, stop)
        if self.seed is not None:
            return [numbers] * len(self.axes)
        return np.unravel_index(numbers, tuple(self.dims.values()))

    def content_hash(self) -> str:
        """Return a hash of every value that is swept."""
        digest = hashlib.sha256()
        for swept in self.axes:
            digest.update(swept.parameter.encode() + b"\0" + swept.values.astype("<f8").tobytes())
        return digest.hexdigest()


def grid(axes: Sequence[Axis]) -> Design:
    """Return the grid of these axes; raises `UsageError` where nothing, too much or one parameter twice is swept."""
    _check_parameters([swept.quantity for swept in axes])
    made = Design(tuple(axes))
    _check_rows(made.row_count)
    return made


def sobol(ranges: Sequence[Range], rows: int, seed: int) -> Design:
    """Return a scrambled Sobol sample (Owen 1998, as scipy has it) of these ranges; the balance is best for 2^m rows.

    Raises `UsageError` where nothing, too much or one parameter twice is swept.
    """
    from scipy.stats import qmc

    _check_parameters([swept.quantity for swept in ranges])
    _check_rows(rows)
    if seed < 0:
        raise UsageError(f"seed = {seed} is negative: give 0 or more.")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the help of --sobol says that 2^m rows balance best
        unit = qmc.Sobol(len(ranges), scramble=True, seed=np.random.default_rng(seed)).random(rows)
    return Design(tuple(axis(swept.quantity, _scaled(swept, unit[:, i])) for i, swept in enumerate(ranges)), seed)


def _scaled(swept: Range, share: Row) -> Row:
    if not swept.logarithmic:
        return np.asarray(np.clip(swept.low + (swept.high - swept.low) * share, swept.low, swept.high))
    scaled = np.exp(np.log(swept.low) + (np.log(swept.high) - np.log(swept.low)) * share)
    return np.asarray(np.clip(scaled, swept.low, swept.high))  # rounding may step over an end


def _check_parameters(swept: Sequence[Quantity]) -> None:
    if not swept:
        raise UsageError("a sweep needs something to sweep: give for example --over b_ad=0:300:31.")
    by_parameter: dict[str, list[str]] = {}
    for item in swept:
        by_parameter.setdefault(item.parameter, []).append(item.name)
    for parameter, names in by_parameter.items():
        if len(names) > 1:
            both = " and ".join(dict.fromkeys(names))
            twice = f"{both} both sweep {parameter}" if both != names[0] else f"{both} is swept twice"
            raise UsageError(f"{twice}: sweep it by one --over.")


def _check_rows(rows: int) -> None:
    if not 1 <= rows <= MOST_ROWS:
        raise UsageError(f"a sweep of {rows} scenes cannot be made: sweep 1 to {MOST_ROWS} of them.")
