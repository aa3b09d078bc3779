"""From a file's bytes to everything that is stored of it, before any database lock is taken.

Reading, hashing and compressing release the interpreter, so the raw copy, the samples and the jump detection of one
file are made side by side. Files are on disk and synced before a row refers to them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any, Self

import msgspec
import numpy as np

from data_schema.errors import BookDamaged, unknown_name
from data_schema.journal import canonical
from data_schema.queries.detections import DetectionRow
from data_schema.vocabulary import FileRole
from ingest.model import (
    ColumnDeclaration,
    Declarations,
    Finding,
    FloatArray,
    Limits,
    PackFacts,
    Profile,
    ReadFile,
    RobotFacts,
    SignalPart,
)
from ingest.read import read_file
from ingest.spool import row_blocks
from ingest.store import FileInStore, Store, raw_path
from labbook.analysis.outcomes.detection import (
    BODY_HEIGHT,
    FOUND,
    Detection,
    detect_part,
    detection_row,
    remember_other_detectors,
)
from labbook.config.model import ProfileSettings
from labbook.config.parsing import Configuration
from labbook.config.profiles import declared_channel

_ZERO = np.float64(0.0)


@dataclass(frozen=True, slots=True)
class ReadSettings:
    """All that a reading depends on beside the bytes and the readers: what is declared, and how jumps are found.

    `rest_length_m` is None where the book has no robot: then no jumps are found yet.
    """

    declared: Declarations
    detector: str
    rest_length_m: float | None

    def as_json(self) -> dict[str, Any]:
        """Return what the journal keeps."""
        kept: dict[str, Any] = msgspec.json.decode(msgspec.json.encode(self))
        return kept

    @classmethod
    def from_json(cls, record: Mapping[str, Any]) -> Self:
        """Return the settings that the journal keeps."""
        try:
            return msgspec.convert(record, cls)
        except msgspec.ValidationError as error:
            raise BookDamaged(
                f"the settings of a reading are not as labbook writes them ({error}): restore from a backup."
            ) from error


@dataclass(frozen=True, slots=True)
class PartJumps:
    """The jumps found in a part as they are stored, the signal's uid left blank, and where the body stands too high.

    `misfires` counts the stances after which no flight came.

    Without any jump, the 1st and the 99th percentile of the heights say how high the body was.
    """

    row: DetectionRow
    rest_length_m: float
    zero_m: float
    height_range_m: tuple[float, float] | None
    misfires: int


@dataclass(frozen=True, slots=True)
class StoredPart:
    """The stored samples of one part, and the jumps found in them if it holds a body height.

    `file_sha256` is that of the file of samples as it lies in the store, None where nobody verified it.
    `time_sha256` is the hash of its elapsed times: verdicts on jumps hold for all readings that have the same.
    `ranges` are the lowest and highest value of each channel, None of one without any.
    """

    sha256: str
    store_path: str
    file_sha256: str | None
    time_sha256: str
    ranges: tuple[tuple[float, float] | None, ...]
    detection: PartJumps | None


@dataclass(frozen=True, slots=True)
class PreparedImport:
    """One file read, and its copy and samples on disk; `parts` are in the order of `read.parts`.

    `settings` are those that were in force: of the profiles, the one that was used. `copy_sha256` is that of the raw
    copy as it lies in the store, compressed, None where nobody verified it.
    """

    sha256: str
    n_bytes: int
    read: ReadFile
    settings: ReadSettings
    parts: tuple[StoredPart, ...]
    copy_sha256: str | None = None


def as_read(done: PreparedImport) -> dict[str, Any]:
    """Return the journal's record of a reading: all that it depended on, and its outcome.

    Another reading can be made from the first and compared with the second.
    """
    read = done.read
    members = [row.member for row in read.charges]
    return {
        "reader": read.format,
        "reader_version": read.reader_version,
        "settings": done.settings.as_json(),
        "role": str(read.role or FileRole.LOG),
        "rows": {"read": read.rows_read, "kept": read.rows_kept, "rejected": read.rows_rejected},
        "plugin": read.plugin,
        "parts": [part.part for part in read.parts],
        "signals": [part.sha256 for part in done.parts],
        "times": [part.time_sha256 for part in done.parts],
        "charge_lines": [row.line for row in read.charges],
        "charge_numbers": list(range(1, len(members) + 1)),
        **({"charge_members": members} if any(members) else {}),
    }


def finding_values(finding: Finding) -> dict[str, Any]:
    """Return the columns of a finding's row."""
    return {
        "severity": str(finding.severity),
        "rule": finding.rule,
        "line": finding.line,
        "column_name": finding.column,
        "value": finding.value,
        "n": finding.count,
        "more_lines_json": canonical(list(finding.more_lines)),
        "message": finding.message,
    }


