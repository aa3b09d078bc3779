"""Sheets of the thesis's studies (flasks, walks, trials of a leg's gains), and the logs that such a sheet names.

`labbook study` reads them with the functions here, and ingest does beforehand: what a study would refuse is refused
where it can still be measured again.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import InputRefused, UsageError, nearest
from data_schema.vocabulary import FileRole
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.formats.format import LAYOUT, Clue, Format, Head, Reader, Recognition
from ingest.model import Reading
from ingest.tables.long_table import LineRefused
from ingest.tables.study_sheet import Quantity, StudySheet, read_study_sheet, repeated
from ingest.text.cells import CANDIDATES, split_cells
from ingest.text.source import DEFAULT_PAGE, TextSource, open_text

Floats = NDArray[np.float64]

_LIGHTEST_KG = 0.02
"""Less than the lightest legged robots that were built carry, and kilograms below a column of grams."""
_FLASK = {
    "radius": Quantity("m", "inner radius of the spherical flask"),
    "water": Quantity("m^3", "water that filled the gaps"),
    "flask": Quantity("m^3", "volume of the flask", needed=False),
}
_WALK = {
    "mass": Quantity("kg", "robot's mass", least=_LIGHTEST_KG),
    "distance": Quantity("m", "distance walked"),
    "energy": Quantity("J", "energy taken from the battery", needed=False),
    "charge": Quantity("A*s", "charge put back", needed=False),
    "voltage": Quantity("V", "battery's voltage", needed=False),
}
_TRIAL = {
    "gain": Quantity("1", "position gain"),
    "damping_gain": Quantity("1", "velocity gain", any_sign=True),
    "mass": Quantity("kg", "mass that the leg carries", least=_LIGHTEST_KG),
    "neutral": Quantity("m", "leg's length without load", needed=False),
}
_OSCILLATION = {
    "time": Quantity("s", "time", any_sign=True),
    "position": Quantity("m", "leg's compression", any_sign=True),
    "velocity": Quantity("m/s", "rate of compression", any_sign=True),
}
_POWER = {
    "time": Quantity("s", "time", any_sign=True),
    "power": Quantity("W", "power taken from the battery", needed=False, any_sign=True),
    "current": Quantity("A", "battery's current", needed=False, any_sign=True),
    "voltage": Quantity("V", "battery's voltage", needed=False),
}
_WALKS_EXAMPLE = "walk,robot,mass_kg,distance_m,energy_Wh (or charge_mAh,voltage_V, or log)"
_POWER_EXAMPLE = "time_s,power_W (or current_A,voltage_V)"
_LONGEST_STEP, _LONGEST_SHARE = 10.0, 0.01
"""A gap of a power log that is refused: longer than so many usual steps, and than this share of the walk."""
_MOST_REPEATS = 5
_FULLEST = 0.95
"""A fraction that is refused: spheres of one size fill 0.7405 at most, the broadest mixtures of sizes some 0.9."""


@dataclass(frozen=True, slots=True)
class FlaskSheet:
    """Fillings of flasks, one a row: radii in m, volumes of flasks and water in m^3, states of the grains.

    `repeats` are as those of `StudySheet`: two fillings may give the same digits, or were pasted twice.
    """

    radii_m: Sequence[float]
    flasks_m3: Sequence[float]
    water_m3: Sequence[float]
    states: Sequence[str]
    lines: Sequence[int]
    repeats: Sequence[tuple[int, int]]

    def doubt(self) -> str | None:
        """Say which rows may have been pasted twice, None where all differ."""
        if not self.repeats:
            return None
        listed = ", ".join(f"line {line} those of line {first}" for first, line in self.repeats[:_MOST_REPEATS])
        more = len(self.repeats) - _MOST_REPEATS
        listed += f" and {more} more" if more > 0 else ""
        return f"Rows have the very cells of rows before ({listed}): each counts as a filling; drop what is a copy."


def read_flasks(text: str, file: str, decimal: str | None) -> FlaskSheet:
    """Read a sheet of flasks; without a column of their volumes they are spheres.

    Raises `InputRefused` as `read_study_sheet` does, for a third state, for more water than a flask holds, and for less
    than any grains leave room for.
    """
    sheet = read_study_sheet(text, file, _FLASK, ("state",), "radius_mm,state,water_ml (and flask_ml)", decimal)
    _refuse_third("state", sheet, file)
    radii_m, water_m3 = sheet.values["radius"], sheet.values["water"]
    flasks_m3 = sheet.values.get("flask", [4.0 / 3.0 * math.pi * radius_m**3 for radius_m in radii_m])
    for radius_m, flask_m3, water, line in zip(radii_m, flasks_m3, water_m3, sheet.lines, strict=True):
        if water > flask_m3:
            raise LineRefused(
                line,
                f"line {line} of {file} has more water than the flask of {radius_m * 1e3:g} mm holds "
                f"({water * 1e6:.4g} of {flask_m3 * 1e6:.4g} ml): check both.",
            )
        if water < (1.0 - _FULLEST) * flask_m3:
            raise LineRefused(
                line,
                f"line {line} of {file} leaves {water * 1e6:.4g} ml for water in a flask of {radius_m * 1e3:g} mm and "
                f"{flask_m3 * 1e6:.4g} ml, which no grains fill beyond {_FULLEST:g}: check the units of both.",
            )
    return FlaskSheet(radii_m, flasks_m3, water_m3, sheet.words["state"], sheet.lines, sheet.repeats)


@dataclass(frozen=True, slots=True)
class WalkSheet:
    """Robots on walks, one a row: masses in kg, distances in m, and energies in J or the logs that have them."""

    walks: Sequence[str]
    robots: Sequence[str]
    masses_kg: Sequence[float]
    distances_m: Sequence[float]
    energies_j: Sequence[float] | None
    logs: Sequence[str]
    lines: Sequence[int]

    def doubt(self) -> str | None:
        """Say where a robot is of more kg than it walked m, None where none is: their product would not show it."""
        for mass_kg, distance_m, line in zip(self.masses_kg, self.distances_m, self.lines, strict=True):
            if mass_kg > distance_m:
                return (
                    f"Line {line} has a robot of {mass_kg:g} kg walk {distance_m:g} m: are mass and distance swapped?"
                )
        return None


def read_walks(text: str, file: str, decimal: str | None) -> WalkSheet:
    """Read a sheet of walks, whose energies stand in it, or are charges times voltages, or come of logs.

    Raises `InputRefused` as `read_study_sheet` does, where it has energies in no way or in two, for a third robot, and
    for a robot that is twice on a walk or a log that is named twice.
    """
    words = ("walk", "robot")
    sheet = read_study_sheet(text, file, _WALK, words, _WALKS_EXAMPLE, decimal, optional_words=("log",))
    values, logs = sheet.values, sheet.words.get("log", ())
    sources = [
        name
        for name, there in (("energies", "energy" in values), ("charges", "charge" in values), ("logs", logs))
        if there
    ]
    if len(sources) > 1:
        raise InputRefused(f"{file} has {' and '.join(sources)}: keep the one that is meant.")
    energies_j = values.get("energy")
    if "charge" in values and "voltage" in values:
        energies_j = [charge * volts for charge, volts in zip(values["charge"], values["voltage"], strict=True)]
    if energies_j is None and not logs:
        raise InputRefused(
            f"{file} says no energies, nor charges and voltages, nor logs: name the columns as in {_WALKS_EXAMPLE}."
        )
    _refuse_third("robot", sheet, file)
    for first, line in repeated(zip(sheet.words["walk"], sheet.words["robot"], strict=True), sheet.lines):
        what = f"line {line} of {file} has the walk and the robot of line {first}"
        raise LineRefused(line, f"{what}: give each walk a name of its own, or drop the copy.")
    _refuse_log_twice(logs, sheet.lines, file)
    columns = (sheet.words["walk"], sheet.words["robot"], values["mass"], values["distance"])
    return WalkSheet(*columns, energies_j, logs, sheet.lines)


def _refuse_third(word: str, sheet: StudySheet, file: str) -> None:
    """Refuse a third word where two are compared, at the first line of the one that is written least often."""
    cells = sheet.words[word]
    counts = Counter(reversed(cells))  # of those as rare, the last to come in
    if len(counts) > 2:
        odd = min(counts, key=lambda cell: counts[cell])
        others = [cell for cell in dict.fromkeys(cells) if cell != odd]
        line, close = sheet.lines[cells.index(odd)], nearest(odd, others)
        hint = "keep a sheet for each two." if close is None else f"did you mean {close!r}?"
        raise LineRefused(
            line,
            f"line {line} of {file} has the {word} {odd!r} beside {', '.join(map(repr, others))}; compare two {word}s: "
            f"{hint}",
        )


def read_trials(text: str, file: str, decimal: str | None) -> StudySheet:
    """Read a sheet of trials: words `file`, values `gain`, `damping_gain`, `mass` in kg, perhaps `neutral` in m.

    Raises `InputRefused` as `read_study_sheet` does, and for a log that is named twice.
    """
    sheet = read_study_sheet(text, file, _TRIAL, ("file",), "file,gain,damping_gain,mass_kg,neutral_cm", decimal)
    _refuse_log_twice(sheet.words["file"], sheet.lines, file)
    return sheet


def _refuse_log_twice(logs: Sequence[str], lines: Sequence[int], file: str) -> None:
    """Refuse a log in two rows: what was recorded once would count twice."""
    for first, line in repeated(logs, lines) if logs else ():
        what = f"line {line} of {file} names the log of line {first} again"
        raise LineRefused(line, f"{what}: name the log that was recorded, or drop the copy.")


def read_oscillation(text: str, file: str, decimal: str | None) -> tuple[Floats, Floats, Floats]:
    """Read the log of a trial: times in s, displacements in m, velocities in m/s.

    Raises `InputRefused` as `read_study_sheet` does, and for times that do not rise.
    """
    log = read_study_sheet(text, file, _OSCILLATION, (), "time_ms,position_mm,velocity (m/s)", decimal)
    return _rising_s(log, file), np.array(log.values["position"]), np.array(log.values["velocity"])


def _rising_s(log: StudySheet, file: str) -> Floats:
    time_s = np.array(log.values["time"])
    still = np.flatnonzero(np.diff(time_s) <= 0.0)
    if time_s.size < 2 or still.size:
        line = log.lines[int(still[0]) + 1 if still.size else 0]
        what = f"the time of {file} does not rise from row to row (line {line})"
        raise LineRefused(line, f"{what}: give the log of one walk or trial as it was made.")
    return time_s


def read_power(text: str, file: str, decimal: str | None) -> tuple[Floats, Floats]:
    """Read the power log of a walk: times in s, and the power in W that is integrated by the trapezoidal rule.

    Raises `InputRefused` as `read_study_sheet` does, and for a log without power, in disorder, with a gap, or of no
    energy.
    """
    log = read_study_sheet(text, file, _POWER, (), _POWER_EXAMPLE, decimal)
    time_s = _rising_s(log, file)
    if "power" in log.values:
        power_w = np.array(log.values["power"])
    elif "current" in log.values and "voltage" in log.values:
        power_w = np.array(log.values["current"]) * np.array(log.values["voltage"])
    else:
        raise InputRefused(f"{file} has no power, nor current and voltage: name its columns as in {_POWER_EXAMPLE}.")
    steps_s = np.diff(time_s)
    place = int(steps_s.argmax())
    gap_s, whole_s = float(steps_s[place]), float(time_s[-1] - time_s[0])
    if gap_s > _LONGEST_STEP * np.median(steps_s) and gap_s > _LONGEST_SHARE * whole_s:
        raise LineRefused(
            log.lines[place],
            f"{file} has nothing for {gap_s:g} s from line {log.lines[place]} on, so that its energy would be a guess: "
            "give the walk's charge instead, or leave the walk out for both robots.",
        )
    energy_j = float(np.trapezoid(power_w, time_s))
    if energy_j <= 0.0:
        raise InputRefused(f"{file} says {energy_j:g} J were taken: turn the current's sign, taken is positive.")
    return time_s, power_w


STUDY_LOG, _TRIAL_LOG = "study_log", "log of a trial"
_COLUMNS: Mapping[str, tuple[str, ...]] = {
    "flask_sheet": ("radius", "state", "water"),
    "walk_sheet": ("walk", "robot", "mass", "distance"),
    "trial_sheet": ("file", "gain", "damping_gain", "mass"),
    STUDY_LOG: ("time",),
}
"""The columns that a header has, among others, each with its unit behind its name where it has one."""
_WHAT = {
    "flask_sheet": "Volume fractions of grains in flasks, a filling a row (`labbook study compaction`).",
    "walk_sheet": "What robots took on walks, a robot on a walk a row (`labbook study field`).",
    "trial_sheet": "Trials of a leg's gains, a log a row (`labbook study characterisation`).",
    STUDY_LOG: "Logs that a sheet of trials or walks names: oscillations, power; only where declared.",
}
_CLUES = {"flask_sheet": b"radius", "walk_sheet": b"walk", "trial_sheet": b"damping"}
_SEPARATOR = re.compile(rb'\s*"?sep=."?\s*', re.IGNORECASE)
"""A first line that spreadsheets write."""
_TITLE_LINES = 10


def may_be_cut(text: str, file: str) -> str | None:
    """Say that the last line of a sheet or log may be cut, as it has no line end; None where it has one."""
    if text.endswith(("\n", "\r")):
        return None
    return (
        f"The last line of {file} has no line end, so that it may be cut: end it, or say `--complete` if it is whole."
    )


def _header(source: TextSource | None, columns: tuple[str, ...]) -> tuple[int, bool] | None:
    """Return the number of the line that has the columns, and whether only blank ones stand above it."""
    if source is None:
        return None
    named = [re.compile(rf"{name.replace('_', '[_ ]')}([_ (\[].*)?") for name in columns]
    lines = [line for line in source.head_lines() if line.content.strip() and not _SEPARATOR.fullmatch(line.content)]
    for place, line in enumerate(lines[:_TITLE_LINES]):
        for delimiter in CANDIDATES[:-1]:  # blanks stand in names
            names = [source.decode(cell).lower() for cell in split_cells(line.content, delimiter) or ()]
            if all(any(name.fullmatch(cell) for cell in names) for name in named):
                return line.number, place == 0
    return None


_ROWS: Mapping[str, Callable[[str, str, str | None], tuple[int, str | None]]] = {
    "flask_sheet": lambda *asked: (len((sheet := read_flasks(*asked)).lines), sheet.doubt()),
    "walk_sheet": lambda *asked: (len((sheet := read_walks(*asked)).lines), sheet.doubt()),
    "trial_sheet": lambda *asked: (len(read_trials(*asked).lines), None),
    STUDY_LOG: lambda *asked: (len(read_power(*asked)[0]), None),
    _TRIAL_LOG: lambda *asked: (len(read_oscillation(*asked)[0]), None),
}
"""How many rows each has, read as the study does, and what is doubtful about them."""


_DOUBTS = {"flask_sheet": "rows_repeated", "walk_sheet": "columns_swapped"}


def _reader(name: str) -> Reader:
    def read(head: Head, findings: FindingCollector) -> Reading:
        header = _header(head.source, _COLUMNS[name])
        if head.source is None:
            findings.add(FILE, "sheet_refused", "The file is no text: save it as CSV in UTF-8.")
            return Reading()
        if header is not None and not header[1]:
            message = f"Line {header[0]} names the columns: take out the lines above it."
            findings.add(FILE, "header_not_first", message, lines=header[:1])
            return Reading(role=FileRole.SHEET)
        of_trial = name == STUDY_LOG and _header(head.source, ("position",)) is not None
        source = open_text(head.data, head.declared.encoding or DEFAULT_PAGE, FindingCollector())
        text, file = source.decode(source.data[source.start :]), head.declared.file_name or "the file"
        if not head.declared.complete and (unended := may_be_cut(text, file)) is not None:
            findings.add(FILE, "last_line_unended", unended)
        rows = _count(_TRIAL_LOG if of_trial else name, text, file, head.declared.decimal_sign, findings)
        return Reading(rows_read=rows, role=FileRole.SHEET)

    return read


def _count(name: str, text: str, file: str, decimal: str | None, findings: FindingCollector) -> int:
    """Count the rows of a sheet, or report what the study would refuse: a note where a decimal sign is all it lacks."""
    refused, lines = "", tuple[int, ...]()
    for sign in (decimal,) if decimal is not None else (None, ",", "."):
        try:
            rows, doubt = _ROWS[name](text, file, sign)
        except (InputRefused, UsageError) as error:
            if not refused:
                refused, lines = str(error), (error.line,) if isinstance(error, LineRefused) else ()
            continue
        if refused:
            findings.add(NOTE, "sheet_decimal_unclear", refused, lines=lines)
        if doubt is not None:
            findings.add(NOTE, _DOUBTS[name], doubt)
        return rows
    findings.add(FILE, "sheet_refused", refused, lines=lines)
    return 0


def _sheet(name: str) -> Format:
    def recognise(head: Head) -> Recognition | None:
        """A first line with the columns of a study's sheet."""
        if _header(head.source, _COLUMNS[name]) is None:
            return None
        return Recognition(LAYOUT, f"a header with the columns {', '.join(_COLUMNS[name])}")

    return Format(name, 3, recognise, _reader(name), _WHAT[name], clue=Clue(says=(_CLUES[name],)))


def _declared_only(_head: Head) -> Recognition | None:
    """Never by its content: a log of a robot's jumps may have the same columns."""
    return None


FORMATS = (
    *(_sheet(name) for name in _COLUMNS if name != STUDY_LOG),
    Format(
        STUDY_LOG,
        3,
        _declared_only,
        _reader(STUDY_LOG),
        _WHAT[STUDY_LOG],
        clue=Clue(instrument=STUDY_LOG),
    ),
)
