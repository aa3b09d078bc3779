"""From a table to signals: columns, rows, checks, time axis, in that order, reporting on the way."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from data_schema.vocabulary import FileRole
from ingest.channels.axes import turn_axes
from ingest.channels.checks import held_rows, note_missing, note_still_channels, out_of_range
from ingest.channels.columns import ColumnPlan, Plan, plan_columns
from ingest.channels.declared import note_absent
from ingest.channels.forces import check_plates, note_assumed_signs, orient
from ingest.channels.robot_facts import check_robot
from ingest.channels.synonyms import is_cop
from ingest.explaining import table_use
from ingest.findings import NOTE, FindingCollector
from ingest.instruments import Instrument, instrument_named
from ingest.model import ChannelData, Declarations, FloatArray, Gap, Reading, SignalPart
from ingest.profiles import with_profile_for_names
from ingest.spool.columns import by_blocks, take
from ingest.tables.table import Block, CellKind, Table, Wanted
from ingest.timebase.axis import Recording, TimeSources, recordings
from ingest.timebase.clock_column import split_clocks
from ingest.timebase.trials import trial_position, trials


def read_signals(table: Table, declared: Declarations, findings: FindingCollector, instrument: Instrument) -> Reading:
    """Turn a table into one signal part for each recording in it."""
    declared = with_profile_for_names(declared, table.names, findings)
    note_absent(declared, table.names, findings)
    if declared.instrument is not None:
        instrument = _declared_instrument(declared.instrument, instrument)
    plan = plan_columns(table, declared, findings, instrument.convention)
    trial_column = trial_position(declared.trials, table, findings)
    no_time = plan.time is None and declared.rate_hz is None and table.preamble.rate_hz is None
    clocks = [position for position, kind in enumerate(table.kinds) if kind is CellKind.CLOCK] if no_time else []
    block = table.read_rows(_wanted(plan, trial_column, clocks))
    if not block.n_rows or not plan.columns:
        findings.tables.append(table_use(table, plan, plan.columns, declared, instrument, trial_column))
        role = _role(plan.columns)
        return Reading(rows_read=block.rows_read, rows_rejected=block.rows_read, role=role, declared=declared)
    stored = {column.position: _stored(block, column) for column in plan.columns}
    if declared.axes is not None:
        instrument = dataclasses.replace(instrument, frame=declared.axes, axes={}, evidence="axes declared")
    said_by = instrument.convention.maker if declared.axes is None else "declared"
    columns = turn_axes(plan.columns, stored, instrument.frame, f"{instrument.frame}: {said_by}")
    usable = ~out_of_range(stored, columns, block, findings)
    note_missing(stored, columns, block, findings)
    columns = orient(columns, stored, instrument.axes, instrument.convention.maker, findings)
    if not instrument.evidence:
        note_assumed_signs(columns, findings)
    columns = check_plates(columns, stored, findings)
    check_robot(columns, stored, usable, declared, findings)
    findings.tables.append(table_use(table, plan, columns, declared, instrument, trial_column))
    given = [position for position in clocks if position in block.clocks]  # not every table of a maker keeps them
    clock_columns = split_clocks({table.names[position]: block.clocks[position] for position in given})
    sources = TimeSources(block, plan, stored, declared, table.preamble, instrument.fixed_rate_hz, clock_columns)
    parts: list[SignalPart] = []
    kept = 0
    for trial, rows in trials(block, trial_column, findings):
        found = recordings(sources, usable & rows, findings)
        name = instrument.part if trial is None else f"trial_{trial}"
        parts += [
            _part(instrument, name if number == 1 else f"{name}_segment_{number}", recording, columns, stored, findings)
            for number, recording in enumerate(found.recordings, start=1)
        ]
        kept += int(np.count_nonzero(found.keep))
    return Reading(tuple(parts), (), block.rows_read, block.rows_read - kept, _role(columns), declared)


def _declared_instrument(name: str, own: Instrument) -> Instrument:
    """Return a declared instrument; of a file whose layout tells its own, the part and units stay."""
    declared = instrument_named(name)
    if not own.evidence:
        return declared
    convention = declared.convention if declared.convention.units else own.convention
    return dataclasses.replace(declared, part=own.part, convention=convention)


def _role(columns: Sequence[ColumnPlan]) -> FileRole:
    return FileRole.FORCE if any(column.channel == "force_z" for column in columns) else FileRole.LOG


def _wanted(plan: Plan, trial_column: int | None, clocks: Sequence[int]) -> list[Wanted]:
    # Only time stamps need all digits of a long integer; a channel is stored as float64 anyway.
    wanted = [
        Wanted(column.position, column.source_name, CellKind.NUMBER, is_cop(column.channel)) for column in plan.columns
    ]
    if plan.time is not None:
        wanted.append(Wanted(plan.time.position, plan.time.source_name, plan.time.kind))
        if plan.time.date_position is not None:
            wanted.append(Wanted(plan.time.date_position, "date", CellKind.CLOCK))
    if trial_column is not None and all(column.position != trial_column for column in wanted):
        wanted.append(Wanted(trial_column, "trial", CellKind.CLOCK))
    known = {column.position for column in wanted}
    wanted += [Wanted(position, "clock", CellKind.CLOCK) for position in clocks if position not in known]
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
