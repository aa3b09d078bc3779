"""PASCO Capstone exports: a row of run names above a row of names with units; further runs stand to the right.

Numbers may be quoted with a decimal comma. Runs differ in length: the cells below the end of a shorter one are blank.
The date has minutes only, so times are the elapsed seconds of each run.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence

import numpy as np

from ingest.channels.names import clean_name, parse_header, squash
from ingest.formats.fixed_table import FixedHeader, fixed_table
from ingest.formats.format import Format, Head
from ingest.instruments import Instrument
from ingest.model import FindingCollector, Reading
from ingest.signals import combine, read_signals
from ingest.tables.table import Block, CellKind, Preamble, Table, Wanted
from ingest.text import TextSource, texts_of

_RUN = re.compile(r"Run #\d+")
_DELIMITERS = (b",", b";", b"\t")
_CHANNELS = {"time": "time", "normalforce": "force_z", "dateandtime": "date_and_time"}


def _recognise(head: Head) -> str | None:
    """`Run #1` above every column."""
    runs, _ = _run_names(head.text)
    return f"{runs[0]!r} above every column" if runs else None


def _run_names(source: TextSource) -> tuple[list[str], bytes]:
    """Return the run above every column and what stands between them; none where the first line is no row of them."""
    lines = source.head_lines(2)
    for delimiter in _DELIMITERS if len(lines) == 2 else ():
        cells = texts_of(source, lines[0], delimiter)
        width = len([cell for cell in texts_of(source, lines[1], delimiter) if cell])
        if width > 1 and len(cells) >= width and all(map(_RUN.fullmatch, cells[:width])):
            return cells[:width], delimiter
    return [], b""


def _read(head: Head, findings: FindingCollector) -> Reading:
    source = head.text
    (runs, delimiter), lines = _run_names(source), source.head_lines(3)
    if not runs or len(lines) < 3:
        return Reading()
    names = texts_of(source, lines[1], delimiter)[: len(runs)]
    table = fixed_table(source, FixedHeader(names, delimiter, lines[2]), head.declared, findings)
    if table is None:
        return Reading()
    numeric = [position for position, kind in enumerate(table.kinds) if kind is CellKind.NUMBER]
    block = table.read_rows([Wanted(position, names[position], CellKind.NUMBER) for position in numeric])
    first = texts_of(source, lines[2], delimiter) + [""] * len(runs)
    readings = []
    for run in dict.fromkeys(runs):
        columns = [position for position, name in enumerate(runs) if name == run]
        part = _run_table(table, block, columns, first)
        readings.append(
            read_signals(part, head.declared, findings, Instrument(clean_name(run), "PASCO", evidence="PASCO"))
        )
        block = dataclasses.replace(block, rows_rejected=0)  # a rejected line is counted once
    return combine(readings)


def _run_table(table: Table, block: Block, columns: Sequence[int], first: Sequence[str]) -> Table:
    """Return the columns of one run as a table of their own, without the blank rows below its end."""
    numeric = [position for position in columns if position in block.numbers]
    filled = [np.flatnonzero(~np.isnan(block.numbers[position])) for position in numeric]
    stop = max((int(rows[-1]) + 1 for rows in filled if rows.size), default=0)
    run = dataclasses.replace(
        block,
        numbers={
            place: block.numbers[position][:stop] for place, position in enumerate(columns) if position in numeric
        },
        lines=block.lines[:stop],
        ordinals=block.ordinals[:stop],
    )
    names = tuple(table.names[position] for position in columns)
    known = [_CHANNELS.get(squash(parse_header(name).base)) for name in names]
    date = next(
        (first[column] for column, channel in zip(columns, known, strict=True) if channel == "date_and_time"), ""
    )
    return Table(
        names,
        (None,) * len(names),
        tuple(table.kinds[position] for position in columns),
        Preamble(None, date or None),
        lambda _wanted: run,
        tuple(known),
    )


FORMAT = Format("pasco", 5, _recognise, _read, clues=(b"run #",))
