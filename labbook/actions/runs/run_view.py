"""Everything the book has on one run."""

from __future__ import annotations

import shlex
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.outcomes import Outcome
from data_schema.queries.charges import ChargeOfRun, charges_of_run
from data_schema.queries.files import waiting_files
from data_schema.queries.history import EntryRow, NoteRow, RunFileRow, files_of_run, history_of_run, notes_of
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import (
    CalibratedChannel,
    GapRow,
    SignalRow,
    calibrated_channels,
    gaps_of,
    signals_of_runs,
)
from data_schema.rounding import decimals_for, fixed_text, known_error
from data_schema.rounding import number_text as plain_number_text
from data_schema.vocabulary import FileRole, RunKind, RunState, Undefined
from labbook.actions.runs.jump_review import review_lines
from labbook.analysis.outcomes.conditions import measure, number_of
from labbook.analysis.outcomes.detection import Detections, jumps_found
from labbook.analysis.outcomes.run_apexes import (
    JudgedRun,
    Reviewed,
    by_protocol,
    calibrated_for_other_day,
    judged_run,
    not_reviewed,
    reviewed,
)
from labbook.analysis.outcomes.run_force import PushOffRules, force_of_run
from labbook.analysis.results import Results
from labbook.analysis.study_data import gather_about, records, waits
from labbook.book.naming import changes_in_words, run_named, study_of, words_of
from labbook.config.local_time import local_text
from labbook.config.parsing import Configuration
from reports.display import as_shown, number_text
from reports.numbers import Number

WIDTH = 100
"""Columns of a line of history."""


@dataclass(frozen=True, slots=True)
class RunView:
    """A run with all that belongs to it.

    `from_plate` has what its record of a force plate gives, by the keys of outcomes, empty without one; `others` the
    outcomes beside these, joules and apex height. `charge_waits` says for which file its charge waits.
    `jumps_found` counts the flights with an apex in its logs, or says why they do not count; None without a log.
    `reviewed` and `not_reviewed` have the numbers of the jumps on which a person's verdict stands, and of the others.
    Joules and apex height are None of a run that has none by its kind, or is void.
    """

    run: RunRow
    files: tuple[RunFileRow, ...]
    signals: tuple[tuple[SignalRow, tuple[GapRow, ...]], ...]
    calibrated: tuple[CalibratedChannel, ...]
    calibrated_for_other_day: str | None
    charges: tuple[ChargeOfRun, ...]
    notes: tuple[NoteRow, ...]
    jumps_found: int | Undefined | None
    reviewed: tuple[Reviewed, ...]
    not_reviewed: tuple[int, ...]
    history: tuple[EntryRow, ...]
    history_in_words: tuple[str, ...]
    joules_per_jump: Number | None
    mean_apex_height: Number | None
    from_plate: Mapping[str, Number]
    others: Mapping[str, Number]
    time_zone: str
    charge_waits: Undefined | None


def run_view(detections: Detections, configuration: Configuration, name: str) -> RunView:
    """Collect what belongs to a run, and compute its numbers."""
    connection = detections.connection
    run = run_named(connection, name)
    charges = tuple(charges_of_run(connection, run.uid))
    history = tuple(history_of_run(connection, run.uid, [charge.uid for charge in charges]))
    zone = study_of(connection).time_zone
    protocol = configuration.protocol
    numbers = _numbers(detections, configuration, run)
    signals = signals_of_runs(connection, run_uids=[run.uid])
    logs = [signal for signal in signals if records(signal, FileRole.LOG)]
    forces = [signal for signal in signals if records(signal, FileRole.FORCE)]
    judged = judged_run(detections, run, logs, by_protocol(protocol)) if logs else None
    jumps = judged.judgement.jumps if isinstance(judged, JudgedRun) else ()
    calibrated = calibrated_channels(connection, run.uid)
    other_day = calibrated_for_other_day(run, logs, calibrated)
    return RunView(
        run=run,
        files=tuple(files_of_run(connection, run.uid)),
        signals=tuple((signal, gaps_of(connection, signal.uid)) for signal in signals),
        calibrated=tuple(one for several in calibrated.values() for one in several),
        calibrated_for_other_day=None if other_day is None else other_day.reason,
        charges=charges,
        notes=tuple(notes_of(connection, run.uid)),
        jumps_found=jumps_found(item.jump for item in jumps) if isinstance(judged, JudgedRun) else judged,
        reviewed=reviewed(jumps),
        not_reviewed=not_reviewed(jumps),
        history=history,
        history_in_words=tuple(_in_words(connection, item, zone) for item in history),
        joules_per_jump=numbers.get(Outcome.JOULES),
        mean_apex_height=numbers.get(Outcome.APEX),
        from_plate=_from_plate(detections, forces, PushOffRules(protocol.onset, protocol.take_off)) if forces else {},
        others={outcome.key: number for outcome, number in numbers.items() if outcome not in _NAMED},
        time_zone=zone,
        charge_waits=None if charges else waits(waiting_files(connection), run.uid, FileRole.CHARGE),
    )


_NAMED = (Outcome.JOULES, Outcome.APEX)


def _numbers(detections: Detections, configuration: Configuration, run: RunRow) -> dict[Outcome, Number]:
    """Return a run's outcomes but those of force, or why it has none; nothing of a run not of jumps, or void."""
    if run.kind is not RunKind.JUMPS or run.state is RunState.VOID:
        return {}
    data, computed = gather_about(detections.connection, configuration, [run]), Results()
    found = {}
    for outcome in (outcome for outcome in Outcome if outcome.source is not FileRole.FORCE):
        measured = measure(outcome, computed, detections, data)
        result = measured.results.get(run.uid)
        found[outcome] = (
            Number(measured.missing[run.uid], outcome.unit) if result is None else number_of(result, outcome)
        )
    return found


