"""Formats of others: Python packages with an entry point in the group `labbook.formats`.

An entry point is a `Format`, a list of them, or a function without arguments that returns either. What is wrong with
a plug-in is a sentence, and never keeps the other formats from being read.
"""

from __future__ import annotations

import functools
import importlib.metadata
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from data_schema.errors import InputRefused, UsageError
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.formats import FORMATS
from ingest.formats.format import Format, Recognition
from ingest.formats.head import Head
from ingest.model import Reading, SignalPart
from ingest.tables.second_header import SecondHeader

GROUP = "labbook.formats"


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
    formats: list[Format] = []
    faults: list[str] = []
    for entry in importlib.metadata.entry_points(group=GROUP):
        distribution = f"{entry.dist.name} {entry.dist.version}" if entry.dist else entry.name
        try:
            for format_ in _formats_of(entry.load()):
                taken = {known.name for known in (*FORMATS, *formats)}
                if format_.name in taken:
                    faults.append(
                        f"Plug-in {distribution} has a format {format_.name!r}, a name that is taken: rename it."
                    )
                else:
                    formats.append(replace(format_, plugin=distribution))
        except Exception as error:  # whatever somebody else's code does
            faults.append(
                f"Plug-in {distribution} cannot be loaded ({type(error).__name__}: {error}): update or uninstall it."
            )
    return Plugins(tuple(formats), tuple(faults))


def _formats_of(loaded: object) -> Iterator[Format]:
    if callable(loaded) and not isinstance(loaded, Format):
        loaded = loaded()
    for item in [loaded] if isinstance(loaded, Format) or not isinstance(loaded, Iterable) else loaded:
        if not isinstance(item, Format):
            raise TypeError(f"{GROUP} has to name a Format, a list of them, or a function that returns one")
        yield item


def recognition(format_: Format, head: Head, findings: FindingCollector) -> Recognition | None:
    """Return by what a format recognises a file; a plug-in that fails at it does not recognise it, which is noted."""
    if format_.plugin is None:
        return format_.recognise(head)
    try:
        found = format_.recognise(head)
        if found is None or isinstance(found, Recognition):
            return found
        raise TypeError(f"recognise gave {type(found).__name__}, no Recognition")
    except Exception as error:  # whatever somebody else's code does
        findings.add(NOTE, "plugin_failed", f"{_failed(format_, error)}; the file is read without it.")
        return None


def reading(format_: Format, head: Head, findings: FindingCollector) -> Reading:
    """Read a file; a plug-in that fails at it, or gives samples that cannot be, refuses the file."""
    if format_.plugin is None:
        return format_.read(head, findings)
    try:
        found = format_.read(head, findings)
        _check(found)
        return found
    except (InputRefused, UsageError, SecondHeader):
        raise
    except Exception as error:  # whatever somebody else's code does
        advice = "tell its author, or read the file as another format with `--format`."
        findings.add(FILE, "plugin_failed", f"{_failed(format_, error)}: {advice}")
        return Reading()


def _failed(format_: Format, error: Exception) -> str:
    return f"Format {format_.name!r} of plug-in {format_.plugin} failed ({type(error).__name__}: {error})"


def _check(found: Reading) -> None:
    """Raise `ValueError` for samples and charges that no book can store."""
    names = [part.part for part in found.parts]
    if len(set(names)) < len(names):
        raise ValueError(f"two parts have one name, of {', '.join(map(repr, names))}")
    for part in found.parts:
        _check_part(part)
    for charge in found.charges:
        amounts = (charge.charge_mah, charge.resolution_mah, charge.duration_s or 1.0, charge.end_voltage_v or 0.0)
        if not np.isfinite(amounts).all() or charge.charge_mah < 0 or charge.resolution_mah <= 0 or amounts[2] <= 0:
            raise ValueError(f"charge {charge.row_number} holds an amount that cannot be: {amounts}")


def _check_part(part: SignalPart) -> None:
    """Raise for samples of other lengths than their times, times that do not increase, and names that are no text."""
    names = [channel.name for channel in part.channels]
    units = [channel.unit or "" for channel in part.channels]
    texts = [part.part, *names, *units, *(channel.source_name for channel in part.channels)]
    if len(set(names)) < len(names) or not all(isinstance(text, str) for text in texts):
        raise ValueError(f"the names of part {part.part!r}, its channels and units are not one text each: {texts}")
    "".join(texts).encode()
    if not np.isfinite(part.time_s).all() or (np.diff(part.time_s) <= 0).any():
        raise ValueError(f"the times of part {part.part!r} do not increase")
    for channel in part.channels:
        if channel.values.dtype != np.float64 or channel.values.shape != part.time_s.shape:
            raise ValueError(f"channel {channel.name!r} is not one float64 a time")
