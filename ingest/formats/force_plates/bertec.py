"""Text exports of Bertec force plates: Bertec Acquire, and the logs of programs on Bertec's SDK.

Acquire writes `Seq, Timestamp, Sync, Aux` and then, for each plate, `Fx Fy Fz Mx My Mz COPx COPy` and sometimes three
more columns; a balance plate has `Fz, Mx, My` only. This order is the evidence: `Time, Fz, Mx, My, CoPx, CoPy` alone is
any maker's, and needs `--instrument bertec_balance`. Neither units nor rate are in the file: newtons, newton metres,
metres and milliseconds are the maker's, stored with each channel as assumed. The origin is the plate's back outer
corner, x to the left, z down, forces act on the plate.

SDK logs (`Timestamp;Fx1;Fy1;...`) differ in unit and sign of the centre of pressure from program to program, so these
follow from moments and force; their stamps may be Windows FILETIME at arrival, and then samples are counted at the
amplifier's fixed 1000 Hz (AM6800 line), which also distinguishes seconds from milliseconds.
"""

from __future__ import annotations

import dataclasses
import re
from itertools import pairwise

from ingest.channels.names import parse_header, squash, strip_comment
from ingest.formats.format import LAYOUT, Format, Head
from ingest.instruments import INSTRUMENTS, Instrument, bertec_sdk
from ingest.model import FindingCollector, Reading
from ingest.signals import read_signals
from ingest.tables.rows import text_table

_EVIDENCE = "columns as Bertec's programs order them"
_ACQUIRE = dataclasses.replace(INSTRUMENTS["bertec_acquire"], evidence=_EVIDENCE)
_LEADING = ("seq", "timestamp", "sync", "aux")
_PLATES = (("fx", "fy", "fz", "mx", "my", "mz"), ("fz", "mx", "my"))
_NUMBERED = ("fx1", "fy1", "fz1", "mx1", "my1", "mz1")
_CELLS = re.compile(r"[;,\t]")
_STAMP = re.compile(r"(?:\d{4}-\d\d-\d\d[^;]*;)?(\d+(?:\.\d+)?);")
_FILETIME_DIGITS = 18


def _header(head: Head) -> tuple[str, ...]:
    """Return the names of the first line that has a vertical force and its moments, in their order."""
    for line in head.lines:
        if "fz" not in line.lower():
            continue
        names = tuple(squash(parse_header(strip_comment(cell)).base) for cell in _CELLS.split(line))
        if {"fz", "mx", "my"} <= set(names) or {"fz1", "mx1", "my1"} <= set(names):
            return names
    return ()


def _instrument(head: Head) -> Instrument | None:
    """Return the instrument that the order of the columns proves; names that any maker gives prove none."""
    names = _header(head)
    if names[:4] == _LEADING and any(names[4 : 4 + len(plate)] == plate for plate in _PLATES):
        return _ACQUIRE
    names = names[1:] if names[:1] == ("date",) else names
    if names[:7] == ("timestamp", *_NUMBERED) and "copxy1" in names:
        return bertec_sdk(_sdk_time_unit(head), _EVIDENCE)
    return None


def _sdk_time_unit(head: Head) -> str | None:
    """Return the unit in which the amplifier's fixed rate gives the steps seen: 1 ms is 0.001 s, 1 ms or a FILETIME."""
    stamps = [match[1] for match in map(_STAMP.match, head.lines) if match]
    if stamps and all(len(stamp) == _FILETIME_DIGITS for stamp in stamps):
        return "filetime"
    steps = sorted(float(after) - float(before) for before, after in pairwise(stamps))
    step = steps[len(steps) // 2] if steps else 0.0
    return next((unit for unit, period in (("s", 1e-3), ("ms", 1.0)) if abs(step / period - 1) < 0.05), None)


def _recognise(head: Head) -> str | None:
    """Columns in the order of Bertec's programs."""
    return None if _instrument(head) is None else _EVIDENCE


def _read(head: Head, findings: FindingCollector) -> Reading:
    instrument = _instrument(head)
    if instrument is None:
        return Reading()
    table = text_table(head.text, head.declared, findings)
    return Reading() if table is None else read_signals(table, head.declared, findings, instrument)


FORMAT = Format("bertec_text", 9, _recognise, _read, clues=(b"fz",), score=LAYOUT)
