"""Columns from Arrow and back: the numbers that Arrow's own conversion gives, whatever their type and parts."""

from __future__ import annotations

import math

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.spool import to_arrow, to_numpy

DOUBLES = st.lists(st.none() | st.floats(width=64), max_size=12)
WHOLE = st.lists(st.integers(-(2**63), 2**63 - 1), max_size=12)


@given(st.lists(DOUBLES, max_size=4), st.integers(0, 5), st.integers(0, 30))
def test_doubles_in_parts_with_gaps(parts: list[list[float | None]], start: int, length: int) -> None:
    column = pa.chunked_array([pa.array(part, pa.float64()) for part in parts], pa.float64()).slice(start, length)
    expected = [math.nan if value is None else value for value in column.to_pylist()]
    found = to_numpy(column)
    assert found.dtype == np.float64
    assert found.tobytes() == np.array(expected, np.float64).tobytes()


@given(st.lists(WHOLE, max_size=4), st.integers(0, 5))
def test_whole_numbers_keep_all_digits(parts: list[list[int]], start: int) -> None:
    column = pa.chunked_array([pa.array(part, pa.int64()) for part in parts], pa.int64()).slice(start)
    found = to_numpy(column)
    assert found.dtype == np.int64
    assert found.tolist() == column.to_pylist()


@pytest.mark.parametrize("kind", [pa.int64(), pa.int8(), pa.float32()])
def test_other_numbers_become_doubles(kind: pa.DataType) -> None:
    found = to_numpy(pa.chunked_array([pa.array([1, None, 3], kind)]))
    assert found.dtype == np.float64
    np.testing.assert_array_equal(found, [1.0, math.nan, 3.0])


def test_words_are_no_numbers() -> None:
    with pytest.raises(pa.ArrowException):
        to_numpy(pa.chunked_array([pa.array(["one", "two"])]))


def test_values_go_there_and_back() -> None:
    every_other = np.arange(10.0)[::2]
    for values in (every_other, np.array([]), np.arange(3, dtype=np.float32)):
        assert to_numpy(pa.chunked_array([to_arrow(values)])).tolist() == values.tolist()
