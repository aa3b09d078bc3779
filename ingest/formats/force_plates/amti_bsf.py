"""AMTI NetForce binary files (.bsf), version 105: a header, a header for each plate, samples as doubles.

A header's own size is its first word; that of the file follows the version. What is inside is in pounds force and
inches, whatever unit NetForce showed. Plates have z down and give the force on themselves, as AMTI's manuals define it.
"""

from __future__ import annotations

import struct

import numpy as np

from ingest.formats.format import Format, Head
from ingest.instruments import Instrument
from ingest.model import FILE, FindingCollector, Reading
from ingest.signals import read_signals
from ingest.tables.table import Preamble, array_table

_VERSION = 105
_AFTER_VERSION = 4
_TRIAL_LENGTH_S, _RATE_HZ, _CHANNELS = 164, 212, 32
"""Where the trial length (double) and rate (int32) stand in the file, the channels (int32) in a plate's header."""

_SIZES = range(900, 4097)
_COMPONENTS = tuple(f"{quantity}_{axis}" for quantity in ("force", "moment") for axis in "xyz")
_INSTRUMENT = Instrument("force", "AMTI", frame="z down", action=True, evidence="AMTI")


def _recognise(head: Head) -> str | None:
    """A version and a header's size as NetForce writes them."""
    if head.source is not None or len(head.data) < 8:
        return None
    version, size = struct.unpack_from("<ii", head.data)
    known = version in (100, _VERSION) and size in _SIZES
    return f"a NetForce header of version {version}" if known else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    data = head.data
    version, size, n_plates = struct.unpack_from("<iii", data.ljust(12, b"\0"))
    if version != _VERSION:
        message = (
            f"The NetForce file has version {version} and only {_VERSION} is read: export it from NetForce as text."
        )
        findings.add(FILE, "bsf_version", message, value=str(version))
        return Reading()
    start, damage = _first_sample(data, size, n_plates)
    rate_hz = 0
    if not damage:
        (length_s,) = struct.unpack_from("<d", data, _TRIAL_LENGTH_S)
        (rate_hz,) = struct.unpack_from("<i", data, _RATE_HZ)
        damage = _size_differs(len(data) - start, 8 * len(_COMPONENTS) * n_plates, length_s, rate_hz)
    if damage:
        message = f"The NetForce file cannot be read: {damage}; copy it again, or export it from NetForce as text."
        findings.add(FILE, "bsf_damaged", message)
        return Reading()
    samples = np.frombuffer(data, "<f8", offset=start).reshape(-1, len(_COMPONENTS) * n_plates)
    names = [name if plate == 1 else f"{name}_{plate}" for plate in range(1, n_plates + 1) for name in _COMPONENTS]
    units = ["lbf" if name.startswith("force") else "lbf*in" for name in names]
    columns = [np.ascontiguousarray(column, dtype=np.float64) for column in samples.T]
    table = array_table(names, units, columns, Preamble(float(rate_hz), None, "the header"))
    return read_signals(table, head.declared, findings, _INSTRUMENT)


def _first_sample(data: bytes, size: int, n_plates: int) -> tuple[int, str]:
    """Return where the samples begin, and what is wrong with the headers before them, empty if nothing is."""
    at = _AFTER_VERSION + size
    if not 1 <= n_plates <= 16:
        return at, f"it says {n_plates} plates"
    for plate in range(1, n_plates + 1):
        if at + _CHANNELS + 4 > len(data):
            return at, f"it ends before the header of plate {plate}"
        (own,), (channels,) = struct.unpack_from("<i", data, at), struct.unpack_from("<i", data, at + _CHANNELS)
        if own not in _SIZES or channels != len(_COMPONENTS):
            return at, f"the header of plate {plate} says {own} bytes and {channels} channels, which should be 6"
        at += own
    return at, "" if at <= len(data) else "it ends inside its headers"


def _size_differs(there: int, row: int, length_s: float, rate_hz: int) -> str:
    if not (0 < rate_hz <= 100_000 and 0 < length_s < 1e6):
        return f"it says a rate of {rate_hz} Hz and a length of {length_s:g} s"
    samples = round(length_s * rate_hz)
    if there == samples * row:
        return ""
    return f"its header says {samples} samples ({length_s:g} s at {rate_hz} Hz) and it holds {there / row:.6g}"


FORMAT = Format("amti_bsf", 4, _recognise, _read, begins=rb"[di]\0\0\0")
