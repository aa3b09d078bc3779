"""What a day at the rig still needs, and which runs of jumps have no joules or no apex height, each with the reason.

Also the statement of a day's checks.
"""

from __future__ import annotations

import math
import shlex
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from data_schema.errors import UsageError, unknown_name
from data_schema.queries.charges import charges_of_runs
from data_schema.queries.detections import verdicts_waiting
from data_schema.queries.files import inbox, waiting_files
from data_schema.queries.history import first_measurement, void_reasons
from data_schema.queries.runs import RunRow, runs_of_conditions, runs_of_day
from data_schema.queries.signals import SignalRow, signals_of_runs
from data_schema.queries.study import checks_by_day, planned_runs
from data_schema.vocabulary import FileRole, RunKind, RunState, Undefined
from labbook.actions.runs.remarks import remarks_on
from labbook.actions.runs.rig_line import joules_of, known_joules, too_little_charged
from labbook.analysis.outcomes.control_limits import runs_outside
from labbook.analysis.outcomes.detection import BODY_HEIGHT, Detections, rest_length_m
from labbook.analysis.outcomes.run_apexes import Judgement, as_protocol, judge, usable_logs
from labbook.analysis.outcomes.run_energy import above_capacity, drain_lines
from labbook.analysis.study_data import StudyData, gather_about, outdated_files, outdated_sentence
from labbook.book.naming import ensure_day, study_of
from labbook.book.write_session import WriteSession
from labbook.config.local_time import day_named
from labbook.config.model import HOW_TO_DECIDE, Configuration
from labbook.terminal import listed


@dataclass(frozen=True, slots=True)
class ToDo:
    """What is left to do for a day; runs by name. `planned_not_done` is of all plans, whatever their days.

    These hold a reason by run: `logs_do_not_count` why its logs do not count though they have a body height,
    `no_joules` and `no_apexes` why a run of jumps lacks that number, `too_little_charged` what its charge is below, and
    `above_capacity` what it is above. `outside_limits` are the runs out of the control limits of their condition,
    `zero_doubtful` has a log of each run whose heights may be too high, `samples_twice` says which files are copies.
    `void` are runs that do not count, none of those done, with the reason. `analysis_undecided`: nothing is decided
    about the analysis, and nothing measured yet.
    """

    day: str
    runs_done: tuple[str, ...]
    planned_not_done: tuple[str, ...]
    open_runs: tuple[str, ...]
    log_without_charge: tuple[str, ...]
    charge_without_log: tuple[str, ...]
    neither: tuple[str, ...]
    logs_do_not_count: Mapping[str, str]
    no_joules: Mapping[str, str]
    no_apexes: Mapping[str, str]
    checks_not_made: tuple[str, ...]
    inbox: int
    analysis_undecided: bool
    too_little_charged: Mapping[str, str] = field(default_factory=dict)
    above_capacity: Mapping[str, str] = field(default_factory=dict)
    outside_limits: tuple[str, ...] = ()
    samples_twice: tuple[str, ...] = ()
    zero_doubtful: Mapping[str, str] = field(default_factory=dict)
    files_waiting: tuple[str, ...] = ()
    verdicts_waiting: tuple[str, ...] = ()
    void: Mapping[str, str] = field(default_factory=dict)
    files_outdated: tuple[str, ...] = ()


