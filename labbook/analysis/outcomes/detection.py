"""Finding the jumps of logs with the detector that the study's configuration names, now or before.

What the protocol's detector found in a log as it was ingested is in the book. What others find, or it after a change of
the protocol, is in a cache of files. The others look over a short log as it is ingested: every report sets them beside.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from data_schema.file_cache import FileCache
from data_schema.journal import canonical
from data_schema.queries.detections import DecisionRow, DetectionRow, JumpRow, detections_by_key
from data_schema.queries.facts import read_fact
from data_schema.queries.signals import GapRow, SignalRow, gaps_by_signal
from data_schema.vocabulary import GapKind, Undefined
from ingest.store import Store
from stats.apexes.detectors import DETECTORS, find_jumps, jump_at
from stats.apexes.jumps import Jump, Jumps

if TYPE_CHECKING:
    from ingest.model import Gap, SignalPart

BODY_HEIGHT = "body_height"
LEG_LENGTH = "leg_length"
SAMPLES_MISSING = (GapKind.DROPPED, GapKind.PAUSE, GapKind.REJECTED, GapKind.HELD)
"""The gaps that a detector heeds: a value that the sensor held is as little a measurement as none."""


@dataclass(frozen=True, slots=True)
class Log:
    """What a detector looks at: times in s, heights and leg lengths in m, gaps as (start, length) in s."""

    time_s: NDArray[np.float64]
    body_height_m: NDArray[np.float64]
    leg_length_m: NDArray[np.float64] | None
    gaps: tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Detection:
    """What one detector found, the settings that it ran with, and the gaps in the log that it was given."""

    algorithm: str
    version: int
    parameters: Mapping[str, Any]
    gaps: tuple[tuple[float, float], ...]
    found: Jumps


def detect(log: Log, algorithm: str, rest_length_m: float) -> Detection:
    """Run a detector of `stats.apexes.detectors.DETECTORS` on a log."""
    found = find_jumps(
        log.time_s,
        log.body_height_m,
        leg_length_m=log.leg_length_m,
        gaps=log.gaps,
        rest_length_m=rest_length_m,
        detector=algorithm,
    )
    return Detection(algorithm, version(algorithm), settings(algorithm, rest_length_m), log.gaps, found)


def jumps_found(jumps: Iterable[Jump | JumpRow]) -> int:
    """Count the flights with an apex, which are set beside the jumps made.

    A stance without one is no jump found: the last landing was not jumped from, and of a jump whose apex was lost, or
    that misfired, nothing can be measured.
    """
    return sum(jump.undefined_reason is None for jump in jumps)


def version(algorithm: str) -> int:
    """Return the version of a detector."""
    return DETECTORS[algorithm].version


def settings(algorithm: str, rest_length_m: float) -> dict[str, Any]:
    """Return everything that a detection depends on beside the log, its gaps and the algorithm's version."""
    return {"rest_length_m": rest_length_m, **asdict(DETECTORS[algorithm].parameters)}


def detect_part(part: SignalPart, algorithm: str, rest_length_m: float | None) -> Detection | None:
    """Find the jumps of a part just read, or None where it holds no body height or no robot's rest length is known."""
    log = _log_of(part)
    return None if log is None or rest_length_m is None else detect(log, algorithm, rest_length_m)


def _log_of(part: SignalPart) -> Log | None:
    channels = {channel.name: channel.values for channel in part.channels}
    if BODY_HEIGHT not in channels:
        return None
    return Log(part.time_s, channels[BODY_HEIGHT], channels.get(LEG_LENGTH), gaps_for_detector(part.gaps))


def gaps_for_detector(gaps: Iterable[Gap | GapRow]) -> tuple[tuple[float, float], ...]:
    """Return (start, length) in s of the gaps that a detector takes into account, by their start."""
    return tuple(sorted((float(gap.start_s), float(gap.length_s)) for gap in gaps if gap.kind in SAMPLES_MISSING))


def detection_key(
    signal_sha256: str,
    algorithm: str,
    version: int,
    parameters: Mapping[str, Any],
    gaps: Sequence[tuple[float, float]],
) -> str:
    """Name a detection after everything it depends on."""
    parts = [signal_sha256, algorithm, version, parameters, [list(gap) for gap in gaps]]
    return hashlib.sha256(canonical(parts).encode()).hexdigest()


