"""Sheets of the thesis's studies (flasks, walks, trials of a leg's gains), and the logs that such a sheet names.

`labbook study` reads them with the functions here, and ingest does beforehand: what a study would refuse is refused
where it can still be measured again. Columns are quantities with units in their names, and words.
"""

from __future__ import annotations

import contextlib
import dataclasses
import math
import re
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from data_schema.errors import InputRefused, UsageError, nearest
from data_schema.units import conversion
from data_schema.vocabulary import FileRole
from ingest.formats.format import LAYOUT, Format, Head
from ingest.model import FILE, NOTE, FindingCollector, FloatArray, Reading
from ingest.tables.sheet import (
    Sheet,
    SheetFault,
    SheetFile,
    SheetRefused,
    decimal_sign,
    head_rows,
    numbers_of,
    read_sheet,
)
from ingest.text import TextSource

_SPELLINGS = {"m3": "m^3", "cm3": "cm^3", "mm3": "mm^3", "wh": "Wh", "kwh": "kWh", "mah": "mAh", "ah": "Ah"}
_SPELLINGS |= {"a": "A", "v": "V", "w": "W", "j": "J", "n": "N"}
"""Units as people write them in a header, in any case; `energy_j` is no year and `voltage_v` no volume."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity of a sheet: the unit that it is turned into, and what it is, for who has not named a column so.

    One of unit "1" has no unit in its name. `any_sign`: it may be 0 or negative. Below `least` it is of another unit.
    """

    unit: str
    meaning: str
    needed: bool = True
    any_sign: bool = False
    least: float = 0.0


@dataclass(frozen=True, slots=True)
class StudySheet:
    """What a sheet holds: by quantity its values in SI units, by word its cells; all as long as the sheet has rows.

    A word in other letters (upper case) is the one that came first. `lines` are the rows' in the file, `doubt` is a
    sentence about what may be a slip.
    """

    values: Mapping[str, Sequence[float]]
    words: Mapping[str, Sequence[str]]
    lines: Sequence[int]
    doubt: str | None = None


def _read_study_sheet(
    file: SheetFile,
    quantities: Mapping[str, Quantity],
    words: Sequence[str],
    example: str,
    optional_words: Sequence[str] = (),
) -> tuple[StudySheet, Sheet]:
    """Read a sheet whose columns are named as `radius_mm` or `water (ml)`, and `state`; upper case is the same.

    Of the `optional_words`, those are read that the sheet has a column of.

    Raises `InputRefused` for columns that are missing, units of something else, and all cells that hold no positive
    number or no word.
    """
    sheet = read_sheet(file, f"a header such as {example} and a row for each")
    named = re.compile(
        rf"({'|'.join(quantities)})(?:[ _]volume)?(?:[_ ]([a-z0-9^*/]+)|\s*[(\[]([^)\]]+)[)\]])", re.IGNORECASE
    )
    columns: dict[str, tuple[str, float]] = {}
    for column in sheet.columns:
        if (name := column.lower().replace(" ", "_")) in quantities and quantities[name].unit == "1":
            columns[name] = column, 1.0
        elif matched := named.fullmatch(column):
            name = matched[1].lower()
            factor = _factor(matched[2] or matched[3], quantities[name].unit)
            if name in columns:
                what = f"columns {columns[name][0]!r} and {column!r} both are {name}: keep one."
                raise sheet.fault(sheet.header_line, None, what)
            if factor is None:
                what = f"it is in no unit of the {quantities[name].meaning}: name the columns as in {example}."
                raise sheet.fault(sheet.header_line, column, what)
            columns[name] = column, factor
    there = {column.lower(): column for column in sheet.columns}
    for name, quantity in quantities.items():
        if quantity.needed and name not in columns:
            with_unit = "" if quantity.unit == "1" else " with its unit"
            what = f"no column is the {quantity.meaning}{with_unit}: name the columns as in {example}."
            raise sheet.fault(sheet.header_line, None, what)
    for word in words:
        if word not in there:
            what = f"no column is {word!r}: name the columns as in {example}."
            raise sheet.fault(sheet.header_line, None, what)
    sign = decimal_sign(sheet, [column for column, _ in columns.values()])
    faults: list[SheetFault] = []
    values = {
        name: _values(sheet, column, factor, quantities[name], sign, faults)
        for name, (column, factor) in columns.items()
    }
    read = [*words, *(word for word in optional_words if word in there)]
    cells = {word: _words(sheet, there[word], faults) for word in read}
    sheet.refuse(faults)
    return StudySheet(values, cells, sheet.lines), sheet