def to_do(detections: Detections, configuration: Configuration, day: str | None) -> ToDo:
    """Compare the day's runs with what they should have; without `day`, today in the study's time zone."""
    connection = detections.connection
    date = day_named("--day", day, configuration.study.time_zone)
    of_day = runs_of_day(connection, date)
    runs = [run for run in of_day if run.state is not RunState.VOID]
    jumped = [run for run in runs if run.kind is RunKind.JUMPS]
    idle = [run for run in runs if run.kind is RunKind.IDLE]
    why_void = void_reasons(connection, [run.uid for run in of_day if run.state is RunState.VOID])
    charged = charges_of_runs(connection, [run.uid for run in runs])
    logged = {log.run_uid for log in signals_of_runs(connection, FileRole.LOG, [run.uid for run in runs])}
    made = {check.kind for check in checks_by_day(connection).get(date, ())}
    conditions = list({run.condition_uid for run in jumped if run.condition_uid is not None})
    evidence = gather_about(connection, configuration, jumped, runs_of_conditions(connection, conditions))
    drains = drain_lines(evidence)
    judged = _judgements(detections, evidence, jumped)
    outside = {run.uid for run in runs_outside(evidence.runs, known_joules(evidence, drains))}
    lacking: dict[tuple[bool, bool], list[str]] = {
        (log, charge): [] for log in (True, False) for charge in (True, False)
    }
    for run in jumped:
        lacking[run.uid in logged, run.uid in charged].append(run.name)
    return ToDo(
        day=date,
        runs_done=_names(runs),
        void={run.name: why_void.get(run.uid, "") for run in of_day if run.state is RunState.VOID},
        planned_not_done=tuple(row.name for row in planned_runs(connection) if row.run_name is None),
        open_runs=_names(run for run in runs if run.state is RunState.OPEN),
        log_without_charge=tuple(lacking[True, False]),
        charge_without_log=tuple(lacking[False, True]),
        neither=(*lacking[False, False], *_names(run for run in idle if run.uid not in charged)),
        logs_do_not_count=_reasons(jumped, lambda run: _why_not(run, evidence.logs.get(run.uid, []))),
        no_joules=_reasons(jumped, lambda run: _reason(joules_of(run, evidence, drains))),
        too_little_charged=_reasons(jumped, lambda run: too_little_charged(run, evidence, drains)),
        above_capacity=_reasons(runs, lambda run: above_capacity(run, charged.get(run.uid, ()), configuration)),
        outside_limits=_names(run for run in jumped if run.uid in outside),
        samples_twice=tuple(one.message for one in remarks_on(connection, configuration, _names(runs), ["samples"])),
        no_apexes=_reasons(jumped, lambda run: _why_no_apex(evidence, run, run.uid in logged, judged.get(run.uid))),
        zero_doubtful={
            run.name: evidence.logs[run.uid][0].file_name
            for run in jumped
            if run.uid in judged and judged[run.uid].zero_doubtful
        },
        checks_not_made=tuple(kind for kind in configuration.protocol.checks if kind not in made),
        inbox=len(inbox(connection)),
        files_outdated=outdated_files(connection, configuration),
        files_waiting=tuple(file.why.reason for file in waiting_files(connection)),
        verdicts_waiting=tuple(verdict.sentence for verdict in verdicts_waiting(connection)),
        analysis_undecided=configuration.analysis is None and first_measurement(connection) is None,
    )


def _names(runs: Iterable[RunRow]) -> tuple[str, ...]:
    return tuple(run.name for run in runs)


def _reasons(runs: Iterable[RunRow], why: Callable[[RunRow], str | None]) -> dict[str, str]:
    """Return the reason of each run, by name, that has one."""
    return {run.name: reason for run in runs if (reason := why(run)) is not None}


def _reason(found: object) -> str | None:
    return found.reason if isinstance(found, Undefined) else None


