"""From a file's bytes to everything that is stored of it, before any lock is taken.

Reading, hashing and compressing release the interpreter, so the raw copy, the samples and the jump detection of one
file are made side by side. Files are on disk and synced before a row speaks of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from data_schema.errors import unknown_name
from ingest.model import ColumnDeclaration, Declarations, Limits, Profile, ReadFile, RobotFacts
from ingest.read import read_file
from ingest.store import Store
from labbook.analysis.detecting import Detection, detect_part
from labbook.config.model import ProfileSettings
from labbook.config.parsing import Configuration


@dataclass(frozen=True, slots=True)
class StoredPart:
    """Where the samples of one part lie, and the jumps found in them if it holds a body height."""

    sha256: str
    store_path: str
    detection: Detection | None


@dataclass(frozen=True, slots=True)
class PreparedImport:
    """One file read, and its copy and samples on disk; `parts` are in the order of `read.parts`."""

    sha256: str
    n_bytes: int
    read: ReadFile
    raw_path: str
    parts: tuple[StoredPart, ...]


def read_and_store(
    store: Store,
    data: bytes,
    sha256: str,
    configuration: Configuration,
    options: Mapping[str, Any],
    *,
    file_name: str | None = None,
    anew: bool = False,
) -> PreparedImport:
    """Read a file and keep its copy and samples; a refused file is read only, nothing is kept.

    `anew` writes samples that are there already once more, because a rebuild must not trust them.
    """
    read = read_file(data, declarations(configuration, options, file_name))
    if read.refused:
        return PreparedImport(sha256, len(data), read, "", ())
    with ThreadPoolExecutor(max_workers=2) as pool:
        raw = pool.submit(store.put_raw, data, sha256)
        kept = [pool.submit(store.put_signal, part, anew=anew) for part in read.parts]
        detections = [detect_part(part, configuration) for part in read.parts]
        parts = tuple(StoredPart(*done.result(), detection) for done, detection in zip(kept, detections, strict=True))
        return PreparedImport(sha256, len(data), read, raw.result(), parts)


def declarations(
    configuration: Configuration, options: Mapping[str, Any], file_name: str | None = None
) -> Declarations:
    """Say what is known beforehand about a file: the command line's `options` over the book's profiles.

    Raises `UsageError` for a profile asked for by a name that labbook.toml does not have.
    """
    given = dict(options)
    columns = {name: ColumnDeclaration(**column) for name, column in given.pop("columns", {}).items()}
    profiles = tuple(_profile(name, profile) for name, profile in configuration.profiles.items())
    named = given.get("profile")
    if named is not None and named not in configuration.profiles:
        raise unknown_name("profile of labbook.toml", named, configuration.profiles)
    robots = tuple(
        RobotFacts(robot.body_mass_kg + robot.foot_mass_kg, robot.leg_max_m) for robot in configuration.robots.values()
    )
    zone = configuration.study.time_zone
    limits = Limits(**configuration.files.limits)
    return Declarations(
        columns=columns,
        profiles=profiles,
        time_zone=zone,
        file_name=file_name,
        robots=robots,
        limits=limits,
        **given,
    )


def _profile(name: str, said: ProfileSettings) -> Profile:
    columns = {
        source: ColumnDeclaration(column.channel, column.unit, column.sign) for source, column in said.columns.items()
    }
    return Profile(name, said.recognise, said.files, columns=columns, **said.settings)
