"""Names and units of columns: parsing a header cell (`height [m]`, `height_mm`, `legLength/mm`), and its meaning.

A unit is read only where it is marked as one; nothing is inferred from the name of the quantity. Names of channels are
compared without case, blanks and underscores. Those that mean different things in different labs (`z`, `h`, `velocity`,
`voltage`, `position`) are left out on purpose: they are declared, not guessed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from data_schema import units
from data_schema.errors import InputRefused
from data_schema.vocabulary import CHANNELS
from ingest.model import FILE, Declarations, FindingCollector

_WRITTEN_UNITS = {
    "s": "sec, secs, second, seconds",
    "ms": "msec, millisecond, milliseconds",
    "us": "usec, microsecond, microseconds",
    "min": "minute, minutes, mins",
    "h": "hour, hours, hr",
    "d": "day, days",
    "m": "metre, meter, metres, meters",
    "in": "inch, inches",
    "N": "Newton, Newtons, newton, newtons",
    "N*m": "Nm, N.m, N-m, N m",
    "N*mm": "Nmm, N.mm, N-mm, N mm",
    "m/s": "mps, m_s, m s^-1, m s-1, m.s-1",
    "mm/s": "mm_s",
    "cm/s": "cm_s",
    "rad/s": "rad_s",
    "deg/s": "deg_s",
    "V": "volt, volts",
    "A": "amp, amps, ampere",
    "mAh": "mah, mA*h, mA.h",
    "Ah": "ah, A*h",
    "degC": "C, °C",
    "deg": "degree, degrees, °",
    "1": "-, none",
    "filetime": "FILETIME",
    "counts": "count, Counts, ADC, LSB",
}
"""How instruments and people write units, case kept: `mV` is not `MV`."""
_SPELLINGS = {word: unit for unit, words in _WRITTEN_UNITS.items() for word in words.split(", ")}
_KNOWN_UNITS = (
    "s ms us ns min h d filetime m cm mm um in ft m/s cm/s mm/s m/s^2 m/s2 m/s² N kN lbf N*m N*mm N*cm V mV A mA mAh "
    "Ah W J degC K deg rad rad/s deg/s rpm Hz kHz kg g Pa kPa % 1 counts"
)
_UNITS = frozenset(_KNOWN_UNITS.split())
COUNTS = frozenset({"counts", "1"})
"""Raw numbers of a sensor: what they measure needs a calibration."""

# After an underscore only units that no word ends in by chance; single letters need a name that is known.
_SAFE_SUFFIXES = (
    "ms us ns mm cm um mV mA mAh Ah Nm Nmm kN degC deg rad rad_s deg_s m_s mm_s cm_s mps Hz kHz sec msec usec rpm"
)
_SUFFIX = re.compile(r"(.+?)[_ .]((?:rad|deg|mm|cm|m)_s|[A-Za-zµμ°%]+)")
_BRACKETS = re.compile(r"\[([^\[\]]*)\]|\(((?:[^()]|\([^()]*\))*)\)")
_SEPARATED = re.compile(r"(.*\S)\s*(?:,|\bin\b)\s*(\S.*)")
_WORD = r"[A-Za-zµμ°%Ω]+(?:\^?-?[1-9]|[²³])?"
_BETWEEN = r"(?:\s*[/*·.]\s*|\s+)"
_COMPOUND = re.compile(
    rf"(?=.*[/*·^²³])(?:1|{_WORD}|\({_WORD}(?:{_BETWEEN}{_WORD})*\))"
    rf"(?:{_BETWEEN}(?:{_WORD}|\({_WORD}(?:{_BETWEEN}{_WORD})*\)))*"
)
"""Units multiplied, divided or to a power: `N/kg`, `mAh/g`, `kg m/s^2`, `W/(m K)`."""
_TICK = re.compile(r"(0[.,]0*[1-9]\d*|1/[1-9]\d*)\s*([^\s\d].*)")
"""What one count of a column is, as in `[0.1 mm]`; a number from 1 on is that of a range."""
_NO_UNIT = frozenset({"N/A", "n/a"})
_LONGEST_UNIT = 30
_LONGEST_NAME = 200
"""A longer cell is no name with a unit; to look for brackets in one of 100 kB takes minutes."""
_CAMEL = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")


@dataclass(frozen=True, slots=True)
class HeaderCell:
    """A column's name as written, without its unit, and the unit in the spelling used here; None where none is marked.

    `suffix_unit` is a one-letter ending (`height_m`, `time_s`) that counts only where the name before it is known;
    `suffix_base` is that name.
    """

    base: str
    unit: str | None
    suffix_base: str | None = None
    suffix_unit: str | None = None

    def named(self, is_known: Callable[[str], bool]) -> tuple[str, str | None]:
        """Return name and unit: a one-letter ending is one where only the name before it is known."""
        if self.suffix_base is not None and is_known(self.suffix_base) and not is_known(self.base):
            return self.suffix_base, self.suffix_unit
        return self.base, self.unit


def parse_header(text: str) -> HeaderCell:
    """Take a header cell apart; the words around a unit in brackets stay part of the name."""
    text = text.strip().strip("\u200e\u200f\ufeff").strip()
    if len(text) > _LONGEST_NAME:
        return HeaderCell(text, None)
    brackets = [*_BRACKETS.finditer(text)]
    units_in = [found for found in brackets if is_unit(found[1] or found[2] or "")]
    marked = units_in[-1:] or [found for found in brackets if found[1] is not None or _is_tick(text, found)]
    if marked:
        return HeaderCell(_without(text, marked[0]), normal_unit(marked[0][0]))
    separated = _SEPARATED.fullmatch(text)
    if separated and is_unit(separated[2]):
        return HeaderCell(separated[1], normal_unit(separated[2]))
    return _divided(text) or _suffixed(text, "") or HeaderCell(text, None)


def _without(text: str, found: re.Match[str]) -> str:
    return f"{text[: found.start()].rstrip()} {text[found.end() :].lstrip()}".strip()


def _is_tick(text: str, bracket: re.Match[str]) -> bool:
    """Whether a bracket behind the name of a time holds what one count is: `time (0.1 ms)`."""
    return bracket[2][:1].isdigit() and squash(_without(text, bracket)) in TIME_NAMES


def _divided(text: str) -> HeaderCell | None:
    """Take apart `leg length/mm`: the longest unit behind a stroke, or one that the stroke divides (`velocity_m/s`)."""
    if is_unit(text):
        return None
    for stroke in re.finditer("/", text):
        name, unit = text[: stroke.start()].rstrip(), text[stroke.end() :].strip()
        if name and name.count("(") == name.count(")") and is_unit(unit):
            known = squash(name) in TIME_NAMES or channel_of(name) is not None
            return (None if known else _suffixed(name, f"/{unit}")) or HeaderCell(name, normal_unit(unit))
    return None


def _suffixed(name: str, divided_by: str) -> HeaderCell | None:
    """Take a unit, divided by another one or not, off the end of a name; None where there is none."""
    suffix = _SUFFIX.fullmatch(name)
    if suffix is None or not is_unit(suffix[2] + divided_by):
        return None
    unit = normal_unit(suffix[2] + divided_by)
    if suffix[2] in _SAFE_SUFFIXES.split():
        return HeaderCell(suffix[1], unit)
    return HeaderCell(name + divided_by, None, suffix[1], unit)


def normal_unit(text: str) -> str | None:
    """Return a unit in the spelling used here; None for no text. Unknown units stay as they are written."""
    text = text.strip()
    if text[:1] + text[-1:] in ("[]", "()"):
        text = text[1:-1].strip()
    text = text.replace("µ", "u").replace("μ", "u").replace("·", "*")
    return _SPELLINGS.get(text, text) or None


def is_unit(text: str) -> bool:
    """Whether a text is a unit known here (and not just any word), or made of such as the units library reads it."""
    unit = normal_unit(text)
    if unit is not None and (tick := _TICK.fullmatch(unit)):
        return is_unit(tick[2])
    if unit in _UNITS or unit is None or unit in _NO_UNIT or len(unit) > _LONGEST_UNIT:
        return unit in _UNITS
    words = re.findall(r"[A-Za-zµμ°%Ω]+", unit) if _COMPOUND.fullmatch(unit) else []
    return any(normal_unit(word) in _UNITS for word in words) and units.is_unit(unit)


def squash(name: str) -> str:
    """Return a name for comparing: `Leg Length`, `legLength` and `leg_length` are one."""
    return "".join(letter for letter in name.lower() if letter.isalnum())


def clean_name(name: str) -> str:
    """Return a channel name from a column's: lower case words joined by `_`; empty when no letter or digit is left."""
    words = re.split(r"[\W_]+", _CAMEL.sub("_", name))
    return "_".join(word.lower() for word in words if word)


