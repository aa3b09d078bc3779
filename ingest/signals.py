"""From a table to signals: columns, rows, checks, time axis, in that order, reporting on the way.

Several tables of one file become parts of their own. What each column became is reported too, and where its unit and
the rate come from.

A long table, `time, sensor, value, unit`, is several: each word of a column names the numbers beside it. A word is the
name of a column wherever the column of numbers has no known name of its own: each series is then read as a table of
that column. Otherwise the words distinguish trials of one channel.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence

import numpy as np

from data_schema.errors import unknown_name
from data_schema.vocabulary import FileRole
from ingest.channels.checks import (
    SIGNED_BY_DIRECTION,
    check_robot,
    held_rows,
    note_missing,
    note_still_channels,
    out_of_range,
    refuse_unsigned,
)
from ingest.channels.columns import ColumnPlan, Plan, TimePlan, plan_columns, with_calibration
from ingest.channels.forces import AXES, Load, check_plates, orient
from ingest.channels.names import (
    TIME_NAMES,
    UNIT_OF_NAME,
    channel_of,
    clean_name,
    is_cop,
    is_of_plate,
    is_unit,
    normal_unit,
    parse_header,
    squash,
)
from ingest.declared import declared_columns, note_absent, positions_of, with_profile_for_names, without
from ingest.instruments import Instrument, instrument_named
from ingest.model import (
    FILE,
    NOTE,
    BoolArray,
    ChannelData,
    ColumnUse,
    Declarations,
    FindingCollector,
    FloatArray,
    Gap,
    IntArray,
    Reading,
    SignalPart,
    TableUse,
)
from ingest.spool import by_blocks, take
from ingest.tables.layout import refuse_jumps_by_thousand
from ingest.tables.table import Block, CellKind, Table, Wanted
from ingest.timebase.axis import Recording, TimeSources, first_day, recordings, with_epoch_unit


def read_signals(table: Table, declared: Declarations, findings: FindingCollector, instrument: Instrument) -> Reading:
    """Turn a table into one signal part for each recording in it. Raises `UsageError` for axes that are none."""
    declared = with_profile_for_names(declared, table.names, findings)
    by_word = series(table, declared, findings)
    if by_word.keys() != {""}:
        named = [
            (each, dataclasses.replace(instrument, part=f"trial_{clean_name(word) or number}"))
            for number, (word, each) in enumerate(by_word.items(), start=1)
        ]
        return read_several(named, dataclasses.replace(declared, trials=None), findings)
    table = by_word[""]
    note_absent(declared, table.names, findings)
    if declared.instrument is not None:
        instrument = _declared_instrument(declared.instrument, instrument)
    plan = plan_columns(table, declared, findings, instrument)
    trial_column = trial_position(declared.trials, table, findings)
    signed = any(column.channel in SIGNED_BY_DIRECTION for column in plan.columns)
    mixed = declared.trials is None and plan.time is not None
    texts = [at for at, kind in enumerate(table.kinds) if (signed or mixed) and kind is CellKind.TEXT]
    block = table.read_rows(_wanted(plan, trial_column, texts))
    words = {table.names[at]: block.clocks[at] for at in texts if at in block.clocks}
    if mixed and plan.time is not None:
        refuse_series(block, plan.time.position, words, findings)
    if table.text is not None:
        refuse_jumps_by_thousand(block, table.text, declared, findings)
    plan = dataclasses.replace(plan, time=with_epoch_unit(plan.time, block, findings))
    plan = _calibrated(plan, block, table, declared, findings)
    if not block.n_rows or not plan.columns:
        findings.tables.append(table_use(table, plan, plan.columns, declared, instrument, trial_column))
        role = _role(plan.columns)
        return Reading(rows_read=block.rows_read, rows_rejected=block.rows_read, role=role, declared=declared)
    stored = {column.position: _stored(block, column) for column in plan.columns}
    if declared.axes is not None:
        if declared.axes not in AXES:
            raise unknown_name("frame of forces", declared.axes, AXES)
        action = instrument.action and declared.axes == instrument.frame
        instrument = dataclasses.replace(
            instrument, frame=declared.axes, action=action, evidence="axes declared", declared=True
        )
    if instrument.frame not in AXES:  # of a plug-in, which is named beside the sentence
        raise ValueError(str(unknown_name("frame of forces", instrument.frame, AXES)))
    columns, loads = plan.columns, dict[int, Load]()
    of_plates = any(map(is_of_plate, (column.channel for column in columns)))
    if of_plates:
        columns, loads = orient(columns, stored, instrument, findings)
    usable = ~out_of_range(stored, columns, loads, block, findings)
    note_missing(stored, columns, block, findings)
    refuse_unsigned(stored, columns, words, usable, findings)
    columns = check_plates(columns, stored, loads, usable, findings) if of_plates else columns
    check_robot(columns, stored, loads, usable, declared, findings)
    findings.tables.append(table_use(table, plan, columns, declared, instrument, trial_column))
    sources = TimeSources(block, plan, stored, declared, table.preamble, instrument.fixed_rate_hz, findings)
    parts: list[SignalPart] = []
    n_usable = 0
    for trial, rows in trials(block, trial_column, findings):
        found = recordings(sources, usable & rows)
        name = instrument.part if trial is None else f"trial_{trial}"
        parts += [
            _part(instrument, name if number == 1 else f"{name}_segment_{number}", recording, columns, stored, findings)
            for number, recording in enumerate(found.recordings, start=1)
        ]
        n_usable += int(np.count_nonzero(found.keep))
    return Reading(tuple(parts), (), block.rows_read, block.rows_read - n_usable, _role(columns), declared)


def _calibrated(plan: Plan, block: Block, table: Table, declared: Declarations, findings: FindingCollector) -> Plan:
    """Choose the calibration of each column by the day that is declared, or else of the first row."""
    if not any(column.calibrations for column in plan.columns):
        return plan
    sources = TimeSources(block, plan, {}, declared, table.preamble, None, FindingCollector())  # noted later, once
    day = declared.day or first_day(sources)
    return dataclasses.replace(plan, columns=tuple(with_calibration(column, day, findings) for column in plan.columns))


def _declared_instrument(name: str, own: Instrument) -> Instrument:
    """Return a declared instrument; a part that has a name keeps it, a file whose layout shows its maker the units."""
    declared = instrument_named(name)
    maker = declared if declared.units or not own.evidence else own
    part = declared.part if own.part == Instrument().part else own.part
    return dataclasses.replace(declared, part=part, maker=maker.maker, units=maker.units, time_unit=maker.time_unit)


def _role(columns: Sequence[ColumnPlan]) -> FileRole:
    channels = {column.channel for column in columns}
    return FileRole.FORCE if "force_z" in channels and "body_height" not in channels else FileRole.LOG


def _wanted(plan: Plan, trial_column: int | None, texts: Sequence[int]) -> list[Wanted]:
    # Only time stamps need all digits of a long integer; a channel is stored as float64 anyway.
    wanted = [
        Wanted(column.position, column.source_name, CellKind.NUMBER, is_cop(column.channel)) for column in plan.columns
    ]
    if plan.time is not None:
        wanted.append(Wanted(plan.time.position, plan.time.source_name, plan.time.kind))
        if plan.time.date_position is not None:
            wanted.append(Wanted(plan.time.date_position, "date", CellKind.CLOCK))
        if plan.time.fraction_position is not None:
            wanted.append(Wanted(plan.time.fraction_position, "fractions of a second", CellKind.NUMBER))
    if trial_column is not None and all(column.position != trial_column for column in wanted):
        wanted.append(Wanted(trial_column, "trial", CellKind.CLOCK))
    known = {column.position for column in wanted}
    wanted += [Wanted(position, "words", CellKind.TEXT) for position in texts if position not in known]
    return sorted(wanted, key=lambda column: column.position)


def _stored(block: Block, plan: ColumnPlan) -> FloatArray:
    """Return a column in its stored unit, its declared sign applied; the column itself where nothing changes."""
    values: FloatArray = np.asarray(block.numbers[plan.position], dtype=np.float64)
    scale, offset = plan.sign * plan.scale, plan.sign * plan.offset
    if scale != 1.0:
        values = by_blocks(values, lambda block: block * scale)
    return by_blocks(values, lambda block: block + offset) if offset != 0.0 else values


def _part(
    instrument: Instrument,
    name: str,
    recording: Recording,
    plans: Sequence[ColumnPlan],
    stored: Mapping[int, FloatArray],
    findings: FindingCollector,
) -> SignalPart:
    channels = tuple(
        ChannelData(
            plan.channel,
            plan.unit,
            plan.source_name,
            plan.source_unit,
            plan.scale,
            plan.offset,
            plan.sign,
            plan.assumed,
            take(stored[plan.position], recording.rows),
            plan.calibrations[0] if plan.calibrations else None,
            plan.calibrated_unit if plan.calibrations else None,
        )
        for plan in plans
    )
    axis = recording.timebase
    held: tuple[Gap, ...] = ()
    if not instrument.steady:
        note_still_channels(channels, findings)
        held = held_rows(axis.time_s, channels)
    if held:
        message = "All channels repeat for several rows: a logger that writes its last packet again; marked as gaps."
        findings.add(NOTE, "packets_held", message, count=len(held))
    return SignalPart(
        name,
        axis.time_s,
        axis.rate_hz,
        recording.start_utc,
        recording.start_original,
        channels,
        tuple(sorted((*axis.gaps, *held), key=lambda gap: gap.start_s)),
    )


def read_several(
    tables: Sequence[tuple[Table, Instrument]], declared: Declarations, findings: FindingCollector
) -> Reading:
    """Read each table into parts; what is declared of a column concerns the tables that have it.

    An instrument's `part` is the name of what comes of its table, unique in the file.
    """
    present = [{*table.names, *(parse_header(name).base for name in table.names)} for table, _ in tables]
    anywhere = set().union(*present)
    return combine(
        [
            read_signals(table, without(declared, anywhere - names), findings, instrument)
            for (table, instrument), names in zip(tables, present, strict=True)
        ]
    )


def combine(readings: Sequence[Reading]) -> Reading:
    """Return the readings of a file's tables as one: their parts and charges in order, their rows added."""
    roles = {reading.role for reading in readings}
    charges = [charge for reading in readings for charge in reading.charges]
    return Reading(
        tuple(part for reading in readings for part in reading.parts),
        tuple(dataclasses.replace(charge, row_number=number) for number, charge in enumerate(charges, start=1)),
        sum(reading.rows_read for reading in readings),
        sum(reading.rows_rejected for reading in readings),
        next((role for role in (FileRole.FORCE, FileRole.CHARGE, FileRole.LOG) if role in roles), None),
    )