def _factor(unit: str, target: str) -> float | None:
    """Return what a value in `unit` is multiplied with, None where the unit is of something else."""
    spelt = _SPELLINGS.get(unit.lower(), unit)
    for spelling in (spelt, spelt.lower()):  # MM, Kg
        with contextlib.suppress(InputRefused):
            return conversion(spelling, target)[0]
    return None


def _values(
    sheet: Sheet, column: str, factor: float, quantity: Quantity, sign: str, faults: list[SheetFault]
) -> list[float]:
    found = []
    for number, line in zip(numbers_of(sheet, column, "the study", sign), sheet.lines, strict=True):
        value = math.nan if number is None else number * factor
        if number is None or (number <= 0 and not quantity.any_sign):
            kind = "" if quantity.any_sign else "positive "
            faults.append(SheetFault(line, column, f"the row has no {kind}{column}: measure it, or drop the row."))
        elif value < quantity.least and not quantity.any_sign:
            what = f"{number:g} is less than {quantity.least:g} {quantity.unit}: check the unit of the "
            faults.append(SheetFault(line, column, f"{what}{quantity.meaning}."))
        found.append(value)
    return found


def _words(sheet: Sheet, column: str, faults: list[SheetFault]) -> tuple[str, ...]:
    cells = sheet.columns[column]
    blank = f"the row has no {column}: write it, or drop the row."
    faults += [SheetFault(line, column, blank) for cell, line in zip(cells, sheet.lines, strict=True) if not cell]
    first = {cell.casefold(): cell for cell in reversed(cells)}
    return tuple(first[cell.casefold()] for cell in cells)


def _repeated(keys: Iterable[Hashable], lines: Sequence[int]) -> list[tuple[int, int]]:
    """Return the lines of keys that came before: the first line of each such key, and that of its repeat."""
    first: dict[Hashable, int] = {}
    found = [(first.setdefault(key, line), line) for key, line in zip(keys, lines, strict=True)]
    return [pair for pair in found if pair[0] != pair[1]]


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


def read_flasks(file: SheetFile) -> StudySheet:
    """Read a sheet of flasks: values `radius` in m, `flask` and `water` in m^3, words `state`.

    Without a column of their volumes flasks are spheres. Two fillings may give the same digits, or were pasted twice,
    which is the `doubt`. Raises `InputRefused` as every sheet does, for a third state, for more water than a flask
    holds, and for less than any grains leave room for.
    """
    found, sheet = _read_study_sheet(file, _FLASK, ("state",), "radius_mm,state,water_ml (and flask_ml)")
    _refuse_third("state", found, sheet)
    radii_m, water_m3 = found.values["radius"], found.values["water"]
    flasks_m3 = found.values.get("flask", [4.0 / 3.0 * math.pi * radius_m**3 for radius_m in radii_m])
    faults = []
    for radius_m, flask_m3, water, line in zip(radii_m, flasks_m3, water_m3, sheet.lines, strict=True):
        flask = f"the flask of {radius_m * 1e3:g} mm and {flask_m3 * 1e6:.4g} ml"
        if water > flask_m3:
            faults.append(SheetFault(line, None, f"{water * 1e6:.4g} ml of water are more than {flask}: check both."))
        elif water < (1.0 - _FULLEST) * flask_m3:
            what = f"{water * 1e6:.4g} ml for water in {flask}, which no grains fill beyond {_FULLEST:g}: "
            faults.append(SheetFault(line, None, f"{what}check the units of both."))
    sheet.refuse(faults)
    return dataclasses.replace(found, values={**found.values, "flask": flasks_m3}, doubt=_copied_rows(sheet))