def strip_comment(text: str) -> str:
    """Return a header cell without the comment sign that some loggers write before the first name, and without NULs."""
    return text.replace("\0", "").strip().lstrip("#%").removeprefix("//").strip()


_TIMES = "millis micros filetime time t timestamp elapsed elapsedtime timeelapsed epoch unixtime datetime dateandtime"
TIME_NAMES = frozenset(_TIMES.split())
UNIT_OF_NAME = {"millis": "ms", "micros": "us", "filetime": "filetime", "mah": "mAh"}
"""Names that imply their unit: Arduino's clock functions are defined in milliseconds and microseconds."""

_WRITTEN_AS = {
    "body_height": "height, robot height, string pot, string pot height, string potentiometer, pot height, body z",
    "foot_height": "toe height",
    "leg_length": "leg len, leg extension length",
    "leg_velocity": "leg vel, leg speed, leg length velocity",
    "body_velocity": "body vel, vertical velocity, height rate",
    "platform_height": "platform, ground height, emulator height",
    "k_gain": "stiffness gain, extension gain",
    "b_gain": "damping gain",
    "b_ad_gain": "ad gain, b ad, active damping gain, active damping",
    "controller_state": "state, controller mode, control mode, fsm state",
    "battery_voltage": "v bat, pack voltage, v pack, battery v",
    "input_voltage": "v in, supply voltage",
    "current": "i bat, battery current",
    "charge": "mah",
    "temperature_internal": "int temp, t int, internal temperature",
    "temperature_external": "ext temp, t ext, external temperature",
    "force_x": "fx",
    "force_y": "fy",
    "force_z": "fz, grf v, grf z, v grf, vertical grf, vertical ground reaction force",
    "moment_x": "mx",
    "moment_y": "my",
    "moment_z": "mz",
    "cop_x": "cx",
    "cop_y": "cy",
    "cop_z": "cz",
    "free_moment_z": "tz",
    "sync": "",
    "aux": "",
    "sequence": "seq, sample, sample number, packet, packet number, frame",
}
_PLATED = re.compile(r"((?:force|moment|free_moment|cop)_[xyz])(?:_\d+)?")
_PLATE = re.compile(r"_(\d+)$")
_PLATE_NUMBER = re.compile(r"(f[xyz]|m[xyz]|cop[xyz]|force[xyz]|moment[xyz])([1-9])")

