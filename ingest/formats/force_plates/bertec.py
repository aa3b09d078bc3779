"""Text exports of Bertec force plates: Bertec Acquire, and the logs of programs on Bertec's SDK.

Acquire writes `Seq, Timestamp, Sync, Aux` and then, for each plate, `Fx Fy Fz Mx My Mz COPx COPy` and sometimes three
more columns; a balance plate has `Fz, Mx, My` only. Neither units nor rate are in the file: newtons, newton metres,
metres and milliseconds are the maker's, kept with each channel as assumed. The origin is the plate's back outer corner,
x to the left, z down, forces act on the plate.

SDK logs (`Timestamp;Fx1;Fy1;...`) differ in unit and sign of the centre of pressure from program to program, so these
follow from moments and force; their stamps may be Windows FILETIME at arrival, and then samples are counted at the
amplifier's fixed 1000 Hz (AM6800 line), which also tells seconds from milliseconds.
"""

from __future__ import annotations

import re
from itertools import pairwise

from ingest.channels.columns import Convention
from ingest.channels.forces import Z_DOWN_ACTION
from ingest.findings import FindingCollector
from ingest.formats.format import LAYOUT, Format, Recognition
from ingest.formats.head import Head
from ingest.model import Reading
from ingest.signals import Instrument, read_signals
from ingest.tables.header_cells import parse_header, squash, strip_comment
from ingest.tables.text_table import text_table

AMPLIFIER_RATE_HZ = 1000.0

_UNITS = {
    f"{quantity}_{axis}": unit for quantity, unit in (("force", "N"), ("moment", "N*m"), ("cop", "m")) for axis in "xyz"
}
_ACQUIRE = Instrument("force", Convention("Bertec Acquire", _UNITS, "ms"), Z_DOWN_ACTION)
_SDK = {
    unit: Instrument("force", Convention("Bertec SDK", _UNITS, unit), Z_DOWN_ACTION, AMPLIFIER_RATE_HZ)
    for unit in ("s", "ms", "filetime", None)
}
_BALANCE = Instrument("force", Convention("Bertec balance plate", _UNITS), Z_DOWN_ACTION)
_CELLS = re.compile(r"[;,\t]")
_STAMP = re.compile(r"(?:\d{4}-\d\d-\d\d[^;]*;)?(\d+(?:\.\d+)?);")
_FILETIME_DIGITS = 18


def _header(head: Head) -> frozenset[str]:
    """Return the names of the first line that has a vertical force and its moments."""
    for line in head.lines:
        if "fz" not in line.lower():
            continue
        names = frozenset(squash(parse_header(strip_comment(cell)).base) for cell in _CELLS.split(line))
        if {"fz", "mx", "my"} <= names or {"fz1", "mx1", "my1"} <= names:
            return names
    return frozenset()


def _instrument(head: Head) -> Instrument | None:
    names = _header(head)
    if {"seq", "timestamp"} <= names:
        return _ACQUIRE
    if {"timestamp", "copx1", "copxy1"} <= names:
        return _SDK[_sdk_time_unit(head)]
    if names == {"time", "fz", "mx", "my", "copx", "copy"}:
        return _BALANCE
    titled = any("bertec" in line.lower() for line in head.lines[:20])
    return _ACQUIRE if names and titled else None


def _sdk_time_unit(head: Head) -> str | None:
    """Return the unit in which the amplifier's fixed rate gives the steps seen: 1 ms is 0.001 s, 1 ms or a FILETIME."""
    stamps = [match[1] for match in map(_STAMP.match, head.lines) if match]
    if stamps and all(len(stamp) == _FILETIME_DIGITS for stamp in stamps):
        return "filetime"
    steps = sorted(float(after) - float(before) for before, after in pairwise(stamps))
    step = steps[len(steps) // 2] if steps else 0.0
    return next((unit for unit, period in (("s", 1e-3), ("ms", 1.0)) if abs(step / period - 1) < 0.05), None)


def _recognise(head: Head) -> Recognition | None:
    if head.source is None or _instrument(head) is None:
        return None
    return Recognition(LAYOUT, "columns as Bertec's programs order them")


def _read(head: Head, findings: FindingCollector) -> Reading:
    instrument = _instrument(head)
    if head.source is None or instrument is None:
        return Reading()
    table = text_table(head.source, head.declared, findings)
    return Reading() if table is None else read_signals(table, head.declared, findings, instrument)


FORMAT = Format("bertec_text", 5, _recognise, _read)
