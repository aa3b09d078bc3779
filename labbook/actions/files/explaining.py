"""How a file would be read and what would be stored of it, without storing anything; and the draft of a profile.

A draft holds the settings found in the file, and as commented lines, with the choices, those that it leaves open.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from data_schema.errors import nearest
from data_schema.queries.facts import find_uid
from data_schema.vocabulary import CHANNELS
from ingest.channels.names import TICKS_PER_SECOND, channel_kind, clean_name, parse_header
from ingest.formats.chargers.sheet import AMOUNTS
from ingest.model import ChargeRow, ColumnUse, Explanation, Finding, Limits, ReadFile, TableUse, TextShape
from ingest.signals import LEFT_OUT
from ingest.tables.table import CellKind
from labbook.actions.files.against_book import refused_by_book, refused_without_columns
from labbook.actions.files.ingesting import read_for_run
from labbook.actions.files.named_files import own_name
from labbook.book.opening import Book
from labbook.config.profiles import OWN, SHEET_COLUMNS
from labbook.statements.ingesting import runs_contradict


@dataclass(frozen=True, slots=True)
class PartStored:
    """One signal that would be stored: its channels with their units, samples, rate and gaps."""

    part: str
    channels: tuple[tuple[str, str | None], ...]
    samples: int
    duration_s: float
    rate_hz: float | None
    start_utc: str | None
    gaps: int
    samples_missing: int


@dataclass(frozen=True, slots=True)
class Explained:
    """How one file would be read. `run` is the run it would belong to, `run_known` whether the book has it."""

    file: str
    refused: bool
    format: str
    reader_version: int
    plugin: str | None
    evidence: str
    profile: str | None
    explanation: Explanation
    rows_read: int
    rows_kept: int
    parts: tuple[PartStored, ...]
    charges: tuple[ChargeRow, ...]
    run: str | None
    run_known: bool
    findings: tuple[Finding, ...]


def explain_file(book: Book, path: Path, options: Mapping[str, Any], run: str | None, *, alone: bool) -> Explained:
    """Read a file as `ingest` would and explain how; `run` is the one named for it, `alone`: no other file is read."""
    _, read, stated = read_for_run(book, _bytes_of(book, path), path, options, run)
    read = refused_without_columns(read, options) if alone else read
    with book.reading() as connection:
        run = run or (stated[0] if len(stated) == 1 else None)
        read = refused_by_book(connection, read, run, notes=True)
        if run is None:
            read = replace(read, findings=(*read.findings, *runs_contradict(stated, path.name)))
        known = run is not None and find_uid(connection, "run", name=run) is not None
    return Explained(
        own_name(path),
        read.refused,
        read.format,
        read.reader_version,
        read.plugin,
        read.evidence,
        read.profile,
        read.explanation,
        read.rows_read,
        read.rows_kept,
        () if read.refused else _parts(read),
        () if read.refused else read.charges,
        run,
        known,
        read.findings,
    )


def _bytes_of(book: Book, path: Path) -> bytes:
    """Return the bytes of a file, mapped where they are many; raises `InputRefused` beyond the book's limit."""
    data, _ = book.store.read_and_hash(path, Limits(**book.configuration.files.limits).largest_file_bytes)
    return data


def _parts(read: ReadFile) -> tuple[PartStored, ...]:
    return tuple(
        PartStored(
            part.part,
            tuple((channel.name, channel.unit) for channel in part.channels),
            len(part.time_s),
            float(part.time_s[-1] - part.time_s[0]) if len(part.time_s) else 0.0,
            part.rate_hz,
            part.start_utc,
            len(part.gaps),
            sum(gap.samples_missing for gap in part.gaps),
        )
        for part in read.parts
    )


_DELIMITERS = ("\t", ";", ",", "|")
_HEAD_BYTES, _HEAD_LINES = 65_536, 60

_MOST_RECOGNISED = 4
"""Columns by which a draft recognises files: enough to tell loggers apart, few enough to survive a new column."""

_TIME_UNITS = "UNIT: s, ms, us, ns, filetime, min, h or d"


@dataclass(frozen=True, slots=True)
class Draft:
    """The profile `name` for files like `file`, as it stands in labbook.toml."""

    file: str
    name: str
    toml: str


def draft_profile(book: Book, path: Path, options: Mapping[str, Any]) -> Draft:
    """Draft the profile of a file from all that could be found in it, whether or not it is refused."""
    data = _bytes_of(book, path)
    _, read, _ = read_for_run(book, data, path, options, None)
    file_name = own_name(path)
    taken = book.configuration.profiles
    stem = clean_name(re.sub(r"\d+", " ", Path(file_name).stem)) or "logger"
    name = next(n for n in (stem, *(f"{stem}_{number}" for number in range(2, len(taken) + 3))) if n not in taken)
    return Draft(file_name, name, "\n".join(_lines(name, file_name, read, data)) + "\n")


