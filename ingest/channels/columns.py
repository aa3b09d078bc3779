"""From source columns to channels: which quantity, unit and factor; a unit is never guessed."""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from data_schema.calibration import Calibration
from data_schema.vocabulary import CHANNELS
from ingest.channels.names import (
    COUNTS,
    FACTORS,
    TIME_NAMES,
    UNIT_OF_NAME,
    channel_kind,
    channel_of,
    clean_name,
    factor,
    is_common,
    is_of_plate,
    normal_unit,
    parse_header,
    refuse_other_unit,
    refuse_two_units,
    squash,
    usual_units,
)
from ingest.declared import argument, declared_columns, flag_names, positions_of
from ingest.instruments import Instrument
from ingest.model import FILE, NOTE, ColumnDeclaration, Declarations, FindingCollector
from ingest.tables.table import CellKind, Table

TIME = "time"
DATE = "date"
_DATE_NAMES = frozenset({"date", "datum"})


@dataclass(frozen=True, slots=True)
class ColumnPlan:
    """How one source column becomes a channel: `stored = sign * (scale * source + offset)`.

    `base` is its name without the unit, `flag` how flags name it, `kind` what its cells hold; `channel` is empty where
    none is known, `unit` the one it is stored in: until that is decided, the one in the file. `file_unit` is the file's
    whatever is declared. `declared_channel` is what flags call the channel: by the file's own axes. Until one of the
    `calibrations` is chosen, `scale` and `offset` convert their `calibrated_unit` to the stored one.
    """

    position: int
    source_name: str
    base: str
    flag: str
    kind: CellKind
    channel: str
    unit: str | None
    source_unit: str | None
    file_unit: str | None
    is_declared: bool
    declared_sign: int | None
    calibrations: tuple[Calibration, ...]
    declared_channel: str = ""
    scale: float = 1.0
    offset: float = 0.0
    sign: int = 1
    assumed: tuple[str, ...] = ()
    calibrated_unit: str | None = None


@dataclass(frozen=True, slots=True)
class TimePlan:
    """The time column; `unit` is None for clock text, and where it is stated nowhere.

    `flag` is how flags name it, `file_unit` the unit in the file, whatever is declared; `date_position` is where the
    dates stand that go with clock texts without one, `fraction_position` where the nanoseconds or microseconds that
    go with whole seconds.
    """

    position: int
    source_name: str
    flag: str
    kind: CellKind
    unit: str | None
    date_position: int | None = None
    file_unit: str | None = None
    fraction_position: int | None = None

    @property
    def positions(self) -> tuple[int, ...]:
        """All columns that the time is in."""
        also = (self.date_position, self.fraction_position)
        return (self.position, *(position for position in also if position is not None))


@dataclass(frozen=True, slots=True)
class Plan:
    """All columns that are read."""

    time: TimePlan | None
    columns: tuple[ColumnPlan, ...]


def plan_columns(table: Table, declared: Declarations, findings: FindingCollector, instrument: Instrument) -> Plan:
    """Decide what each column becomes; every column without a unit that needs one is reported."""
    declarations = declared_columns(declared, table.names)
    declared = _time_of_flags(declared, table.names)
    columns = [
        _column(position, flag, table, declared, declarations.get(position), findings)
        for position, flag in enumerate(flag_names(table.names))
    ]
    _refuse_side_by_side(columns, findings)
    time = _with_date(_time_plan(columns, instrument, findings), columns, declared, table.names)
    planned = []
    for column in columns:
        if time is not None and column.position in time.positions:
            continue
        plan = _channel_plan(column, instrument, findings)
        if plan is not None:
            planned.append(plan)
    assumed = [plan.source_name for plan in planned if plan.assumed]
    if assumed:
        message = (
            f"Units that the file does not state are those of {instrument.maker}; kept with the channels as assumed."
        )
        findings.add(NOTE, "unit_assumed", message, count=len(assumed), value=", ".join(assumed))
    if not planned and columns:
        findings.add(FILE, "no_channels", "No column beside the time holds numbers: there is no signal to import.")
    return Plan(time, _distinct(planned, findings))


def _time_of_flags(declared: Declarations, names: Sequence[str]) -> Declarations:
    """Return `declared` without the time column, or its unit, where declarations of single columns differ from it."""
    direct = declared_columns(dataclasses.replace(declared, profile_columns={}), names)
    own = () if declared.time_column is None else positions_of(declared.time_column, names)
    named = [position for position, declaration in direct.items() if declaration.channel == TIME]
    other = [position for position in own if position in direct and direct[position].channel not in (None, TIME)]
    if other or (named and not set(named).intersection(own)):
        return dataclasses.replace(declared, time_column=None, time_unit=None)
    if any(position in direct and direct[position].unit for position in (*own, *named)):
        return dataclasses.replace(declared, time_unit=None)
    return declared


