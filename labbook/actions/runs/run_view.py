"""Everything the book has on one run, every run in a line, and what two runs do not have alike."""

from __future__ import annotations

import json
import math
import shlex
import textwrap
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple, TypeAlias

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
from ingest.store import Store
from labbook.actions.runs.jump_review import review_lines
from labbook.analysis.outcomes.conditions import measure, number_of
from labbook.analysis.outcomes.detection import Detections, jumps_found
from labbook.analysis.outcomes.run_apexes import (
    JudgedRun,
    Reviewed,
    as_protocol,
    by_protocol,
    calibrated_for_other_day,
    judge_runs,
    judged_run,
    logs_that_count,
    not_reviewed,
    reviewed,
    to_review,
)
from labbook.analysis.outcomes.run_energy import drain_lines
from labbook.analysis.outcomes.run_force import PushOffRules, force_of_run
from labbook.analysis.results import Results
from labbook.analysis.study_data import gather, gather_about, records, waits
from labbook.book.naming import changes_in_words, run_named, study_of, words_of
from labbook.config.local_time import local_text
from labbook.config.parsing import Configuration
from labbook.terminal import columns, listed
from reports.display import as_shown, number_text, with_unit
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


Value: TypeAlias = str | float | bool | Sequence[Any] | Mapping[str, Any] | Number | Undefined | None
"""What a run has of a thing; None where it has none."""

UTC = "UTC"
"""The unit of instants, which people see in local time."""
SAME_RATE = 1e-3
"""Rates that differ by less than this part are alike: they are found from times that jitter."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A thing that two runs do not have alike, in `unit`; `of` says of which file or charge, "" of the run itself."""

    of: str
    what: str
    unit: str
    first: Value
    second: Value


@dataclass(frozen=True, slots=True)
class RunsCompared:
    """What two runs, by their names, do not have alike; empty where they have all alike.

    `files` also has how they were read, `numbers` what was computed of the runs.
    """

    first: str
    second: str
    facts: tuple[Difference, ...]
    files: tuple[Difference, ...]
    channels: tuple[Difference, ...]
    charges: tuple[Difference, ...]
    numbers: tuple[Difference, ...]
    verdicts: tuple[Difference, ...]

    @property
    def by_subject(self) -> dict[str, tuple[Difference, ...]]:
        """The differences by the name of their field."""
        return {one.name: getattr(self, one.name) for one in fields(self) if one.name not in ("first", "second")}


class Thing(NamedTuple):
    """What is compared, as `Difference` names it."""

    of: str
    what: str
    unit: str = ""


Things: TypeAlias = Iterator[tuple[Thing, Value]]


def compare_runs(first: RunView, second: RunView) -> RunsCompared:
    """Set all that the book has on two runs side by side, and leave what differs."""

    def differing(of: Callable[[RunView], Things]) -> tuple[Difference, ...]:
        return _differences(dict(of(first)), dict(of(second)))

    return RunsCompared(
        first=first.run.name,
        second=second.run.name,
        facts=differing(_facts),
        files=differing(_files),
        channels=differing(_channels),
        charges=differing(_charges),
        numbers=differing(_computed),
        verdicts=differing(_verdicts),
    )


def _differences(first: Mapping[Thing, Value], second: Mapping[Thing, Value]) -> tuple[Difference, ...]:
    """Return what differs; of a file, charge or calibration that only one of them has, its name alone."""
    common = {thing.of for thing in first} & {thing.of for thing in second}
    names = {thing.of: thing for thing in reversed([*first, *second])}
    return tuple(
        Difference(*thing, first.get(thing), second.get(thing))
        for thing in {**first, **second}
        if (thing.of in common or thing == names[thing.of])
        and not _alike(first.get(thing), second.get(thing), thing.unit)
    )


def _alike(first: Value, second: Value, unit: str) -> bool:
    if isinstance(first, Number) and isinstance(second, Number):
        return replace(first, provenance="") == replace(second, provenance="")
    if unit == "Hz" and isinstance(first, float) and isinstance(second, float):
        return math.isclose(first, second, rel_tol=SAME_RATE)
    return first == second


