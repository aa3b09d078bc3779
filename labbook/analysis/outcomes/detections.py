"""Detections of the runs' logs: those that are stored, and those that must be made now."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import sqlalchemy as sa

from data_schema.queries.detections import DetectionRow, JumpRow, NewDetection, add_detections, detections_by_key
from data_schema.queries.facts import read_fact
from data_schema.queries.signals import GapRow, SignalRow, gaps_by_signal
from ingest.store import Store
from labbook.analysis.outcomes.detecting import (
    BODY_HEIGHT,
    LEG_LENGTH,
    Detection,
    Log,
    detect,
    detection_key,
    detection_rows,
    heeded_gaps,
    settings,
    version,
)

LOGS_AT_ONCE = 2
"""Reading and most of detecting let other threads run; more would cost memory and gain little."""


@dataclass(frozen=True, slots=True)
class Found:
    """A detection just made: where, as rows to be stored, and as it would be read back."""

    new: NewDetection
    row: DetectionRow


@dataclass
class Detections:
    """Gives what a detector found in signals; what it had to compute waits in `computed` to be stored."""

    connection: sa.Connection
    store: Store
    progress: Callable[[str], None] = field(default=lambda _what: None)
    computed: dict[str, Found] = field(default_factory=dict)

    def of(
        self, runs: Mapping[str, Sequence[SignalRow]], algorithm: str, rest_length_m: float
    ) -> dict[str, tuple[DetectionRow, ...]]:
        """Return the detections of each run's signals, in their order under the same names."""
        signals = {signal.uid: signal for several in runs.values() for signal in several}
        parameters = settings(algorithm, rest_length_m)
        gaps = gaps_by_signal(self.connection, sorted({signal.uid for signal in signals.values()}))
        keys = {
            name: detection_key(row.sha256, algorithm, version(algorithm), parameters, heeded_gaps(gaps[row.uid]))
            for name, row in signals.items()
        }
        stored = detections_by_key(self.connection, sorted(set(keys.values()) - self.computed.keys()))
        missing = {keys[name]: row for name, row in signals.items() if keys[name] not in stored}
        anew = {key: row for key, row in missing.items() if key not in self.computed}
        self._compute(anew, gaps, algorithm, rest_length_m)
        found = {uid: stored[key] if key in stored else self.computed[key].row for uid, key in keys.items()}
        return {name: tuple(found[signal.uid] for signal in several) for name, several in runs.items()}

    def log(self, signal: SignalRow) -> Log:
        """Read a signal's samples."""
        return _read(self.store, signal, gaps_by_signal(self.connection, [signal.uid])[signal.uid])

    def _compute(
        self,
        missing: Mapping[str, SignalRow],
        gaps: Mapping[str, Sequence[GapRow]],
        algorithm: str,
        rest_length_m: float,
    ) -> None:
        """Find the jumps of logs side by side; the database is asked from this thread only."""

        def find(signal: SignalRow) -> Detection:
            return detect(_read(self.store, signal, gaps[signal.uid]), algorithm, rest_length_m)

        with ThreadPoolExecutor(LOGS_AT_ONCE) as pool:
            made = pool.map(find, missing.values())
            for (key, signal), detection in zip(missing.items(), made, strict=True):
                self.progress(f"finding jumps ({algorithm}) in {signal.run_name}")
                self.computed[key] = _found(key, signal, detection)


def rest_length_m(connection: sa.Connection, robot_uid: str) -> float:
    """Return the leg's rest length of a robot as the book has it."""
    return float(read_fact(connection, "robot", robot_uid, ["rest_length_m"])["rest_length_m"])


def keep_detections(connection: sa.Connection, detections: Detections) -> None:
    """Store what was found anew, in a writing transaction."""
    add_detections(connection, [found.new for found in detections.computed.values()])


def _read(store: Store, signal: SignalRow, gaps: Sequence[GapRow]) -> Log:
    samples = store.samples(signal.store_path, [BODY_HEIGHT, LEG_LENGTH])
    return Log(samples["time"], samples[BODY_HEIGHT], samples.get(LEG_LENGTH), heeded_gaps(gaps))


def _found(key: str, signal: SignalRow, detection: Detection) -> Found:
    values, jumps = detection_rows(detection, signal.sha256)
    row = DetectionRow(
        uid=values["uid"],
        key=key,
        algorithm=detection.algorithm,
        version=detection.version,
        signal_uid=signal.uid,
        signal_sha256=signal.sha256,
        jumps=tuple(_jump_of(row, found.flags) for row, found in zip(jumps, detection.found.jumps, strict=True)),
    )
    return Found(NewDetection(signal.uid, values, jumps), row)


def _jump_of(row: Mapping[str, Any], flags: Sequence[str]) -> JumpRow:
    values = {name: row[name] for name in JumpRow.__slots__ if name in row and name != "gap_touched"}
    return JumpRow(**values, gap_touched=bool(row["gap_touched"]), flags=tuple(flags))
