"""What a message advises, in backquotes, done as a person would: flags, keys of a profile, commands.

Flags go through the parser of `labbook ingest`, keys through that of labbook.toml, and the same bytes are read again.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import re
import shlex
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import msgspec
import pytest
import typer

from data_schema.errors import LabbookError
from data_schema.vocabulary import CHANNELS
from ingest import read as reading
from ingest.channels.names import TICKS_PER_SECOND, channel_kind, is_unit, parse_header
from ingest.declared import flag_names
from ingest.formats.format import Head
from ingest.model import ColumnDeclaration, ColumnUse, Declarations, Finding, ReadFile
from ingest.read import read_file
from labbook.cli.declaring import Declared
from labbook.cli.file_options import declared_options
from labbook.cli.main import application
from labbook.config.parsing import parse_configuration, template

_BOOK = template("advised", "Ada Nwosu")
_SNIPPET = re.compile(r"(`[^`]*`)")
_KEY = re.compile(r"[a-z_]+ = .+")
_FILES_TRIED, _LARGEST = 2, 300_000
"""Files on which each sentence of advice is tried, and their most bytes."""
_PLACEHOLDER = re.compile(r"\b(NAME|UNIT|CHANNEL|HZ|SCALE|OFFSET|YYYY-MM-DD)\b")
_NUMBERS = {"HZ": "200", "SCALE": "0.001", "OFFSET": "0", "YYYY-MM-DD": "2024-03-04"}
"""What may stand for placeholders of numbers and dates."""
_OF_TIME = re.compile(rf"=(?:time:)?(?:{'|'.join(TICKS_PER_SECOND)})\b")
_CHOICES = re.compile(r"UNIT[^(]{0,20}\((?:UNIT: )?(?:one of )?([^)]+)")

REFUSES_DECLARATIONS = {
    *("declared_column_absent", "unit_contradicts", "unit_not_convertible", "time_unit_unknown"),
    *("trial_column_absent", "rate_contradicts", "format_not_read"),
}
"""Rules by which a file is refused for what was declared of it."""
FASTEST_HZ = 5000.0
"""No file of the tests has a faster rate that it does not state."""
RATE_DOUBTED = {"rate_implausible", "mostly_missing"}
"""Rules by which a file is refused where the unit of its time is wrong."""
ROWS_LOST = {"no_rows_kept", "too_many_rejected", "thousands_separator"}
"""Rules by which it is refused where its rows cannot be read as declared."""
DECLARED_OR_HEADER = "unit_contradicts"
"""Of two units one is wrong, and the message cannot tell which: in the one declared no row may be possible."""


@dataclass
class Advice:
    """One way that a message names: flags, keys of a profile, flags that are to be left out.

    `conditional`: it is not the whole way, or only for some files, as in "where no number has decimals".
    """

    flags: list[str] = field(default_factory=list)
    keys: list[str] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    conditional: bool = False


def advice_of(message: str) -> list[Advice]:
    """Return the ways that a message names; what stands between two snippets says whether they go together."""
    found: list[Advice] = []
    between = ""
    pieces = _SNIPPET.split(message)
    for place, piece in enumerate(pieces):
        snippet = piece.strip("`")
        is_flags = snippet.startswith("--") and not _only_names(snippet)
        if place % 2 == 0 or not (is_flags or _KEY.fullmatch(snippet)):
            between += piece
            continue
        together = found and " and " in between and not re.search(r"\bor\b|;", between)
        if not together:
            found.append(Advice())
        left_out = is_flags and re.search(r"\bleave $", between) and pieces[place + 1].startswith(" out")
        (found[-1].left_out if left_out else found[-1].flags if is_flags else found[-1].keys).append(snippet)
        found[-1].conditional |= bool(re.search(r"\[profiles\.NAME\][^`]* and [^`]*$", between))
        found[-1].conditional |= re.match(r"( out)? where\b", pieces[place + 1]) is not None
        between = ""
    return found


def _only_names(snippet: str) -> bool:
    """Whether a snippet is the name of an option that takes a value, as in "say which holds with `--rate`"."""
    option = snippet.removeprefix("--").replace("-", "_")
    return any(one.name == option and one.default is not False for one in fields(Declared))


def command(*words: str) -> Any:
    """Return a command of labbook, or group of commands, by its words; None where there is no such command."""
    found: Any = application()
    for word in words:
        found = getattr(found, "commands", {}).get(word)
    return found


def faults_of_advice(data: bytes, declared: Declarations, finding: Finding, before: ReadFile) -> list[str]:
    """Return what is wrong with the ways that a finding names: one that is not accepted, or that changes nothing."""
    faults = []
    for advice in advice_of(finding.message):
        tried = [_faults(data, declared, finding, before, advice, choice) for choice in _choices(advice, finding)]
        faults += min(tried, key=len)
    return faults


def _choices(advice: Advice, finding: Finding) -> list[str | None]:
    """Return what may stand for UNIT by the message, as in "UNIT: one of s, ms", one of which has to do; [None] where
    it names none.
    """
    named = _CHOICES.search(finding.message) if "UNIT" in " ".join(advice.flags) else None
    units = re.findall(r"[^\s,]+", named[1].replace(" or ", " ")) if named else []
    return [unit for unit in units if is_unit(unit) or unit in TICKS_PER_SECOND] or [None]


def _faults(
    data: bytes, declared: Declarations, finding: Finding, before: ReadFile, advice: Advice, unit: str | None
) -> list[str]:
    """Return what is wrong with one way, `unit` standing for UNIT."""
    flags = " ".join(advice.flags)
    try:
        as_advised = _as_advised(advice, declared, finding, before, unit)
        if as_advised is None or advice.conditional or "DD" in flags or _cannot_be_judged(advice, finding, before):
            return []
        again = read_file(data, as_advised)
    except (LabbookError, typer.TyperException, ValueError) as error:
        return [f"{advice} is not accepted: {error}"]
    faults = []
    refused = _refused_now(before, again, finding, which_column_is_open="NAME" in flags)
    if refused is not None:
        faults.append(f"{advice} is refused: {refused.rule}: {refused.message}")
    rates_hz = [part.rate_hz or 0.0 for part in again.parts]
    if unit is None and before.refused and _OF_TIME.search(flags):
        doubted = RATE_DOUBTED & ({each.rule for each in again.findings} - {each.rule for each in before.findings})
        if doubted or max(rates_hz, default=0.0) > FASTEST_HZ:
            faults.append(f"{advice} gives {max(rates_hz, default=0.0):g} Hz {' '.join(doubted)}")
    left = [each for each in again.findings if _is_same(each, finding)]
    if left and "NAME" not in flags and _names(before).count(finding.column) < 2:
        faults.append(f"{advice} leaves the finding: {left[0].message}")
    return faults


def _cannot_be_judged(advice: Advice, finding: Finding, before: ReadFile) -> bool:
    """Whether something else is wrong with a file, its rows or a note in one refused, or other tables are meant, too:
    all have a rate, and a column of that place or number.
    """
    rules = {each.rule for each in before.findings}
    damaged = "too_many_rejected" in rules or (before.refused and finding.severity != "file")
    of_all_tables = re.search(r'--rate|--(?:column|unit) "?(?:\d+|[^"=]*#\d+)=', " ".join(advice.flags)) is not None
    return (damaged and finding.rule != "out_of_range") or (of_all_tables and len(before.explanation.tables) > 1)


def _refused_now(before: ReadFile, again: ReadFile, finding: Finding, *, which_column_is_open: bool) -> Finding | None:
    """Return what refuses a file for what was advised; None where nothing does that did not before."""
    fewer_rows = again.rows_rejected > before.rows_rejected and before.rows_read and not which_column_is_open
    rules = REFUSES_DECLARATIONS | (ROWS_LOST if fewer_rows else set())
    refused = [each for each in again.findings if each.severity == "file" and each.rule in rules]
    new = [each for each in refused if not any(_is_same(each, known) for known in before.findings)]
    return None if finding.rule == DECLARED_OR_HEADER else next(iter(new), None)


def _is_same(one: Finding, other: Finding) -> bool:
    return (one.rule, one.column, one.severity) == (other.rule, other.column, other.severity)


def _names(result: ReadFile) -> list[str | None]:
    return [column.name for table in result.explanation.tables for column in table.columns]


def _as_advised(
    advice: Advice, declared: Declarations, finding: Finding, before: ReadFile, unit: str | None
) -> Declarations | None:
    """Return what is declared after a person did what the message says, placeholders filled in; None where the file has
    no column that could stand for one.
    """
    filled = [_filled(flags, finding, before, unit) for flags in advice.flags]
    if None in filled:
        return None
    words = [word for flags in filled for word in shlex.split(flags or "")]
    given = command("ingest").make_context("ingest", ["FILE", *words]).params
    options = declared_options(Declared(**{one.name: given[one.name] for one in fields(Declared)}))
    own = {name: msgspec.convert(column, ColumnDeclaration) for name, column in options.pop("columns", {}).items()}
    for flag in advice.left_out:
        name = shlex.split(flag)[0].removeprefix("--").replace("-", "_")
        options[{"decimal": "decimal_sign", "rate": "rate_hz"}.get(name, name)] = None
    in_force = declared if before.declared is None or "profile" in options else before.declared
    settings = _profile(advice, finding) if advice.keys else {}
    columns, by_profile = {**in_force.columns, **own}, dict(in_force.profile_columns)
    for name, column in settings.pop("columns", {}).items():
        stated = columns if name in columns else by_profile
        stated[name] = dataclasses.replace(stated.get(name, column), sign=column.sign)
    return dataclasses.replace(in_force, **settings, **options, columns=columns, profile_columns=by_profile)


def _profile(advice: Advice, finding: Finding) -> dict[str, Any]:
    """Return the settings of a profile with the keys that are advised; `sign` is that of the finding's column."""
    lines = ["[profiles.advised]", 'files = "*"']
    for key in advice.keys:
        of_column = key.startswith("sign = ")
        lines.append(f"columns = {{ {json.dumps(finding.column)} = {{ {key} }} }}" if of_column else key)
    profile = parse_configuration("\n".join([_BOOK, *lines]), "labbook.toml").profiles["advised"]
    columns = {
        name: ColumnDeclaration(column.channel, column.unit, column.sign) for name, column in profile.columns.items()
    }
    return {**profile.settings, "columns": columns}


