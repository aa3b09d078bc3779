"""What was read of a file, in the user's cache folder: a replay of the journal then reads no file again.

A file of the cache is named after the bytes, the settings of the reading and the formats that were there. Arrays of
samples are not in it, which are in the store: only how long they are.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np

from data_schema.file_cache import FileCache
from ingest.formats.registry import PLUGIN_FAILED, all_formats
from labbook.statements.importing import PreparedImport

_MOST_BYTES = 2**30
"""The readings of 100 000 logs."""


_READ = FileCache(
    "readings",
    (
        "data_schema/**/*.py",
        "ingest/**/*.py",
        "stats/**/*.py",
        "labbook/analysis/outcomes/detection.py",
        "labbook/statements/importing.py",
        "labbook/statements/reading_cache.py",
    ),
    ("numpy", "scipy", "pyarrow", "python-calamine", "msgspec"),
)


def remember(done: PreparedImport, settings: Mapping[str, Any] | None = None) -> None:
    """Keep a reading, by the `settings` that were asked for, where another profile may have been used.

    What a plug-in had a part in is not kept: nobody knows its sources.
    """
    if done.read.plugin is None and all(finding.rule != PLUGIN_FAILED for finding in done.read.findings):
        _READ.write(_name(done.sha256, settings or done.settings.as_json()), pack(done))


def remembered(sha256: str, settings: Mapping[str, Any]) -> PreparedImport | None:
    """Return how this version read these bytes with the settings in an entry, None where that is not known."""
    data = _READ.read(_name(sha256, settings))
    return None if data is None else unpack(data)


def pack(done: PreparedImport) -> bytes:
    """Return a reading as bytes, without samples."""
    return _ENCODER.encode(done)


def unpack(data: bytes) -> PreparedImport:
    """Return a reading from what `pack` gave."""
    return _DECODER.decode(data)


def forget_unused() -> None:
    """Remove what was not used for the longest time; makes the folder of the cache, where it is missing."""
    _READ.forget_unused(_MOST_BYTES)


def _name(sha256: str, settings: Mapping[str, Any]) -> str:
    formats = [[each.name, each.version, each.plugin] for each in all_formats()]
    return hashlib.sha256(_SORTED.encode([sha256, settings, formats])).hexdigest()


def _plain(value: Any) -> Any:
    """Write an array as its length, and a number of numpy as it is."""
    return len(value) if isinstance(value, np.ndarray) else value.item()


def _without_values(_type: type, length: int) -> np.ndarray:
    """Return an array of that length which takes no memory."""
    return np.ndarray((length,), np.float64, _ZERO, strides=(0,))


_ZERO = bytes(8)
_SORTED = msgspec.json.Encoder(order="sorted")
_ENCODER = msgspec.msgpack.Encoder(enc_hook=_plain)
_DECODER = msgspec.msgpack.Decoder(PreparedImport, dec_hook=_without_values)