def _column(
    position: int,
    flag: str,
    table: Table,
    declared: Declarations,
    declaration: ColumnDeclaration | None,
    findings: FindingCollector,
) -> ColumnPlan:
    name = table.names[position]
    cell = parse_header(name)
    base, unit = cell.named(_is_known)
    if base == cell.base and cell.suffix_unit is not None and is_common(cell.suffix_unit, _stored_unit(base)):
        unit = cell.suffix_unit  # `battery_V` is known as a whole, and `v_in` is in no inches
    row_unit = normal_unit(table.units[position] or "")
    decided = declared.override_units and declaration is not None and declaration.unit is not None
    if not decided:
        refuse_two_units(name, flag, unit, row_unit, findings)
    unit = unit or row_unit or UNIT_OF_NAME.get(squash(base))
    own = table.channels[position] if table.channels else None
    channel = own or (TIME if squash(base) in TIME_NAMES else channel_of(base, unit))
    sign, calibrations = None, tuple[Calibration, ...]()
    file_unit, declared_unit = unit, None
    if declaration is not None:
        declared_unit = normal_unit(declaration.unit) if declaration.unit else None
        channel, unit, sign = declaration.channel or channel, declared_unit or unit, declaration.sign
        calibrations = declaration.calibrations
    if declared.time_column is not None:
        is_time = position in positions_of(declared.time_column, table.names)
        channel = TIME if is_time else None if channel == TIME else channel
    if channel == TIME and declared.time_unit is not None:
        unit = declared_unit = normal_unit(declared.time_unit)
    raw_unit = file_unit
    if all(each.scale == 1.0 for each in calibrations) and not (calibrations and file_unit in COUNTS):
        refuse_other_unit(name, file_unit, declared_unit, declared, findings)
        raw_unit = unit  # else the header's unit is that of the raw numbers
    is_declared = declaration is not None and declaration.channel is not None
    is_declared |= channel == TIME and declared.time_column is not None
    return ColumnPlan(
        position,
        name,
        base,
        flag,
        table.kinds[position],
        channel or "",
        unit,
        raw_unit,
        file_unit,
        is_declared,
        sign,
        calibrations,
    )


def _refuse_side_by_side(columns: list[ColumnPlan], findings: FindingCollector) -> None:
    """Refuse columns that an empty one without a name parts into two tables, both with a time or one same channel."""
    for middle in columns[1:-1]:
        if middle.source_name or middle.kind is not CellKind.EMPTY:
            continue
        left = {column.channel for column in columns[: middle.position] if column.channel}
        both = left & {column.channel for column in columns[middle.position + 1 :]}
        if both:
            findings.add(
                FILE,
                "tables_side_by_side",
                f"Left and right of the empty column {middle.position + 1} stand two tables, for both have "
                f"{min(both)}: export one table a file.",
            )
            return


def _stored_unit(name: str) -> str:
    kind = channel_kind(channel_of(name) or "")
    return "" if kind is None else CHANNELS[kind].unit


def _is_known(name: str) -> bool:
    return squash(name) in TIME_NAMES or channel_of(name) is not None


def _time_plan(columns: list[ColumnPlan], instrument: Instrument, findings: FindingCollector) -> TimePlan | None:
    of_seconds = _fractions(columns)
    named = [column for column in columns if column.channel == TIME]
    named = named or [column for column in columns if not column.channel and column.position in of_seconds]
    named = [column for column in named if column.is_declared] or named
    if len(named) > 1:
        numeric = [column for column in named if column.kind in (CellKind.NUMBER, CellKind.INTEGER)]
        if len(numeric) != 1:
            listed = ", ".join(repr(column.source_name) for column in named)
            findings.add(
                FILE,
                "several_time_columns",
                f"Columns {listed} are all times, and each may govern those to its right: "
                f'say which one counts with `--column "{named[0].flag}=time"`, or export one table a file.',
            )
            return None
        named = numeric
    if not named:
        return None
    column = named[0]
    if column.kind in (CellKind.TEXT, CellKind.EMPTY):
        findings.add(
            FILE,
            "time_unreadable",
            "The time column holds neither numbers nor times as 2021-06-05 14:30:00 or 14:30:00: name another one, "
            f"`--column NAME=time`, or have samples counted by their rate, {count_by_rate_flags(column.flag)}.",
            column=column.source_name,
        )
        return None
    unit = column.unit or instrument.time_unit
    if column.kind is CellKind.CLOCK:
        unit = None
    time = TimePlan(column.position, column.source_name, column.flag, column.kind, unit, file_unit=column.file_unit)
    if column.position not in of_seconds:
        return time
    position, unit = of_seconds[column.position]
    return dataclasses.replace(time, unit=unit, fraction_position=position)


