"""Sheets of the thesis's studies (flasks, walks, trials of a leg's gains), and the logs that such a sheet names.

A sheet is kept for `labbook study`, which reads its numbers; here only its header and its rows' cells are looked at.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from data_schema.vocabulary import FileRole
from ingest.findings import FILE, FindingCollector
from ingest.formats.format import LAYOUT, Clue, Format, Head, Reader, Recognition
from ingest.model import Reading
from ingest.text.cells import CANDIDATES, split_cells
from ingest.text.source import TextSource, numbered_lines

STUDY_LOG = "study_log"
_COLUMNS: Mapping[str, tuple[str, ...]] = {
    "flask_sheet": ("radius", "state", "water"),
    "walk_sheet": ("walk", "robot", "mass", "distance"),
    "trial_sheet": ("file", "gain", "damping_gain", "mass"),
    STUDY_LOG: ("time",),
}
"""The columns that a header has, among others, each with its unit behind its name where it has one."""
_WHAT = {
    "flask_sheet": "Volume fractions of grains in flasks, a filling a row (`labbook study compaction`).",
    "walk_sheet": "What robots took on walks, a robot on a walk a row (`labbook study field`).",
    "trial_sheet": "Trials of a leg's gains, a log a row (`labbook study characterisation`).",
    STUDY_LOG: "Logs that a sheet of trials or walks names: oscillations, power; only where declared.",
}
_CLUES = {"flask_sheet": b"radius", "walk_sheet": b"walk", "trial_sheet": b"damping"}
_SEPARATOR = re.compile(rb'\s*"?sep=."?\s*', re.IGNORECASE)
"""A first line that spreadsheets write."""
_TITLE_LINES = 10


@dataclass(frozen=True, slots=True)
class _Header:
    """The line that names a sheet's columns, how they are delimited and how many they are; `above`: text before it."""

    line: int
    delimiter: bytes
    width: int
    above: bool


def _header(source: TextSource, columns: tuple[str, ...]) -> _Header | None:
    """Find the line that has the columns among the first that are not blank."""
    named = [re.compile(rf"{name.replace('_', '[_ ]')}([_ (\[].*)?") for name in columns]
    lines = [line for line in source.head_lines() if line.content.strip() and not _SEPARATOR.fullmatch(line.content)]
    for place, line in enumerate(lines[:_TITLE_LINES]):
        for delimiter in CANDIDATES[:-1]:  # blanks stand in names
            cells = split_cells(line.content, delimiter)
            names = [source.decode(cell).lower() for cell in cells or ()]
            if all(any(name.fullmatch(cell) for cell in names) for name in named):
                return _Header(line.number, delimiter, len(names), above=place > 0)
    return None


def _reader(name: str) -> Reader:
    def read(head: Head, findings: FindingCollector) -> Reading:
        header = None if head.source is None else _header(head.source, _COLUMNS[name])
        if head.source is None or header is None:
            named = ", ".join(_COLUMNS[name])
            findings.add(
                FILE, "columns_missing", f"Its first line does not name the columns {named}: write them there."
            )
            return Reading()
        if header.above:
            message = f"Line {header.line} names the columns: take out the lines above it."
            findings.add(FILE, "header_not_first", message, lines=(header.line,))
        rows = 0
        for number, content in numbered_lines(head.source.data, head.source.start):
            if number <= header.line or not content.strip():
                continue
            rows += 1
            cells = split_cells(content, header.delimiter)
            if cells is None or len(cells) != header.width:
                message = f"The row has another number of cells than the header, which has {header.width}: mend it."
                value = head.source.decode(content)
                findings.add(FILE, "row_width", message, lines=(number,), value=value)
        if head.source.data[-1:] not in (b"\n", b"\r") and not head.declared.complete:
            message = (
                "The last line has no line end, so that it may be cut: end it, or say `--complete` if it is whole."
            )
            findings.add(FILE, "last_line_unended", message)
        return Reading(rows_read=rows, role=FileRole.SHEET)

    return read


def _sheet(name: str) -> Format:
    def recognise(head: Head) -> Recognition | None:
        """A first line with the columns of a study's sheet."""
        if head.source is None or _header(head.source, _COLUMNS[name]) is None:
            return None
        return Recognition(LAYOUT, f"a header with the columns {', '.join(_COLUMNS[name])}")

    return Format(name, 1, recognise, _reader(name), _WHAT[name], clue=Clue(says=(_CLUES[name],)))


def _declared_only(_head: Head) -> Recognition | None:
    """Never by its content: a log of a robot's jumps may have the same columns."""
    return None


FORMATS = (
    *(_sheet(name) for name in _COLUMNS if name != STUDY_LOG),
    Format(
        STUDY_LOG,
        1,
        _declared_only,
        _reader(STUDY_LOG),
        _WHAT[STUDY_LOG],
        clue=Clue(instrument=STUDY_LOG),
    ),
)