LEFT_OUT = {
    CellKind.TEXT: "it holds text",
    CellKind.CLOCK: "it holds dates or times",
    CellKind.EMPTY: "it is empty",
}


def table_use(
    table: Table,
    plan: Plan,
    columns: Sequence[ColumnPlan],
    declared: Declarations,
    instrument: Instrument,
    trial_column: int | None,
) -> TableUse:
    """Say what became of a table whose final columns are `columns`."""
    uses = {
        at: ColumnUse(at + 1, name, None, left_out=LEFT_OUT.get(table.kinds[at], "nothing is known of it"))
        for at, name in enumerate(table.names)
    }
    if trial_column is not None:
        uses[trial_column] = ColumnUse(trial_column + 1, table.names[trial_column], "trial")
    for column in columns:
        uses[column.position] = ColumnUse(
            column.position + 1,
            column.source_name,
            column.channel,
            column.source_unit,
            column.unit,
            _unit_from(column.position, column.source_unit, table, declared, instrument),
            column.sign,
            column.assumed,
        )
    if (time := plan.time) is not None:
        unit, unit_from = time.unit, _time_unit_from(time, table, declared, instrument)
        if time.fraction_position is not None:
            unit, unit_from = "s", "header"
        elif time.kind is CellKind.CLOCK:
            unit = "clock"
        for at, holds, its_unit, its_source in (
            (time.position, "time", unit, unit_from),
            (time.date_position, "date", None, None),
            (time.fraction_position, "time", time.unit, "header"),
        ):
            if at is not None:
                uses[at] = ColumnUse(at + 1, table.names[at], holds, its_unit, unit_from=its_source)
    return TableUse(table.text, tuple(uses.values()), _rate_from(table, plan, declared, instrument))


