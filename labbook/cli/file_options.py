"""What a person declares about a file on the command line, or when asked for it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import typer

from data_schema.errors import UsageError
from data_schema.vocabulary import Severity
from labbook.actions.files.ingesting import FileOutcome
from labbook.cli.declaring import Declared
from labbook.config.local_time import date_named
from labbook.config.model import ProfileSettings
from labbook.config.parsing import check_profile
from labbook.config.profiles import check_unit, declared_column, name_and_value
from labbook.config.reading import read_model
from labbook.terminal import say

_ASKED_WORDS = {"date_unclear": ("dates", ("d/m/y", "m/d/y")), "clock_unclear": ("clock", ("m:s", "h:m"))}
"""What is asked for where a file leaves it open, by rule: the option, and the words it takes."""

_KEYS = {
    "rate": "rate_hz",
    "decimal": "decimal",
    "delimiter": "delimiter",
    "dates": "date",
    "clock": "clock",
    "axes": "axes",
}
"""The key of a profile that an option is."""

_AS_GIVEN = ("format", "profile", "instrument", "override_units", "complete", "no_robot_check")
"""Options that the journal stores as they are written on the command line."""


def declared_options(given: Declared) -> dict[str, Any]:
    """Return the options that were given, as the journal stores them.

    Raises `UsageError` for an option that has no meaning.
    """
    options = _as_profile({name: value for name in _KEYS if (value := getattr(given, name)) is not None})
    if given.encoding is not None:
        try:
            "".encode(given.encoding)
        except LookupError:
            raise UsageError(f"--encoding {given.encoding!r} is not known: give for example cp1252.") from None
        options["encoding"] = given.encoding
    declared: dict[str, dict[str, Any]] = {}
    for text in given.column or ():
        name, column = declared_column(text)
        declared[name] = column
    for text in given.unit or ():
        name, unit = name_and_value("--unit", text, "COLUMN=UNIT")
        check_unit(unit, None)
        declared.setdefault(name, {"channel": None})["unit"] = unit
    if declared:
        options["columns"] = declared
    if given.day is not None:
        options["day"] = date_named("--day", given.day)
    return options | {name: value for name in _AS_GIVEN if (value := getattr(given, name))}


def _as_profile(given: Mapping[str, Any]) -> dict[str, Any]:
    """Read options, by name, as the keys of a profile that they are."""
    faults: list[str] = []
    keys = {_KEYS[option]: "\t" if value == "tab" else value for option, value in given.items()}
    profile = read_model(ProfileSettings, {"files": "*", **keys}, faults)
    if profile is not None:
        faults += check_profile(profile, "")
    if profile is None or faults:
        key, _colon, sentence = faults[0].partition(": ")
        option = next(option for option, name in _KEYS.items() if name == key.strip("."))
        raise UsageError(f"--{option}: {sentence}")
    return profile.settings


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
            declared |= _as_profile({option: typer.prompt(" or ".join(allowed), err=True)})
    return declared if declared != dict(options) else None
