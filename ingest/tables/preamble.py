"""Facts in the lines above a table: the sampling rate, in which line it stands, and when the recording began."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

_SAMPLING = (
    "sampl|acqui|digiti|abtast|akwizyc|pr[oó]bkowa|[eé]chantillon|muestreo|adquisi|campionament|amostragem|bemonster"
)
_RATE = "rate|freq|fréq|frec|frekv|stotliwo|hz"
_OF_SAMPLING = re.compile(rf"(?i)(?:{_SAMPLING})\w*.{{0,20}}?(?:{_RATE})|(?:{_RATE})\w*.{{0,20}}?(?:{_SAMPLING})")
_OF_DATA = re.compile(r"(?i)\b(?:data|log|logging|recording|record)[ _-]*(?:rate|frequency|freq)\b")
_BARE = re.compile(r"(?i)\W*(?:rate|frequency|freq)\b[\s:=,(\[]*(?:k?hz)?[\s:=,)\]]*(?=\d|$)")
_OTHER_RATE = re.compile(
    r"(?i)filter|cut[ _-]?off|corner|pass\b|display|update|refresh|baud|bit|heart|frame|video|camera|screen|nyquist"
    r"|divi[ds]|limit|range|max|interval|period|ratio|error"
)
_VALUE = re.compile(
    r"(?i)(?<![\d.+-])(?<!\d,)(?P<value>\d+(?:[.,]\d+)?(?:e[+-]?\d+)?)(?![\d:]|[.-]\d)[ \t]*(?P<unit>k?hz)?"
)
_GROUPED = re.compile(r"[1-9]\d{0,2}[.,]\d{3}")
_CLAUSE = re.compile(r"[;|\t]|,(?!\d)")
_START = re.compile(
    r"(?i)(?:date|start\w*|began|recorded|recording)\b[^0-9]{0,30}"
    r"(?P<when>\d{4}-\d\d-\d\d[T ]\d\d:\d\d(?::\d\d(?:\.\d+)?)?(?:Z|[+-]\d\d:?\d\d)?)"
)


@dataclass(frozen=True, slots=True)
class Preamble:
    """What the lines above the table say; None where they say nothing.

    `rate_line` is the line that states the rate, `other_rate_line` one that states another sampling rate.
    """

    rate_hz: float | None
    start: str | None
    rate_line: str | None = None
    other_rate_line: str | None = None


NO_PREAMBLE = Preamble(None, None)


def read_preamble(lines: Sequence[str]) -> Preamble:
    """Search the lines for a sampling rate and for an ISO-8601 date and time.

    A rate is one that names sampling, acquisition or logging, or a bare `rate` or `frequency` in hertz; that of a
    filter, a display or a serial line is none.
    """
    found = [(rate, line.strip()) for line in lines if (rate := _rate(line)) is not None]
    start = next((match["when"] for match in map(_START.search, lines) if match), None)
    if not found:
        return Preamble(None, start)
    rate, rate_line = found[0]
    other = next((line for further, line in found if abs(further / rate - 1) > 0.005), None)
    return Preamble(rate, start, rate_line, other)


def _is_grouped(value: str) -> bool:
    """Whether `1,000` or `1.000` may be a thousand: a rate of 1 Hz is as unlikely."""
    return _GROUPED.fullmatch(value) is not None and ("," in value or float(value) < 20)


def _rate(line: str) -> float | None:
    clauses = _CLAUSE.split(line)
    for number, clause in enumerate(clauses):
        if _OTHER_RATE.search(clause):
            continue
        sampling = _OF_SAMPLING.search(clause) is not None
        if not (sampling or _OF_DATA.search(clause) or _BARE.match(clause)):
            continue
        # `Rate;1000` and `Rate<TAB>1000` put the value into the next cell.
        next_cell = next((cell.strip() for cell in clauses[number + 1 :] if cell.strip()), "")
        values = [*_VALUE.finditer(clause), *_VALUE.finditer(next_cell)]
        match = next((value for value in values if value["unit"]), values[0] if values else None)
        if match is None or _is_grouped(match["value"]):
            continue
        named = re.search(r"(?i)(k?)hz", clause)
        if not (sampling or match["unit"] or named):
            continue
        kilo = (match["unit"] or (named[0] if named else "")).lower() == "khz"
        value = float(match["value"].replace(",", ".")) * (1000.0 if kilo else 1.0)
        if value > 0:
            return value
    return None
