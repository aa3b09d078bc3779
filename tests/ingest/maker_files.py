"""Exports of makers' programs as a second, independent reader knows them: which cell is which channel, by what factor.

It shares no code with `ingest`: a row is a line of numbers as the maker writes them, and nothing else is.
"""

from __future__ import annotations

import functools
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from tests.ingest import synthetic_plates as plates
from tests.ingest.formats.synthetic_chargers import lines
from tests.ingest.second_parser import MISSING, NUMBER, Row
from tests.ingest.synthetic import icharger_rows


@dataclass(frozen=True)
class Maker:
    """A format: a good file, its lines of header, what separates cells, and each column's channel and factor.

    `time` are the columns that make up the time, each with its unit in s; `part` is the name that its signal has where
    there are several, `followed_by` what the line behind its rows begins with.
    """

    write: Callable[[], bytes]
    head: int
    delimiter: str
    columns: Sequence[tuple[str, float] | None]
    rate_hz: float
    time: Mapping[int, float] | None = None
    part: str | None = None
    followed_by: str | None = None
    checked: bool = False

    def row(self, line: str, place: int) -> Row | None:
        """Read a line, which is at this place among the rows; None where it is none."""
        line = line.strip("\0")
        if "\0" in line or (self.checked and not _checksum_agrees(line)):
            return None
        cells = _unquoted(line, self.delimiter)
        while len(cells) > len(self.columns) and not cells[-1]:
            cells.pop()
        if len(cells) != len(self.columns):
            return None
        values = {}
        for cell, column in zip(cells, self.columns, strict=True):
            number = _number(cell)
            if column and number == math.inf and column[0].startswith("cop"):
                number = math.nan
            if column and number in (None, math.inf):
                return None
            if column and number is not None:
                values[column[0]] = column[1] * number
        if self.time is None:
            return Row(place / self.rate_hz, values)
        stamps = [(_number(cells[position]), unit) for position, unit in self.time.items()]
        time_s = sum(math.nan if number in (None, math.inf) else number * unit for number, unit in stamps)
        return None if math.isnan(time_s) else Row(time_s, values)


def _unquoted(line: str, delimiter: str) -> list[str]:
    """Return the stripped cells without their quotes, which a cell may have left open over the end of its line."""
    bare = line.strip(" \r\x1a" if delimiter == "\t" else " \t\r\x1a")
    return [cell.replace('"', "").strip(" \t") for cell in bare.split(delimiter)]


def _number(cell: str) -> float | None:
    """Return a number, NaN for a missing one, infinity for what no number holds; None for anything else."""
    if cell.lower() in MISSING:
        return math.nan
    if cell.lower().lstrip("+-") in ("inf", "1.#inf"):
        return math.inf
    if not NUMBER.fullmatch(cell):
        return None
    return abs(float(cell)) if math.isinf(float(cell)) else float(cell)


def _checksum_agrees(line: str) -> bool:
    body, mark, said = line.strip().rpartition(";")
    return bool(mark) and said == str(functools.reduce(operator.xor, (body + mark).encode("latin-1")))


def _six(plate: int, sign: Mapping[str, float], moment: float = 1.0) -> list[tuple[str, float] | None]:
    ending = "" if plate == 1 else f"_{plate}"
    scales = (("force", 1.0), ("moment", moment))
    return [(f"{quantity}_{axis}{ending}", scale * sign[axis]) for quantity, scale in scales for axis in "xyz"]


def _bioware(plate: int) -> list[tuple[str, float] | None]:
    ending = "" if plate == 1 else f"_{plate}"
    names = ("force_x", "force_y", "force_z", "ft", "moment_x", "moment_y", "moment_z", "cop_x", "cop_y")
    return [(name + ending, 1.0) for name in names]


def _vicon(plate: int) -> list[tuple[str, float] | None]:
    ending = "" if plate == 1 else f"_{plate}"
    return [*_six(plate, _UP, 1e-3), *((f"cop_{axis}{ending}", 1e-3) for axis in "xyz")]


def _opensim(quantity: str, plate: int) -> list[tuple[str, float] | None]:
    ending = "" if plate == 1 else f"_{plate}"
    return [(f"{quantity}_x{ending}", 1.0), (f"{quantity}_z{ending}", 1.0), (f"{quantity}_y{ending}", -1.0)]


_UP = {"x": 1.0, "y": 1.0, "z": 1.0}
_ON_PLATE = {"x": -1.0, "y": 1.0, "z": 1.0}
"""Of the force on a plate with z down."""

_CHARGER = [
    *(None, None, None, None, None, ("current", 0.01), ("input_voltage", 1e-3), ("battery_voltage", 1e-3)),
    *(("charge", 1.0), ("temperature_internal", 0.1), ("temperature_external", 0.1)),
    *((f"cell_{number}_voltage", 1e-3) for number in range(1, 5)),
    *(None,) * 7,
]

_BERTEC = [("sequence", 1.0), None, ("sync", 1.0), ("aux", 1.0), *_six(1, _ON_PLATE), ("cop_x", 1.0), ("cop_y", -1.0)]
_OPENSIM = [
    None,
    *(column for plate in (1, 2) for quantity in ("force", "cop") for column in _opensim(quantity, plate)),
    *(column for plate in (1, 2) for column in _opensim("free_moment", plate)),
]
_QUALISYS = [("sequence", 1.0), None, *_six(1, _ON_PLATE), ("cop_x", 1e-3), ("cop_y", -1e-3), ("cop_z", -1e-3)]
_NEXUS = [None, ("sub_frame", 1.0), *_vicon(1), *_vicon(2)]
_NEXUS_TIME = {0: 1e-2, 1: 1e-3}

MAKERS: Mapping[str, Maker] = {
    "bertec_text": Maker(lambda: plates.bertec(120), 1, ",", _BERTEC, 1000.0, {1: 1e-3}),
    "amti_text": Maker(lambda: plates.amti(120), 4, ",", [*_six(1, _ON_PLATE), *_six(2, _ON_PLATE)], 100.0),
    "bioware": Maker(lambda: plates.bioware(120), 18, "\t", [None, *_bioware(1), *_bioware(2)], 1000.0, {0: 1.0}),
    "opensim": Maker(lambda: plates.opensim(120), 7, "\t", _OPENSIM, 300.0, {0: 1.0}),
    "qualisys_tsv": Maker(lambda: plates.qualisys(120), 26, "\t", _QUALISYS, 500.0, {1: 1.0}),
    "vicon_csv": Maker(lambda: plates.vicon(120), 5, ",", _NEXUS, 1000.0, _NEXUS_TIME, "devices", "Trajectories"),
    "icharger_log": Maker(
        lambda: lines(icharger_rows(120), "\n"), 0, ";", _CHARGER, 1.0, {2: 1e-3}, "channel_1", checked=True
    ),
}