def _copied_rows(sheet: Sheet) -> str | None:
    """Say which rows may have been pasted twice, None where all differ."""
    repeats = _repeated(sheet.rows, sheet.lines)
    if not repeats:
        return None
    listed = ", ".join(f"line {line} those of line {first}" for first, line in repeats[:_MOST_REPEATS])
    listed += f" and {len(repeats) - _MOST_REPEATS} more" if len(repeats) > _MOST_REPEATS else ""
    return f"Rows have the very cells of rows before ({listed}): each counts as a filling; drop what is a copy."


def read_walks(file: SheetFile) -> StudySheet:
    """Read a sheet of walks: words `walk` and `robot`, values `mass` in kg, `distance` in m, and `energy` in J, which
    stand in it or are charges times voltages, or words `log`, the logs that have them.

    Masses that exceed distances may be swapped with them, which is the `doubt`. Raises `InputRefused` as every sheet
    does, where it has energies in no way or in two, for a third robot, and for a robot that is twice on a walk or a log
    that is named twice.
    """
    found, sheet = _read_study_sheet(file, _WALK, ("walk", "robot"), _WALKS_EXAMPLE, ("log",))
    values, logs = dict(found.values), found.words.get("log", ())
    there = {"energies": "energy" in values, "charges": "charge" in values, "logs": bool(logs)}
    sources = [name for name, is_there in there.items() if is_there]
    if len(sources) > 1:
        raise InputRefused(f"{file.name} has {' and '.join(sources)}: keep the one that is meant.")
    if "charge" in values and "voltage" in values:
        values["energy"] = [charge * volts for charge, volts in zip(values["charge"], values["voltage"], strict=True)]
    if "energy" not in values and not logs:
        raise InputRefused(
            f"{file.name} says no energies, nor charges and voltages, nor logs: name the columns as in "
            f"{_WALKS_EXAMPLE}."
        )
    _refuse_third("robot", found, sheet)
    twice = _repeated(zip(found.words["walk"], found.words["robot"], strict=True), sheet.lines)
    what = "walk and robot are those of line {}: give each walk a name of its own, or drop the copy."
    sheet.refuse([SheetFault(line, "walk", what.format(first)) for first, line in twice])
    _refuse_log_twice(logs, sheet)
    swapped = None
    for mass_kg, distance_m, line in zip(values["mass"], values["distance"], sheet.lines, strict=True):
        if mass_kg > distance_m:
            swapped = f"Line {line} has a robot of {mass_kg:g} kg walk {distance_m:g} m: are mass and distance swapped?"
            break
    return dataclasses.replace(found, values=values, doubt=swapped)


def _refuse_third(word: str, found: StudySheet, sheet: Sheet) -> None:
    """Refuse a third word where two are compared, at the first line of the one that is written least often."""
    cells = found.words[word]
    counts = Counter(reversed(cells))  # of those as rare, the last to come in
    if len(counts) > 2:
        odd = min(counts, key=lambda cell: counts[cell])
        others = [cell for cell in dict.fromkeys(cells) if cell != odd]
        close = nearest(odd, others)
        hint = "keep a sheet for each two." if close is None else f"did you mean {close!r}?"
        what = f"the {word} {odd!r} stands beside {', '.join(map(repr, others))}; compare two {word}s: {hint}"
        raise sheet.fault(sheet.lines[cells.index(odd)], word, what)