_SECONDS = re.compile(r"(?i)(.*?)(n|nano|u|micro)?sec(?:s|onds)?")
_UNIT_OF_FRACTION = {"n": "ns", "nano": "ns", "u": "us", "micro": "us"}


def _fractions(columns: Sequence[ColumnPlan]) -> dict[int, tuple[int, str]]:
    """Return, by the position of whole seconds, that of the fractions beside them, and their unit: `stamp.sec` and
    `stamp.nanosec` of ROS, `tv_sec` and `tv_usec` of C.
    """
    found = {}
    for left, right in itertools.pairwise(columns):
        whole, fraction = _SECONDS.fullmatch(left.source_name.strip()), _SECONDS.fullmatch(right.source_name.strip())
        if whole is None or fraction is None or whole[2] or not fraction[2] or whole[1] != fraction[1]:
            continue
        if not right.channel and {left.kind, right.kind} <= {CellKind.NUMBER, CellKind.INTEGER}:
            found[left.position] = (right.position, _UNIT_OF_FRACTION[fraction[2].lower()])
    return found


def count_by_rate_flags(flag: str, rate: str = "HZ") -> str:
    """Return the flags that have samples counted at a rate, whatever is in the time column, which flags call `flag`."""
    return f"`--rate {rate} --column {argument(f'{flag}=own.clock')}`"


def _with_date(
    time: TimePlan | None, columns: list[ColumnPlan], declared: Declarations, names: Sequence[str]
) -> TimePlan | None:
    """Return the time column with the column of dates: the one declared, or the one that is called so."""
    if time is None or time.kind is not CellKind.CLOCK:
        return time
    dates = [column.position for column in columns if column.channel == DATE]
    if declared.date_column is not None:
        dates = list(positions_of(declared.date_column, names))
    if not dates:
        dates = [c.position for c in columns if c.kind is CellKind.CLOCK and squash(c.base) in _DATE_NAMES]
    return dataclasses.replace(time, date_position=dates[0]) if dates and dates[0] != time.position else time


def _channel_plan(column: ColumnPlan, instrument: Instrument, findings: FindingCollector) -> ColumnPlan | None:
    if column.kind in (CellKind.TEXT, CellKind.CLOCK):
        what = "text, not numbers" if column.kind is CellKind.TEXT else "dates or times"
        message = f"The column holds {what}: it stays in the raw copy only."
        findings.add(NOTE, "text_column", message, column=column.source_name)
        return None
    if column.kind is CellKind.EMPTY:
        findings.add(NOTE, "empty_column", "The column is empty: it is left out.", column=column.source_name)
        return None
    known = channel_kind(column.channel)
    if known is None:
        return _unknown(column, findings)
    stored = CHANNELS[known].unit
    assumed: tuple[str, ...] = ()
    unit = column.unit
    if unit is None and known in instrument.units:
        unit = instrument.units[known]
        assumed = (f"unit {unit}: {instrument.maker}",)
    if unit is None and stored != "1":
        findings.add(
            FILE,
            "unit_missing",
            f"Column {column.source_name!r} is {column.channel} and its unit is stated nowhere: say which it is in, "
            f'`--unit "{column.flag}=UNIT"` ({usual_units(stored)}), or in a [profiles.NAME] table of labbook.toml.',
            column=column.source_name,
        )
    if unit in COUNTS and stored != "1":
        findings.add(
            FILE,
            "calibration_missing",
            f"Column {column.source_name!r} is {column.channel} and its unit is {unit!r}: say what 1 is in {stored}, "
            f'`--column "{column.flag}={column.channel}:{stored},scale=SCALE,offset=OFFSET"`, or what it shows at '
            f'known values, `--column "{column.flag}={column.channel}:{stored},raw=812 3071,value=0.2 0.85"`.',
            column=column.source_name,
        )
        return _plan(column, clean_name(column.base) or f"column_{column.position + 1}", "counts", unit)
    scale, offset = factor(column.source_name, unit or stored, stored, findings, column.flag)
    return _plan(column, column.channel, stored, unit, scale, offset, assumed)


def _plan(
    column: ColumnPlan,
    channel: str,
    stored: str | None,
    unit: str | None,
    scale: float = 1.0,
    offset: float = 0.0,
    assumed: tuple[str, ...] = (),
) -> ColumnPlan:
    return dataclasses.replace(
        column,
        channel=channel,
        declared_channel=channel,
        unit=stored,
        source_unit=column.source_unit if column.calibrations else unit,
        scale=scale,
        offset=offset,
        sign=column.declared_sign or 1,
        assumed=assumed,
        calibrated_unit=unit,
    )


