"""The name and the unit in one header cell: `height [m]`, `height_mm`, `Force Beam 1 (N)`, `legLength/mm`.

A unit is read only where it is marked as one; nothing is inferred from the name of the quantity.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

# Spellings of units as instruments and people write them, case kept: `mV` is not `MV`.
_SPELLINGS = {
    "sec": "s", "secs": "s", "second": "s", "seconds": "s",
    "msec": "ms", "millisecond": "ms", "milliseconds": "ms",
    "usec": "us", "microsecond": "us", "microseconds": "us",
    "minute": "min", "minutes": "min", "mins": "min", "hour": "h", "hours": "h", "hr": "h",
    "metre": "m", "meter": "m", "metres": "m", "meters": "m", "inch": "in", "inches": "in",
    "Newton": "N", "Newtons": "N", "newton": "N", "newtons": "N",
    "Nm": "N*m", "N.m": "N*m", "N-m": "N*m", "N m": "N*m",
    "Nmm": "N*mm", "N.mm": "N*mm", "N-mm": "N*mm", "N mm": "N*mm",
    "mps": "m/s", "m_s": "m/s", "mm_s": "mm/s", "cm_s": "cm/s", "rad_s": "rad/s", "deg_s": "deg/s",
    "m s^-1": "m/s", "m s-1": "m/s", "m.s-1": "m/s",
    "volt": "V", "volts": "V", "amp": "A", "amps": "A", "ampere": "A",
    "mah": "mAh", "mA*h": "mAh", "mA.h": "mAh", "ah": "Ah", "A*h": "Ah",
    "C": "degC", "°C": "degC", "degree": "deg", "degrees": "deg", "°": "deg",
    "-": "1", "none": "1", "FILETIME": "filetime",
}  # fmt: skip
_UNITS = {
    "s", "ms", "us", "ns", "min", "h", "filetime", "m", "cm", "mm", "um", "in", "ft", "m/s", "cm/s", "mm/s",
    "m/s^2", "m/s2", "m/s²", "N", "kN", "lbf", "N*m", "N*mm", "N*cm", "V", "mV", "A", "mA", "mAh", "Ah", "W", "J",
    "degC", "K", "deg", "rad", "rad/s", "deg/s", "rpm", "Hz", "kHz", "kg", "g", "Pa", "kPa", "%", "1",
}  # fmt: skip
# After an underscore only units that no word ends in by chance; single letters need a name that is known.
_SAFE_SUFFIXES = {
    "ms", "us", "ns", "mm", "cm", "um", "mV", "mA", "mAh", "Ah", "Nm", "Nmm", "kN", "degC", "deg", "rad", "rad_s",
    "deg_s", "m_s", "mm_s", "cm_s", "mps", "Hz", "kHz", "sec", "msec", "usec", "rpm",
}  # fmt: skip
_SUFFIX = re.compile(r"(.+?)[_ .]((?:rad|deg|mm|cm|m)_s|[A-Za-zµμ°%]+)")
_BRACKETS = re.compile(r"(.*?)\s*(\[|\()\s*([^\])]*?)\s*[\])]\s*(.*)")
_SEPARATED = re.compile(r"(.*\S)\s*(?:/|,|\bin\b)\s*(\S+)")
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


def parse_header(text: str) -> HeaderCell:
    """Take a header cell apart; the words around a unit in brackets stay part of the name."""
    text = text.strip().strip("\u200e\u200f\ufeff").strip()
    if len(text) > _LONGEST_NAME:
        return HeaderCell(text, None)
    brackets = _BRACKETS.fullmatch(text)
    if brackets and (brackets[2] == "[" or is_unit(brackets[3])):
        return HeaderCell(f"{brackets[1]} {brackets[4]}".strip(), normal_unit(brackets[3]))
    separated = _SEPARATED.fullmatch(text)
    if separated and is_unit(separated[2]):
        return HeaderCell(separated[1], normal_unit(separated[2]))
    suffix = _SUFFIX.fullmatch(text)
    if suffix and suffix[2] in _SAFE_SUFFIXES:
        return HeaderCell(suffix[1], normal_unit(suffix[2]))
    if suffix and is_unit(suffix[2]):
        return HeaderCell(text, None, suffix[1], normal_unit(suffix[2]))
    return HeaderCell(text, None)


def normal_unit(text: str) -> str | None:
    """Return a unit in the spelling used here; None for no text. Unknown units stay as they are written."""
    text = text.strip().strip("[]()").strip().replace("µ", "u").replace("μ", "u").replace("·", "*")
    return _SPELLINGS.get(text, text) or None


def is_unit(text: str) -> bool:
    """Whether a text is a unit known here (and not just any word)."""
    return normal_unit(text) in _UNITS


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