def read_trials(file: SheetFile) -> StudySheet:
    """Read a sheet of trials: words `file`, values `gain`, `damping_gain`, `mass` in kg, perhaps `neutral` in m.

    Raises `InputRefused` as every sheet does, and for a log that is named twice.
    """
    found, sheet = _read_study_sheet(file, _TRIAL, ("file",), "file,gain,damping_gain,mass_kg,neutral_cm")
    _refuse_log_twice(found.words["file"], sheet)
    return found


def _refuse_log_twice(logs: Sequence[str], sheet: Sheet) -> None:
    """Refuse a log in two rows: what was recorded once would count twice."""
    what = "the log is that of line {}: name the log that was recorded, or drop the copy."
    twice = _repeated(logs, sheet.lines) if logs else []
    sheet.refuse([SheetFault(line, None, what.format(first)) for first, line in twice])


def read_oscillation(file: SheetFile) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Read the log of a trial: times in s, displacements in m, velocities in m/s.

    Raises `InputRefused` as every sheet does, and for times that do not rise.
    """
    log, sheet = _read_study_sheet(file, _OSCILLATION, (), "time_ms,position_mm,velocity (m/s)")
    return _rising_s(log, sheet), np.array(log.values["position"]), np.array(log.values["velocity"])


def _rising_s(log: StudySheet, sheet: Sheet) -> FloatArray:
    time_s = np.array(log.values["time"])
    still = np.flatnonzero(np.diff(time_s) <= 0.0)
    if time_s.size < 2 or still.size:
        line = log.lines[int(still[0]) + 1 if still.size else 0]
        what = "the time does not rise from row to row: give the log of one walk or trial as it was made."
        raise sheet.fault(line, "time", what)
    return time_s


def read_power(file: SheetFile) -> tuple[FloatArray, FloatArray]:
    """Read the power log of a walk: times in s, and the power in W that is integrated by the trapezoidal rule.

    Raises `InputRefused` as every sheet does, and for a log without power, in disorder, with a gap, or of no energy.
    """
    log, sheet = _read_study_sheet(file, _POWER, (), _POWER_EXAMPLE)
    time_s = _rising_s(log, sheet)
    if "power" in log.values:
        power_w = np.array(log.values["power"])
    elif "current" in log.values and "voltage" in log.values:
        power_w = np.array(log.values["current"]) * np.array(log.values["voltage"])
    else:
        what = f"no power, nor current and voltage: name the columns as in {_POWER_EXAMPLE}."
        raise sheet.fault(sheet.header_line, None, what)
    steps_s = np.diff(time_s)
    place = int(steps_s.argmax())
    gap_s, whole_s = float(steps_s[place]), float(time_s[-1] - time_s[0])
    if gap_s > _LONGEST_STEP * np.median(steps_s) and gap_s > _LONGEST_SHARE * whole_s:
        what = (
            f"nothing stands for {gap_s:g} s from here on, so that the energy would be a guess: give the walk's charge "
            "instead, or leave the walk out for both robots."
        )
        raise sheet.fault(log.lines[place], None, what)
    energy_j = float(np.trapezoid(power_w, time_s))
    if energy_j <= 0.0:
        raise InputRefused(f"{file.name} says {energy_j:g} J were taken: turn the current's sign, taken is positive.")
    return time_s, power_w


@dataclass(frozen=True, slots=True)
class _Kind:
    """A kind of sheet: the columns that its header has, among others, each with its unit behind its name where it has
    one; what its files are; the clue to them, None where they are read as declared only; what reads one as the study
    does and returns how many rows it has and what is doubtful, and by which rule of findings that is noted.
    """

    columns: tuple[str, ...]
    what: str
    clue: bytes | None
    count: Callable[[SheetFile], tuple[int, str | None]]
    doubt: str = ""


STUDY_LOG = "study_log"
_KINDS = {
    "flask_sheet": _Kind(
        ("radius", "state", "water"),
        "Volume fractions of grains in flasks, a filling a row (`labbook study compaction`).",
        b"radius",
        lambda file: (len((sheet := read_flasks(file)).lines), sheet.doubt),
        "rows_repeated",
    ),
    "walk_sheet": _Kind(
        ("walk", "robot", "mass", "distance"),
        "What robots took on walks, a robot on a walk a row (`labbook study field`).",
        b"walk",
        lambda file: (len((sheet := read_walks(file)).lines), sheet.doubt),
        "columns_swapped",
    ),
    "trial_sheet": _Kind(
        ("file", "gain", "damping_gain", "mass"),
        "Trials of a leg's gains, a log a row (`labbook study characterisation`).",
        b"damping",
        lambda file: (len(read_trials(file).lines), None),
    ),
    STUDY_LOG: _Kind(
        ("time",),
        "Logs that a sheet of trials or walks names: oscillations, power; a log of jumps may have the same columns.",
        None,
        lambda file: (len(read_power(file)[0]), None),
    ),
}
_TRIAL_LOG = _Kind(("position",), "", None, lambda file: (len(read_oscillation(file)[0]), None))
"""A log that has this column is one of a trial."""
_TITLE_LINES = 10


def _header(source: TextSource, columns: tuple[str, ...]) -> tuple[int, bool] | None:
    """Return the number of the line that has the columns, and whether only blank ones stand above it."""
    named = [re.compile(rf"{name.replace('_', '[_ ]')}([_ (\[].*)?") for name in columns]
    first = None
    for number, _, cells in head_rows(source, _TITLE_LINES):
        first = first or number
        if isinstance(cells, list) and all(any(name.fullmatch(cell.lower()) for cell in cells) for name in named):
            return number, number == first
    return None


def _format(name: str, kind: _Kind) -> Format:
    def recognise(head: Head) -> str | None:
        """A first line with the columns of a study's sheet."""
        is_there = _header(head.text, kind.columns) is not None
        return f"a header with the columns {', '.join(kind.columns)}" if is_there else None

    def read(head: Head, findings: FindingCollector) -> Reading:
        header = _header(head.text, kind.columns)
        if header is not None and not header[1]:
            message = f"Line {header[0]} names the columns: take out the lines above it."
            findings.add(FILE, "header_not_first", message, lines=header[:1])
            return Reading(role=FileRole.SHEET)
        declared = head.declared
        of_trial = name == STUDY_LOG and _header(head.text, _TRIAL_LOG.columns) is not None
        own_name = declared.file_name or "the file"
        file = SheetFile(own_name, head.data, declared.encoding, declared.decimal_sign, bool(declared.complete))
        return Reading(rows_read=_count(_TRIAL_LOG if of_trial else kind, file, findings), role=FileRole.SHEET)

    if kind.clue is None:  # a log of a robot's jumps may have the same columns
        return Format(name, 4, None, read, kind.what)
    return Format(name, 4, recognise, read, kind.what, clues=(kind.clue,), score=LAYOUT)


def _count(kind: _Kind, file: SheetFile, findings: FindingCollector) -> int:
    """Count the rows of a sheet, or report what the study would refuse: a note where a decimal sign is all it lacks."""
    refused: InputRefused | UsageError | None = None
    for sign in (file.decimal,) if file.decimal is not None else (None, ",", "."):
        try:
            rows, doubt = kind.count(dataclasses.replace(file, decimal=sign))
        except (InputRefused, UsageError) as error:
            refused = refused or error
            continue
        if refused is not None:
            findings.add(NOTE, "sheet_decimal_unclear", str(refused))
        if doubt is not None:
            findings.add(NOTE, kind.doubt, doubt)
        return rows
    if isinstance(refused, SheetRefused):
        for sentence, same in refused.sentences:
            lines = [fault.line for fault in same]
            findings.add(FILE, "sheet_refused", sentence, column=same[0].column, lines=lines, value=same[0].value)
    else:
        findings.add(FILE, "sheet_refused", str(refused))
    return 0


FORMATS = tuple(_format(name, kind) for name, kind in _KINDS.items())
