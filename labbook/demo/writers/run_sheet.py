"""Run sheet as CSV: one row a run, in the columns that `labbook runs import` reads."""

from __future__ import annotations

import csv
import datetime as dt
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from data_schema.vocabulary import RunKind


@dataclass(frozen=True, slots=True)
class RunRow:
    """One run as written down; `levels` maps factor names to levels and is empty for an idle run."""

    run: str
    started: dt.datetime
    position: int
    kind: RunKind
    levels: Mapping[str, object]
    battery: str
    robot: str
    duration_s: int
    jumps_made: int
    starts: int
    note: str


def run_sheet(factors: Sequence[str], rows: Iterable[RunRow]) -> bytes:
    """Return the sheet with a column for each of `factors`, in the order given; times are local."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    before, after = (
        ["run", "date", "position", "kind"],
        ["battery", "robot", "started", "duration_s", "jumps_made", "starts", "note"],
    )
    writer.writerow([*before, *factors, *after])
    for row in rows:
        writer.writerow(
            [
                row.run,
                f"{row.started:%Y-%m-%d}",
                row.position,
                row.kind.value,
                *(row.levels.get(factor, "") for factor in factors),
                row.battery,
                row.robot,
                f"{row.started:%H:%M}",
                row.duration_s,
                row.jumps_made,
                row.starts,
                row.note,
            ]
        )
    return stream.getvalue().encode()
