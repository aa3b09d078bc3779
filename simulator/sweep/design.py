"""Which scenes a sweep holds: every combination of the values of some axes, or a Sobol sample of their ranges."""

from __future__ import annotations

import hashlib
import itertools
import math
import warnings
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError
from simulator.sweep.axis import Axis, Quantity, Row, axis

Places = NDArray[np.int64]
MOST_ROWS = 10**8
"""Most scenes in one sweep; its file would take 34 GB."""
SAMPLE = "sample"
"""Name of the dimension of a Sobol sample."""


class Design(Protocol):
    """Scenes in a fixed order; each is a row of values, one an axis."""

    @property
    def axes(self) -> tuple[Axis, ...]:
        """What is swept."""
        ...

    @property
    def dims(self) -> dict[str, int]:
        """Dimensions of the result and their lengths; their product is the number of rows."""
        ...

    @property
    def description(self) -> str:
        """How the rows were chosen, in words."""
        ...

    def dim_of(self, swept: Axis) -> str:
        """Return the dimension along which an axis varies."""
        ...

    def rows(self, start: int, stop: int) -> Row:
        """Return the parameters of the rows from `start` to before `stop`, shape (rows, axes)."""
        ...

    def combinations(self, parameters: Collection[str]) -> Iterator[dict[str, float]]:
        """Yield every combination of these swept parameters that the rows hold."""
        ...

    def combination_count(self, parameters: Collection[str]) -> int:
        """Return how many combinations of these parameters there are."""
        ...

    def combination_places(self, parameters: Collection[str], start: int, stop: int) -> Places:
        """Return which of the combinations of these parameters each row has, shape (rows,)."""
        ...


def row_count(design: Design) -> int:
    """Return the number of scenes."""
    return math.prod(design.dims.values())


def content_hash(design: Design) -> str:
    """Return a hash of every value that is swept."""
    digest = hashlib.sha256()
    for swept in design.axes:
        digest.update(swept.parameter.encode() + b"\0" + swept.values.astype("<f8").tobytes())
    return digest.hexdigest()


@dataclass(frozen=True, slots=True)
class Grid:
    """Every combination of the axes' values; the last axis varies fastest."""

    axes: tuple[Axis, ...]

    @property
    def dims(self) -> dict[str, int]:
        """One dimension an axis."""
        return {swept.name: len(swept.values) for swept in self.axes}

    @property
    def description(self) -> str:
        """A grid is described by its axes."""
        return "grid"

    def dim_of(self, swept: Axis) -> str:
        """Each axis is a dimension of its own."""
        return swept.name

    def rows(self, start: int, stop: int) -> Row:
        """Return the parameters of some rows, shape (rows, axes)."""
        places = np.unravel_index(np.arange(start, stop), tuple(self.dims.values()))
        return np.column_stack([swept.values[place] for swept, place in zip(self.axes, places, strict=True)])

    def combinations(self, parameters: Collection[str]) -> Iterator[dict[str, float]]:
        """Yield the product of the values of these axes alone."""
        chosen = [swept for swept in self.axes if swept.parameter in parameters]
        names = [swept.parameter for swept in chosen]
        for point in itertools.product(*(swept.values.tolist() for swept in chosen)):
            yield dict(zip(names, point, strict=True))

    def combination_count(self, parameters: Collection[str]) -> int:
        """Return the product of these axes' lengths."""
        return math.prod(len(swept.values) for swept in self.axes if swept.parameter in parameters)

    def combination_places(self, parameters: Collection[str], start: int, stop: int) -> Places:
        """Number the product of these axes as `combinations` yields it."""
        places = np.unravel_index(np.arange(start, stop), tuple(self.dims.values()))
        found = np.zeros(stop - start, np.int64)
        for swept, place in zip(self.axes, places, strict=True):
            if swept.parameter in parameters:
                found = found * len(swept.values) + place
        return found


