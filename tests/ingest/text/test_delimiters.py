"""The delimiter of a table: none is passed over that looking at all of the sample would choose."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.text import cells
from ingest.text.source import Line

CELLS = st.sampled_from([b"1", b"-2.5", b"3,5", b"name", b"", b"nan", b"12:30", b"2021-06-01 10:00:00", b"a 1"])
DELIMITERS = st.sampled_from([b",", b";", b"\t", b" ", b"|"])
LINES = st.tuples(DELIMITERS, st.lists(CELLS, min_size=1, max_size=4)).map(lambda row: row[0].join(row[1]))


def lines(contents: list[bytes]) -> list[Line]:
    return [Line(number, number, content, True) for number, content in enumerate(contents, start=1)]


@given(st.lists(LINES, max_size=90), st.lists(LINES, max_size=40), DELIMITERS, st.integers(0, 70))
def test_a_delimiter_that_is_ruled_out_early_would_not_have_been_chosen(
    head: list[bytes], further: list[bytes], usual: bytes, rows: int
) -> None:
    table = [usual.join([b"1.5", b"2", b"3"])] * rows
    first, deeper = lines([*head, *table]), lines([*table[:20], *further])
    found = cells.best_split(first, deeper)
    whole = cells._split
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(cells, "_split", lambda head, further, delimiter, _least=0.0: whole(head, further, delimiter))
        assert cells.best_split(first, deeper) == found