def _lines(name: str, file_name: str, read: ReadFile, data: bytes) -> Iterator[str]:
    rules = {finding.rule for finding in read.findings}
    tables = read.explanation.tables
    table = tables[0] if tables else _guessed_columns(data, read.explanation.encoding)
    yield f"# Drafted from {_text(file_name)}. Lines that begin with # are open, or were found by themselves: take"
    yield "# the # away from those that are to be said, correct them, and put all of it into labbook.toml."
    yield f"[profiles.{name}]"
    pattern = f"files = {_text(re.sub(r'[0-9]+', '*', file_name))}"
    if read.explanation.encoding is not None and table.text is not None and table.text.header_line is not None:
        names = [column.name for column in table.columns if column.name]
        alone = [each for each, count in Counter(names).items() if count == 1] or names[:1]
        yield f"recognise = [{', '.join(map(_text, alone[:_MOST_RECOGNISED]))}]"
        yield f"#{pattern}"
    else:
        yield pattern
    formats = [each.format for each in read.explanation.candidates] or ["delimited_log"]
    others = f"; also recognised as {', '.join(formats[1:])}" if formats[1:] else ""
    is_sheet = "charge_column_missing" in rules
    if is_sheet:
        yield 'format = "charger_sheet"'
    else:
        yield f'#format = "{formats[0]}"  # a sheet of recharges: "charger_sheet"; `labbook formats` lists all{others}'
    yield from _layout_lines(read, table, rules)
    if not is_sheet:
        yield from _time_lines(table, rules)
    yield ""
    yield f"[profiles.{name}.columns]"
    yield "# channels: `labbook channels`; in a sheet of recharges: " + ", ".join(SHEET_COLUMNS)
    lacking = {finding.column for finding in read.findings if finding.rule == "unit_missing"}
    if is_sheet:
        yield from _sheet_lines(table)
    else:
        yield from _column_lines(table, lacking, is_log=formats[0] == "delimited_log")


def _guessed_columns(data: bytes, encoding: str | None) -> TableUse:
    """Return the columns of a text in which no table of numbers was found: those of the lines most alike."""
    if encoding is None:
        return TableUse(None, ())
    lines = [line.decode(encoding, errors="replace") for line in data[:_HEAD_BYTES].splitlines()[:_HEAD_LINES]]
    best: tuple[int, int, str] = (0, 0, "")
    for sign in _DELIMITERS:
        widths = Counter(line.count(sign) + 1 for line in lines if sign in line)
        if widths:
            width, alike = widths.most_common(1)[0]
            best = max(best, (alike, width, sign))
    alike, width, sign = best
    if not alike:
        return TableUse(None, ())
    header = next(number for number, line in enumerate(lines) if line.count(sign) + 1 == width)
    names = [cell.strip().strip('"') for cell in lines[header].lstrip("\ufeff#% ").split(sign)]
    shape = TextShape(sign, "." if sign == "," else ",", header + 1, None, header + 2)
    return TableUse(shape, tuple(ColumnUse(place, name, None) for place, name in enumerate(names, start=1)))


def _layout_lines(read: ReadFile, table: TableUse, rules: set[str]) -> Iterator[str]:
    encoding = read.explanation.encoding
    if encoding not in (None, "utf-8"):
        yield f'encoding = "{encoding}"  # correct it where letters of names look wrong'
    if table.text is None:
        return
    if table.text.delimiter:
        yield f"delimiter = {_text(table.text.delimiter)}"
    if not read.explanation.tables or "decimal_sign_unclear" in rules:
        yield '#decimal = ","  # or ".": whether 1,234 is a decimal or a thousand'
    else:
        yield f"decimal = {_text(table.text.decimal)}"
    yield f"#header_row = {table.text.header_line or 0}  # 0: there is none"
    if table.text.units_line is not None:
        yield f"#units_row = {table.text.units_line}"
    yield f"#first_row = {table.text.first_line}"
    yield '#comment = "#"  # lines that begin so are skipped'
    yield '#footer = "END"  # the data end at a line that begins so'


