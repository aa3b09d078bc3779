"""Series of a long table, `time, sensor, value, unit`: each word of a column names the numbers beside it.

A word is the name of a column wherever the column of numbers has no known name of its own: each series is then read as
a table of that column. Otherwise the words distinguish trials of one channel.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from ingest.channels.names import TIME_NAMES, channel_of, is_unit, normal_unit, parse_header, squash
from ingest.declared import declared_columns, positions_of
from ingest.findings import FILE, FindingCollector
from ingest.model import BoolArray, Declarations
from ingest.tables.table import Block, CellKind, Table, Wanted

_TIME = "time"
_MOST_SERIES = 500


def series(table: Table, declared: Declarations, findings: FindingCollector) -> Mapping[str, Table]:
    """Return the table of each series by its word, in order of first rows; of a table whose words name no columns, that
    table alone, by no word.

    Units of a column of units beside them are those of the series; two of one series refuse the file.
    """
    found = () if declared.trials is None else positions_of(declared.trials, table.names)
    if not found or table.kinds[found[0]] is not CellKind.TEXT:
        return {"": table}
    own = found[0]
    declarations = declared_columns(declared, table.names)
    times = {at for at, name in enumerate(table.names) if any(squash(base) in TIME_NAMES for base in _bases(name))}
    times |= {at for at, declaration in declarations.items() if declaration.channel == _TIME}
    if declared.time_column is not None:
        times = set(positions_of(declared.time_column, table.names))
    numeric = [at for at, kind in enumerate(table.kinds) if kind in (CellKind.NUMBER, CellKind.INTEGER)]
    values = [at for at in numeric if at not in times]
    if len(values) != 1:
        return {"": table}
    filled = [at for at, kind in enumerate(table.kinds) if kind is not CellKind.EMPTY]
    block = table.read_rows([Wanted(at, table.names[at], table.kinds[at]) for at in filled])
    cells = np.array([cell.decode("utf-8", errors="replace").strip() for cell in block.clocks[own]], dtype=np.str_)
    words, first = np.unique(cells, return_index=True)
    ordered = [str(words[at]) for at in np.argsort(first)]
    direct = {**declared.profile_columns, **declared.columns}
    named = any(word in direct or any(map(channel_of, _bases(word))) for word in ordered)
    cell = parse_header(table.names[values[0]])
    declaration = declarations.get(values[0])
    measured = any(map(channel_of, _bases(table.names[values[0]]))) or (declaration and declaration.channel)
    if len(ordered) > _MOST_SERIES or "" in ordered or (measured and not named):
        return {"": dataclasses.replace(table, read_rows=lambda _wanted: block)}
    units = _unit_column(table, block, own)
    tables = {}
    for number, word in enumerate(ordered):
        rows = cells == word
        part = _rows(block, rows, 0 if number else block.rows_rejected)
        unit = table.units[values[0]] or cell.unit
        if units is not None:
            unit = _unit(word, part.clocks[units], findings)
        tables[word] = _table(table, values[0], word, unit, part)
    return tables


def _bases(name: str) -> list[str]:
    """Return the name of a header cell without its unit: `time` of `time [s]`, `time_s` or `time` of `time_s`."""
    cell = parse_header(name)
    return [cell.base, *filter(None, [cell.suffix_base])]


def _unit_column(table: Table, block: Block, own: int) -> int | None:
    """Return the position of the column of which all cells are units."""
    for at, kind in enumerate(table.kinds):
        if at != own and kind is CellKind.TEXT:
            written = {cell.decode("utf-8", errors="replace").strip() for cell in set(block.clocks[at])}
            if written and all(map(is_unit, written)):
                return at
    return None


def _unit(word: str, cells: Sequence[bytes], findings: FindingCollector) -> str | None:
    units = sorted({normal_unit(cell.decode("utf-8", errors="replace")) or "" for cell in set(cells)})
    if len(units) > 1:
        message = f"The rows of {word!r} are in {' and '.join(units[:3])}: a column is read in one unit; export it so."
        findings.add(FILE, "cell_units_differ", message, column=word)
    return units[0] if units else None


def _table(table: Table, position: int, word: str, unit: str | None, block: Block) -> Table:
    names, units = list(table.names), list(table.units)
    names[position], units[position] = word, unit
    return dataclasses.replace(table, names=tuple(names), units=tuple(units), read_rows=lambda _wanted: block)


def _rows(block: Block, rows: BoolArray, rejected: int) -> Block:
    """Return those rows of a block that `rows`, shape (n_rows,), marks."""
    at = np.flatnonzero(rows)
    numbers = {position: values[at] for position, values in block.numbers.items()}
    clocks = {position: [cells[row] for row in at.tolist()] for position, cells in block.clocks.items()}
    return Block(numbers, clocks, block.lines[at], block.ordinals[at], rejected)