def detection_row(detection: Detection, signal_sha256: str) -> DetectionRow:
    """Return what was found in a signal as it is stored."""
    key = detection_key(signal_sha256, detection.algorithm, detection.version, detection.parameters, detection.gaps)
    return DetectionRow(
        uid=key[:16],
        key=key,
        algorithm=detection.algorithm,
        version=detection.version,
        signal_sha256=signal_sha256,
        parameters_json=canonical(detection.parameters),
        jumps=tuple(_jump_row(key, jump) for jump in detection.found.jumps),
    )


def _jump_row(key: str, jump: Jump) -> JumpRow:
    return JumpRow(
        uid=hashlib.sha256(f"{key}\n{jump.number}".encode()).hexdigest()[:12],
        number=jump.number,
        touchdown_s=_plain(jump.touchdown_s),
        liftoff_s=_plain(jump.liftoff_s),
        apex_s=_plain(jump.apex_s),
        apex_height_m=_plain(jump.apex_height_m),
        apex_height_se_m=_plain(jump.apex_height_se_m),
        undefined_reason=jump.undefined_reason,
        flight_time_s=_plain(jump.flight_time_s),
        samples_used=jump.samples_used,
        gap_touched=bool(jump.gap_touched),
        flags=tuple(map(str, jump.flags)),
    )


PlacedApexes = Mapping[tuple[str, float], JumpRow]
"""The jumps that people see at a time, by the hash of a signal and that time."""


def placed_apex(log: Log, signal_sha256: str, at_s: float, rest_length_m: float) -> JumpRow:
    """Find the jump that a person sees at a time of a log; where there is none, the row says why and when it was said.

    Whatever the protocol's detector, the apex is that of the robust one's parabola about this time.
    """
    found = jump_at(
        log.time_s,
        log.body_height_m,
        at_s,
        rest_length_m=rest_length_m,
        leg_length_m=log.leg_length_m,
        gaps=log.gaps,
    )
    key = f"{signal_sha256}\n{at_s!r}"
    if isinstance(found, Undefined):
        uid = hashlib.sha256(f"{key}\n1".encode()).hexdigest()[:12]
        return JumpRow(uid, 1, None, None, at_s, None, None, found.reason, None, 0, False, ())
    return _jump_row(key, found)


def _plain(value: float | Undefined) -> float | None:
    return None if isinstance(value, Undefined) else float(value)


FOUND = FileCache(
    "jumps",
    (
        "stats/**/*.py",
        "labbook/analysis/outcomes/detection.py",
        "data_schema/*.py",
        "data_schema/queries/detections.py",
    ),
    ("numpy", "scipy"),
)
_MOST_BYTES = 2**30
"""Of found jumps: those of 100 000 runs."""


MOST_SAMPLES = 100_000
"""A longer log is looked over when a report asks for it: an ingest of it has little time and memory to spare."""


def remember_other_detectors(part: SignalPart, signal_sha256: str, algorithm: str, rest_length_m: float | None) -> None:
    """Put into the cache what the detectors but `algorithm` find in a part just read, while its samples are at hand."""
    log = _log_of(part)
    if log is None or rest_length_m is None or log.time_s.size > MOST_SAMPLES:
        return
    for other in DETECTORS.keys() - {algorithm}:
        key = detection_key(signal_sha256, other, version(other), settings(other, rest_length_m), log.gaps)
        if _found_before(key) is None:
            _found_now(key, signal_sha256, detect(log, other, rest_length_m))


def _found_before(key: str) -> DetectionRow | None:
    """Return what the cache has under a key."""
    cached = FOUND.read(key)
    return None if cached is None else msgspec.msgpack.decode(cached, type=DetectionRow)


def _found_now(key: str, signal_sha256: str, detection: Detection) -> DetectionRow:
    """Return what was found in a signal, which the cache has then, too."""
    found = detection_row(detection, signal_sha256)
    FOUND.write(key, msgspec.msgpack.encode(found))
    return found


LOGS_AT_ONCE = 2
"""Reading and most of detecting let other threads run; more would cost memory and gain little."""


