"""Readings of files that are made once for all books that hold them."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import pytest

from ingest.formats import registry
from ingest.formats.format import Format
from ingest.model import Declarations, ReadFile, SignalPart
from ingest.read import read_file
from labbook.analysis.outcomes.detection import Detection, detect_part
from stats.apexes.detectors import DETECTORS, Detector

MOST = 512
"""So many are remembered: more than the files of any test."""
_READERS = (
    "labbook.actions.files.ingesting",
    "labbook.actions.files.rereading",
    "labbook.statements.importing",
    "labbook.statements.ingesting",
)


@dataclass(frozen=True, slots=True)
class _Asked:
    """All that a reading depends on."""

    data: bytes
    declared: Declarations = field(hash=False)
    formats: tuple[Format, ...] = field(hash=False)


@contextmanager
def read_once() -> Iterator[None]:
    """Let books have what was read of the same bytes under the same declarations before, and the jumps found in it.

    Samples cannot be written to, so that no book changes those of another.
    """

    @functools.lru_cache(MOST)
    def read(asked: _Asked) -> ReadFile:
        found = read_file(asked.data, asked.declared)
        for part in found.parts:
            for values in (part.time_s, *(channel.values for channel in part.channels)):
                values.flags.writeable = False
        return found

    @functools.lru_cache(MOST)
    def detected(part: SignalPart, algorithm: str, rest_length_m: float | None, _by: Detector) -> Detection | None:
        return detect_part(part, algorithm, rest_length_m)

    with pytest.MonkeyPatch.context() as patch:
        for module in _READERS:
            patch.setattr(
                f"{module}.read_file", lambda data, declared: read(_Asked(data, declared, registry.all_formats()))
            )
        patch.setattr(
            "labbook.statements.importing.detect_part",
            lambda part, algorithm, rest_length_m: detected(part, algorithm, rest_length_m, DETECTORS[algorithm]),
        )
        yield
