"""Records `$channel;state;...;checksum`, one a line, as chargers send them; and the procedures that they make up.

The checksum is the exclusive or of all bytes from `$` to the last `;`, both included; makers whose chargers send none
write 0. Outputs of a charger interleave; each of its starts begins a procedure of its own.
"""

from __future__ import annotations

import functools
import operator
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

import numpy as np

from ingest.findings import NOTE, ROW, FindingCollector
from ingest.formats.format import Head
from ingest.model import FloatArray, IntArray
from ingest.text.source import numbered_lines

_RECORD = re.compile(rb"\$\d{1,2}(?:;[^;\x00-\x1f]{0,24})+")
_HEAD_RECORD = re.compile(r"\$\d{1,2}(?:;[^;]*){3}")
_SHOWN = 60
_REPEATED = 20


class Record(NamedTuple):
    """A line that holds a record: its number, and its fields without `$` and checksum, the channel first."""

    line: int
    fields: list[bytes]


def head_records(head: Head) -> list[list[str]]:
    """Return the fields, checksum included, of the records among the first lines; none where most lines are others."""
    lines = [line.replace("\0", "").strip() for line in head.lines]
    lines = [line for line in lines if line and not line.startswith("@")]
    records = [line[1:].split(";") for line in lines if _HEAD_RECORD.match(line)]
    return records if records and 2 * len(records) >= len(lines) else []


def usual_fields(records: Sequence[Sequence[str]]) -> int:
    """Return the most common number of fields, 0 of no records."""
    counts = Counter(map(len, records))
    return counts.most_common(1)[0][0] if counts else 0


def checksum_of(body: bytes) -> int:
    """Return the exclusive or of the bytes of a record up to the last `;`, which is included."""
    return functools.reduce(operator.xor, body, 0)


def read_records(
    head: Head, findings: FindingCollector, zero_is_none: bool = False
) -> Iterator[tuple[int, Record | None]]:
    """Yield line number and record of every line; None, reported, for one that is no record or has a wrong checksum.

    `zero_is_none` takes a checksum of 0 as none.
    """
    data, start = (head.data, 0) if head.source is None else (head.source.data, head.source.start)
    for number, content in numbered_lines(data, start):
        line = content.strip(b"\0\x1a \t")
        if not line:
            continue
        if line.startswith(b"@"):
            text = line.decode("latin-1")
            findings.add(NOTE, "instrument", f"Written by {text[1:]}.", lines=[number], value=text)
            continue
        yield number, _record(line, number, zero_is_none, findings)


def _record(line: bytes, number: int, zero_is_none: bool, findings: FindingCollector) -> Record | None:
    body, _, checksum = line.rpartition(b";")
    if not _RECORD.fullmatch(line) or not checksum.isdigit():
        reject_record(number, line, findings)
        return None
    if checksum_of(body + b";") != int(checksum) and not (zero_is_none and int(checksum) == 0):
        message = "The checksum of the line is wrong: bytes were lost or changed; it is left out."
        findings.add(ROW, "checksum_wrong", message, lines=[number], value=line[:_SHOWN].decode("latin-1"))
        return None
    return Record(number, body[1:].split(b";"))


def reject_record(number: int, line: bytes, findings: FindingCollector) -> None:
    """Report a line that is no record of its format."""
    message = "The line is no record `$channel;state;...;checksum` of this format; it is left out."
    findings.add(ROW, "record_malformed", message, lines=[number], value=line[:_SHOWN].decode("latin-1"))


@dataclass(slots=True)
class Procedure:
    """The records of one output from one start of the charger: their numbers, the lines they stand in, and which of the
    file's rows they are, those left out before them counted.
    """

    channel: int
    rows: list[list[float]] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    ordinals: list[int] = field(default_factory=list)

    def column(self, position: int) -> FloatArray:
        """Return one field of all records, shape (n,)."""
        return np.array([row[position] for row in self.rows], dtype=np.float64)

    def line_numbers(self) -> IntArray:
        """Return the 1-based line of every record, shape (n,)."""
        return np.array(self.lines, dtype=np.int64)

    def row_numbers(self) -> IntArray:
        """Return the number of every record among the rows of the file that concern it, shape (n,)."""
        return np.array(self.ordinals, dtype=np.int64)


class Sequel(Enum):
    """What a record is to the procedure that is going on."""

    GOES_ON = "goes on"
    BEGINS = "begins another"
    OUT_OF_ORDER = "out of order"


Judge = Callable[[Procedure, list[float]], Sequel]


def by_clock(position: int, soon: float) -> Judge:
    """Return the judge of records with a clock at `position`: one that goes back to where the procedure began, `soon`
    in its unit after that at most, begins another; one that goes back elsewhere, or was there, is out of order.
    """

    def judge(procedure: Procedure, row: list[float]) -> Sequel:
        first, last = procedure.rows[0][position], procedure.rows[-1][position]
        if row[position] >= last:
            return Sequel.GOES_ON
        known = row in procedure.rows[-_REPEATED:]
        begins = row[position] <= first or (row[position] <= first + soon and not known)
        return Sequel.BEGINS if begins else Sequel.OUT_OF_ORDER

    return judge


class Procedures:
    """Collects records into procedures; `rows_rejected` counts those left out."""

    __slots__ = ("_judge", "_open", "found", "rows_rejected")

    def __init__(self, judge: Judge) -> None:
        self.found: list[Procedure] = []
        self.rows_rejected = 0
        self._open: dict[int, Procedure] = {}
        self._judge = judge

    def add(self, line: int, row: list[float], findings: FindingCollector) -> None:
        """Take the numbers of one record, the channel first."""
        channel = int(row[0])
        procedure = self._open.get(channel)
        sequel = Sequel.BEGINS
        if procedure is not None and len(row) == len(procedure.rows[0]):
            sequel = self._judge(procedure, row)
        if sequel is Sequel.OUT_OF_ORDER:
            message = "The record lies before the one above it: a line repeated or out of order; it is left out."
            findings.add(ROW, "time_backwards", message, column="time", lines=[line])
            self.rows_rejected += 1
            return
        if procedure is None or sequel is Sequel.BEGINS:
            if procedure is not None:
                message = "The charger started again: what follows is kept as a procedure of its own."
                findings.add(NOTE, "time_restarted", message, column="time", lines=[line])
            procedure = self._open[channel] = Procedure(channel)
            self.found.append(procedure)
        procedure.rows.append(row)
        procedure.lines.append(line)
        procedure.ordinals.append(len(procedure.rows) + self.rows_rejected)
