"""Read a run sheet that a person filled in, and say everything that is wrong with it at once.

Spreadsheets rewrite cells, so `25.0`, `9:05` and `12,5` are understood too.
"""

from __future__ import annotations

import datetime
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from data_schema.errors import InputRefused, UsageError, nearest, unknown_name
from data_schema.vocabulary import RunKind
from ingest.tables.sheet import Sheet, SheetFault, SheetFile, lone_number, number_in, read_sheet
from ingest.text import decimal_sign_of
from labbook.config.reading import is_plain
from labbook.plan.drawing import PlanFactor
from labbook.plan.local_time import order_of_dates, parse_clock, parse_date
from labbook.plan.sheet import AFTER_FACTORS, BEFORE_FACTORS, without_mark

_MOST_COLUMNS_EXPLAINED = 5
"""More columns than this that are not known are one fault, not as many."""
_GIVE = "the sheet that `labbook plan` writes, with its header and one run a line"
_NUMBERS = ("position", "duration_s", "jumps_made", "starts")
_LEAST_COUNT = {"position": 1, "jumps_made": 0, "starts": 1}


@dataclass(frozen=True, slots=True)
class RunSheetRow:
    """One run as written down; None where a cell is empty. `levels` (factor: level) is empty for an idle run."""

    line: int
    name: str
    date: datetime.date
    position: int
    kind: RunKind
    levels: Mapping[str, str]
    battery: str | None
    robot: str | None
    started: datetime.time | None
    duration_s: float | None
    jumps_made: int | None
    starts: int | None
    note: str

    @property
    def done(self) -> bool:
        """Whether the run was made: something was written down that only a run that was made has."""
        return any(value is not None for value in (self.started, self.duration_s, self.jumps_made, self.starts))


def read_run_sheet(
    file: SheetFile,
    factors: Sequence[PlanFactor],
    *,
    batteries: Collection[str] | None = None,
    robots: Collection[str] | None = None,
    dates: str | None = None,
) -> tuple[tuple[RunSheetRow, ...], str]:
    """Read the rows of a sheet, its columns in any order; returns them and the page of its text.

    `batteries` and `robots` are the names that exist (None: any), `dates` the order of dates with slashes. Raises
    `SheetRefused` with every fault, `InputRefused` where it is no table at all, and `SheetQuestion` for a date with
    slashes whose order was not declared.
    """
    sheet = read_sheet(file, _GIVE)
    if not set(BEFORE_FACTORS) & set(sheet.names):
        raise InputRefused(
            f"{file.name} is no run sheet, its first line names none of the columns {', '.join(BEFORE_FACTORS)}: give "
            f"{_GIVE}."
        )
    readers = {
        **_readers(sheet, dates),
        **{factor.name: _one_of(f"level of {factor.name}", factor.levels) for factor in factors},
        **({} if batteries is None else {"battery": _one_of("battery", batteries)}),
        **({} if robots is None else {"robot": _one_of("robot", robots)}),
    }
    faults = list(_header_faults(sheet, readers, [factor.name for factor in factors]))
    rows = [
        (line, _values(line, dict(zip(sheet.names, map(without_mark, cells), strict=True)), readers, factors, faults))
        for line, cells in zip(sheet.lines, sheet.rows, strict=True)
    ]
    sheet.refuse([*faults, *_repeated(rows)])
    return tuple(_row(line, values, factors) for line, values in rows), sheet.encoding


def _readers(sheet: Sheet, dates: str | None) -> dict[str, Callable[[str], Any]]:
    """Return how the cells of each fixed column are read; an error's text is the sentence shown."""
    order = order_of_dates(sheet.columns.get("date", ()), dates)
    cells = [cell.encode() for name in _NUMBERS for cell in sheet.columns.get(name, ())]
    sign, unclear = decimal_sign_of(cells)
    decimal = "." if unclear is not None else sign.decode()

    def seconds(cell: str) -> float:
        number = number_in(cell, decimal)
        if not isinstance(number, float) or not 0.0 < number <= 86_400.0:
            raise InputRefused(f"{cell!r} is not a duration: write seconds, such as 720.")
        return number

    def counted_from(least: int) -> Callable[[str], int]:
        def count(cell: str) -> int:
            number = number_in(cell, decimal)
            if not isinstance(number, float) or not number.is_integer() or not least <= number <= 1_000_000:
                raise InputRefused(f"{cell!r} is not a count: write a whole number, {least} or more.")
            return int(number)

        return count

    return {
        **dict.fromkeys((*BEFORE_FACTORS, *AFTER_FACTORS), _plain),
        "date": lambda cell: parse_date(cell, order),
        "kind": _kind,
        "started": parse_clock,
        "duration_s": seconds,
        **{name: counted_from(least) for name, least in _LEAST_COUNT.items()},
    }


