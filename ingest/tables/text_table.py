"""The table in a delimited text."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from ingest.findings import FindingCollector
from ingest.model import Declarations
from ingest.tables.layout import check_above, find_layout
from ingest.tables.rows import read_rows
from ingest.tables.table import Block, Table, Wanted, read_preamble
from ingest.text.source import TextSource, refuse_long_line


def text_table(source: TextSource, declared: Declarations, findings: FindingCollector) -> Table | None:
    """Find the table in a text, its rows not read yet; None, with a finding of severity file, where there is none.

    Raises `SecondHeader` where another table stands above it, as its rows do where one follows.
    """
    if source.first_line > 1:  # the lines declared are those of the first table in the text
        declared = dataclasses.replace(declared, header_row=None, units_row=None, first_row=None)
    if refuse_long_line(source, findings):
        return None
    layout = find_layout(source, declared, findings)
    if layout is None:
        return None
    check_above(source, layout)

    def rows(wanted: Sequence[Wanted]) -> Block:
        return read_rows(source, layout, wanted, findings)

    preamble = read_preamble((*source.comments, *layout.preamble), declared.date_format)
    return Table(layout.names, layout.units, layout.kinds, preamble, rows, text=layout.shape)