def _filled(flags: str, finding: Finding, before: ReadFile, choice: str | None) -> str | None:
    """Return flags with a column of the file for NAME, and a channel and unit, or the `choice`, that it can have."""
    if not _PLACEHOLDER.search(flags):
        return flags
    columns = [column for table in before.explanation.tables[:1] for column in table.columns]
    names = flag_names([column.name for column in columns])
    words = shlex.split(_PLACEHOLDER.sub(lambda found: _NUMBERS.get(found[0], found[0]), flags))
    for place, option in enumerate(words):
        if option not in ("--column", "--unit"):
            continue
        name, _, value = words[place + 1].rpartition("=")
        channel = value.partition(":")[0] if option == "--column" else ""
        if name == "NAME":
            others = [(flag, each) for flag, each in zip(names, columns, strict=True) if each.name != finding.column]
            free = [flag for flag, each in others if _may_be(each, channel)]
            if not free:
                return None
            name = free[0]
        column = next((column for column, flag in zip(columns, names, strict=True) if flag == name), None)
        unit = None if column is None else column.unit or parse_header(column.name).unit
        held = channel or (column and column.holds) or ""
        kind = channel_kind(held)
        unit = None if "--override-units" in words else unit
        fits = choice or unit or (CHANNELS[kind].unit if kind else _UNITS.get(held, "1"))
        value = value.replace("CHANNEL", _channel_in(unit))
        words[place + 1] = f"{name}={value.replace('UNIT', fits)}"
    return shlex.join(words)