def _unit_from(
    position: int, unit: str | None, table: Table, declared: Declarations, instrument: Instrument
) -> str | None:
    """Return where the unit of a column was found; None where it is nowhere."""
    of_profile, direct = (
        declared_columns(each, table.names).get(position)
        for each in (declared, dataclasses.replace(declared, profile_columns={}))
    )
    cell = parse_header(table.names[position])
    by_unit = {  # the last that is the unit counts
        UNIT_OF_NAME.get(squash(cell.base)): "name",
        normal_unit(table.units[position] or ""): "header" if table.text is None else "row of units",
        cell.suffix_unit: "header",
        cell.unit: "header",
        normal_unit((of_profile and of_profile.unit) or ""): f"profile {declared.profile}",
        normal_unit((direct and direct.unit) or ""): "declared",
    }
    return None if unit is None else by_unit.get(unit, instrument.maker or None)


def _time_unit_from(time: TimePlan, table: Table, declared: Declarations, instrument: Instrument) -> str | None:
    found = _unit_from(time.position, time.unit, table, declared, instrument)
    if declared.time_unit is None:
        return "its stamps" if found is None and time.unit is not None else found
    return found if found == "declared" or time.unit is None else declared.source


def _rate_from(table: Table, plan: Plan, declared: Declarations, instrument: Instrument) -> str | None:
    if plan.time is not None:
        fixed = f", or {instrument.fixed_rate_hz:g} Hz fixed by the maker" if instrument.fixed_rate_hz else ""
        return f"the stamps in column {plan.time.source_name!r}{fixed}"
    if declared.rate_hz is not None:
        return declared.source
    if table.preamble.rate_hz is not None:
        return "the file's header" if table.preamble.rate_line is None else f"the line {table.preamble.rate_line!r}"
    return None


