"""Blocks are rectangles and one piece each, and together the array."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from simulator.sweep.result_file import BLOCK, block_shape, blocks


@given(shape=st.lists(st.integers(1, 400), min_size=1, max_size=4).filter(lambda shape: math.prod(shape) < 2_000_000))
def test_blocks_make_up_the_array_in_its_order(shape: list[int]) -> None:
    whole = np.arange(math.prod(shape)).reshape(shape)
    end = 0
    for slices, first, after in blocks(shape):
        assert first == end
        end = after
        assert after - first <= BLOCK
        block = whole[slices].ravel()
        assert block[0] == first
        assert block[-1] == after - 1
        assert len(block) == after - first
    assert end == whole.size
    assert math.prod(block_shape(shape)) <= BLOCK


def test_a_long_axis_is_divided() -> None:
    assert block_shape((10_000_000, 2)) == (BLOCK // 2, 2)
    assert block_shape((5, 100_000)) == (1, BLOCK)
    assert block_shape((31, 3)) == (31, 3)