def _plain(cell: str) -> str:
    """Read a name, or a note of one or more lines."""
    if not is_plain("".join(cell.split("\n"))):
        raise InputRefused(f"{cell!r} has unprintable characters: write plain text.")
    return cell


def _kind(cell: str) -> RunKind:
    if cell not in list(RunKind):
        raise unknown_name("kind of run", cell, list(RunKind))
    return RunKind(cell)


def _one_of(what: str, allowed: Iterable[str]) -> Callable[[str], str]:
    """Build the reader of one of the `allowed` names; a number may be written in another way (`400.0` for `400`)."""
    names = list(allowed)
    numbers = {lone_number(name): name for name in names}

    def read_known(cell: str) -> str:
        if cell in names:
            return cell
        number = lone_number(cell)
        if number is None or number not in numbers:
            raise unknown_name(what, cell, names)
        return numbers[number]

    return read_known


def _header_faults(sheet: Sheet, known: Collection[str], factors: Sequence[str]) -> Iterator[SheetFault]:
    unknown = [column for column in sheet.names if column not in known]
    explained: set[str | None] = set()
    if len(unknown) > _MOST_COLUMNS_EXPLAINED:
        shown = ", ".join(repr(column) for column in unknown[:_MOST_COLUMNS_EXPLAINED])
        sentence = (
            f"{len(unknown)} columns are not known, {shown} and so on: take them out; known are {', '.join(known)}."
        )
        yield SheetFault(sheet.header_line, None, sentence)
    else:
        for column in unknown:
            explained.add(nearest(column, known))
            yield SheetFault(sheet.header_line, column, str(unknown_name("column", column, known)), column)
    for column in (*BEFORE_FACTORS, *factors):
        if column not in sheet.names and column not in explained:
            yield SheetFault(sheet.header_line, column, f"the column {column!r} is missing: add it.")


def _values(
    line: int,
    cells: Mapping[str, str],
    readers: Mapping[str, Callable[[str], Any]],
    factors: Sequence[PlanFactor],
    faults: list[SheetFault],
) -> dict[str, Any]:
    """Read the cells of one row that are filled and right; add the faults of the others."""
    values: dict[str, Any] = {}
    for column, cell in cells.items():
        if cell and column in readers:
            try:
                values[column] = readers[column](cell)
            except (InputRefused, UsageError) as error:
                faults.append(SheetFault(line, column, str(error), cell))
    for column, sentence in _contradictions(cells, values.get("kind"), factors):
        faults.append(SheetFault(line, column, sentence, cells[column]))
    return values


def _row(line: int, values: Mapping[str, Any], factors: Sequence[PlanFactor]) -> RunSheetRow:
    fixed: dict[str, Any] = {name: values.get(name) for name in ("date", "position", "kind", *AFTER_FACTORS)}
    levels = {factor.name: values[factor.name] for factor in factors if factor.name in values}
    return RunSheetRow(**{**fixed, "note": values.get("note", "")}, line=line, name=values["run"], levels=levels)


def _contradictions(
    cells: Mapping[str, str], kind: RunKind | None, factors: Sequence[PlanFactor]
) -> Iterator[tuple[str, str]]:
    """Cells that are empty and must not be, or the other way round, each with its sentence."""
    for column in BEFORE_FACTORS:
        if column in cells and not cells[column]:
            yield column, "the cell is empty: every row needs it."
    for factor in factors:
        cell = cells.get(factor.name)
        if kind is RunKind.JUMPS and cell == "":
            yield factor.name, "the cell is empty: a run of jumps has a level of every factor."
        if kind is RunKind.IDLE and cell:
            yield factor.name, f"{cell!r} is given for an idle run, which has no levels: empty the cell."
    jumps_made = cells.get("jumps_made")
    if kind is RunKind.IDLE and jumps_made not in (None, "", "0"):
        yield (
            "jumps_made",
            f"{jumps_made!r} is given for an idle run, which has no jumps: empty the cell, or correct kind.",
        )
    if kind is RunKind.JUMPS and jumps_made == "" and any(cells.get(column) for column in ("started", "duration_s")):
        yield "jumps_made", "the cell is empty though the run was made: count its jumps, 0 if there were none."


def _repeated(runs: Sequence[tuple[int, Mapping[str, Any]]]) -> Iterator[SheetFault]:
    names: dict[str, int] = {}
    places: dict[tuple[datetime.date, int], int] = {}
    for line, values in runs:
        name, date, position = values.get("run"), values.get("date"), values.get("position")
        if name is not None and (first := names.setdefault(name, line)) != line:
            yield SheetFault(line, "run", f"{name!r} is on line {first} too: rename one of them.", name)
        if date is None or position is None:
            continue
        if (first := places.setdefault((date, position), line)) != line:
            sentence = f"position {position} of {date} is on line {first} too: number the runs of a day 1, 2, 3."
            yield SheetFault(line, "position", sentence, str(position))
