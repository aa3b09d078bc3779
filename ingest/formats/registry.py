"""All formats: labbook's own, a line each in `FORMATS`, and those of plug-ins; what each is, in words.

Some are recognised but not read: the refusal names the kind of file and what to export instead.

A plug-in is a Python package with an entry point in the group `labbook.formats`: a `Format`, a list of them, or a
function without arguments that returns either. What is wrong with a plug-in is a sentence, and never keeps the other
formats from being read.
"""

from __future__ import annotations

import contextlib
import functools
import importlib.metadata
import inspect
import re
import sys
import traceback
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from data_schema.errors import InputRefused, UsageError
from data_schema.vocabulary import FileRole
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.formats import archive, study_sheets, workbook
from ingest.formats.chargers import cheali, icharger, logview, logview_zero, sheet
from ingest.formats.chargers.sheet import AMOUNTS
from ingest.formats.force_plates import (
    amti,
    amti_bsf,
    bertec,
    c3d,
    cortex,
    forcedecks,
    kistler,
    opensim,
    pasco,
    qualisys,
    vicon,
)
from ingest.formats.format import SIGNATURE, UNKNOWN, Format, Head, NoText
from ingest.formats.loggers import debug_lines, delimited, labelled_values, labview, matlab, minitaur
from ingest.model import ChargeRow, Reading, SignalPart
from ingest.tables.layout import SecondHeader

_TEXT = "export its data as delimited text with a header, units and time"


def _refused(name: str, what: str, instead: str, begins: bytes) -> Format:
    """Return a format that is only named and refused; `begins` is a pattern of its first bytes."""

    def refuse(_head: Head, findings: FindingCollector) -> Reading:
        findings.add(FILE, "format_not_read", f"This is {what}, which is not read: {instead}.")
        return Reading()

    def recognise(head: Head) -> str | None:
        """Its first bytes or lines."""
        beginnings = (head.data[:_SIGNATURE_BYTES], head.first_line().encode())
        known = any(re.match(begins, each, re.DOTALL) for each in beginnings)
        return f"it begins as {what}" if known else None

    return Format(name, 1, recognise, refuse, f"{what[0].upper()}{what[1:]}: not read; {instead}.")


_SIGNATURE_BYTES = 64
RECOGNISED = (
    _refused("pdf", "a PDF document", "give the data it was made from", rb"%PDF-"),
    _refused("image", "an image", _TEXT, rb"\x89PNG|\xff\xd8\xff|GIF8|II\*\0|MM\0\*"),
    _refused("video", "a video", "keep it beside the book", rb".{4}ftyp"),
    _refused("hdf5", "an HDF5 file, as h5py, netCDF-4 and others write", _TEXT, rb"\x89HDF\r\n\x1a\n"),
    _refused(
        "run_sheet",
        "a run sheet",
        "state its runs with `labbook runs import FILE`",
        rb"run[,;\t]date[,;\t]position[,;\t]kind\b",
    ),
)
"""Formats whose readers refuse."""


FORMATS: tuple[Format, ...] = (
    *RECOGNISED,
    archive.ZIP,
    archive.GZIP,
    *workbook.FORMATS,
    matlab.FORMAT,
    icharger.FORMAT,
    icharger.SERIAL,
    cheali.FORMAT,
    logview.FORMAT,
    logview_zero.FORMAT,
    minitaur.FORMAT,
    debug_lines.FORMAT,
    labelled_values.FORMAT,
    labview.FORMAT,
    amti.FORMAT,
    amti_bsf.FORMAT,
    bertec.FORMAT,
    cortex.FORMAT,
    forcedecks.FORMAT,
    kistler.FORMAT,
    kistler.CHANNELS_FORMAT,
    opensim.FORMAT,
    pasco.FORMAT,
    qualisys.FORMAT,
    vicon.FORMAT,
    c3d.FORMAT,
    *study_sheets.FORMATS,
    sheet.FORMAT,
    delimited.FORMAT,
)


GROUP = "labbook.formats"

_FAILURES = (Exception, SystemExit)
"""Whatever somebody else's code may raise, but a Ctrl-C."""

_LONGEST_ERROR = 200


PLUGIN_FAILED = "plugin_failed"
"""The rule of a finding on a plug-in that raised something."""


@dataclass(frozen=True, slots=True)
class Plugins:
    """The formats of all plug-ins, and what is wrong with those that could not be loaded, a sentence each."""

    formats: tuple[Format, ...]
    faults: tuple[str, ...]


def all_formats() -> tuple[Format, ...]:
    """Return labbook's own formats and those of plug-ins."""
    return (*FORMATS, *plugins().formats)


