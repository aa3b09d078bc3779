"""`labbook calibrate-sensor`: the line of a sensor from a log in which it rested at known values."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from data_schema.calibration import Calibration, line_through
from data_schema.errors import InputRefused, UsageError
from ingest.channels.names import squash
from ingest.model import ColumnDeclaration, Declarations
from ingest.read import read_file
from labbook.actions.files.named_files import read_bytes
from stats.apexes.standing import Rest, rests

_RAW = "raw"
_SHORTER = 0.5
"""A rest that is shorter than this share of those that are taken is a stop on the way."""
_MOST_OFF_LINE = 0.03
"""Share of their range by which known values may lie off the line; values in wrong order lie farther off."""


@dataclass(frozen=True, slots=True)
class SensorCalibration:
    """The line through what a sensor showed at rest at known values; these and the residuals `left` are in `unit`.

    Of `n_rests` the longest were taken, one for each value.
    """

    column: str
    channel: str
    unit: str
    known: tuple[float, ...]
    rests: tuple[Rest, ...]
    calibration: Calibration
    left: tuple[float, ...]
    n_rests: int

    def profile(self) -> str:
        """Return the column as it is written into a profile of labbook.toml."""
        raw = ", ".join(f"{rest.mean:.6g}" for rest in self.rests)
        known = ", ".join(f"{value:g}" for value in self.known)
        source = "" if self.calibration.source is None else f", source = {json.dumps(self.calibration.source)}"
        column = json.dumps(self.column, ensure_ascii=False)
        points = f"raw = [{raw}], value = [{known}]{source}"
        return f'{column} = {{ channel = "{self.channel}", unit = "{self.unit}", {points} }}'


def calibrate_sensor(
    path: Path,
    column: str,
    known: Sequence[float],
    unit: str,
    channel: str,
    options: Mapping[str, Any],
    source: str | None,
) -> SensorCalibration:
    """Find as many rests in a log's column as there are known values, in order of time, and fit a line to their means.

    Raises `InputRefused` for a file that cannot be read, `UsageError` for a log with fewer rests or another column.
    """
    declared = Declarations(
        columns={column: ColumnDeclaration(_RAW, "1")}, no_robot_check=True, override_units=True, **options
    )
    read = read_file(read_bytes(path), declared)
    faults = [finding for finding in read.findings if finding.severity == "file"]
    if faults:
        raise InputRefused(f"{path.name}: {' '.join(finding.message for finding in faults)}")
    found = [(part, each) for part in read.parts for each in part.channels if each.name == _RAW]
    if not found:
        names = sorted({each.source_name for part in read.parts for each in part.channels})
        alike = [name for name in names if squash(name) == squash(column)]
        raise UsageError(
            f"{path.name} has no column {column!r}: name one of {', '.join(alike or names)} with --column."
        )
    part, raw = found[0]
    every = rests(part.time_s, raw.values)
    if len(every) < len(known):
        raise UsageError(
            f"column {column!r} rests {len(every)} times for half a second or longer, and {len(known)} values are "
            "known: hold the sensor still at each for a second."
        )
    by_length = sorted(every, key=lambda rest: rest.start_s - rest.stop_s)
    longest, others = by_length[: len(known)], by_length[len(known) :]
    shown = ", ".join(f"{rest.mean:.5g}" for rest in every)
    if others and _length_s(others[0]) > _SHORTER * _length_s(longest[-1]):
        raise UsageError(
            f"column {column!r} rests {len(every)} times (at {shown}), and {len(known)} values are known: give one for "
            "each rest, in order of time."
        )
    chosen = tuple(sorted(longest, key=lambda rest: rest.start_s))
    line = line_through([rest.mean for rest in chosen], known)
    line = Calibration(line.scale, line.offset, line.errors, line.df, source)
    left = tuple(value - line.scale * rest.mean - line.offset for value, rest in zip(known, chosen, strict=True))
    worst = max(left, key=abs)
    if abs(worst) > _MOST_OFF_LINE * (max(known) - min(known)):
        raise UsageError(
            f"the values do not lie on a line with what column {column!r} shows at its {len(every)} rests ({shown}): "
            f"{known[left.index(worst)]:g} {unit} is {abs(worst):.2g} {unit} off; give one value for each rest, in "
            "order of time."
        )
    return SensorCalibration(raw.source_name, channel, unit, tuple(known), chosen, line, left, len(every))


def _length_s(rest: Rest) -> float:
    return rest.stop_s - rest.start_s
