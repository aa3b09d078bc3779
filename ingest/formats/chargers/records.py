"""Records `$channel;state;...;checksum`, one a line, as chargers send them; and the procedures that they make up.

The checksum is the exclusive or of all bytes from `$` to the last `;`, both included; makers whose chargers send none
write 0. Outputs of a charger interleave; each of its starts begins a procedure of its own.
"""

from __future__ import annotations

import functools
import operator
import re
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from ingest.findings import NOTE, ROW, FindingCollector
from ingest.formats.format import Head
from ingest.model import FloatArray
from ingest.text.source import numbered_lines

_RECORD = re.compile(rb"\$\d{1,2}(?:;[^;\x00-\x1f]{0,24})+")
_HEAD_RECORD = re.compile(r"\$\d{1,2}(?:;[^;]*){3}")
_SHOWN = 60
_REPEATED = 20


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


def usual_width(
    head: Head,
    widths: Collection[int],
    fits: Callable[[list[str]], bool],
    of: Callable[[list[str]], bool] | None = None,
) -> int:
    """Return the usual number of fields of a file's records, or of those that `of` chooses, checksum included; 0 where
    it is none of `widths`, or half of the records do not fit.
    """
    records = [record for record in head_records(head) if of is None or of(record)]
    width = usual_fields(records)
    fitting = sum(len(record) == width and fits(record) for record in records)
    return width if width in widths and 2 * fitting > len(records) else 0


def checksum_of(body: bytes) -> int:
    """Return the exclusive or of the bytes of a record up to the last `;`, which is included."""
    return functools.reduce(operator.xor, body, 0)


def _read_records(
    head: Head, findings: FindingCollector, zero_is_none: bool
) -> Iterator[tuple[int, list[bytes] | None]]:
    """Yield line number and fields, without `$` and checksum, of every line; None, reported, for one that is no record
    or has a wrong checksum.
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
        body, _, checksum = line.rpartition(b";")
        if not _RECORD.fullmatch(line) or not checksum.isdigit():
            reject_record(number, line, findings)
            yield number, None
        elif checksum_of(body + b";") != int(checksum) and not (zero_is_none and int(checksum) == 0):
            message = "The checksum of the line is wrong: bytes were lost or changed; it is left out."
            findings.add(ROW, "checksum_wrong", message, lines=[number], value=line[:_SHOWN].decode("latin-1"))
            yield number, None
        else:
            yield number, body[1:].split(b";")


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


Parse = Callable[[int, list[bytes]], list[float] | None]
"""Line and fields to the numbers of a record, the channel first: none of a line that is skipped, None for no record."""


def read_procedures(
    head: Head, parse: Parse, judge: Judge, findings: FindingCollector, zero_is_none: bool = False
) -> tuple[list[Procedure], int]:
    """Return the procedures of all outputs in the order in which they began, and how many lines were left out.

    `zero_is_none` takes a checksum of 0 as none.
    """
    procedures: list[Procedure] = []
    going_on: dict[int, Procedure] = {}
    rejected = 0
    for line, fields in _read_records(head, findings, zero_is_none):
        row = None if fields is None else parse(line, fields)
        if row is None:
            rejected += 1
            if fields is not None:
                reject_record(line, b"$" + b";".join(fields), findings)
        if not row:
            continue
        channel = int(row[0])
        procedure = going_on.get(channel)
        sequel = Sequel.BEGINS
        if procedure is not None and len(row) == len(procedure.rows[0]):
            sequel = judge(procedure, row)
        if sequel is Sequel.OUT_OF_ORDER:
            message = "The record lies before the one above it: a line repeated or out of order; it is left out."
            findings.add(ROW, "time_backwards", message, column="time", lines=[line])
            rejected += 1
            continue
        if procedure is None or sequel is Sequel.BEGINS:
            if procedure is not None:
                message = "The charger started again: what follows is kept as a procedure of its own."
                findings.add(NOTE, "time_restarted", message, column="time", lines=[line])
            procedure = going_on[channel] = Procedure(channel)
            procedures.append(procedure)
        procedure.rows.append(row)
        procedure.lines.append(line)
        procedure.ordinals.append(len(procedure.rows) + rejected)
    return procedures, rejected
