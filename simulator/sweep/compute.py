"""Who computes the chunks of a sweep: threads here, or a cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from simulator.sweep.chunks import Recipe

Block = NDArray[np.float64]
ValuesOf = Callable[[int], Block]
"""Gives the swept values of a chunk, shape (rows, axes)."""
Keep = Callable[[int, Block], None]
"""Takes a chunk that is done, shape (rows, jumps, outputs)."""


class Compute(Protocol):
    """Computes chunks, in any order."""

    def prepare(self, recipe: Recipe) -> float:
        """Make ready, so that compiling is not part of the sweep's time; return the seconds that compiling took."""
        ...

    def run(self, recipe: Recipe, values_of: ValuesOf, numbers: Sequence[int], keep: Keep) -> Iterator[int]:
        """Compute the chunks with these numbers, have each kept, and yield its number when that is done."""
        ...
