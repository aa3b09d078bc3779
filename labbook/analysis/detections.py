"""Detections of the runs' logs: those that are stored, and those that must be made now."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sqlalchemy as sa

from data_schema.queries.signals import DetectionRow, JumpRow, SignalRow, add_detection, detections_by_key, gaps_of
from ingest.store import Store
from labbook.analysis.detecting import (
    BODY_HEIGHT,
    LEG_LENGTH,
    SAMPLES_MISSING,
    Detection,
    Log,
    detect,
    detection_key,
    detection_rows,
    settings,
    version,
)


@dataclass
class Detections:
    """Gives what a detector found in signals; what it had to compute waits in `computed` to be stored."""

    connection: sa.Connection
    store: Store
    progress: Callable[[str], None] = field(default=lambda _what: None)
    computed: dict[str, tuple[SignalRow, Detection]] = field(default_factory=dict)

    def of(self, signals: Mapping[str, SignalRow], algorithm: str, rest_length_m: float) -> dict[str, DetectionRow]:
        """Return the detection of each signal, under the same names."""
        parameters = settings(algorithm, rest_length_m)
        keys = {
            name: detection_key(row.sha256, algorithm, version(algorithm), parameters) for name, row in signals.items()
        }
        stored = detections_by_key(self.connection, sorted(set(keys.values())))
        found = {}
        for name, signal in signals.items():
            row = stored.get(keys[name])
            if row is None:
                self.progress(f"finding jumps ({algorithm}) in {signal.run_name}")
                row = self._find(signal, algorithm, rest_length_m, keys[name])
                stored[keys[name]] = row
            found[name] = row
        return found

    def log(self, signal: SignalRow) -> Log:
        """Read a signal's samples."""
        samples = self.store.samples(signal.store_path, [BODY_HEIGHT, LEG_LENGTH])
        gaps = tuple(
            (gap.start_s, gap.length_s) for gap in gaps_of(self.connection, signal.uid) if gap.kind in SAMPLES_MISSING
        )
        return Log(samples["time"], samples[BODY_HEIGHT], samples.get(LEG_LENGTH), gaps)

    def _find(self, signal: SignalRow, algorithm: str, rest_length_m: float, key: str) -> DetectionRow:
        detection = detect(self.log(signal), algorithm, rest_length_m)
        self.computed[key] = (signal, detection)
        values, jumps = detection_rows(detection, signal.sha256)
        return DetectionRow(
            uid=values["uid"],
            key=key,
            algorithm=algorithm,
            version=detection.version,
            signal_uid=signal.uid,
            signal_sha256=signal.sha256,
            jumps=tuple(_jump_of(row, found.flags) for row, found in zip(jumps, detection.found.jumps, strict=True)),
        )


def keep_detections(connection: sa.Connection, detections: Detections) -> None:
    """Store what was found anew, in a writing transaction."""
    for signal, detection in detections.computed.values():
        values, jumps = detection_rows(detection, signal.sha256)
        add_detection(connection, signal.uid, values, jumps)


def _jump_of(row: Mapping[str, Any], flags: Sequence[str]) -> JumpRow:
    values = {name: row[name] for name in JumpRow.__slots__ if name in row and name != "gap_touched"}
    return JumpRow(**values, gap_touched=bool(row["gap_touched"]), flags=tuple(flags))