def to_do_lines(found: ToDo) -> list[str]:
    """Say it line by line; what is in order is not mentioned."""
    void = [f"{name} ({why})" for name, why in found.void.items()]
    beside = f", and {len(void)} void: {listed(void)}" if void else ""
    done = len(found.runs_done)
    lines = [f"{found.day}: {done} run{'' if done == 1 else 's'}{beside}."]
    for what, names in (
        ("planned, not done, of all plans and days", found.planned_not_done),
        ("still open (duration or jumps missing)", found.open_runs),
        ("log without charge", found.log_without_charge),
        ("charge without log", found.charge_without_log),
        ("neither log nor charge", found.neither),
        ("outside the control limits of their condition", found.outside_limits),
        ("checks not made", found.checks_not_made),
    ):
        if names:
            lines.append(f"{what} ({len(names)}): {listed(names)}")
    lines += _lines_by_reason("logs that do not count", found.logs_do_not_count, ())
    uncharged, unlogged = {*found.log_without_charge, *found.neither}, {*found.charge_without_log, *found.neither}
    lines += _lines_by_reason("no joules", found.no_joules, uncharged)
    lines += [f"too little charged: {name}: {what}" for name, what in found.too_little_charged.items()]
    lines += [f"too much charged: {name} has {what}" for name, what in found.above_capacity.items()]
    lines += found.samples_twice
    if found.zero_doubtful:
        file = shlex.quote(next(iter(found.zero_doubtful.values())))
        lines.append(
            f"heights that may be too high ({len(found.zero_doubtful)}): {listed([*found.zero_doubtful])} "
            f"(`labbook files show {file}` says why and what corrects it)"
        )
    lines += _lines_by_reason("no apexes", found.no_apexes, {*unlogged, *found.logs_do_not_count})
    lines += [f"{reason}." for reason in found.files_waiting]
    lines += [f"{outdated_sentence(found.files_outdated)}."] if found.files_outdated else []
    lines += found.verdicts_waiting
    if found.inbox:
        lines.append(f"in the inbox: {found.inbox} (`labbook runs inbox`)")
    if found.analysis_undecided:
        lines.append(f"nothing is decided about the analysis: {HOW_TO_DECIDE}")
    return lines if len(lines) > 1 else [*lines, "nothing is missing."]


def _lines_by_reason(what: str, reasons: Mapping[str, str], named: Collection[str]) -> list[str]:
    """Say it in a line for each reason; runs that a line above has `named` are left out."""
    by_reason: dict[str, list[str]] = {}
    for name, why in reasons.items():
        if name not in named:
            by_reason.setdefault(why, []).append(name)
    return [f"{what} ({why}): {listed(names)}" for why, names in by_reason.items()]


def _why_not(run: RunRow, logs: Sequence[SignalRow]) -> str | None:
    return _reason(usable_logs(run, logs)) if logs else None


def _judgements(detections: Detections, evidence: StudyData, runs: Sequence[RunRow]) -> dict[str, Judgement]:
    """Return the judged jumps of the runs whose logs count, by uid."""
    variant = as_protocol(evidence)
    found = {}
    for run in runs:
        logs = usable_logs(run, evidence.logs.get(run.uid, []))
        if not isinstance(logs, Undefined):
            detected = detections.of(
                {run.uid: logs}, variant.detector, rest_length_m(detections.connection, run.robot_uid)
            )
            found[run.uid] = judge(detected[run.uid], evidence.decisions, variant.rules)
    return found


def _why_no_apex(evidence: StudyData, run: RunRow, has_log: bool, judged: Judgement | None) -> str | None:
    heights = evidence.logs.get(run.uid, [])
    if not heights:
        declare = f'`labbook ingest FILE --column "COLUMN={BODY_HEIGHT}:UNIT"`'
        return f"the log has no {BODY_HEIGHT}: {declare}" if has_log else "no log"
    if judged is None:
        return _why_not(run, heights)
    if judged.counted:
        return None
    excluded = Counter(str(item.excluded) for item in judged.jumps)
    return f"no jump counts: {', '.join(excluded)}" if excluded else "no jump was found in the log"


def state_check(
    session: WriteSession,
    configuration: Configuration,
    kind: str,
    value: float | None,
    unit: str | None,
    passed: bool,
    day: str | None,
) -> str:
    """State that a check of `[protocol] checks` was made on a day (default: today in the study's time zone).

    Returns the date. Raises `UsageError` for a check that is not listed, a value or a date that is none.
    """
    listed = configuration.protocol.checks
    if kind not in listed:
        remedy = 'A day\'s checks are those that labbook.toml lists under [protocol], as checks = ["rail_angle"].'
        raise unknown_name("check", kind, listed, remedy)
    if value is not None and not math.isfinite(value):
        raise UsageError(f"--value {value} is not a measurement: give a finite number.")
    date = day_named("--day", day, configuration.study.time_zone)
    day_uid = ensure_day(session, study_of(session.connection).uid, date)
    session.declare("day_check", day=day_uid, kind=kind, value=value, unit=unit, passed=int(passed))
    return date