def _unknown(column: ColumnPlan, findings: FindingCollector) -> ColumnPlan:
    name = column.channel if column.channel != TIME else ""
    name = name or clean_name(column.base) or f"column_{column.position + 1}"
    if not column.is_declared:
        unit, example = (f"in {column.unit}", "") if column.unit else ("without a unit", ":UNIT")
        findings.add(
            NOTE,
            "unknown_column",
            f"Not a channel known here: kept as {name!r}, {unit}; to name it, "
            f'`--column "{column.flag}=CHANNEL{example}"`.',
            column=column.source_name,
        )
    return _plan(column, name, column.unit, column.unit)


def _distinct(planned: list[ColumnPlan], findings: FindingCollector) -> tuple[ColumnPlan, ...]:
    """Give repeated channels the suffixes `_2`, `_3`: plates repeat theirs by design, other columns do not."""
    seen: Counter[str] = Counter()
    taken = {plan.channel for plan in planned}
    distinct = []
    for plan in planned:
        seen[plan.channel] += 1
        name = plan.channel
        if seen[name] > 1:
            number = seen[name]
            while f"{name}_{number}" in taken:
                number += 1
            name = f"{name}_{number}"
            taken.add(name)
            if not is_of_plate(plan.channel):
                findings.add(
                    NOTE,
                    "duplicate_column",
                    f"Another column is the same channel: this one is kept as {name!r}.",
                    column=plan.source_name,
                )
        distinct.append(dataclasses.replace(plan, channel=name))
    return tuple(distinct)


_LENGTHS = {**FACTORS["m"], "in": 0.0254, "ft": 0.3048}


def fitting_units(plan: ColumnPlan, value: float, low: float, high: float) -> tuple[str, ...]:
    """Return the other units in which a stored `value` of a column would lie in `low` to `high`."""
    if plan.calibrations:
        return ()
    source = value / plan.scale
    known = _LENGTHS if plan.unit == "m" else FACTORS.get(plan.unit or "", {})
    own = plan.source_unit or plan.unit
    return tuple(unit for unit, scale in known.items() if unit != own and low <= source * scale <= high)


def in_unit(plan: ColumnPlan, value: float, unit: str) -> float:
    """Return a stored length as it would be, its column being in another unit."""
    return value / plan.scale * _LENGTHS[unit]


def unit_flags(plan: ColumnPlan, units: Sequence[str]) -> str:
    """Return the flags that have the column read in a unit, left open with the choices where there are several."""
    choices = "" if len(units) == 1 else f" (UNIT: one of {', '.join(units)})"
    return f'`--unit "{plan.flag}={units[0] if len(units) == 1 else "UNIT"}" --override-units`{choices}'


UNDATED = "calibration_undated"
"""The rule of a log without a date whose column has calibrations with dates."""


def with_calibration(plan: ColumnPlan, day: str | None, findings: FindingCollector) -> ColumnPlan:
    """Return the column with the calibration that is in force on a local date; the file is refused where that is none.

    A column without calibrations stays as it is.
    """
    if not plan.calibrations:
        return plan
    raw = dataclasses.replace(
        plan, channel=f"raw_{plan.channel}", unit="counts", scale=1.0, offset=0.0, calibrations=()
    )
    dated = any(each.first_day or each.last_day for each in plan.calibrations)
    if dated and day is None:
        periods = "; ".join(each.period for each in plan.calibrations)
        message = f"The calibrations of column {plan.source_name!r} have dates ({periods}), and the file has none: say"
        findings.add(FILE, UNDATED, f"{message} `--day YYYY-MM-DD`.", column=plan.source_name)
        return raw
    held = [each for each in plan.calibrations if day is None or each.holds_on(day)]
    if len(held) != 1:
        periods = "; ".join(each.period for each in plan.calibrations)
        message = f"{len(held) or 'None'} of the calibrations of column {plan.source_name!r} ({periods}) hold on {day}"
        message += ": correct `from` and `until` in its profile, or the day with `--day YYYY-MM-DD`."
        findings.add(FILE, "calibration_unclear", message, column=plan.source_name, value=day)
        return raw
    (chosen,) = held
    message = f"Calibrated: {chosen.sentence(plan.source_name, plan.channel, plan.calibrated_unit)}."
    findings.add(NOTE, "calibrated", message, column=plan.source_name)
    return dataclasses.replace(
        plan, scale=plan.scale * chosen.scale, offset=plan.scale * chosen.offset + plan.offset, calibrations=(chosen,)
    )
