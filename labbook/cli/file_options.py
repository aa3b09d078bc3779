"""What a person declares about a file on the command line, or when asked for it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import typer

from data_schema.errors import UsageError, unknown_name
from data_schema.vocabulary import Severity
from ingest.channels.forces import AXES
from ingest.timebase.clock_formats import CLOCK_FORMATS, DATE_FORMATS
from labbook.actions.files.ingesting import FileOutcome
from labbook.config.profiles import can_part_cells, channel_meant, check_unit
from labbook.terminal import say

_ASKED_WORDS = {"date_unclear": ("dates", ("d/m/y", "m/d/y")), "clock_unclear": ("clock", ("m:s", "h:m"))}
"""What is asked for where a file leaves it open, by rule: the option, and the words it takes."""

_AS_GIVEN = ("format", "profile", "instrument", "override_units", "complete", "no_robot_check")
"""Options that the journal keeps in the words of the command line."""


def declared_options(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of `declaring` as the journal keeps them: only what was said.

    Raises `UsageError` for what has no meaning.
    """
    options: dict[str, Any] = {}
    rate_hz, decimal_sign = given["rate"], given["decimal"]
    delimiter, encoding = given["delimiter"], given["encoding"]
    if rate_hz is not None:
        if not 0 < rate_hz < 1e7:
            raise UsageError(f"--rate {rate_hz:g} is no sampling rate: give samples a second, for example 300.")
        options["rate_hz"] = rate_hz
    if decimal_sign is not None:
        if decimal_sign not in (".", ","):
            raise UsageError(f"--decimal {decimal_sign!r} is no decimal sign: give . or ,")
        options["decimal_sign"] = decimal_sign
    if delimiter is not None:
        options["delimiter"] = sign = "\t" if delimiter == "tab" else delimiter
        if not can_part_cells(sign):
            raise UsageError(f"--delimiter {delimiter!r} cannot part cells: give one sign such as ; , | or tab.")
    if encoding is not None:
        try:
            "".encode(encoding)
        except LookupError:
            raise UsageError(f"--encoding {encoding!r} is not known: give for example cp1252 or utf-8.") from None
        options["encoding"] = encoding
    declared: dict[str, dict[str, Any]] = {}
    for text in given["column"] or ():
        name, channel = _pair("--column", text, "h=body_height:mm")
        channel, _colon, unit = channel.partition(":")
        channel = channel_meant(channel)
        if unit:
            check_unit(unit, channel)
        declared[name] = {"channel": channel, "unit": unit or None}
    for text in given["unit"] or ():
        name, unit = _pair("--unit", text, "time=ms")
        check_unit(unit, None)
        declared.setdefault(name, {"channel": None})["unit"] = unit
    if declared:
        options["columns"] = declared
    options |= declared_words(given["dates"], given["clock"], given["axes"])
    options |= {name: given[name] for name in _AS_GIVEN if given[name]}
    return options


def declared_words(dates: str | None, clock: str | None, axes: str | None) -> dict[str, Any]:
    """Return what was said of dates, clock times and axes. Raises `UsageError` for words that are not known."""
    said = {}
    for name, given, allowed, what in (
        ("date_format", dates, DATE_FORMATS, "order of dates (--dates)"),
        ("clock_format", clock, CLOCK_FORMATS, "form of clock times (--clock)"),
        ("axes", axes, AXES, "frame (--axes)"),
    ):
        if given is not None:
            if given not in allowed:
                raise unknown_name(what, given, allowed)
            said[name] = given
    return said


def ask_for(outcome: FileOutcome, options: Mapping[str, Any]) -> dict[str, Any] | None:
    """Ask a person for what the file does not say and nobody declared; None where nothing can be asked for."""
    if outcome.status != "refused" or outcome.read is None:
        return None
    said = dict(options)
    for finding in outcome.read.findings:
        if finding.rule == "rate_missing":
            say(f"{outcome.path}: {finding.message}", err=True)
            said["rate_hz"] = typer.prompt("samples a second", type=float, err=True)
        elif finding.rule == "time_unit_missing":
            say(f"{outcome.path}: {finding.message}", err=True)
            unit = typer.prompt(f"unit of {finding.column} (s, ms or us)", err=True)
            column = {"channel": None, "unit": unit}
            said["columns"] = {**said.get("columns", {}), finding.column or "time": column}
        elif finding.rule in _ASKED_WORDS and finding.severity is Severity.FILE:
            say(f"{outcome.path}: {finding.message}", err=True)
            option, allowed = _ASKED_WORDS[finding.rule]
            answer = typer.prompt(" or ".join(allowed), err=True)
            said |= declared_words(**{"dates": None, "clock": None, "axes": None, option: answer})
    return said if said != dict(options) else None


def _pair(option: str, text: str, example: str) -> tuple[str, str]:
    name, equals, value = text.rpartition("=")
    if not equals or not name.strip() or not value.strip():
        raise UsageError(f'{option} {text!r} says nothing: write for example {option} "{example}".')
    return name.strip(), value.strip()
