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
from ingest.formats import archive, study_sheets, workbook
from ingest.formats.chargers import cheali, icharger, logview, sheet
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
from ingest.formats.format import SIGNATURE, SIGNATURE_BYTES, UNKNOWN, Format, Head, NoText
from ingest.formats.loggers import debug_lines, delimited, labelled_values, labview, matlab, minitaur
from ingest.model import FILE, NOTE, ChargeRow, FindingCollector, Reading, SignalPart
from ingest.tables.layout import SecondHeader

_TEXT = "export its data as delimited text with a header, units and time"


def _refused(name: str, what: str, instead: str, begins: bytes) -> Format:
    """Return a format that is only named and refused; `begins` is a pattern of its first bytes."""

    def refuse(_head: Head, findings: FindingCollector) -> Reading:
        findings.add(FILE, "format_not_read", f"This is {what}, which is not read: {instead}.")
        return Reading()

    def recognise(head: Head) -> str | None:
        """Its first bytes or lines."""
        beginnings = (head.data[:SIGNATURE_BYTES], head.first_line().encode())
        known = any(re.match(begins, each, re.DOTALL) for each in beginnings)
        return f"it begins as {what}" if known else None

    return Format(name, 1, recognise, refuse, f"{what[0].upper()}{what[1:]}: not read; {instead}.")


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
    logview.ZERO,
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
    if format_.recognise is None:
        return None
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
_WITH_CAPITALS = re.compile(rb"\\.|\(\?P", re.DOTALL)
"""What a pattern may hold beside lower case."""
_IDLE_GROUP = re.compile(rb"(?<![\\\[])\((?!\?)[^|()\[\]]*\)(?![*+?{])")
_BACK_REFERENCE = re.compile(rb"\\[1-9]")


def check_format(found: Format) -> None:
    """Raise `ValueError` unless a format can be registered."""
    is_name = isinstance(found.name, str) and _NAME.fullmatch(found.name)
    _require(is_name, f"its name {found.name!r} is not made of letters, digits and _")
    is_version = isinstance(found.version, int) and 1 <= found.version <= _LARGEST_VERSION
    _require(is_version, f"its version {found.version} is not from 1 to {_LARGEST_VERSION}")
    is_score = isinstance(found.score, int) and 1 <= found.score <= SIGNATURE
    _require(is_score, f"its score {found.score} is not from 1 to {SIGNATURE}, of a signature")
    are_patterns = isinstance(found.begins, bytes) and isinstance(found.clues, tuple)
    _require(are_patterns, "its begins is not bytes, or its clues are no tuple of bytes")
    for clue in found.clues:
        _check_pattern("clue", clue)
        letters = _WITH_CAPITALS.sub(b"", clue)
        is_low = letters == letters.lower() and b"\0" not in clue
        _require(is_low, f"its clue {clue!r} is not in lower case, or holds a zero byte")
    if found.begins:
        _check_pattern("begins", found.begins)
    are_functions = callable(found.read) and (found.recognise is None or callable(found.recognise))
    _require(are_functions, "its read is no function, or its recognise neither one nor None")


def _check_pattern(what: str, pattern: bytes) -> None:
    """Raise `ValueError` unless it is a pattern of bytes that not every file fits, and no text as it is written."""
    _require(isinstance(pattern, bytes), f"its {what} {pattern!r} is not bytes")
    try:
        fits_all = re.search(pattern, b"", re.DOTALL) is not None
    except re.error as error:
        raise ValueError(f"its {what} {pattern!r} is no pattern ({error}): escape its signs") from error
    _require(not fits_all, f"its {what} {pattern!r} fits an empty file, and so any")
    groups_nothing = _IDLE_GROUP.search(pattern) and not _BACK_REFERENCE.search(pattern)
    _require(not groups_nothing, f"the brackets in its {what} {pattern!r} group nothing: write them as \\( and \\)")