_UNITS = {"s": "s", "mah": "mAh", "v": "V", "hz": "Hz", "utc": UTC}
"""Units by the ending of a field's name."""
_OF_RUN = (
    *("kind", "state", "day", "position_in_day", "planned", "robot", "battery"),
    *("started_utc", "duration_s", "starts", "jumps_made"),
)
_OF_CHARGE = (
    *("charge_mah", "resolution_mah", "recharge_s", "end_voltage_v"),
    *("mode", "stated_pack", "ended_utc", "added"),
)


def _fields(of: str, item: object, names: Sequence[str]) -> Things:
    """Give fields of a thing; what stands for its unit at the end of a field's name is that."""
    for name in names:
        what, _mark, ending = name.rpartition("_")
        thing = Thing(of, what, _UNITS[ending]) if what and ending in _UNITS else Thing(of, name)
        yield thing._replace(what=thing.what.replace("_", " ")), getattr(item, name)


def _facts(view: RunView) -> Things:
    yield from _fields("", view.run, _OF_RUN)
    yield from ((Thing("", name), label) for name, label in view.run.levels.items())
    yield Thing("", "notes"), tuple(note.text for note in view.notes)


def _files(view: RunView) -> Things:
    for name, file in _named(view.files):
        yield from _fields(name, file, ("name", "n_bytes", "reader", "reader_version"))
        for setting, value in _settings(file.settings):
            if setting != "declared.file_name":  # its name, once more
                yield Thing(name, setting.removeprefix("declared.")), value
    for name, signal, gaps in _signals(view):
        yield from _fields(name, signal, ("rate_hz", "n_samples", "start_utc"))
        for kind, count in Counter(gap.kind for gap in gaps).items():
            yield Thing(name, f"gaps ({kind})"), count
            missing = sum(gap.samples_missing for gap in gaps if gap.kind == kind)
            yield Thing(name, f"samples missing ({kind})"), missing


def _named(files: Iterable[RunFileRow]) -> Iterator[tuple[str, RunFileRow]]:
    """Name the files of a run by their roles, by which those of two runs are set side by side: log, log 2."""
    count = Counter[str]()
    for file in files:
        count[file.role] += 1
        yield _numbered(file.role, count[file.role]), file


def _numbered(what: str, number: int) -> str:
    return what if number == 1 else f"{what} {number}"


def _signals(view: RunView) -> Iterator[tuple[str, Any, Any]]:
    """Name each signal by its file, the further ones of a file by their place in it: log, log, part 2."""
    names = {file.sha256: name for name, file in _named(view.files)}
    count = Counter[str]()
    for signal, gaps in view.signals:
        name = names[signal.file_sha256]
        count[name] += 1
        yield name if count[name] == 1 else f"{name}, part {count[name]}", signal, gaps