_TIME = "time"
_MOST_SERIES = 500


def series(table: Table, declared: Declarations, findings: FindingCollector) -> Mapping[str, Table]:
    """Return the table of each series by its word, in order of first rows; of a table whose words name no columns, that
    table alone, by no word.

    Units of a column of units beside them are those of the series; two of one series refuse the file.
    """
    found = () if declared.trials is None else positions_of(declared.trials, table.names)
    if not found or table.kinds[found[0]] is not CellKind.TEXT:
        return {"": table}
    own = found[0]
    declarations = declared_columns(declared, table.names)
    times = {at for at, name in enumerate(table.names) if any(squash(base) in TIME_NAMES for base in _bases(name))}
    times |= {at for at, declaration in declarations.items() if declaration.channel == _TIME}
    if declared.time_column is not None:
        times = set(positions_of(declared.time_column, table.names))
    numeric = [at for at, kind in enumerate(table.kinds) if kind in (CellKind.NUMBER, CellKind.INTEGER)]
    values = [at for at in numeric if at not in times]
    if len(values) != 1:
        return {"": table}
    filled = [at for at, kind in enumerate(table.kinds) if kind is not CellKind.EMPTY]
    block = table.read_rows([Wanted(at, table.names[at], table.kinds[at]) for at in filled])
    cells = np.array([cell.decode("utf-8", errors="replace").strip() for cell in block.clocks[own]], dtype=np.str_)
    words, first = np.unique(cells, return_index=True)
    ordered = [str(words[at]) for at in np.argsort(first)]
    direct = {**declared.profile_columns, **declared.columns}
    named = any(word in direct or any(map(channel_of, _bases(word))) for word in ordered)
    cell = parse_header(table.names[values[0]])
    declaration = declarations.get(values[0])
    measured = any(map(channel_of, _bases(table.names[values[0]]))) or (declaration and declaration.channel)
    if len(ordered) > _MOST_SERIES or "" in ordered or (measured and not named):
        return {"": dataclasses.replace(table, read_rows=lambda _wanted: block)}
    units = _unit_column(table, block, own)
    tables = {}
    for number, word in enumerate(ordered):
        rows = cells == word
        part = _rows(block, rows, 0 if number else block.rows_rejected)
        unit = table.units[values[0]] or cell.unit
        if units is not None:
            unit = _unit(word, part.clocks[units], findings)
        tables[word] = _table(table, values[0], word, unit, part)
    return tables


def _bases(name: str) -> list[str]:
    """Return the name of a header cell without its unit: `time` of `time [s]`, `time_s` or `time` of `time_s`."""
    cell = parse_header(name)
    return [cell.base, *filter(None, [cell.suffix_base])]


def _unit_column(table: Table, block: Block, own: int) -> int | None:
    """Return the position of the column of which all cells are units."""
    for at, kind in enumerate(table.kinds):
        if at != own and kind is CellKind.TEXT:
            written = {cell.decode("utf-8", errors="replace").strip() for cell in set(block.clocks[at])}
            if written and all(map(is_unit, written)):
                return at
    return None


def _unit(word: str, cells: Sequence[bytes], findings: FindingCollector) -> str | None:
    units = sorted({normal_unit(cell.decode("utf-8", errors="replace")) or "" for cell in set(cells)})
    if len(units) > 1:
        message = f"The rows of {word!r} are in {' and '.join(units[:3])}: a column is read in one unit; export it so."
        findings.add(FILE, "cell_units_differ", message, column=word)
    return units[0] if units else None


