"""An array divided into blocks that are rectangles and, at the same time, in one piece in its row-major order."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

BLOCK = 65_536
"""Most numbers in a block."""


def block_shape(shape: Sequence[int]) -> tuple[int, ...]:
    """Return the shape of the blocks: whole in the last dimensions, a part of one, 1 in those before."""
    for place in range(len(shape)):
        rest = math.prod(shape[place + 1 :])
        if rest <= BLOCK:
            return (*[1] * place, min(shape[place], BLOCK // rest), *shape[place + 1 :])
    return ()


def blocks(shape: Sequence[int]) -> Iterator[tuple[tuple[slice, ...], int, int]]:
    """Yield each block as slices, and as its first number and the one after its last in row-major order."""
    each = block_shape(shape)
    starts = [range(0, length, step) for length, step in zip(shape, each, strict=True)]
    first = 0
    for corner in itertools.product(*starts):
        slices = tuple(
            slice(begin, min(begin + step, length)) for begin, step, length in zip(corner, each, shape, strict=True)
        )
        after = first + math.prod(part.stop - part.start for part in slices)
        yield slices, first, after
        first = after
