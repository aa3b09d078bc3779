"""Rows of a text, and the cells in quotes in them, are those that Python's csv module reads."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

from hypothesis import example, given
from hypothesis import strategies as st

from ingest.model import FindingCollector
from ingest.tables.sheet import text_rows
from ingest.text import open_text

Rows = list[tuple[int, list[str]]]
DELIMITERS = st.sampled_from([",", ";", "\t", "|"])
CELLS = st.text('ab", ;\t|\n', max_size=8)
BLANKS = " \t\r\n"


def rows_of(written: str, delimiter: str) -> list[tuple[int, object]]:
    source = open_text(written.encode(), "cp1252", FindingCollector())
    return list(text_rows(source, delimiter.encode()))


def by_csv(written: str, delimiter: str) -> Rows | None:
    """The rows that have any cell, with their first line; None where a quote is out of place."""
    reader = csv.reader(io.StringIO(written, newline=""), delimiter=delimiter, strict=True, skipinitialspace=True)
    rows: Rows = []
    line = 1
    try:
        for cells in reader:
            stripped = [cell.replace("\r\n", "\n").replace("\r", "\n").strip(BLANKS) for cell in cells]
            if any(stripped):
                rows.append((line, stripped))
            line = reader.line_num + 1
    except csv.Error:
        return None
    return rows


@given(st.lists(st.lists(CELLS, min_size=1, max_size=4), max_size=6), DELIMITERS, st.booleans(), st.booleans())
def test_what_is_written_is_read(table: Sequence[Sequence[str]], delimiter: str, quoted: bool, dos: bool) -> None:
    target = io.StringIO()
    end, quoting = "\r\n" if dos else "\n", csv.QUOTE_ALL if quoted else csv.QUOTE_MINIMAL
    csv.writer(target, delimiter=delimiter, lineterminator=end, quoting=quoting).writerows(table)
    written = target.getvalue()
    assert [cells for _, cells in rows_of(written, delimiter)] == [
        stripped for cells in table if any(stripped := [cell.strip(BLANKS) for cell in cells])
    ]
    assert rows_of(written, delimiter) == by_csv(written, delimiter)


@given(st.text('ab"", ;\t|\n\n', max_size=40), DELIMITERS)
@example('a,\t"two\nlines,b"\n', ",")
@example('a\t "two\nlines"\tb\n', "\t")
def test_what_is_in_place_is_read_as_by_csv(written: str, delimiter: str) -> None:
    known = by_csv(written, delimiter)
    if known is not None:
        assert rows_of(written, delimiter) == known
