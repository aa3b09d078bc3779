"""Finding the jumps of a log with the detector that the study's configuration names."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from data_schema.journal import canonical
from data_schema.queries.detections import JumpRow
from data_schema.queries.signals import GapRow
from data_schema.vocabulary import GapKind, Undefined
from ingest.model import Gap, SignalPart
from stats.apexes.detectors import DETECTORS, find_jumps
from stats.apexes.jumps import Jump, Jumps

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
    """What one detector found, the settings that it ran with, and the gaps it was told of."""

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
    channels = {channel.name: channel.values for channel in part.channels}
    if BODY_HEIGHT not in channels or rest_length_m is None:
        return None
    log = Log(part.time_s, channels[BODY_HEIGHT], channels.get(LEG_LENGTH), heeded_gaps(part.gaps))
    return detect(log, algorithm, rest_length_m)


def heeded_gaps(gaps: Iterable[Gap | GapRow]) -> tuple[tuple[float, float], ...]:
    """Return (start, length) in s of the gaps that a detector heeds, by their start."""
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


def detection_rows(detection: Detection, signal_sha256: str) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return the columns of a detection's row and of its jumps' rows."""
    key = detection_key(signal_sha256, detection.algorithm, detection.version, detection.parameters, detection.gaps)
    values = {
        "uid": key[:16],
        "key": key,
        "algorithm": detection.algorithm,
        "version": detection.version,
        "parameters_json": canonical(detection.parameters),
    }
    return values, [_jump_row(key, jump) for jump in detection.found.jumps]


def _jump_row(key: str, jump: Jump) -> dict[str, Any]:
    return {
        "uid": hashlib.sha256(f"{key}\n{jump.number}".encode()).hexdigest()[:12],
        "number": jump.number,
        "touchdown_s": _plain(jump.touchdown_s),
        "liftoff_s": _plain(jump.liftoff_s),
        "apex_s": _plain(jump.apex_s),
        "apex_height_m": _plain(jump.apex_height_m),
        "apex_height_se_m": _plain(jump.apex_height_se_m),
        "undefined_reason": jump.undefined_reason,
        "flight_time_s": _plain(jump.flight_time_s),
        "samples_used": jump.samples_used,
        "gap_touched": int(jump.gap_touched),
        "flags_json": canonical(list(jump.flags)),
    }


def _plain(value: float | Undefined) -> float | None:
    return None if isinstance(value, Undefined) else float(value)
