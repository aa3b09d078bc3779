"""The table under a header whose form its maker fixes: names, delimiter and first line of data are known beforehand.

And what such headers have in common: values by key, channels by plate, counts that are checked.
"""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ingest.formats.format import Head
from ingest.instruments import PLATE_UNITS, Instrument
from ingest.model import FILE, Declarations, FindingCollector, Reading
from ingest.signals import read_signals
from ingest.tables.layout import Layout, decimal_sign, kind_of
from ingest.tables.rows import read_rows
from ingest.tables.sheet import lone_number
from ingest.tables.table import Preamble, Table
from ingest.text import Line, TextSource, split_cells, too_wide


@dataclass(frozen=True, slots=True)
class FixedHeader:
    """What is known of a table before its rows are read.

    `first` is the first line of data; `names`, `units` and `channels` (see `Table`) have an entry per column, the last
    two may be left out. Cells beyond the last name must be blank in all rows.
    """

    names: Sequence[str]
    delimiter: bytes
    first: Line
    units: Sequence[str | None] = ()
    channels: Sequence[str | None] = ()
    preamble: Preamble = field(default_factory=Preamble)


def fixed_table(
    source: TextSource, header: FixedHeader, declared: Declarations, findings: FindingCollector
) -> Table | None:
    """Return the table below `header`, its rows not read yet; None, with a finding, where rows have another width."""
    lines = source.lines_at(header.first.start, header.first.number)
    further = [*source.sample_lines(0.5), *source.sample_lines(0.95)]
    lines += [line for line in further if line.start >= header.first.start]
    whole = [line for line in lines if line.ended and line.content.strip()] or [header.first]
    rows = _usual([split_cells(line.content, header.delimiter) or [b""] for line in whole])
    width, columns = len(rows[0]), len(header.names)
    if too_wide(width, declared, findings):
        return None
    if width < columns or any(cell for row in rows for cell in row[columns:]):
        message = (
            f"The header names {columns} columns and the rows have {width} cells: export again so that they agree."
        )
        findings.add(FILE, "header_mismatch", message, lines=[header.first.number])
        return None
    kinds = tuple(kind_of([row[column] for row in rows]) for column in range(columns))
    layout = Layout(
        delimiter=header.delimiter,
        decimal=decimal_sign(rows, header.delimiter, declared, findings),
        width=columns,
        trailing=width - columns,
        names=tuple(header.names),
        units=tuple(header.units) or (None,) * columns,
        kinds=kinds,
        data_start=header.first.start,
        data_line=header.first.number,
        last_cells=tuple(row[-1] for row in rows) if header.first.ended else (),
        complete=bool(declared.complete),
        fixed=True,
    )
    read = functools.partial(read_rows, source, layout, findings)
    return Table(layout.names, layout.units, kinds, header.preamble, read, tuple(header.channels), layout.shape)


def _usual(rows: list[list[bytes]]) -> list[list[bytes]]:
    """Return the rows of the width that most have."""
    width, _ = Counter(map(len, rows)).most_common(1)[0]
    return [row for row in rows if len(row) == width]


MILLIMETRE_UNITS: Mapping[str, str] = {
    kind: {"N*m": "N*mm", "m": "mm"}.get(unit, unit) for kind, unit in PLATE_UNITS.items()
}
"""For makers that write newton millimetres and millimetres."""


def plate_channel(quantity: str, axis: str, plate: int) -> str:
    """Return the channel of a component on a plate, counted from 1: `force_z`, `force_z_2`."""
    return f"{quantity}_{axis}" if plate == 1 else f"{quantity}_{axis}_{plate}"


def number_among(known: list[str], name: str) -> int:
    """Return the place of a name, from 1, among those known; a new one joins them."""
    if name not in known:
        known.append(name)
    return known.index(name) + 1


def number(text: str | None) -> float | None:
    """Return the number that a header's value is, its decimal sign a point or a comma; None where it is none.

    `1,000` is none either: it may be one or a thousand.
    """
    return None if text is None else lone_number(text.strip().removesuffix("Hz").strip())


def positive(text: str | None) -> float | None:
    """Return the number of a rate, None where there is none above zero."""
    value = number(text)
    return value if value is not None and value > 0 else None


def next_filled(source: TextSource, line: Line) -> Line | None:
    """Return the next line after `line` that is not blank, None at the end of the file."""
    return next((after for after in source.lines_at(line.start, line.number, 20)[1:] if after.content.strip()), None)


def read_fixed(
    head: Head, header: FixedHeader, findings: FindingCollector, instrument: Instrument, samples: float | None = None
) -> Reading:
    """Read the one table below a maker's header; `samples` is the header's number of samples."""
    table = fixed_table(head.text, header, head.declared, findings)
    if table is None:
        return Reading()
    reading = read_signals(table, head.declared, findings, instrument)
    check_count(reading, samples, findings)
    return reading


def check_count(reading: Reading, samples: float | None, findings: FindingCollector) -> None:
    """Refuse a file whose number of rows is not its header's; a last row that was cut does not count."""
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