_CHANNEL_OF = {squash(name): name for name in CHANNELS}
_CHANNEL_OF |= {squash(word): name for name, words in _WRITTEN_AS.items() for word in words.split(",") if word}

_CHANNEL_IN_UNIT: dict[tuple[str, str | None], str] = {
    ("battery", "V"): "battery_voltage",
    ("battery", "mV"): "battery_voltage",
}
"""Names that may be those of several quantities, and the units that decide which."""


def channel_of(name: str, unit: str | None = None) -> str | None:
    """Return the channel that a source column of this name, in this unit, holds, None when it is not known.

    Force plates number their columns (`Fx1`, `COPx2`): plate 1 keeps the plain name, further ones a suffix.
    """
    squashed = squash(name)
    plate = _PLATE_NUMBER.fullmatch(squashed)
    if plate:
        channel = _CHANNEL_OF[plate[1]]
        return channel if plate[2] == "1" else f"{channel}_{plate[2]}"
    return _CHANNEL_OF.get(squashed) or _CHANNEL_IN_UNIT.get((squashed, unit))


def channel_kind(channel: str) -> str | None:
    """Return the key of `CHANNELS` for a channel, its plate suffix removed; None for a name that is not known."""
    plated = _PLATED.fullmatch(channel)
    if plated:
        return plated[1]
    return channel if channel in CHANNELS else None


def is_of_plate(channel: str) -> bool:
    """Whether a channel is a component of a force, moment or point of application, of any plate."""
    return _PLATED.fullmatch(channel) is not None


def is_cop(channel: str) -> bool:
    """Whether a channel is a coordinate of a centre of pressure, of any plate."""
    return (channel_kind(channel) or "").startswith("cop_")


def plate_of(channel: str) -> int:
    """Return the number of the plate that a channel belongs to, 1 where it has none."""
    match = _PLATE.search(channel)
    return int(match[1]) if match else 1


FACTORS = {
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "m/s": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3},
    "N": {"N": 1.0, "kN": 1e3},
    "N*m": {"N*m": 1.0, "N*mm": 1e-3},
    "V": {"V": 1.0, "mV": 1e-3},
    "A": {"A": 1.0, "mA": 1e-3, "10 mA": 1e-2},
    "mAh": {"mAh": 1.0, "Ah": 1e3},
    "degC": {"degC": 1.0, "0.1 degC": 0.1, "0.01 degC": 0.01},
    "1": {"1": 1.0},
}
"""The units that logs are full of, by the stored one: the units library, slow to load, is for the others."""


