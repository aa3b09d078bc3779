"""Debug output of a robot's program, saved as a log: `motor1: -2957986`, one value a line, the names in turn.

A row is one turn of the names. There is no time unless one of the names is a time, so the rate is declared.
"""

from __future__ import annotations

import re
from collections import Counter

from ingest.formats.format import LAYOUT, Format, Head
from ingest.instruments import Instrument
from ingest.model import NOTE, ROW, FindingCollector, Reading
from ingest.signals import read_signals
from ingest.tables.table import LineRows, array_table
from ingest.text import NUMBER_PATTERN, TextSource, debug_line, is_single_number, numbered_lines, value_of

_LOG = Instrument()
_FEWEST_LINES = 4
_MOST_NAMES = 256
_FRAGMENT = re.compile(rb"\s*[\d.eE+-]+\s*\S{0,8}\s*")
_VALUE = re.compile(rb"(" + NUMBER_PATTERN + rb")\s*(\S*)")


def _recognise(head: Head) -> str | None:
    """Lines `name: value`."""
    sample = [*head.text.head_lines(60), *head.text.sample_lines(0.5)]
    lines = list({line.start: line.content for line in sample if line.content.strip()}.values())
    found = [debug for debug in map(debug_line, lines) if debug is not None and is_single_number(debug)]
    values = len(found)
    if values < _FEWEST_LINES or values < 0.8 * len(lines) or len({debug.name for debug in found}) == values:
        return None  # names that never come again are settings, no log
    return f"{values} of {len(lines)} lines seen are `name: value`"


def _read(head: Head, findings: FindingCollector) -> Reading:
    source = head.text
    names, units = _names(source)
    turns = _Turns(names, units, findings)
    unended = source.data[-1:] not in (b"\n", b"\r")
    last = 0
    for number, _, content, _ in numbered_lines(source.data, source.start):
        if content.strip(b" \t\0\x1a"):
            turns.take(number, content)
            last = number
    turns.finish(last, unended)
    table = array_table(
        [source.decode(name) for name in names],
        [source.decode(unit) or None for unit in units],
        [turns.found.column(position) for position in range(len(names))],
        lines=turns.found.lines,
        ordinals=turns.found.ordinals,
        rows_rejected=turns.rejected,
    )
    return read_signals(table, head.declared, findings, _LOG)


def _names(source: TextSource) -> tuple[list[bytes], list[bytes]]:
    """Return the names in the order of their turn, and their units: those that repeat among the first lines."""
    found: list[tuple[bytes, bytes]] = []
    for line in source.head_lines():
        debug = debug_line(line.content)
        value = None if debug is None else _VALUE.fullmatch(debug.value)
        if debug is not None and value is not None:
            found.append((debug.name, value[2]))
    counts = Counter(name for name, _ in found)
    usual = max(counts.values(), default=0)
    units = {name: unit for name, unit in reversed(found) if 2 * counts[name] > usual}
    names = list(dict.fromkeys(name for name, _ in found if name in units))[:_MOST_NAMES]
    return names, [units[name] for name in names]


class _Turns:
    """Collects values into rows, each from the first name to the last; `rejected` counts turns that are broken."""

    def __init__(self, names: list[bytes], units: list[bytes], findings: FindingCollector) -> None:
        self.names, self.units, self.findings = names, units, findings
        self.found = LineRows()
        self.rejected = 0
        self._open: list[float] = []
        self._skipping = False
        self._first_line = 0

    def take(self, line: int, content: bytes) -> None:
        """Take one line that is not blank."""
        debug = debug_line(content)
        if debug is None and _FRAGMENT.fullmatch(content):
            self._break_before(line)
            return
        if debug is None or debug.name not in self.names:
            message = "Lines that are no `name: value` of the names in turn are skipped."
            self.findings.add(NOTE, "debug_line", message, lines=[line])
            return
        if self._open and debug.name != self.names[len(self._open)]:
            self._break(line)
        value = _VALUE.fullmatch(debug.value)
        position = len(self._open)
        if debug.name != self.names[position] or value is None or value[2] != self.units[position]:
            if not self._skipping:
                self._break(line)
            return
        if not position:
            self._first_line = line
        self._skipping = False
        self._open.append(value_of(value[1]))
        if len(self._open) == len(self.names):
            self.found.add(self._open, self._first_line, self.rejected)
            self._open = []

    def _break(self, line: int) -> None:
        message = (
            f"A turn of {len(self.names)} names is not complete, or holds no number in its unit; the row is left out."
        )
        self.findings.add(ROW, "turn_broken", message, lines=[line])
        self.rejected += 1
        self._open = []
        self._skipping = True

    def _break_before(self, line: int) -> None:
        """Leave out the turn that a line end inside a number has cut: the open one, or the last that seems whole."""
        if not self._open and self.found.rows:
            self._drop_last()
        self._break(line)

    def _drop_last(self) -> None:
        del self.found.rows[-1], self.found.lines[-1], self.found.ordinals[-1]

    def finish(self, last_line: int, unended: bool) -> None:
        """Judge the last line, whose number may be cut where it has no line end."""
        if self._open:
            self._break(last_line)
        elif unended and self.found.rows:
            message = "The last line has no line end and its number may be cut: the row is left out."
            self.findings.add(ROW, "last_line_cut", message, lines=[last_line])
            self.rejected += 1
            self._drop_last()


FORMAT = Format("debug_lines", 6, _recognise, _read, clues=(b":", b"="), score=LAYOUT)