def _time_lines(table: TableUse, rules: set[str]) -> Iterator[str]:
    key = _keys(table)
    time = next((column for column in table.columns if column.holds == "time"), None)
    if time is not None and time.unit == "clock":
        yield f"time = {{ column = {key[time.place]} }}"
    elif time is not None and time.unit is not None:
        yield f"time = {{ column = {key[time.place]}, unit = {_text(time.unit)} }}"
    elif time is not None:
        yield f'#time = {{ column = {key[time.place]}, unit = "UNIT" }}  # {_TIME_UNITS}'
    elif clock := next((column for column in table.columns if column.left_out == LEFT_OUT[CellKind.CLOCK]), None):
        yield f"#time = {{ column = {key[clock.place]} }}  # its dates or times; dates apart: `date_column`"
    elif table.columns and not any(column.holds in SHEET_COLUMNS for column in table.columns):
        units = {column.place: parse_header(column.name).unit for column in table.columns}
        place = next((place for place, unit in units.items() if unit in TICKS_PER_SECOND), table.columns[0].place)
        unit = units[place] if units[place] in TICKS_PER_SECOND else "UNIT"
        yield f'#time = {{ column = {key[place]}, unit = "{unit}" }}  # its time column; {_TIME_UNITS}'
        if table.rate_from is None:
            yield '#rate_hz = "HZ"  # without a time column: samples a second'
    if "date_unclear" in rules:
        yield '#date = "d/m/y"  # or "m/d/y"'
    if "clock_unclear" in rules:
        yield '#clock = "m:s"  # or "h:m"'
    if any((channel_kind(column.holds or "") or "").startswith("force") for column in table.columns):
        yield '#axes = "z up"  # or "z down" or "y up"'


def _sheet_lines(table: TableUse) -> Iterator[str]:
    """Yield the columns of a sheet of recharges that its reader does not know; those in mAh or Ah are charges."""
    for column in table.columns:
        unit = parse_header(column.name).unit
        if unit in AMOUNTS["charge"].factors:
            yield f'{_keys(table)[column.place]} = {{ channel = "charge", unit = "{unit}" }}'
        elif column.name:
            yield f'#{_keys(table)[column.place]} = {{ channel = "run" }}  # or another of those above'


def _column_lines(table: TableUse, lacking: Collection[str | None], *, is_log: bool) -> Iterator[str]:
    key = _keys(table)
    for column in table.columns:
        if column.holds not in ("time", "date", "trial") and column.name:
            unknown = is_log and column.holds not in CHANNELS  # stored under its name, which may be that of a sheet's
            yield _column(key[column.place], column, column.name in lacking, of_sheet=not unknown)


def _column(key: str, column: ColumnUse, lacks_unit: bool, *, of_sheet: bool) -> str:
    kind = channel_kind(column.holds or "")
    sign = ", sign = -1" if column.sign == -1 and not column.assumed else ""
    of_sheet = of_sheet and column.holds in SHEET_COLUMNS
    if of_sheet and lacks_unit:
        return _open_unit(key, column, column.stored_unit or "1")
    if of_sheet or (kind is not None and column.unit is not None):
        unit = "" if column.unit is None else f", unit = {_text(column.unit)}"
        return f"{key} = {{ channel = {_text(column.holds or '')}{unit}{sign} }}"
    if kind is not None and CHANNELS[kind].unit == "1":
        return f"{key} = {{ channel = {_text(column.holds or '')}{sign} }}"
    if kind is not None:
        return _open_unit(key, column, CHANNELS[kind].unit)
    if column.left_out is None and column.holds is None:
        return f'#{key} = {{ channel = "charge", unit = "UNIT" }}  # or another, and its unit where it has one'
    close = nearest(column.name, CHANNELS)
    unit = "" if column.unit is None else f", unit = {_text(column.unit)}"
    own = f"{OWN}{clean_name(column.name) or f'column_{column.place}'}"
    why = f"  # {column.left_out}" if column.left_out else f"  # or a channel{f', perhaps {close}' if close else ''}"
    return f"#{key} = {{ channel = {_text(own)}{unit} }}{why}"


def _open_unit(key: str, column: ColumnUse, stored_unit: str) -> str:
    return (
        f'#{key} = {{ channel = {_text(column.holds or "")}, unit = "UNIT" }}'
        f"  # UNIT: its unit in the file, such as {stored_unit}"
    )


def _keys(table: TableUse) -> dict[int, str]:
    """Return how each column is called, by place: its name, and which one of several equal names."""
    counts = Counter(column.name for column in table.columns)
    seen: Counter[str] = Counter()
    keys = {}
    for column in table.columns:
        seen[column.name] += 1
        keys[column.place] = _text(column.name if counts[column.name] == 1 else f"{column.name}#{seen[column.name]}")
    return keys


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
