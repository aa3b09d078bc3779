"""What `labbook ingest --explain` prints of a file."""

from __future__ import annotations

from collections.abc import Sequence

from ingest.model import ColumnUse, TableUse
from labbook.actions.files.explaining import Explained, PartStored
from labbook.cli.common import columns
from labbook.cli.ingest_lines import finding_lines

_SIGNS = {"\t": "tab", " ": "blanks", "": "none (one column)"}


def explained_lines(explained: Explained) -> list[str]:
    """Return the lines for people: format, layout, columns, what would be stored, findings."""
    plugin = f" of plug-in {explained.plugin}" if explained.plugin else ""
    by = f", recognised by: {explained.evidence}" if explained.evidence else ""
    lines = [f"{explained.file}: {explained.format}, version {explained.reader_version}{plugin}{by}"]
    others = [each for each in explained.explanation.candidates if each.format != explained.format][:2]
    if others:
        listed = "; ".join(f"{each.format} ({each.evidence})" for each in others)
        lines.append(f"  next likely: {listed}; `--format NAME` decides")
    lines.append(f"  profile: {explained.profile or 'none'}")
    if explained.explanation.encoding:
        lines.append(f"  text: {explained.explanation.encoding}")
    for table in explained.explanation.tables:
        lines += [f"  {line}" for line in _table(table)]
    lines += [f"  {line}" for line in _stored(explained)]
    return [*lines, *(f"  {line}" for line in finding_lines(explained.findings))]


def _table(table: TableUse) -> list[str]:
    lines = []
    if table.text is not None:
        shape = table.text
        sign = _SIGNS.get(shape.delimiter, repr(shape.delimiter))
        header = "no header" if shape.header_line is None else f"header in line {shape.header_line}"
        units = "" if shape.units_line is None else f", units in line {shape.units_line}"
        lines.append(
            f"layout: delimiter {sign}, decimal sign {shape.decimal!r}, {header}{units}, data from line "
            f"{shape.first_line}"
        )
    if table.columns:
        rows = [_column(column) for column in table.columns]
        lines += columns(("column", "name", "becomes", "unit", "from", "stored in"), rows)
    if table.rate_from is not None:
        lines.append(f"rate from: {table.rate_from}")
    assumed = list(dict.fromkeys(reason for column in table.columns for reason in column.assumed))
    return [*lines, *([f"assumed: {'; '.join(assumed)}"] if assumed else [])]


def _column(column: ColumnUse) -> Sequence[str]:
    becomes = f"left out: {column.left_out}" if column.holds is None else column.holds
    stored = column.stored_unit or "-"
    return (
        str(column.place),
        column.name,
        becomes,
        column.unit or "-",
        column.unit_from or "-",
        stored if column.sign == 1 else f"{stored}, sign turned round",
    )


def _stored(explained: Explained) -> list[str]:
    if explained.refused:
        return ["would be refused; nothing would be stored"]
    lines = [_part(part) for part in explained.parts]
    if explained.charges:
        total = sum(charge.charge_mah for charge in explained.charges)
        lines.append(f"would be stored: {len(explained.charges)} recharges, {total:g} mAh")
    run = "no run (its name states none)" if explained.run is None else f"run {explained.run}"
    known = "" if explained.run is None or explained.run_known else ", which the book does not have"
    if explained.parts:
        lines.append(f"would belong to: {run}{known}")
    return [*lines, f"rows: {explained.rows_kept} of {explained.rows_read} kept"]


def _part(part: PartStored) -> str:
    rate = "" if part.rate_hz is None else f" at {part.rate_hz:.6g} Hz"
    gaps = f", {part.gaps} gaps with {part.samples_missing} samples missing" if part.gaps else ", no gaps"
    start = f", from {part.start_utc}" if part.start_utc else ""
    return f"would be stored: part {part.part}, {part.samples} samples, {part.duration_s:.6g} s{rate}{gaps}{start}"
