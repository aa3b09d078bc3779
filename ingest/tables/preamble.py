"""Facts in the lines above a table: the sampling rate and when the recording began."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

_RATE = re.compile(
    r"(?i)(?P<what>(?:sampl\w*|acquisition|acquire|data|logging|log)?[ _-]*(?:rate|frequency|freq))\b"
    r"(?P<between>[^0-9+-]{0,30}?)(?P<value>\d+(?:[.,]\d+)?(?:e[+-]?\d+)?)[ \t]*(?P<unit>k?hz)?"
)
_OTHER_RATE = re.compile(r"(?i)\b(?:baud|heart|bit|frame|refresh)[ _-]*(?:rate|frequency)")
_START = re.compile(
    r"(?i)(?:date|start\w*|began|recorded|recording)\b[^0-9]{0,30}"
    r"(?P<when>\d{4}-\d\d-\d\d[T ]\d\d:\d\d(?::\d\d(?:\.\d+)?)?(?:Z|[+-]\d\d:?\d\d)?)"
)


@dataclass(frozen=True, slots=True)
class Preamble:
    """What the lines above the table say; None where they say nothing."""

    rate_hz: float | None
    start: str | None


NO_PREAMBLE = Preamble(None, None)


def read_preamble(lines: Sequence[str]) -> Preamble:
    """Search the lines for a rate that names hertz or sampling, and for an ISO-8601 date and time."""
    rate = next((found for found in map(_rate, lines) if found is not None), None)
    start = next((match["when"] for match in map(_START.search, lines) if match), None)
    return Preamble(rate, start)


def _rate(line: str) -> float | None:
    match = None if _OTHER_RATE.search(line) else _RATE.search(line)
    if match is None:
        return None
    unit = (match["unit"] or "").lower()
    in_name = re.search(r"(?i)(k?)hz", match["between"])
    sampling = re.search(r"(?i)sampl|acqui", match["what"]) is not None
    if not (unit or in_name or sampling):
        return None
    kilo = unit == "khz" or (in_name is not None and bool(in_name[1]))
    value = float(match["value"].replace(",", ".")) * (1000.0 if kilo else 1.0)
    return value if value > 0 else None