def _table(table: Table, position: int, word: str, unit: str | None, block: Block) -> Table:
    names, units = list(table.names), list(table.units)
    names[position], units[position] = word, unit
    return dataclasses.replace(table, names=tuple(names), units=tuple(units), read_rows=lambda _wanted: block)


def _rows(block: Block, rows: BoolArray, rejected: int) -> Block:
    """Return those rows of a block that `rows`, shape (n_rows,), marks."""
    at = np.flatnonzero(rows)
    numbers = {position: values[at] for position, values in block.numbers.items()}
    clocks = {position: [cells[row] for row in at.tolist()] for position, cells in block.clocks.items()}
    return Block(numbers, clocks, block.lines[at], block.ordinals[at], rejected)


MOST_TRIALS = 500


def trial_position(column: str | None, table: Table, findings: FindingCollector) -> int | None:
    """Return the position of the column that distinguishes trials; a column that is not there refuses the file."""
    if column is None:
        return None
    positions = positions_of(column, table.names)
    if positions:
        return positions[0]
    listed = ", ".join(map(repr, table.names[:12]))
    message = f"The trials are told apart by column {column!r}, which the file does not have: it has {listed}."
    findings.add(FILE, "trial_column_absent", message, column=column)
    return None


def trials(block: Block, position: int | None, findings: FindingCollector) -> list[tuple[str | None, BoolArray]]:
    """Return the name of each trial and its rows, shape (n_rows,), in order of their first row; one trial without such
    a column.
    """
    if position is None:
        return [(None, np.ones(block.n_rows, dtype=np.bool_))]
    if position in block.clocks:
        values = np.array([cell.decode("utf-8", errors="replace").strip() for cell in block.clocks[position]])
    else:
        values = np.array([f"{value:.15g}" for value in np.asarray(block.numbers[position]).tolist()])
    found, first, which = np.unique(values, return_index=True, return_inverse=True)
    if len(found) > MOST_TRIALS:
        message = f"The column has {len(found)} values, more than the {MOST_TRIALS} trials allowed: name another one."
        findings.add(FILE, "too_many_trials", message)
        return []
    names: list[str] = []
    for value in found.tolist():
        name = clean_name(value) or "without_name"
        names.append(name if name not in names else f"{name}_{len(names)}")
    return [(names[trial], which == trial) for trial in np.argsort(first).tolist()]


def refuse_series(
    block: Block, time_position: int, texts: Mapping[str, Sequence[bytes]], findings: FindingCollector
) -> None:
    """Refuse a long table: its stamps repeat and are each once under each word of a column, by name in `texts`, or
    those of each word follow each other more steadily than all together.
    """
    stamps = block.clocks[time_position] if time_position in block.clocks else block.numbers[time_position]
    if not texts:
        return
    repeats = block.n_rows - len(np.unique(np.asarray(stamps)))
    repeated = repeats >= max(2, block.n_rows / 100)
    stamp = np.unique(np.asarray(stamps), return_inverse=True)[1].astype(np.int64)
    for name, cells in texts.items():
        words, word = np.unique(np.asarray(cells), return_inverse=True)
        if len(words) > MOST_TRIALS:
            continue
        listed = ", ".join(repr(each.decode("utf-8", errors="replace").strip()) for each in words[:6].tolist())
        if repeated and len(np.unique(stamp * len(words) + word)) == block.n_rows:
            message = f"Each stamp stands beside several words of column {name!r} ({listed})"
        elif time_position in block.numbers and _steadier(np.asarray(stamps, dtype=np.float64), word, len(words)):
            message = f"The stamps beside each word of column {name!r} ({listed}) are steadier than all together"
        else:
            continue
        message += (
            f", as in a long table: say `trials = {json.dumps(name, ensure_ascii=False)}` in a [profiles.NAME] table "
            "of labbook.toml, and each becomes a part of its own."
        )
        findings.add(FILE, "series_interleaved", message, column=name)


_STEADIER = 0.5
"""Steps of this share of the spread of all are those of another clock; of a word by chance the spread is as large."""
_FEWEST_STEPS = 3


def _steadier(stamps: FloatArray, word: IntArray, n_words: int) -> bool:
    """Whether the steps between the stamps, shape (n_rows,), of each of several words spread less than all steps."""
    if n_words < 2 or np.bincount(word).min() <= _FEWEST_STEPS:
        return False
    most = _STEADIER * float(np.std(np.diff(stamps)))
    return all(float(np.std(np.diff(stamps[word == each]))) < most for each in range(n_words))
