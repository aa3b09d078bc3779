"""The table in a delimited text."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

from ingest.channels.declared import declared_columns
from ingest.channels.factors import refuse_two_units
from ingest.findings import FindingCollector
from ingest.model import Declarations
from ingest.tables.cell_units import without_cell_units
from ingest.tables.header_cells import normal_unit
from ingest.tables.layout import Layout, find_layout
from ingest.tables.preamble import read_preamble
from ingest.tables.rows import read_rows
from ingest.tables.second_header import check_above
from ingest.tables.table import Block, Table, Wanted
from ingest.text.comma_pairs import BETWEEN, with_pairs_joined
from ingest.text.source import TextSource, refuse_long_line


def text_table(source: TextSource, declared: Declarations, findings: FindingCollector) -> Table | None:
    """Find the table in a text, its rows not read yet; None, with a finding of severity file, where there is none.

    Raises `SecondHeader` where another table stands above it, as its rows do where one follows.
    """
    if source.first_line > 1:  # the lines declared are those of the first table in the text
        declared = dataclasses.replace(declared, header_row=None, units_row=None, first_row=None)
    if refuse_long_line(source, findings):
        return None
    pairs = with_pairs_joined(source, declared, findings)
    if "decimal_comma_unquoted" in findings:
        return None
    if pairs is not None:
        source, declared = pairs, dataclasses.replace(declared, delimiter=BETWEEN)
    source, cell_units = without_cell_units(source, declared, findings)
    if "cell_units_too_large" in findings:
        return None
    layout = find_layout(source, declared, findings)
    if layout is None:
        return None
    check_above(source, layout)

    def rows(wanted: Sequence[Wanted]) -> Block:
        return read_rows(source, layout, wanted, findings)

    preamble = read_preamble((*source.comments, *layout.preamble))
    units = _units(layout, cell_units, declared, findings)
    shape = layout.shape if pairs is None else dataclasses.replace(layout.shape, delimiter=",")
    return Table(layout.names, units, layout.kinds, preamble, rows, text=shape)


def _units(
    layout: Layout, cell_units: Mapping[int, str], declared: Declarations, findings: FindingCollector
) -> tuple[str | None, ...]:
    """Return the units of the columns, from their cells or the row of units; two different ones refuse the file."""
    said = declared_columns(declared, layout.names) if declared.override_units else {}
    for position, (name, unit) in enumerate(zip(layout.names, layout.units, strict=True)):
        decided = position in said and said[position].unit is not None
        if not decided:
            refuse_two_units(name, normal_unit(unit or ""), cell_units.get(position), findings)
    return tuple(cell_units.get(position) or unit for position, unit in enumerate(layout.units))