@functools.cache
def plugins() -> Plugins:
    """Load all plug-ins, once."""
    formats: dict[str, Format] = {format_.name: format_ for format_ in FORMATS}
    faults: list[str] = []
    for distribution, entry in _entry_points(faults):
        try:
            for found in _formats_of(entry.load()):
                taken = formats.get(found.name)
                if taken is not None or found.name == UNKNOWN:
                    whose = f"plug-in {taken.plugin}" if taken is not None and taken.plugin else "labbook"
                    faults.append(
                        f"Plug-in {distribution} has a format {found.name!r}, a name of {whose}: rename it there."
                    )
                else:
                    formats[found.name] = replace(found, plugin=distribution)
        except _FAILURES as error:
            faults.append(_not_loaded(distribution, error))
    return Plugins(tuple(format_ for format_ in formats.values() if format_.plugin is not None), tuple(faults))


def _entry_points(faults: list[str]) -> Iterator[tuple[str, importlib.metadata.EntryPoint]]:
    """Yield name and version of a distribution and an entry point of its; a damaged one concerns itself only."""
    seen: set[tuple[str, str]] = set()
    for distribution in importlib.metadata.distributions():
        try:
            entries = [entry for entry in distribution.entry_points if entry.group == GROUP]
            name = f"{distribution.name} {distribution.version}" if entries else ""
            if entries and not (distribution.name and distribution.version):
                raise ValueError("its metadata lack its name or version")
        except _FAILURES as error:
            if GROUP in (distribution.read_text("entry_points.txt") or ""):
                faults.append(_not_loaded(str(getattr(distribution, "_path", "without a name")), error))
            continue
        for entry in entries:
            if (distribution.name, entry.name) not in seen:  # an older one may lie farther down the path
                seen.add((distribution.name, entry.name))
                yield name, entry


def _formats_of(loaded: object) -> Iterator[Format]:
    if callable(loaded) and not isinstance(loaded, Format):
        loaded = loaded()
    for item in [loaded] if isinstance(loaded, Format) or not isinstance(loaded, Iterable) else loaded:
        if not isinstance(item, Format):
            raise TypeError(f"{GROUP} has to name a Format, a list of them, or a function that returns one")
        check_format(item)
        yield item


def recognition(format_: Format, head: Head, findings: FindingCollector) -> str | None:
    """Return by what a format recognises a file; a plug-in that fails at it does not recognise it, which is noted."""
    if format_.plugin is None:
        with contextlib.suppress(NoText):
            return format_.recognise(head)
        return None
    try:
        found = format_.recognise(head)
        if found is not None and not isinstance(found, str):
            raise TypeError(f"what recognise gave is {type(found).__name__}, not its evidence in words or None")
        return found
    except _FAILURES as error:
        findings.add(NOTE, PLUGIN_FAILED, f"{_failed(format_, error)}; the file is read without it.")
        return None


def reading(format_: Format, head: Head, findings: FindingCollector) -> Reading:
    """Read a file; a plug-in that fails at it, or gives what cannot be stored, refuses the file."""
    if format_.plugin is None:
        try:
            return format_.read(head, findings)
        except NoText:
            findings.add(
                FILE, "no_text", f"The file is no text, as files of {format_.name} are: declare another format."
            )
            return Reading()
    own = FindingCollector()
    try:
        found = format_.read(head, own)
        check_reading(found, own)
    except (InputRefused, UsageError, SecondHeader):
        raise
    except _FAILURES as error:
        advice = "tell its author, or read the file as another format with `--format`."
        findings.add(FILE, PLUGIN_FAILED, f"{_failed(format_, error)}: {advice}")
        return Reading()
    findings.take_over(own)
    return found


def _not_loaded(distribution: str, error: BaseException) -> str:
    return f"Plug-in {distribution} cannot be loaded ({_error_text(error)}): update or uninstall it."


def _failed(format_: Format, error: BaseException) -> str:
    return f"Format {format_.name!r} of plug-in {format_.plugin} failed ({_error_text(error)})"


def _error_text(error: BaseException) -> str:
    """Return the kind of an error and its message, on one line."""
    return " ".join(traceback.format_exception_only(error)[-1].split())[:_LONGEST_ERROR]


_NAME = re.compile(r"[A-Za-z0-9][\w.-]{0,63}")
_LARGEST_VERSION = 10**6


def check_format(found: Format) -> None:
    """Raise `TypeError` or `ValueError` unless a format can be registered."""
    if not isinstance(found.name, str) or not _NAME.fullmatch(found.name):
        raise ValueError(f"its name {found.name!r} is not made of letters, digits and _")
    if not isinstance(found.version, int) or not 1 <= found.version <= _LARGEST_VERSION:
        raise ValueError(f"its version {found.version} is not from 1 to {_LARGEST_VERSION}")
    if not isinstance(found.score, int) or not 1 <= found.score <= SIGNATURE:
        raise ValueError(f"its score {found.score} is not from 1 to {SIGNATURE}, of a signature")
    if any(not clue or clue != clue.lower() or b"\0" in clue for clue in found.clues):
        raise ValueError("its clues are not in lower case, or empty, or hold a zero byte")
    for name in ("recognise", "read"):
        if not callable(getattr(found, name)):
            raise TypeError(f"its {name} is no function")