def without_values(read: ReadFile) -> ReadFile:
    """Return a file without its samples, which are in the store; its arrays have the same length and take no memory."""
    return replace(
        read, parts=tuple(_with_values(part, np.broadcast_to(_ZERO, part.time_s.shape)) for part in read.parts)
    )


def _with_values(part: SignalPart, values: FloatArray) -> SignalPart:
    channels = tuple(replace(channel, values=values) for channel in part.channels)
    return replace(part, time_s=values, channels=channels)


def without_name(settings: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the settings of a reading without the name that the file came under: that alone makes no other reading."""
    return {**settings, "declared": {**settings["declared"], "file_name": None}}


def times_sha256(time_s: FloatArray) -> str:
    """Return the SHA-256 of elapsed times in s, shape (n,)."""
    digest = hashlib.sha256()
    for rows in row_blocks(time_s):
        digest.update(np.ascontiguousarray(time_s[rows], dtype="<f8").data)
    return digest.hexdigest()


def store_reading(
    store: Store, data: bytes, sha256: str, read: ReadFile, settings: ReadSettings, *, anew: bool = False
) -> PreparedImport:
    """Store the copy and the samples of a file that was read, and find its jumps; of a refused file nothing is stored.

    With `anew`, samples that are there already are read back and compared, because a rebuild must not trust them; the
    bytes are those of the raw copy then. Without, what other detectors find is cached for the first report.
    """
    in_force = with_used_profile(settings, read)
    if read.refused:
        return PreparedImport(sha256, len(data), read, in_force, ())
    cached = not anew and FOUND.folder is not None  # made before threads make files
    with ThreadPoolExecutor(max_workers=2) as pool:
        raw = pool.submit(store.put_raw, data, sha256)
        stored_signals = [pool.submit(store.put_signal, part, anew=anew) for part in read.parts]
        found = [_detected(part, settings) for part in read.parts]
        pairs = zip(read.parts, stored_signals, found, strict=True)
        stored = tuple(_stored_part(part, *done.result(), jumps) for part, done, jumps in pairs)
        if cached:
            for part, of_part in zip(read.parts, stored, strict=True):
                remember_other_detectors(part, of_part.sha256, settings.detector, settings.rest_length_m)
        copy_sha256 = store.file_sha256(raw_path(sha256)) if anew else raw.result().file_sha256
        return PreparedImport(sha256, len(data), read, in_force, stored, copy_sha256)


def reread_stored(store: Store, data: bytes, sha256: str, settings: ReadSettings) -> PreparedImport:
    """Read a stored copy and do what `store_reading` does with `anew`, one thing after the other.

    For a process beside others that do the same: threads of its own would only wait for each other.
    """
    read = read_file(data, settings.declared)
    stored = tuple(
        _stored_part(part, *store.put_signal(part, anew=True), _detected(part, settings))
        for part in (() if read.refused else read.parts)
    )
    copy_sha256 = store.file_sha256(raw_path(sha256))
    return PreparedImport(sha256, len(data), read, with_used_profile(settings, read), stored, copy_sha256)


def without_storing(data: bytes, sha256: str, read: ReadFile, settings: ReadSettings) -> PreparedImport:
    """Return what `store_reading` does, and store nothing."""
    from ingest.store import signal_sha256

    parts = () if read.refused else read.parts
    stored = tuple(
        _stored_part(part, signal_sha256(part), FileInStore("", None), _detected(part, settings)) for part in parts
    )
    return PreparedImport(sha256, len(data), read, with_used_profile(settings, read), stored)


def _detected(part: SignalPart, settings: ReadSettings) -> Detection | None:
    return detect_part(part, settings.detector, settings.rest_length_m)


def _stored_part(part: SignalPart, sha256: str, file: FileInStore, found: Detection | None) -> StoredPart:
    jumps = None
    if found is not None:
        row, height_range_m = detection_row(found, sha256), None
        if not row.jumps:
            heights = next(channel.values for channel in part.channels if channel.name == BODY_HEIGHT)
            low_m, high_m = np.nanpercentile(heights, (1.0, 99.0))
            height_range_m = (float(low_m), float(high_m))
        misfires = sum(jump.misfired for jump in found.found.jumps)
        jumps = PartJumps(row, float(found.parameters["rest_length_m"]), found.found.zero_m, height_range_m, misfires)
    ranges = tuple(_range(channel.values) for channel in part.channels)
    return StoredPart(sha256, file.path, file.file_sha256, times_sha256(part.time_s), ranges, jumps)


def _range(values: FloatArray) -> tuple[float, float] | None:
    """Return the lowest and the highest of some values."""
    low, high = np.inf, -np.inf
    for rows in row_blocks(values):
        low = np.fmin.reduce(values[rows], initial=low)
        high = np.fmax.reduce(values[rows], initial=high)
    return (float(low), float(high)) if np.isfinite([low, high]).all() else None


def with_used_profile(settings: ReadSettings, read: ReadFile) -> ReadSettings:
    """Return the settings with no profile but the one that was used, and with no packs where none was charged."""
    used = tuple(profile for profile in settings.declared.profiles if _was_used(profile, read))
    packs = settings.declared.packs if read.role is FileRole.CHARGE else ()
    return replace(settings, declared=replace(settings.declared, profiles=used, packs=packs))


def _was_used(profile: Profile, read: ReadFile) -> bool:
    if read.profile is not None:
        return profile.name == read.profile
    messages = [finding.message for finding in read.findings if finding.rule == "profile_used"]
    return any(repr(profile.name) in message for message in messages)


def current_settings(
    configuration: Configuration, options: Mapping[str, Any], file_name: str | None = None
) -> ReadSettings:
    """Return how a file is read under a configuration: the command line's `options` over the book's profiles.

    Whose log it is may not be known yet: the first robot is taken. What is found is used for runs of a robot with that
    rest length only, for the key of a detection holds the length.
    """
    first = next(iter(configuration.robots.values()), None)
    return ReadSettings(
        declarations(configuration, options, file_name),
        configuration.protocol.detector,
        None if first is None else first.rest_length_m,
    )


def declarations(
    configuration: Configuration, options: Mapping[str, Any], file_name: str | None = None
) -> Declarations:
    """Return the declarations about a file: the command line's `options` over the book's profiles.

    Raises `UsageError` for a profile asked for by a name that labbook.toml does not have.
    """
    given = dict(options)
    columns = msgspec.convert(given.pop("columns", {}), dict[str, ColumnDeclaration])
    profiles = tuple(_profile(name, profile) for name, profile in configuration.profiles.items())
    named = given.get("profile")
    if named is not None and named not in configuration.profiles:
        raise unknown_name("profile of labbook.toml", named, configuration.profiles)
    robots = tuple(
        RobotFacts(robot.body_mass_kg + robot.foot_mass_kg, robot.leg_max_m) for robot in configuration.robots.values()
    )
    packs = tuple(PackFacts(name, pack.capacity_mah) for name, pack in configuration.batteries.items())
    zone = configuration.study.time_zone
    limits = Limits(**configuration.files.limits)
    return Declarations(
        columns=columns,
        profiles=profiles,
        time_zone=zone,
        file_name=file_name,
        robots=robots,
        packs=packs,
        limits=limits,
        **given,
    )


def _profile(name: str, settings: ProfileSettings) -> Profile:
    columns = {
        source: ColumnDeclaration(
            column.channel and declared_channel(column.channel), column.unit, column.sign, column.calibrations
        )
        for source, column in settings.columns.items()
    }
    return Profile(name, settings.recognise, settings.files, columns=columns, **settings.settings)