_UNITS: Mapping[str, str] = {"time": "ms", "charge": "mAh", "duration": "min", "end_voltage": "V"}
"""Units in which quantities may be that are no channels."""


def _may_be(column: ColumnUse, channel: str) -> bool:
    """Whether a column may be what a message says some column is."""
    if channel in ("run", "pack"):
        return True
    unit = column.unit or parse_header(column.name).unit
    kind = channel_kind(channel)
    stored = CHANNELS[kind].unit if kind else _UNITS.get(channel)
    return column.left_out is None and column.holds != "time" and unit in (None, stored)


def _channel_in(unit: str | None) -> str:
    return next((name for name, channel in CHANNELS.items() if channel.unit == unit), "own.quantity")


class AdviceTaken:
    """Notes what is found of the files that are read in this process, and takes the advice in it."""

    def __init__(self) -> None:
        self._found: list[tuple[bytes, Declarations, ReadFile, Finding]] = []
        self._tried: Counter[object] = Counter()

    @contextlib.contextmanager
    def noting_files(self) -> Iterator[None]:
        """Note every file that is read, with what was declared of it: a few for each sentence of advice."""
        sniffed: list[tuple[bytes, Declarations]] = []
        sniff = reading.sniff

        def sniff_and_note(data: bytes, declared: Declarations, *others: Any) -> Head:
            sniffed.append((data, declared))
            return sniff(data, declared, *others)

        def read_and_note(*values: Any, **named: Any) -> ReadFile:
            result = ReadFile(*values, **named)
            self._note(*sniffed.pop(), result)
            return result

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(reading, "sniff", sniff_and_note)
            patch.setattr(reading, "ReadFile", read_and_note)
            yield

    def _note(self, data: bytes, declared: Declarations, result: ReadFile) -> None:
        for finding in result.findings:
            words = re.sub(r"'[^']*'|\"[^\"]*\"|[\d.]+", "", finding.message)
            key = result.format, finding.severity, finding.rule, words
            if "`" in finding.message and self._tried[key] < _FILES_TRIED and len(data) <= _LARGEST:
                self._tried[key] += 1
                self._found.append((data[:], declared, result, finding))

    def clear(self) -> None:
        """Forget what was found."""
        self._found.clear()

    def faults(self) -> list[str]:
        """Return what is wrong with the advice noted, each with its sentence."""
        found, self._found = self._found, []
        return [
            f"{finding.message}\n  {fault}"
            for data, declared, result, finding in found
            for fault in faults_of_advice(data, declared, finding, result)
        ]