@dataclass
class Detections:
    """Gives what a detector found in signals; what it gave is in `known`, for another way to judge the same jumps."""

    connection: sa.Connection
    store: Store
    progress: Callable[[str], None] = field(default=lambda _what: None)
    known: dict[str, DetectionRow] = field(default_factory=dict)
    _gaps: dict[str, tuple[GapRow, ...]] = field(default_factory=dict, init=False)
    _placed: dict[tuple[str, float, float], JumpRow] = field(default_factory=dict, init=False)
    _tidied: bool = field(default=False, init=False)

    def of(
        self, runs: Mapping[str, Sequence[SignalRow]], algorithm: str, rest_length_m: float
    ) -> dict[str, tuple[DetectionRow, ...]]:
        """Return the detections of each run's signals, in their order under the same names."""
        signals = {signal.uid: signal for several in runs.values() for signal in several}
        parameters = settings(algorithm, rest_length_m)
        gaps = self._gaps_of(signals)
        keys = {
            name: detection_key(row.sha256, algorithm, version(algorithm), parameters, gaps_for_detector(gaps[row.uid]))
            for name, row in signals.items()
        }
        self.known |= detections_by_key(self.connection, sorted(set(keys.values()) - self.known.keys()))
        missing = {keys[name]: row for name, row in signals.items() if keys[name] not in self.known}
        self._find(missing, gaps, algorithm, rest_length_m)
        found = {uid: self.known[key] for uid, key in keys.items()}
        return {name: tuple(found[signal.uid] for signal in several) for name, several in runs.items()}

    def placed(
        self, signals: Iterable[SignalRow], decisions: Mapping[str, Sequence[DecisionRow]], rest_length_m: float
    ) -> dict[tuple[str, float], JumpRow]:
        """Find the jumps at the times at which verdicts, by the hash of their signal, put an apex."""
        wanted = [
            (signal, at_s)
            for signal in signals
            for at_s in {said.at_s for said in decisions.get(signal.sha256, ()) if said.at_s is not None}
        ]
        gaps = self._gaps_of({signal.uid for signal, _at_s in wanted})
        found: dict[tuple[str, float], JumpRow] = {}
        for signal, at_s in wanted:
            key = signal.sha256, at_s, rest_length_m
            if key not in self._placed:
                self._placed[key] = self._place(signal, gaps[signal.uid], at_s, rest_length_m)
            found[signal.sha256, at_s] = self._placed[key]
        return found

    def _place(self, signal: SignalRow, gaps: Sequence[GapRow], at_s: float, rest_length_m: float) -> JumpRow:
        """Return the jump at a time of a log: as it was found before, for what people said is asked again and again."""
        where = {"at_s": at_s, "rest_length_m": rest_length_m}
        key = detection_key(signal.sha256, "placed", 1, where, gaps_for_detector(gaps))
        if (cached := FOUND.read(key)) is not None:
            return msgspec.msgpack.decode(cached, type=JumpRow)
        placed = placed_apex(_read(self.store, signal, gaps), signal.sha256, at_s, rest_length_m)
        FOUND.write(key, msgspec.msgpack.encode(placed))
        return placed

    def log(self, signal: SignalRow) -> Log:
        """Read a signal's samples."""
        return _read(self.store, signal, self._gaps_of([signal.uid])[signal.uid])

    def _gaps_of(self, signal_uids: Iterable[str]) -> Mapping[str, Sequence[GapRow]]:
        """Return the gaps of signals, and of others that were asked for before: those of a signal never change."""
        if unknown := sorted({*signal_uids} - self._gaps.keys()):
            self._gaps |= gaps_by_signal(self.connection, unknown)
        return self._gaps

    def _find(
        self,
        missing: Mapping[str, SignalRow],
        gaps: Mapping[str, Sequence[GapRow]],
        algorithm: str,
        rest_length_m: float,
    ) -> None:
        """Find the jumps of logs as they were found before, or side by side; this thread alone asks the database."""
        self.known |= {key: found for key in missing if (found := _found_before(key)) is not None}
        anew = {key: signal for key, signal in missing.items() if key not in self.known}
        if not anew:
            return

        def find(key: str, signal: SignalRow) -> DetectionRow:
            log = _read(self.store, signal, gaps[signal.uid])
            return _found_now(key, signal.sha256, detect(log, algorithm, rest_length_m))

        if not self._tidied:
            FOUND.forget_unused(_MOST_BYTES)  # makes the folder, too, before threads ask for it
            self._tidied = True
        with ThreadPoolExecutor(LOGS_AT_ONCE) as pool:
            made = pool.map(find, anew, anew.values())
            for (key, signal), detection in zip(anew.items(), made, strict=True):
                self.progress(f"finding jumps ({algorithm}) in {signal.run_name}")
                self.known[key] = detection


def rest_length_m(connection: sa.Connection, robot_uid: str) -> float:
    """Return the leg's rest length of a robot as the book has it."""
    return float(read_fact(connection, "robot", robot_uid, ["rest_length_m"])["rest_length_m"])


def _read(store: Store, signal: SignalRow, gaps: Sequence[GapRow]) -> Log:
    samples = store.samples(signal.store_path, [BODY_HEIGHT, LEG_LENGTH])
    return Log(samples["time"], samples[BODY_HEIGHT], samples.get(LEG_LENGTH), gaps_for_detector(gaps))