def check_reading(found: Reading, findings: FindingCollector) -> None:
    """Raise `TypeError` or `ValueError` unless a reading can be stored, or its findings refuse the file."""
    if not isinstance(found, Reading) or not all(isinstance(part, SignalPart) for part in found.parts):
        raise TypeError(f"it gave {type(found).__name__}, not a Reading with parts of signals")
    if not 0 <= found.rows_rejected <= found.rows_read:
        raise ValueError(f"{found.rows_rejected} of {found.rows_read} rows are rejected")
    if findings.refuse:
        return
    if not found.parts and not found.charges:
        raise ValueError("it gave neither samples nor recharges, and no finding that refuses the file")
    if not isinstance(found.role, FileRole):
        raise TypeError(f"the reading's role {found.role!r} is none")
    _check_different([part.part for part in found.parts], "parts")
    for part in found.parts:
        _check_part(part)
    for place, charge in enumerate(found.charges, start=1):
        if charge.row_number != place:
            raise ValueError(f"recharge {place} has row_number {charge.row_number}: they count from 1, in order")
        _check_charge(charge)


def _check_charge(charge: ChargeRow) -> None:
    where = f"recharge {charge.row_number}"
    if charge.resolution_mah <= 0:
        raise ValueError(f"resolution_mah of {where} is {charge.resolution_mah:g}, not above 0")
    if charge.duration_s == 0:
        raise ValueError(f"duration_s of {where} is 0: say None where it is not known")
    amounts = {"charge": charge.charge_mah, "duration": charge.duration_s, "end_voltage": charge.end_voltage_v}
    for role, value in amounts.items():
        amount = AMOUNTS[role]
        if value is not None and not amount.low <= value <= amount.high:
            limits = f"from {amount.low:g} to {amount.high:g}"
            raise ValueError(f"{role} of {where} is {value:g} {amount.unit}, not {limits}")
    _check_instant(charge.ended_utc)


def _check_part(part: SignalPart) -> None:
    where = f"part {part.part!r}"
    arrays = [part.time_s, *(channel.values for channel in part.channels)]
    if not all(isinstance(array, np.ndarray) and array.dtype == np.float64 and array.ndim == 1 for array in arrays):
        raise TypeError(f"{where} holds other than arrays of float64 in one dimension")
    if not part.time_s.size:
        raise ValueError(f"{where} has no sample")
    if not np.isfinite(part.time_s).all() or (np.diff(part.time_s) <= 0).any():
        raise ValueError(f"the times of {where} do not increase")
    if part.rate_hz is not None and not part.rate_hz > 0:
        raise ValueError(f"the rate of {where} is {part.rate_hz}")
    _check_instant(part.start_utc)
    _check_different([channel.name for channel in part.channels], f"channels of {where}")
    for channel in part.channels:
        if channel.values.shape != part.time_s.shape or np.isinf(channel.values).any():
            raise ValueError(f"channel {channel.name!r} of {where} is not one finite number or NaN for each time")
        if channel.sign not in (-1, 1):
            raise ValueError(f"the sign of channel {channel.name!r} is {channel.sign}")
    if any(gap.length_s <= 0 for gap in part.gaps):
        raise ValueError(f"a gap of {where} has no length")


def _check_instant(instant: str | None) -> None:
    if instant is not None and (datetime.fromisoformat(instant).tzinfo is None or not instant.endswith("Z")):
        raise ValueError(f"{instant!r} is no instant of ISO-8601 with Z")


def _check_different(names: Sequence[object], what: str) -> None:
    if len(set(names)) < len(names) or not all(isinstance(name, str) and name for name in names):
        raise ValueError(f"the names of the {what} are not all different, or one is empty")


@dataclass(frozen=True, slots=True)
class Described:
    """A format: `what` its files are, `evidence` by what one is recognised, `plugin` where it comes from."""

    name: str
    version: int
    what: str
    evidence: str
    plugin: str | None


def described_formats() -> tuple[Described, ...]:
    """Describe all formats, in the order of the registry; those without words of their own by their module's."""
    return tuple(
        Described(each.name, each.version, each.what or _of_module(each), _of_recognise(each), each.plugin)
        for each in all_formats()
    )


def _of_module(format_: Format) -> str:
    module = sys.modules.get(format_.read.__module__)
    return _first_sentence(inspect.getdoc(module) or "")


def _of_recognise(format_: Format) -> str:
    return _first_sentence(inspect.getdoc(format_.recognise) or "")


def _first_sentence(text: str) -> str:
    words = " ".join(text.partition("\n\n")[0].split())
    return words.partition(". ")[0].rstrip(".") + "." if words else ""