@dataclass(frozen=True, slots=True)
class Sample:
    """Rows that each have values of their own: all axes are as long as the sample."""

    axes: tuple[Axis, ...]
    seed: int

    @property
    def dims(self) -> dict[str, int]:
        """The one dimension of all axes."""
        return {SAMPLE: len(self.axes[0].values)}

    @property
    def description(self) -> str:
        """Name the sequence and its seed."""
        return f"Sobol sample, scrambled with seed {self.seed}"

    def dim_of(self, swept: Axis) -> str:  # noqa: ARG002
        """All axes share one dimension."""
        return SAMPLE

    def rows(self, start: int, stop: int) -> Row:
        """Return the parameters of some rows, shape (rows, axes)."""
        return np.column_stack([swept.values[start:stop] for swept in self.axes])

    def combinations(self, parameters: Collection[str]) -> Iterator[dict[str, float]]:
        """Yield the rows' values of these axes."""
        chosen = [swept for swept in self.axes if swept.parameter in parameters]
        names = [swept.parameter for swept in chosen]
        for start in range(0, len(self.axes[0].values), 4096):
            for point in zip(*(swept.values[start : start + 4096].tolist() for swept in chosen), strict=True):
                yield dict(zip(names, point, strict=True))

    def combination_count(self, parameters: Collection[str]) -> int:  # noqa: ARG002
        """Every row has values of its own."""
        return len(self.axes[0].values)

    def combination_places(self, parameters: Collection[str], start: int, stop: int) -> Places:  # noqa: ARG002
        """Every row is its own combination."""
        return np.arange(start, stop)


@dataclass(frozen=True, slots=True)
class Range:
    """A quantity to be sampled between two values, evenly or evenly in its logarithm."""

    quantity: Quantity
    low: float
    high: float
    logarithmic: bool = False


def grid(axes: Sequence[Axis]) -> Grid:
    """Return the grid of these axes; raises `UsageError` where nothing, too much or one parameter twice is swept."""
    _check_parameters([swept.quantity for swept in axes])
    made = Grid(tuple(axes))
    _check_rows(row_count(made))
    return made


def sobol(ranges: Sequence[Range], rows: int, seed: int) -> Sample:
    """Return a scrambled Sobol sample (Owen 1998, as scipy has it) of these ranges; the balance is best for 2^m rows.

    Raises `UsageError` where nothing, too much or one parameter twice is swept.
    """
    from scipy.stats import qmc

    _check_parameters([swept.quantity for swept in ranges])
    _check_rows(rows)
    if seed < 0:
        raise UsageError(f"seed = {seed} is negative: give 0 or more.")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # that 2^m rows balance best is said above
        unit = qmc.Sobol(len(ranges), scramble=True, seed=np.random.default_rng(seed)).random(rows)
    return Sample(tuple(axis(swept.quantity, _scaled(swept, unit[:, i])) for i, swept in enumerate(ranges)), seed)


def _scaled(swept: Range, share: Row) -> Row:
    if not swept.logarithmic:
        return np.asarray(np.clip(swept.low + (swept.high - swept.low) * share, swept.low, swept.high))
    scaled = np.exp(np.log(swept.low) + (np.log(swept.high) - np.log(swept.low)) * share)
    return np.asarray(np.clip(scaled, swept.low, swept.high))  # rounding may step over an end


def _check_parameters(swept: Sequence[Quantity]) -> None:
    if not swept:
        raise UsageError("a sweep needs something to sweep: give for example --over b_ad=0:300:31.")
    names = [item.parameter for item in swept]
    for item in swept:
        if names.count(item.parameter) > 1:
            others = list(dict.fromkeys(other.name for other in swept if other.parameter == item.parameter))
            twice = (
                f"{' and '.join(others)} both sweep {item.parameter}"
                if len(others) > 1
                else f"{others[0]} is swept twice"
            )
            raise UsageError(f"{twice}: sweep it by one --over.")


def _check_rows(rows: int) -> None:
    if not 1 <= rows <= MOST_ROWS:
        raise UsageError(f"a sweep of {rows} scenes cannot be made: sweep 1 to {MOST_ROWS} of them.")