def multiple_in(text: str) -> float:
    """Return the number before a unit: 0.1, 0,1 or 1/10."""
    return 1 / float(text[2:]) if text.startswith("1/") else float(text.replace(",", "."))


def factor(
    column: str, unit: str, stored: str, findings: FindingCollector, flag: str | None = None
) -> tuple[float, float]:
    """Return `(scale, offset)` with `stored = scale * value + offset`; a unit of another quantity refuses the file.

    `flag` is how flags name the column, where that is not its name.
    """
    tick = _TICK.fullmatch(unit)
    number, unit_of_tick = (multiple_in(tick[1]), normal_unit(tick[2]) or "") if tick else (1.0, unit)
    common = FACTORS.get(stored, {}).get(unit_of_tick)
    if common is not None:
        return number * common, 0.0
    try:
        scale, offset = units.conversion(unit_of_tick, stored)
        return number * scale, offset
    except InputRefused as error:
        flag = column if flag is None else flag
        own = clean_name(parse_header(column).base) or "quantity"
        own = f"own.{own}" if channel_kind(own) is None else f"own.{own}_other"
        kept = f'; if it is another quantity, `--column "{flag}={own}"`' if is_unit(unit) else ""
        message = (
            f"Column {column!r}: {str(error).rstrip('.')}; if the column holds {stored}, say "
            f'`--unit "{flag}={stored}" --override-units`{kept}.'
        )
        findings.add(FILE, "unit_not_convertible", message, column=column, value=unit)
        return 1.0, 0.0


def usual_units(stored: str) -> str:
    """Return, for a sentence, the units in which logs give a quantity that is stored in `stored`."""
    return " or ".join(unit for unit in FACTORS[stored] if " " not in unit)


def is_common(unit: str, stored: str) -> bool:
    """Whether a unit is one in which logs often give a quantity that is stored in `stored`."""
    return unit in FACTORS.get(stored, {})


def same_unit(one: str, other: str) -> bool:
    """Whether two spellings mean one unit."""
    if one == other:
        return True
    try:
        scale, offset = units.conversion(one, other)
    except InputRefused:
        return False
    return math.isclose(scale, 1.0) and offset == 0.0


def refuse_other_unit(
    column: str, own: str | None, declared_unit: str | None, declared: Declarations, findings: FindingCollector
) -> None:
    """Refuse a file whose header gives a column another unit than is declared, unless declarations override it."""
    if own and declared_unit and is_unit(own) and not declared.override_units and not same_unit(own, declared_unit):
        findings.add(
            FILE,
            "unit_contradicts",
            f"The header of column {column!r} says {own} and {declared_unit} is declared: leave the declaration out, "
            "or say `--override-units` if the header is wrong.",
            column=column,
            value=own,
        )


def refuse_two_units(column: str, flag: str, name: str | None, below: str | None, findings: FindingCollector) -> None:
    """Refuse a column whose name has one unit and the row of units, or the cells, below it another.

    `flag` is how flags name the column.
    """
    if name and below and is_unit(name) and is_unit(below) and not same_unit(name, below):
        findings.add(
            FILE,
            "unit_contradicts",
            f"The header of column {column!r} says {name} and below it stands {below}: correct the file, or say which "
            f'holds with `--unit "{flag}={below}" --override-units`.',
            column=column,
            value=below,
        )


TICKS_PER_SECOND = {
    "s": 1.0,
    "ms": 1e3,
    "us": 1e6,
    "ns": 1e9,
    "filetime": 1e7,
    "min": 1 / 60,
    "h": 1 / 3600,
    "d": 1 / 86_400,
}
"""Units of a time column."""
_MULTIPLE = re.compile(r"(1/[1-9]\d*|\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?)\s*([A-Za-zµμ]+)")


def ticks_per_second(unit: str | None) -> float | None:
    """Return the ticks a second of a unit of time, or of a multiple such as `0.1 ms`; None where it is neither."""
    multiple = None if unit is None else _MULTIPLE.fullmatch(unit)
    if multiple is None:
        return TICKS_PER_SECOND.get(unit or "")
    number, known = multiple_in(multiple[1]), TICKS_PER_SECOND.get(normal_unit(multiple[2]) or "")
    return known / number if known and number else None