def check_reading(found: Reading, findings: FindingCollector) -> None:
    """Raise `ValueError` unless a reading can be stored, or its findings refuse the file."""
    are_parts = isinstance(found, Reading) and all(isinstance(part, SignalPart) for part in found.parts)
    _require(are_parts, f"it gave {type(found).__name__}, not a Reading with parts of signals")
    rejected, read = found.rows_rejected, found.rows_read
    _require(0 <= rejected <= read, f"{rejected} of {read} rows are rejected")
    if findings.refuse:
        return
    _require(found.parts or found.charges, "it gave no samples, no recharges, and no finding that refuses the file")
    _require(isinstance(found.role, FileRole), f"the reading's role {found.role!r} is none")
    _require_different([part.part for part in found.parts], "parts")
    for part in found.parts:
        _check_part(part)
    for place, charge in enumerate(found.charges, start=1):
        _check_charge(place, charge)


def _require(condition: object, what: str) -> None:
    if not condition:
        raise ValueError(what)


def _require_different(names: Sequence[object], what: str) -> None:
    are_different = len(set(names)) == len(names) and all(isinstance(name, str) and name for name in names)
    _require(are_different, f"the names of the {what} are not all different, or one is empty")


def _require_instant(instant: str | None) -> None:
    is_instant = instant is None or (datetime.fromisoformat(instant).tzinfo is not None and instant.endswith("Z"))
    _require(is_instant, f"{instant!r} is no instant of ISO-8601 with Z")


def _check_charge(place: int, charge: ChargeRow) -> None:
    where = f"recharge {place}"
    _require(charge.row_number == place, f"{where} has row_number {charge.row_number}: they count from 1, in order")
    _require(charge.resolution_mah > 0, f"resolution_mah of {where} is not above 0")
    amounts = {"charge": charge.charge_mah, "duration": charge.duration_s, "end_voltage": charge.end_voltage_v}
    for role, value in amounts.items():
        amount = AMOUNTS[role]
        limits = f"from {amount.low:g} to {amount.high:g} {amount.unit}, or None"
        _require(value is None or amount.low <= value <= amount.high, f"{role} of {where} is {value}, not {limits}")
    _require_instant(charge.ended_utc)


def _check_part(part: SignalPart) -> None:
    where = f"part {part.part!r}"
    for array in (part.time_s, *(channel.values for channel in part.channels)):
        is_array = isinstance(array, np.ndarray) and array.dtype == np.float64 and array.shape == part.time_s.shape
        _require(is_array and array.ndim == 1, f"{where} holds other than an array of a float64 for each time")
    _require(part.time_s.size, f"{where} has no sample")
    rises = np.isfinite(part.time_s).all() and (np.diff(part.time_s) > 0).all()
    _require(rises, f"the times of {where} do not increase")
    _require(part.rate_hz is None or part.rate_hz > 0, f"the rate of {where} is {part.rate_hz}")
    _require_instant(part.start_utc)
    _require_different([channel.name for channel in part.channels], f"channels of {where}")
    for channel in part.channels:
        _require(not np.isinf(channel.values).any(), f"channel {channel.name!r} of {where} has an infinite value")
        _require(channel.sign in (-1, 1), f"the sign of channel {channel.name!r} is {channel.sign}")
    _require(all(gap.length_s > 0 for gap in part.gaps), f"a gap of {where} has no length")


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
    found = []
    for each in all_formats():
        module, recognise = sys.modules.get(each.read.__module__), each.recognise
        evidence = "Where declared alone." if recognise is None else _first_sentence(inspect.getdoc(recognise))
        what = each.what or _first_sentence(inspect.getdoc(module))
        found.append(Described(each.name, each.version, what, evidence, each.plugin))
    return tuple(found)


def _first_sentence(text: str | None) -> str:
    words = " ".join((text or "").partition("\n\n")[0].split())
    return words.partition(". ")[0].rstrip(".") + "." if words else ""