def _settings(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Give each setting that a reading depended on by its full name."""
    for name, value in table.items():
        if isinstance(value, Mapping):
            yield from _settings(value, f"{above}{name}.")
        else:
            yield f"{above}{name}", value


def _channels(view: RunView) -> Things:
    for name, signal, _gaps in _signals(view):
        yield Thing(name, "channels"), len(signal.channels)
        yield from ((Thing(name, channel), True) for channel in signal.channels)
    for channel in view.calibrated:
        name = f"calibration of {channel.name}"
        yield Thing(name, "column"), channel.source_name
        yield from _fields(name, channel.calibration, ("scale", "offset", "errors", "source", "period"))


def _charges(view: RunView) -> Things:
    for number, charge in enumerate(view.charges, start=1):
        yield from _fields(_numbered("charge", number), charge, _OF_CHARGE)


def _computed(view: RunView) -> Things:
    yield Thing("", str(Outcome.JOULES)), view.joules_per_jump
    yield Thing("", f"mean {Outcome.APEX}"), view.mean_apex_height
    yield Thing("", "jumps found"), view.jumps_found
    yield from (
        (Thing("", str(outcome)), view.from_plate[outcome.key]) for outcome in Outcome if outcome.key in view.from_plate
    )


def _verdicts(view: RunView) -> Things:
    for one in view.reviewed:
        said = f"{one.verdict}ed by {one.person}, {one.reason_code}{', blind' if one.blind else ''}"
        yield Thing("", said), one.jumps
    yield Thing("", "jumps not reviewed"), len(view.not_reviewed)


def difference_rows(found: RunsCompared, time_zone: str) -> list[tuple[str, str, str, str]]:
    """Write for people what differs: of what, what, and both values."""
    return [
        (subject, f"{one.of}: {one.what}" if one.of else one.what, *_texts(one, time_zone))
        for subject, several in found.by_subject.items()
        for one in several
    ]


def difference_lines(found: RunsCompared, time_zone: str) -> list[str]:
    """Write what differs as a table of the terminal."""
    rows = difference_rows(found, time_zone)
    if not rows:
        return [f"{found.first} and {found.second} are alike in all that is compared."]
    return columns(("", "", found.first, found.second), rows)


def _texts(one: Difference, time_zone: str) -> tuple[str, str]:
    """Return both values as text, with as many digits as tell them apart."""
    texts = _text(one.first, one.unit, time_zone), _text(one.second, one.unit, time_zone)
    return texts if texts[0] != texts[1] else (_exactly(one.first), _exactly(one.second))


def _exactly(value: Value) -> str:
    return f"{value.value!r} {value.unit}" if isinstance(value, Number) else repr(value)


def _text(value: Value, unit: str, time_zone: str) -> str:
    match value:
        case None | () | []:
            return "none"
        case bool():
            return "yes" if value else "no"
        case Undefined():
            return f"none: {value.reason}"
        case Number():
            return number_text(value)
        case float() | int():
            return with_unit(f"{value:.6g}" if isinstance(value, float) else str(value), unit)
        case str():
            return local_text(value, time_zone) if unit == UTC else value
        case tuple():
            return listed([str(item) for item in value])
    return json.dumps(value, ensure_ascii=False)


@dataclass(frozen=True, slots=True)
class RunSummary:
    """A run as a list shows it: energy in J a jump, mean apex height in m, jumps by number; None where there is none.

    `found` are the flights with an apex, `counted` the jumps that count; of those `to_review`, `reviewed` have a
    person's verdict.
    """

    name: str
    kind: str
    state: str
    day: str
    position_in_day: int
    condition: str
    levels: Mapping[str, str]
    battery: str
    joules_per_jump: float | None
    apex_height_m: float | None
    made: int
    found: int | None
    counted: int | None
    to_review: int | None
    reviewed: int | None


def overview(
    connection: sa.Connection, store: Store, configuration: Configuration, where: str | None = None
) -> list[RunSummary]:
    """Return the runs that fulfil `where`, all without one, in the order of the book."""
    from labbook.actions.runs.attention import known_joules  # with all checks, which one run need not load

    evidence = gather(connection, configuration, where)
    joules = known_joules(evidence, drain_lines(evidence))
    logs, _missing = logs_that_count(evidence.runs, evidence.logs, evidence.calibrated)
    judged = judge_runs(Detections(connection, store), evidence.runs, logs, evidence.decisions, as_protocol(evidence))
    return [_summary(run, joules.get(run.uid), judged.get(run.uid)) for run in evidence.selected]


def _summary(run: RunRow, joules: float | None, judged: JudgedRun | None) -> RunSummary:
    counted = None if judged is None else judged.judgement.counted
    heights = [jump.apex_height_m for jump in counted or () if jump.apex_height_m is not None]
    jumps = None if judged is None else judged.judgement.jumps
    return RunSummary(
        name=run.name,
        kind=str(run.kind),
        state=str(run.state),
        day=run.day,
        position_in_day=run.position_in_day,
        condition=run.condition_key,
        levels=run.levels,
        battery=run.battery,
        joules_per_jump=joules,
        apex_height_m=sum(heights) / len(heights) if heights else None,
        made=run.jumps_made,
        found=None if jumps is None else jumps_found(one.jump for one in jumps),
        counted=None if counted is None else len(counted),
        to_review=None if jumps is None else len(to_review(jumps)),
        reviewed=None if jumps is None else sum(one.decision is not None for one in jumps),
    )
