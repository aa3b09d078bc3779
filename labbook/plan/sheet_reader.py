"""Read a run sheet that a person filled in, and say everything that is wrong with it at once."""

from __future__ import annotations

import csv
import datetime
import io
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from data_schema.errors import InputRefused, UsageError, nearest, unknown_name
from data_schema.vocabulary import RunKind
from labbook.config.run_names import composed
from labbook.plan.drawing import PlanFactor
from labbook.plan.sheet import BEFORE_FACTORS
from labbook.plan.sheet_cells import CELL_READERS, SheetQuestion, date_reader, one_of, without_mark

MOST_FAULTS_SHOWN = 50
MOST_LINES_SHOWN = 20
MOST_COLUMNS_EXPLAINED = 5
"""More columns than this that are not known are one fault, not as many."""
_DELIMITERS = ",;\t"
_SEPARATOR_LINE = re.compile(r"sep=[,;\t]")
"""The line that tells spreadsheets the separator."""


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


@dataclass(frozen=True, slots=True)
class RunSheetFault:
    """What is wrong with one cell; `column` is None for a whole row."""

    line: int
    column: str | None
    value: str
    sentence: str

    def __str__(self) -> str:
        place = f"line {self.line}" if self.column is None else f"line {self.line}, {self.column}"
        return f"{place}: {self.sentence}"


def _fault_text(same: Sequence[RunSheetFault]) -> str:
    """Say once what is wrong in several lines."""
    if len(same) == 1:
        return str(same[0])
    lines = ", ".join(str(fault.line) for fault in same[:MOST_LINES_SHOWN])
    more = f" and {len(same) - MOST_LINES_SHOWN} more" if len(same) > MOST_LINES_SHOWN else ""
    column = "" if same[0].column is None else f", {same[0].column}"
    return f"{len(same)} lines, {lines}{more}{column}: {same[0].sentence}"


class RunSheetRefused(InputRefused):
    """A run sheet with faults, all of them in `faults`; nothing of it was taken over."""

    def __init__(self, source: str, faults: Sequence[RunSheetFault]) -> None:
        self.faults = tuple(faults)
        alike: dict[tuple[str | None, str], list[RunSheetFault]] = {}
        for fault in self.faults:
            alike.setdefault((fault.column, fault.sentence), []).append(fault)
        shown = list(alike.values())[:MOST_FAULTS_SHOWN]
        listed = "".join(f"\n  {_fault_text(same)}" for same in shown)
        rest = len(self.faults) - sum(map(len, shown))
        more = f"\n  and {rest} more." if rest > 0 else ""
        count = "1 fault" if len(self.faults) == 1 else f"{len(self.faults)} faults"
        super().__init__(f"{source} has {count}; correct it and try again, nothing was stored:{listed}{more}")


def read_run_sheet(
    text: str,
    factors: Sequence[PlanFactor],
    *,
    source: str = "the run sheet",
    batteries: Collection[str] | None = None,
    robots: Collection[str] | None = None,
    dates: str | None = None,
) -> tuple[RunSheetRow, ...]:
    """Read the rows of a sheet: comma, semicolon or tab between the cells, columns in any order.

    `batteries` and `robots` are the names that exist (None: any), `dates` the order of dates with slashes. Raises
    `RunSheetRefused` with every fault, `InputRefused` where the text is no table at all, and `SheetQuestion` for a date
    with slashes whose order was not declared.
    """
    if "\0" in text.partition("\n")[0]:
        raise InputRefused(f"{source} is no plain text, a spreadsheet's own file or UTF-16: save it as CSV in UTF-8.")
    table = list(_table(text.removeprefix("\ufeff"), source))
    if not table:
        raise InputRefused(f"{source} is empty: give the sheet that `labbook plan` writes, with its header.")
    readers = {
        **CELL_READERS,
        "date": date_reader(dates),
        **{factor.name: one_of(f"level of {factor.name}", factor.levels) for factor in factors},
        **({} if batteries is None else {"battery": one_of("battery", batteries)}),
        **({} if robots is None else {"robot": one_of("robot", robots)}),
    }
    (header_line, header), *body = table
    header = header[: 1 + max(place for place, column in enumerate(header) if column)]
    if not set(BEFORE_FACTORS) & set(header):
        raise InputRefused(
            f"{source} is no run sheet, its first line names none of the columns {', '.join(BEFORE_FACTORS)}: give the "
            "sheet that `labbook plan` writes, with its header."
        )
    faults = list(_header_faults(header_line, header, readers, [factor.name for factor in factors]))
    runs: list[tuple[int, dict[str, Any]]] = []
    for line, cells in body:
        filled = cells if any(cells[len(header) :]) else cells[: len(header)]
        if len(filled) == len(header):
            runs.append((line, _values(line, dict(zip(header, filled, strict=True)), readers, factors, faults)))
        else:
            sentence = f"{len(filled)} cells where the header has {len(header)}: an empty cell needs its separator too."
            faults.append(RunSheetFault(line, None, "", sentence))
    faults += _repeated(runs)
    if not faults and not body:
        raise InputRefused(f"{source} has a header and no run below it: write one run a line and try again.")
    if faults:
        raise RunSheetRefused(source, sorted(faults, key=lambda fault: fault.line))
    return tuple(_row(line, values, factors) for line, values in runs)