def _from_plate(detections: Detections, forces: Sequence[SignalRow], rules: PushOffRules) -> dict[str, Number]:
    force = force_of_run(detections, forces, rules)
    return {
        outcome.key: Number(force, outcome.unit) if isinstance(force, Undefined) else number_of(force, outcome)
        for outcome in Outcome
        if outcome.source is FileRole.FORCE
    }


def view_lines(view: RunView) -> list[str]:
    """Write it for people, with local times."""
    run = view.run
    started = "unknown" if run.started_utc is None else local_text(run.started_utc, view.time_zone)
    lines = [
        f"run {run.name} ({run.kind}, {run.state}) on {run.day}, position {run.position_in_day}",
        f"  condition: {run.condition_key or 'none'}{' (control)' if run.is_control else ''}",
        f"  robot {run.robot}, battery {run.battery}, {run.starts} start{'' if run.starts == 1 else 's'}, "
        f"{run.jumps_made} jumps made{_found(view)}",
        f"  started {started}, duration {'unknown' if run.duration_s is None else f'{run.duration_s:g} s'}",
    ]
    named = [("energy of a jump", view.joules_per_jump), ("mean apex", view.mean_apex_height)]
    others = [(str(outcome), view.others[outcome.key]) for outcome in Outcome if outcome.key in view.others]
    for what, number in (*named, *others):
        if number is not None and not isinstance(number.value, Undefined):
            lines.append(f"  {what} {number_text(number)}")
    lines += [f"  {line}" for line in review_lines(view.reviewed, view.not_reviewed)]
    lines += _plate_lines(view.from_plate)
    lines += [
        f"  file {item.name} ({item.role}, {item.n_bytes} bytes, sha256 {item.sha256[:12]})" for item in view.files
    ]
    sources: dict[str, str] = {}
    for signal, gaps in view.signals:
        if sources.setdefault(signal.sha256, signal.file_name) != signal.file_name:
            lines.append(f"  signal {signal.uid} of {signal.file_name}: the samples of {sources[signal.sha256]}, again")
            continue
        rate = "unknown rate" if signal.rate_hz is None else f"{signal.rate_hz:.1f} Hz"
        lines.append(f"  signal {signal.uid}: {signal.n_samples} samples, {rate}: {', '.join(signal.channels)}")
        lines += [
            f"    gap ({gap.kind}) at {gap.start_s:.3f} s, {gap.length_s * 1e3:.0f} ms, {gap.samples_missing} of "
            f"{gap.samples_expected} samples missing"
            for gap in gaps
        ]
    lines += [f"  calibrated: {each.sentence()}, declared by {each.person}" for each in view.calibrated]
    if view.calibrated_for_other_day is not None:
        lines.append(f"  no heights: {view.calibrated_for_other_day}")
    lines += [
        f"  charge {charge.uid}: {charge.charge_mah:g} mAh (steps of {charge.resolution_mah:g})"
        f"{'' if charge.stated_pack is None else f', pack {charge.stated_pack}'}{', added' if charge.added else ''}"
        for charge in view.charges
    ]
    lines += [f"  {what}" for what in _lacking(view)]
    lines += [
        f"  note by {note.person} on {local_text(note.at_utc, view.time_zone)}: {note.text}" for note in view.notes
    ]
    for words in view.history_in_words:
        lines += textwrap.wrap(words, WIDTH, initial_indent="  ", subsequent_indent="    ")
    return lines


def _plate_lines(from_plate: Mapping[str, Number]) -> list[str]:
    """Write what the plate says of a run, each number with its standard error; for one reason one line."""
    found: list[str] = []
    reasons: dict[str, list[str]] = {}
    for outcome in (outcome for outcome in Outcome if outcome.key in from_plate):
        number = as_shown(from_plate[outcome.key])
        if isinstance(number.value, Undefined):
            reasons.setdefault(number.value.reason, []).append(outcome)
            continue
        se = number.se if isinstance(number.se, float) else 0.0
        error = f" ± {fixed_text(se, decimals_for(se))}" if known_error(se) else ""
        found.append(f"  {outcome} {plain_number_text(number.value, error=se)}{error} {number.unit}")
    return [*found, *(f"  no {' or '.join(names)}: {reason}" for reason, names in reasons.items())]


def _lacking(view: RunView) -> list[str]:
    """Return what is missing of a run that counts, and how to add it."""
    run, name = view.run, shlex.quote(view.run.name)
    if run.state is RunState.VOID or run.kind not in (RunKind.JUMPS, RunKind.IDLE):
        return []
    found = []
    if run.kind is RunKind.JUMPS and not any(item.role == FileRole.LOG for item in view.files):
        found.append(f"no log: `labbook ingest FILE --run {name}` takes it in")
    if view.charge_waits is not None:
        found.append(f"no charge: {view.charge_waits.reason}")
    elif not view.charges:
        found.append(f"no charge: `labbook ingest` of the charger's sheet, or `labbook charge {name} MAH`, adds it")
    return found


def _found(view: RunView) -> str:
    if isinstance(view.jumps_found, Undefined):
        return f", none counted in its logs ({view.jumps_found.reason})"
    return "" if view.jumps_found is None else f", {view.jumps_found} found"


def _in_words(connection: sa.Connection, item: EntryRow, zone: str) -> str:
    changes = changes_in_words(connection, item.old, item.new)
    reason = f" ({item.reason})" if item.reason else ""
    what = f" charge {item.uid}" if item.kind == "charge" else ""
    return f"{local_text(item.at_utc, zone)} {item.person} {words_of(item).did}{what}: {changes}{reason}"
