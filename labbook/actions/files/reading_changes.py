"""What another reading of a file gave otherwise, in words."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import sqlalchemy as sa

from data_schema.queries.charges import SheetRow, rows_of_file, said_by_rows
from data_schema.queries.detections import jumps_found
from data_schema.queries.readings import PartRow, ReadingRow, parts_of_reading
from data_schema.vocabulary import ChargeState, IngestStatus


@dataclass(frozen=True, slots=True)
class Gave:
    """What a reading gave: its row, its parts by name, the jumps found in each, and the file's charges by uid."""

    row: ReadingRow
    parts: Mapping[str, PartRow]
    jumps: Mapping[str, int]
    charges: Mapping[str, tuple[SheetRow, tuple[Any, ...]]]

    @classmethod
    def of(cls, connection: sa.Connection, row: ReadingRow) -> Self:
        """Look up what a reading gave, which must be the last of its file."""
        parts = {part.part: part for part in parts_of_reading(connection, row.uid)}
        said = said_by_rows(connection, row.file_uid or "")
        rows = {item.uid: (item, said[item.uid]) for item in rows_of_file(connection, row.file_uid or "")}
        detector = None if row.settings_json is None else json.loads(row.settings_json)["detector"]
        return cls(row, parts, jumps_found(connection, row.uid, detector), rows)


def changes(old: Gave, new: Gave) -> list[str]:
    """Say what another reading gave otherwise; one sentence where nothing is."""
    said = []
    if old.row.status is IngestStatus.WAITING:
        said.append("the file waited for a declaration and is read now")
    if (old.row.reader, old.row.reader_version) != (new.row.reader, new.row.reader_version):
        said.append(
            f"read as {new.row.reader} version {new.row.reader_version}, was {old.row.reader} version "
            f"{old.row.reader_version}"
        )
    if old.row.rows_kept != new.row.rows_kept:
        said.append(f"{new.row.rows_kept} rows kept, were {old.row.rows_kept}")
    said += [f"part {name!r} is there no longer" for name in old.parts if name not in new.parts]
    for name, part in new.parts.items():
        before = old.parts.get(name)
        if before is None:
            said.append(f"part {name!r} is new: {part.n_samples} samples of {_channels(part)}")
        elif before != part:
            said += [f"{text}{f' in part {name!r}' if len(new.parts) > 1 else ''}" for text in _part(before, part)]
        if name in old.jumps and name in new.jumps and old.jumps[name] != new.jumps[name]:
            said.append(f"{new.jumps[name]} jumps found, were {old.jumps[name]}")
        elif name in new.jumps and name not in old.jumps:
            said.append(f"{new.jumps[name]} jumps found")
    return [*said, *_charges(old, new)] or ["nothing comes out otherwise"]


def _part(old: PartRow, new: PartRow) -> list[str]:
    before, now = dict(old.channels), dict(new.channels)
    said = [f"channel {name} [{unit or 'no unit'}] is new" for name, unit in now.items() if name not in before]
    said += [f"channel {name} is there no longer" for name in before if name not in now]
    said += [
        f"channel {name} is in {now[name] or 'no unit'}, was in {unit or 'no unit'}"
        for name, unit in before.items()
        if name in now and now[name] != unit
    ]
    if old.rate_hz != new.rate_hz:
        said.append(f"{_rate(new)}, was {_rate(old)}")
    if old.n_samples != new.n_samples:
        said.append(f"{new.n_samples} samples, were {old.n_samples}")
    if old.start_utc != new.start_utc:
        said.append(f"starts at {new.start_utc or 'no known instant'}, was {old.start_utc or 'no known instant'}")
    if old.gaps != new.gaps:
        said.append(f"{len(new.gaps)} gaps, were {len(old.gaps)}" if len(old.gaps) != len(new.gaps) else "gaps differ")
    return said or (["values differ"] if old.sha256 != new.sha256 else [])


def _charges(old: Gave, new: Gave) -> list[str]:
    gone = (ChargeState.GONE,)
    counts = {
        "new": sum(row.state not in gone for uid, (row, _) in new.charges.items() if uid not in old.charges),
        "gone": sum(
            row.state in gone and old.charges[uid][0].state not in gone
            for uid, (row, _) in new.charges.items()
            if uid in old.charges
        ),
        "changed": sum(said != old.charges[uid][1] for uid, (_, said) in new.charges.items() if uid in old.charges),
    }
    listed = [f"{count} {what}" for what, count in counts.items() if count]
    return [f"charges: {', '.join(listed)}"] if listed else []


def _channels(part: PartRow) -> str:
    return ", ".join(f"{name} [{unit}]" if unit else name for name, unit in part.channels)


def _rate(part: PartRow) -> str:
    return "no rate" if part.rate_hz is None else f"{part.rate_hz:.6g} samples a second"
