"""What the makers' fixed headers have in common: values by key, the first line of data, counts that are checked."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from data_schema.vocabulary import FileRole
from ingest.findings import FILE, FindingCollector
from ingest.instruments import PLATE_UNITS, Instrument
from ingest.model import Declarations, Reading
from ingest.signals import read_signals
from ingest.tables.fixed_table import FixedHeader, fixed_table
from ingest.text.source import Line, TextSource

MILLIMETRE_UNITS: Mapping[str, str] = {
    kind: {"N*m": "N*mm", "m": "mm"}.get(unit, unit) for kind, unit in PLATE_UNITS.items()
}
"""For makers that write newton millimetres and millimetres."""

_NUMBER = re.compile(r"([+-]?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?)\s*(?:Hz)?")
_GROUPED = re.compile(r"[1-9]\d{0,2},\d{3}")


def plate_channel(quantity: str, axis: str, plate: int) -> str:
    """Return the channel of a component on a plate, counted from 1: `force_z`, `force_z_2`."""
    return f"{quantity}_{axis}" if plate == 1 else f"{quantity}_{axis}_{plate}"


def number(text: str | None) -> float | None:
    """Return the number that a header's value is, its decimal sign a point or a comma; None where it is none.

    `1,000` is none either: it may be one or a thousand.
    """
    found = _NUMBER.fullmatch((text or "").strip())
    if found is None or _GROUPED.fullmatch(found[1]):
        return None
    return float(found[1].replace(",", "."))


def positive(text: str | None) -> float | None:
    """Return the number of a rate, None where there is none above zero."""
    value = number(text)
    return value if value is not None and value > 0 else None


def next_filled(source: TextSource, line: Line) -> Line | None:
    """Return the next line after `line` that is not blank, None at the end of the file."""
    return next((after for after in source.lines_at(line.start, line.number, 20)[1:] if after.content.strip()), None)


def read_fixed(
    source: TextSource,
    header: FixedHeader,
    declared: Declarations,
    findings: FindingCollector,
    instrument: Instrument,
    samples: float | None = None,
) -> Reading:
    """Read the one table below a maker's header; `samples` is how many the header says there are."""
    table = fixed_table(source, header, declared, findings)
    if table is None:
        return Reading()
    reading = read_signals(table, declared, findings, instrument)
    check_count(reading, samples, findings)
    return reading


def check_count(reading: Reading, samples: float | None, findings: FindingCollector) -> None:
    """Refuse a file that does not hold as many rows as its header says; a last row that was cut does not count."""
    whole = reading.rows_read - ("last_line_cut" in findings)
    if samples is not None and whole != samples:
        message = f"The header says {samples:g} samples and the file holds {whole}: it was cut short or edited; "
        findings.add(FILE, "sample_count_contradicts", message + "copy it again, or export it again.")


def refuse_layout(program: str, expected: str, findings: FindingCollector) -> Reading:
    """Report a header that is not as the program's header is known to be."""
    message = f"The file names {program}, and has not {expected}: another version of the program; "
    message += "say its columns in a [profiles.NAME] table of labbook.toml and read it with `--format delimited_log`."
    findings.add(FILE, "layout_unknown", message)
    return Reading()


def joined(readings: Sequence[Reading]) -> Reading:
    """Return what several tables of one file give, their parts in order."""
    role = FileRole.FORCE if any(reading.role is FileRole.FORCE for reading in readings) else FileRole.LOG
    return Reading(
        tuple(part for reading in readings for part in reading.parts),
        (),
        sum(reading.rows_read for reading in readings),
        sum(reading.rows_rejected for reading in readings),
        role,
    )
