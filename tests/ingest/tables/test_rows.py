"""The fast and the slow route give identical values; one bad line costs one line."""

from __future__ import annotations

import threading

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.model import Declarations, SignalPart
from ingest.read import read_file
from ingest.tables.rows import PIECE_BYTES, _take_back
from tests.ingest.reading import only_part, read
from tests.ingest.synthetic import LOG_HEADER, robot_rows, text

ORDINARY = st.floats(-1e17, 1e17).filter(lambda x: x == 0 or abs(x) > 1e-29)  # smaller ones are misframed rows
NUMBERS = st.one_of(
    ORDINARY.map(repr),
    st.integers(-(10**15), 10**15).map(str),
    st.floats(-1e6, 1e6).map(lambda x: f"{x:.6f}"),
    ORDINARY.map(lambda x: f"{x:+.3e}"),
    st.sampled_from(["", "nan", "-nan", "NaN", ".5", "5.", "+7", "-0.0", " 3 ", "0.1", "1e-5", "nan(ind)"]),
)
DECIMAL_SIGNS = st.sampled_from([(",", "."), (";", "."), (";", ","), ("\t", ","), ("\t", ".")])


def same(first: SignalPart, second: SignalPart) -> bool:
    pairs = zip(first.channels, second.channels, strict=True)
    return np.array_equal(first.time_s, second.time_s) and all(
        # Bit for bit, the sign of a zero included, but for the payload of NaN.
        np.array_equal(one.values, other.values, equal_nan=True)
        and np.array_equal(
            np.signbit(one.values), np.signbit(other.values) | np.isnan(one.values) & np.signbit(one.values)
        )
        for one, other in pairs
    )


@given(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=5, max_size=40), DECIMAL_SIGNS)
def test_fast_and_slow_route_give_identical_values(cells: list[tuple[str, str]], signs: tuple[str, str]) -> None:
    delimiter, decimal = signs
    rows = ["0.5,0.25", "1.5,0.75"] * 20 + [",".join(pair) for pair in cells]
    lines = [f"{number}.0,{row}" for number, row in enumerate(rows)]
    lines = [line.replace(",", "\0").replace(".", decimal).replace("\0", delimiter) for line in lines]
    header = "time [ms],a,b".replace(",", delimiter)
    clean = text(header, lines)
    # A comment keeps the whole file from being proved clean: it is read line by line.
    slow = text(header, [*lines[:3], "# remark", *lines[3:]])
    assert same(only_part(read(clean)), only_part(read(slow)))


def test_a_file_of_many_pieces_loses_only_its_bad_line() -> None:
    rows = robot_rows(20_000)
    whole = text(LOG_HEADER, rows)
    assert len(whole) > 2 * PIECE_BYTES
    rows[15_000] = rows[15_000].replace(",400", ",ERROR")
    result = read_file(text(LOG_HEADER, rows), Declarations())
    assert (result.rows_kept, result.rows_rejected) == (19_999, 1)
    (finding,) = [finding for finding in result.findings if finding.severity == "row"]
    assert finding.line == 15_002
    (part,), clean = result.parts, only_part(read(whole))
    for channel, original in zip(part.channels, clean.channels, strict=True):
        assert np.array_equal(channel.values, np.delete(original.values, 15_000))
    assert [gap.kind for gap in part.gaps] == ["rejected"]


def test_a_quoted_cell_across_the_edge_of_a_piece_is_one_cell() -> None:
    rows = [f'{row},"left\nrail"' for row in robot_rows(20_000)]
    result = read_file(text(LOG_HEADER + ",note", rows), Declarations())
    assert (result.rows_kept, result.rows_rejected) == (20_000, 0)


def test_integers_beyond_2_to_53_keep_their_last_digit() -> None:
    first = 133_500_000_000_000_001
    rows = [f"{first + 33_333 * number},{number}" for number in range(200)]
    for data in (text("stamp [filetime],a", rows), text("stamp [filetime],a", [*rows[:9], "# x", *rows[9:]])):
        declared = Declarations(time_column="stamp")
        (part,) = read_file(data, declared).parts
        assert part.start_original == f"{first} filetime"
        assert np.array_equal(part.time_s, np.arange(200) * 33_333 / 1e7)


def test_bytes_lent_to_other_threads_are_back_before_reading_goes_on() -> None:
    lent = memoryview(bytearray(b"1,2"))
    held = [pa.py_buffer(lent)]
    thread = threading.Timer(0.05, held.clear)
    thread.start()
    _take_back(lent)
    with pytest.raises(ValueError, match="released"):
        lent.tobytes()
    thread.join()
