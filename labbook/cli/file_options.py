"""What a person declares about a file on the command line, or when asked for it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict
from datetime import date
from typing import Any

import typer

from data_schema.errors import UsageError, unknown_name
from data_schema.vocabulary import Severity
from ingest.channels.forces import AXES
from ingest.timebase.clock_formats import CLOCK_FORMATS, DATE_FORMATS
from labbook.actions.files.ingesting import FileOutcome
from labbook.config.profiles import calibration_in, check_unit, declared_channel, is_delimiter
from labbook.terminal import say

_ASKED_WORDS = {"date_unclear": ("dates", ("d/m/y", "m/d/y")), "clock_unclear": ("clock", ("m:s", "h:m"))}
"""What is asked for where a file leaves it open, by rule: the option, and the words it takes."""

_AS_GIVEN = ("format", "profile", "instrument", "override_units", "complete", "no_robot_check")
"""Options that the journal stores as they are written on the command line."""


def declared_options(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of `declaring` that were given, as the journal stores them.

    Raises `UsageError` for an option that has no meaning.
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
        if not is_delimiter(sign):
            raise UsageError(f"--delimiter {delimiter!r} cannot part cells: give one sign such as ; , | or tab.")
    if encoding is not None:
        try:
            "".encode(encoding)
        except LookupError:
            raise UsageError(f"--encoding {encoding!r} is not known: give for example cp1252 or utf-8.") from None
        options["encoding"] = encoding
    declared: dict[str, dict[str, Any]] = {}
    for text in given["column"] or ():
        name, column = _column(text)
        declared[name] = column
    for text in given["unit"] or ():
        name, unit = _pair("--unit", text, "COLUMN=UNIT")
        check_unit(unit, None)
        declared.setdefault(name, {"channel": None})["unit"] = unit
    if declared:
        options["columns"] = declared
    if given["day"] is not None:
        options["day"] = _day(given["day"])
    options |= declared_words(given["dates"], given["clock"], given["axes"])
    options |= {name: given[name] for name in _AS_GIVEN if given[name]}
    return options


def _day(text: str) -> str:
    try:
        return str(date.fromisoformat(text))
    except ValueError:
        raise UsageError(f"--day {text!r} is no date: write one such as 2024-03-04.") from None


def declared_words(dates: str | None, clock: str | None, axes: str | None) -> dict[str, Any]:
    """Return the declared order of dates, form of clock times and axes. Raises `UsageError` for unknown words."""
    declared = {}
    for name, given, allowed, what in (
        ("date_format", dates, DATE_FORMATS, "order of dates (--dates)"),
        ("clock_format", clock, CLOCK_FORMATS, "form of clock times (--clock)"),
        ("axes", axes, AXES, "frame (--axes)"),
    ):
        if given is not None:
            if given not in allowed:
                raise unknown_name(what, given, allowed)
            declared[name] = given
    return declared


def ask_for(outcome: FileOutcome, options: Mapping[str, Any]) -> dict[str, Any] | None:
    """Ask a person for what neither the file nor an option declares, and return the options with the answers.

    None where there is nothing to ask for.
    """
    if outcome.status != "refused" or outcome.read is None:
        return None
    declared = dict(options)
    for finding in outcome.read.findings:
        if finding.rule == "rate_missing":
            say(f"{outcome.name}: {finding.message}", err=True)
            declared["rate_hz"] = typer.prompt("samples a second", type=float, err=True)
        elif finding.rule == "time_unit_missing":
            say(f"{outcome.name}: {finding.message}", err=True)
            unit = typer.prompt(f"unit of {finding.column} (s, ms, us or ns)", err=True)
            column = {"channel": None, "unit": unit}
            declared["columns"] = {**declared.get("columns", {}), finding.column or "time": column}
        elif finding.rule in _ASKED_WORDS and finding.severity is Severity.FILE:
            say(f"{outcome.name}: {finding.message}", err=True)
            option, allowed = _ASKED_WORDS[finding.rule]
            answer = typer.prompt(" or ".join(allowed), err=True)
            declared |= declared_words(**{"dates": None, "clock": None, "axes": None, option: answer})
    return declared if declared != dict(options) else None


_COLUMN = re.compile(r"(.+?)=\s*([\w.]+)\s*(?::([^,]*))?((?:,\s*\w+\s*=[^,]*)*)")


def _column(text: str) -> tuple[str, dict[str, Any]]:
    """Return the column that `NAME=CHANNEL[:UNIT][,KEY=VALUE...]` names, and what it declares of it."""
    found = _COLUMN.fullmatch(text.strip())
    if found is None:
        name, channel = _pair("--column", text, "COLUMN=CHANNEL:UNIT")
        channel, unit, rest = *channel.partition(":")[::2], ""
    else:
        name, channel, unit, rest = found[1].strip(), found[2], (found[3] or "").strip(), found[4]
    channel = declared_channel(channel)
    if unit:
        check_unit(unit, channel)
    calibration = calibration_in(rest, f"--column {text!r}")
    if calibration is None:
        return name, {"channel": channel, "unit": unit or None}
    if not unit:
        example = f'--column "{name}={channel}:UNIT{rest}"'
        raise UsageError(f"--column {text!r} has a calibration without a unit: give that of its value, `{example}`.")
    return name, {"channel": channel, "unit": unit, "calibrations": [asdict(calibration)]}


def _pair(option: str, text: str, form: str) -> tuple[str, str]:
    name, equals, value = text.rpartition("=")
    if not equals or not name.strip() or not value.strip():
        raise UsageError(f'{option} {text!r} says nothing: write {option} "{form}".')
    return name.strip(), value.strip()