def _table(text: str, source: str) -> Iterator[tuple[int, list[str]]]:
    """Cut the text into rows of stripped cells, each with the line it starts on; empty rows are left out."""
    text = composed(text)
    first = next((line for line in text.splitlines() if line.strip()), "")
    delimiter = first[-1] if _SEPARATOR_LINE.fullmatch(first) else max(_DELIMITERS, key=first.count)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    line = 1
    try:
        for cells in reader:
            stripped = [without_mark(cell.strip()) for cell in cells]
            if any(stripped) and not (line == 1 and _SEPARATOR_LINE.fullmatch(first)):
                yield line, stripped
            line = reader.line_num + 1
    except csv.Error as error:
        raise InputRefused(
            f"{source} cannot be cut into cells at line {line} ({error}): correct its quotes."
        ) from error


def _header_faults(
    line: int, header: Sequence[str], known: Collection[str], factors: Sequence[str]
) -> Iterator[RunSheetFault]:
    explained: set[str | None] = set()
    unknown = [column for column in header if column not in known]
    if len(unknown) > MOST_COLUMNS_EXPLAINED:
        shown = ", ".join(repr(column) for column in unknown[:MOST_COLUMNS_EXPLAINED])
        sentence = (
            f"{len(unknown)} columns are not known, {shown} and so on: take them out; known are {', '.join(known)}."
        )
        yield RunSheetFault(line, None, "", sentence)
    for place, column in enumerate(header):
        if column not in known and len(unknown) <= MOST_COLUMNS_EXPLAINED:
            explained.add(nearest(column, known))
            yield RunSheetFault(line, column, column, str(unknown_name("column", column, known)))
        elif column in known and column in header[:place]:
            yield RunSheetFault(line, column, column, f"the column {column!r} is there twice: keep one.")
    for column in (*BEFORE_FACTORS, *factors):
        if column not in header and column not in explained:
            yield RunSheetFault(line, column, "", f"the column {column!r} is missing: add it.")


def _values(
    line: int,
    cells: Mapping[str, str],
    readers: Mapping[str, Callable[[str], Any]],
    factors: Sequence[PlanFactor],
    faults: list[RunSheetFault],
) -> dict[str, Any]:
    """Read the cells of one row that are filled and right; add the faults of the others."""
    values: dict[str, Any] = {}
    for column, cell in cells.items():
        if cell and column in readers:
            try:
                values[column] = readers[column](cell)
            except SheetQuestion:
                raise
            except (InputRefused, UsageError) as error:
                faults.append(RunSheetFault(line, column, cell, str(error)))
    for column, sentence in _contradictions(cells, values.get("kind"), factors):
        faults.append(RunSheetFault(line, column, cells[column], sentence))
    return values


def _row(line: int, values: Mapping[str, Any], factors: Sequence[PlanFactor]) -> RunSheetRow:
    return RunSheetRow(
        line=line,
        name=values["run"],
        date=values["date"],
        position=values["position"],
        kind=values["kind"],
        levels={factor.name: values[factor.name] for factor in factors if factor.name in values},
        battery=values.get("battery"),
        robot=values.get("robot"),
        started=values.get("started"),
        duration_s=values.get("duration_s"),
        jumps_made=values.get("jumps_made"),
        starts=values.get("starts"),
        note=values.get("note", ""),
    )


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


def _repeated(runs: Sequence[tuple[int, Mapping[str, Any]]]) -> Iterator[RunSheetFault]:
    names: dict[str, int] = {}
    places: dict[tuple[datetime.date, int], int] = {}
    for line, values in runs:
        name, date, position = values.get("run"), values.get("date"), values.get("position")
        if name is not None and (first := names.setdefault(name, line)) != line:
            yield RunSheetFault(line, "run", name, f"{name!r} is on line {first} too: rename one of them.")
        if date is None or position is None:
            continue
        if (first := places.setdefault((date, position), line)) != line:
            sentence = f"position {position} of {date} is on line {first} too: number the runs of a day 1, 2, 3."
            yield RunSheetFault(line, "position", str(position), sentence)
