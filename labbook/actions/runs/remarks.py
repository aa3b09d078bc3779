"""What is odd in what was written down of a run, one rule an entry of `RULES`: possible, so remarked on, never refused.

`labbook attention` finds by the same rules. Also whether a log recorded the levels of its run: a controller may log
each gain in the channel of its factor.
"""

from __future__ import annotations

import datetime
import functools
import shlex
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from zoneinfo import ZoneInfo

import sqlalchemy as sa

from data_schema.queries.charges import ChargeOfRun, charges_of_runs
from data_schema.queries.files import imported_names
from data_schema.queries.runs import RunRow, list_runs, runs_named
from data_schema.queries.signals import (
    CalibratedChannel,
    RecordedRange,
    SameSamples,
    SignalRow,
    calibrated_channels,
    recorded_ranges,
    same_samples,
    signals_of_runs,
)
from data_schema.queries.study import PlannedRow, StudyRow, days_with_runs, planned_runs
from data_schema.vocabulary import FileRole, RunKind, RunState, Undefined
from labbook.actions.runs.finding import Blank, Finding, Word, correcting, found
from labbook.analysis.outcomes.detection import BODY_HEIGHT
from labbook.analysis.outcomes.log_dates import differing_day
from labbook.analysis.outcomes.run_apexes import calibrated_for_other_day, usable_logs
from labbook.analysis.outcomes.run_energy import above_capacity
from labbook.book.naming import study_of
from labbook.config.local_time import local_text, today_in
from labbook.config.parsing import Configuration
from labbook.config.run_names import RunNames
from labbook.terminal import listed

MOST_NAMED = 20
"""Runs that a remark names beside the first."""
YEAR = datetime.timedelta(days=365)
_RECHARGED_WITHIN = datetime.timedelta(days=7)
"""A pack is recharged at most so long after its run."""


@dataclass(frozen=True, slots=True)
class Remark:
    """One rule, the first thing that it is about, up to `MOST_NAMED` more, and how many there are in all."""

    rule: str
    count: int
    first: str
    more: tuple[str, ...]
    message: str


@dataclass(frozen=True, slots=True)
class Facts:
    """What rules look at: the book's study, settings and days with runs; and of the runs in question, by their uid,
    charges, signals and copies of other files' samples, and their plan by their name.

    `calibrated` has the calibrated channels by the signal's uid. Looked up once, and only where it is asked for:
    `other_levels`, logs of another level; `positions`, whose each position of a day is; `file_names`, how many files
    have a name.
    """

    study: StudyRow
    configuration: Configuration
    days: Sequence[str]
    charges: Mapping[str, Sequence[ChargeOfRun]]
    signals: Mapping[str, Sequence[SignalRow]]
    calibrated: Mapping[str, Sequence[CalibratedChannel]]
    same_samples: Mapping[str, SameSamples]
    planned: Mapping[str, PlannedRow]
    other_levels: Callable[[], Mapping[str, OtherLevel]]
    positions: Callable[[], Mapping[tuple[str, int], str]]
    file_names: Callable[[], Mapping[str, int]]

    def heights(self, run: RunRow) -> list[SignalRow]:
        """Return the logs of a run with a body height."""
        return [one for one in self.signals[run.uid] if one.role == FileRole.LOG and BODY_HEIGHT in one.channels]

    def called(self, name: str, uid: str) -> str:
        """Return how a command names a file: its name, or what names it alone."""
        return name if self.file_names().get(name, 0) == 1 and not name.startswith("-") else uid

    def log_called(self, log: SignalRow) -> str:
        """Return how a command names a log."""
        return self.called(log.file_name, log.file_sha256[:12])

    def redating(self, run: RunRow, date: str) -> tuple[Word, ...]:
        """Return the words that give a run another date, and a position there that is free."""
        there = {place: name for (day, place), name in self.positions().items() if day == date}
        taken = there.get(run.position_in_day, run.name) != run.name
        return correcting(run.name, f"date={date}", *([f"position={max(there) + 1}"] if taken else []))


@dataclass(frozen=True, slots=True)
class Rule:
    """A rule: `odd` returns what it finds of a run, None where nothing is odd; `columns` are those that it looks at.

    `alike`: one message holds for all runs that it concerns, so that they share one remark; else each has its own.
    """

    columns: frozenset[str]
    odd: Callable[[RunRow, Facts], Finding | None]
    alike: bool = True


def remarks_on(
    connection: sa.Connection,
    configuration: Configuration,
    runs: Sequence[str],
    columns: Collection[str] | None = None,
) -> list[Remark]:
    """Apply the rules to runs, given by name: all rules, or those that look at one of `columns`."""
    rows = runs_named(connection, runs)
    facts = facts_about(connection, configuration, rows, days=sorted({row.day for row in rows}))
    remarks = []
    for name, rule in RULES.items():
        if columns is None or rule.columns.intersection(columns):
            odd = {row.name: rule.odd(row, facts) for row in rows}
            messages = {run: f"{one.what}: `{one.command}`" for run, one in odd.items() if one is not None}
            for several in [messages] if rule.alike else [{run: text} for run, text in messages.items()]:
                remarks += _remark(name, several)
    return remarks


def facts_about(
    connection: sa.Connection,
    configuration: Configuration,
    rows: Sequence[RunRow],
    *,
    days: Sequence[str] | None = None,
) -> Facts:
    """Read what the rules look at of some runs; logs are compared with those of `days`, or of the whole book."""
    uids = [row.uid for row in rows]
    signals: dict[str, list[SignalRow]] = {uid: [] for uid in uids}
    for signal in signals_of_runs(connection, run_uids=uids):
        signals[signal.run_uid].append(signal)
    return Facts(
        study_of(connection),
        configuration,
        days_with_runs(connection),
        charges_of_runs(connection, uids),
        signals,
        calibrated_channels(connection),
        same_samples(connection, uids),
        {row.run_name: row for row in planned_runs(connection) if row.run_name is not None},
        functools.cache(lambda: _other_levels(connection, configuration, days)),
        functools.cache(lambda: {(run.day, run.position_in_day): run.name for run in list_runs(connection)}),
        functools.cache(lambda: Counter(imported_names(connection))),
    )


def _other_levels(
    connection: sa.Connection, configuration: Configuration, days: Sequence[str] | None
) -> dict[str, OtherLevel]:
    declared = {
        name: {level.label: level.value for level in factor.levels if level.value is not None}
        for name, factor in configuration.factors.items()
    }
    recorded = recorded_ranges(connection, [name for name, levels in declared.items() if levels], days)
    if not recorded:
        return {}
    runs = [
        run
        for run in list_runs(connection)
        if run.kind is RunKind.JUMPS and run.state is not RunState.VOID and (days is None or run.day in days)
    ]
    return other_levels(recorded, runs, declared)


def remarks_on_names(names: Sequence[str], known: Collection[str], scheme: RunNames) -> list[Remark]:
    """Compare the names of new runs with those of planned runs and of runs that were there, and with the scheme.

    `R 7` may be `r7`; names of another form than `[study] run_names` says are remarked on where they were not planned.
    """
    folded = {_folded(name): name for name in known}
    messages = {
        name: f"run {name} is another run than {folded[_folded(name)]}, and their names differ in case or blanks only: "
        f"`labbook correct {shlex.quote(name)} name=...` renames it"
        for name in names
        if name not in known and _folded(name) in folded
    }
    says = f'run_names = "{scheme.scheme}" in [study] of labbook.toml says: only a file whose name begins so is its own'
    others = {
        name: f"run {name} is not called as {says}"
        for name in names
        if scheme.number(name) is None and name not in known and name not in messages
    }
    return _remark("name_almost_taken", messages) + _remark("name_of_other_form", others)


def remarks_on_places(new: Mapping[str, tuple[str, int]], taken: Mapping[tuple[str, int], str]) -> list[Remark]:
    """Compare the (day, position) of new runs, by name, with those that runs in the book have."""
    messages = {
        name: f"run {name} has position {place[1]} of {place[0]}, as run {taken[place]} has: their order is not known"
        for name, place in new.items()
        if place in taken
    }
    return _remark("position_taken", messages)


def _folded(name: str) -> str:
    return "".join(name.split()).casefold()


def _remark(rule: str, messages: Mapping[str, str]) -> list[Remark]:
    if not messages:
        return []
    first, *more = messages
    message = messages[first]
    if more:
        message += f"; the same of {listed(more, MOST_NAMED)}"
    return [Remark(rule, len(messages), first, tuple(more[:MOST_NAMED]), f"{message}.")]


def _duration(run: RunRow, facts: Facts) -> Finding | None:
    protocol = facts.configuration.protocol
    if run.kind is RunKind.IDLE:
        usual_s = [minutes * 60.0 for minutes in protocol.idle_minutes]
    else:
        usual_s = [protocol.run_duration_s] if run.kind is RunKind.JUMPS and protocol.run_duration_s else []
    if run.duration_s is None or not usual_s or min(usual_s) / 2 <= run.duration_s <= 2 * max(usual_s):
        return None
    usual = " to ".join(f"{value:g}" for value in dict.fromkeys((min(usual_s), max(usual_s))))
    what = f"run {run.name} lasted {run.duration_s:g} s where the protocol has {usual} s"
    return found(what, *correcting(run.name, ("minutes=", Blank.MINUTES)), run=run)


def _future(run: RunRow, facts: Facts) -> Finding | None:
    if run.day <= today_in(facts.study.time_zone):
        return None
    what = f"run {run.name} is of {run.day}, which is yet to come"
    return found(what, *correcting(run.name, ("date=", Blank.DATE)), run=run)


def _long_ago(run: RunRow, facts: Facts) -> Finding | None:
    first = next((day for day in facts.days if day != run.day), None)
    if first is None or datetime.date.fromisoformat(first) - datetime.date.fromisoformat(run.day) <= YEAR:
        return None
    what = f"run {run.name} is of {run.day}, more than a year before the other days, the first of them {first}"
    return found(what, *correcting(run.name, ("date=", Blank.DATE)), run=run)


def _log_day(run: RunRow, facts: Facts) -> Finding | None:
    for log in facts.signals[run.uid]:
        other = differing_day(log.start_utc, run.day, facts.study.time_zone)
        if other is not None:
            swapped = ", with day and month the other way round" if other.swapped else ""
            what = (
                f"{log.file_name} begins on {other.of_log} and its run {run.name} is of {run.day}{swapped}: the date "
                "of the run is wrong, it is the log of another run, or the clock of the logger was wrong"
            )
            return found(what, *facts.redating(run, str(other.of_log)), run=run, file=log.file_name)
    return None


def _calibration(run: RunRow, facts: Facts) -> Finding | None:
    heights = facts.heights(run)
    if run.kind is not RunKind.JUMPS or calibrated_for_other_day(run, heights, facts.calibrated) is None:
        return None
    name = heights[0].file_name
    what = f"{name} was read with a calibration that does not hold on {run.day}, when run {run.name} was made"
    return found(what, "files", "reread", facts.log_called(heights[0]), run=run, file=name)


def _logs(run: RunRow, facts: Facts) -> Finding | None:
    logs = facts.heights(run)
    why = usable_logs(run, logs) if logs and run.kind is RunKind.JUMPS else ()
    if not isinstance(why, Undefined):
        return None
    other = facts.other_levels().get(run.uid)
    one = next((log for log in logs if other is not None and log.uid == other.signal_uid), None)
    one = one or min(reversed(logs), key=lambda log: log.n_samples)  # what was cut off has the fewest
    names = listed(list(dict.fromkeys(log.file_name for log in logs)), 4)
    what = (
        f"run {run.name} has {why.reason}, so none of them counts: {names}; take one off, or correct how often it was "
        "started (starts=N)"
    )
    return found(what, "assign", facts.log_called(one), "none", "--why", Blank.WHY, run=run, file=one.file_name)


def _levels(run: RunRow, facts: Facts) -> Finding | None:
    other = facts.other_levels().get(run.uid)
    if other is None:
        return None
    log = next(one for one in facts.signals[run.uid] if one.uid == other.signal_uid)
    what = f"{log.file_name} recorded {other.factor} {other.level}, and its run {run.name} has {other.has}"
    if other.of_run is not None:
        what += f": it can be of {other.of_run}"
    of_another: tuple[Word, ...] = "assign", facts.log_called(log), other.of_run or Blank.RUN, "--why", Blank.WHY
    words = of_another if other.is_of_another else correcting(run.name, f"{other.factor}={other.level}")
    return found(what, *words, run=run, file=log.file_name)


def _samples(run: RunRow, facts: Facts) -> Finding | None:
    same = facts.same_samples.get(run.uid)
    if same is None:
        return None
    of_run = f" of run {same.other_run}" if same.other_run != run.name else ""
    what = f"{same.file_name} of run {run.name} has the samples of {same.other_file}{of_run}: one is a copy"
    words = "files", "withdraw", facts.called(same.file_name, same.file_sha256[:12]), "--why", Blank.WHY
    return found(what, *words, run=run, file=same.file_name)


def _jumps(run: RunRow, facts: Facts) -> Finding | None:
    nominal = facts.study.jumps_nominal
    if run.kind is not RunKind.JUMPS or run.state is RunState.OPEN or 0 < run.jumps_made <= 2 * nominal:
        return None
    what = f"run {run.name} has {run.jumps_made} jumps made where the protocol has {nominal}"
    return found(what, *correcting(run.name, ("jumps=", Blank.JUMPS)), run=run)


def correcting_charge(run: RunRow, charges: Sequence[ChargeOfRun]) -> tuple[Word, ...]:
    """Return the words that correct the only charge of a run, or the largest of several."""
    if len(charges) == 1:
        return correcting(run.name, ("mah=", Blank.MAH))
    largest = max(charges, key=lambda one: one.charge_mah)
    return correcting(f"charge:{largest.uid}", ("charge_mah=", Blank.MAH))


def _above_pack(run: RunRow, facts: Facts) -> Finding | None:
    charges = facts.charges.get(run.uid, ())
    above = above_capacity(run, charges, facts.configuration)
    if above is None:
        return None
    return found(f"run {run.name} has {above}", *correcting_charge(run, charges), run=run)


def _zero(run: RunRow, facts: Facts) -> Finding | None:
    charges = facts.charges.get(run.uid, ())
    if all(charge.charge_mah for charge in charges):
        return None
    is_idle = run.kind is RunKind.IDLE
    costs = "it pulls the drain line down" if is_idle else ""
    what = f"run {run.name}{' (idle)' if is_idle else ''} has a charge of 0 mAh"
    return found(what, *correcting_charge(run, charges), run=run, costs=costs)


def _charge_date(run: RunRow, facts: Facts) -> Finding | None:
    """Question a recharge that ended before its run began, or long after: one of both dates is wrong.

    Of a date alone midnight is stored, so that its day counts.
    """
    zone = facts.study.time_zone
    for charge in facts.charges.get(run.uid, ()):
        if charge.ended_utc is None:
            continue
        ended, other = datetime.datetime.fromisoformat(charge.ended_utc), differing_day(charge.ended_utc, run.day, zone)
        before = ended.astimezone(ZoneInfo(zone)).date().isoformat() < run.day
        if run.started_utc is not None and ":" in (charge.ended_original or ""):
            before = ended < datetime.datetime.fromisoformat(run.started_utc)
        if before:
            began = run.day if run.started_utc is None else local_text(run.started_utc, zone)
            what = f"run {run.name} began {began} and its charge ended before, at {charge.ended_original}"
        elif other is not None and other.of_log - other.of_run > _RECHARGED_WITHIN:
            what = f"run {run.name} is of {run.day} and its charge ended on {other.of_log}"
        else:
            continue
        words = correcting(f"charge:{charge.uid}", ("ended_utc=", Blank.INSTANT))
        if other is not None and other.swapped:
            what += (
                ", with day and month the other way round (`labbook files reread FILE --dates ...` says their order)"
            )
        elif other is not None:
            words = facts.redating(run, str(other.of_log))
        return found(what, *words, run=run)
    return None


def _pack(run: RunRow, facts: Facts) -> Finding | None:
    for charge in facts.charges.get(run.uid, ()):
        if charge.stated_pack is not None and charge.stated_pack != run.battery:
            what = f"run {run.name} was made with pack {run.battery} and its charge is of pack {charge.stated_pack}"
            return found(what, *correcting(run.name, ("battery=", Blank.PACK)), run=run)
    return None


def _plan(run: RunRow, facts: Facts) -> Finding | None:
    planned = facts.planned.get(run.name)
    if planned is None or (planned.condition_key or "") == run.condition_key:
        return None
    if planned.condition_key is None:
        words = correcting(run.name, "kind=idle", "jumps_made=0", "levels=none")
        return found(f"run {run.name} was planned as an idle run", *words, run=run)
    words = correcting(run.name, *planned.condition_key.split())
    return found(f"run {run.name} was planned with {planned.condition_key}", *words, run=run)


RULES: Mapping[str, Rule] = {
    "duration_unusual": Rule(frozenset({"duration_s", "kind"}), _duration),
    "date_in_future": Rule(frozenset({"day"}), _future),
    "date_long_ago": Rule(frozenset({"day"}), _long_ago),
    "log_day_differs": Rule(frozenset({"day", "log"}), _log_day, alike=False),
    "calibration_of_other_day": Rule(frozenset({"day", "log"}), _calibration, alike=False),
    "level_differs": Rule(frozenset({"condition", "log", "samples"}), _levels, alike=False),
    "samples_twice": Rule(frozenset({"log", "samples"}), _samples, alike=False),
    "logs_too_many": Rule(frozenset({"log", "starts"}), _logs, alike=False),
    "jumps_unusual": Rule(frozenset({"jumps_made", "kind", "state"}), _jumps),
    "charge_above_pack": Rule(frozenset({"charge_mah", "battery", "run"}), _above_pack),
    "charge_zero": Rule(frozenset({"charge_mah", "run"}), _zero),
    "charge_date": Rule(frozenset({"charge_mah", "ended_utc", "started_utc", "day", "run"}), _charge_date, alike=False),
    "pack_differs": Rule(frozenset({"battery", "stated_pack", "run"}), _pack),
    "differs_from_plan": Rule(frozenset({"condition", "kind"}), _plan, alike=False),
}
"""The rules on runs, by name, in the order in which they are shown."""


_NEAR = 0.25
"""Of the distance to the nearest other level: a value within it is of the level, whatever noise it has."""

_Levels = Mapping[str, float]
"""The values of a factor's levels by their labels."""


@dataclass(frozen=True, slots=True)
class OtherLevel:
    """A log that recorded another `level` of a factor than its run `has`, both as they are declared.

    `of_run` names the one run of its day that it can be of: the run that its file names, else one whose log is of this
    run, else one without a log that says otherwise; None where there is none, or are several. `is_of_another`: there
    are some, or the run has a log of its own level.
    """

    signal_uid: str
    factor: str
    has: str
    level: str
    of_run: str | None
    is_of_another: bool


def other_levels(
    recorded: Sequence[RecordedRange], runs: Sequence[RunRow], declared: Mapping[str, _Levels]
) -> dict[str, OtherLevel]:
    """Return, by the run's uid, the first channel of its logs that shows another level than the run has.

    `recorded` is of logs of these `runs`; `declared` has the levels by the factor's name. Nothing is said of a channel
    that may be another thing or in another unit, whatever its logs show.
    """
    of = {run.uid: run for run in runs}
    by_channel: dict[str, list[RecordedRange]] = defaultdict(list)
    for one in recorded:
        if one.run_uid in of:
            by_channel[one.channel].append(one)
    levels = {name: declared[name] for name, some in by_channel.items() if _is_comparable(some, of, declared[name])}
    logs: dict[str, dict[str, list[RecordedRange]]] = defaultdict(dict)
    for one in (one for name in levels for one in by_channel[name]):
        logs[one.run_uid].setdefault(one.signal_uid, []).append(one)

    def is_of(log: Sequence[RecordedRange], run: RunRow) -> bool:
        shown = [(_shown(one, run, levels[one.channel]), run.levels.get(one.channel)) for one in log]
        return all(at is not None and at == has for at, has in shown)

    def contradiction(log: Sequence[RecordedRange], run: RunRow) -> tuple[str, str] | None:
        """Return the first factor of which a log shows another level than a run has, and that level."""
        shown = {one.channel: _shown(one, run, levels[one.channel]) for one in log}
        return next(((name, at) for name, at in shown.items() if at is not None and at != run.levels[name]), None)

    wrong: dict[str, tuple[str, tuple[str, str]]] = {}
    for uid, several in logs.items():
        for signal_uid, log in several.items():
            if uid not in wrong and (found := contradiction(log, of[uid])) is not None:
                wrong[uid] = signal_uid, found
    by_day: dict[str, list[RunRow]] = defaultdict(list)
    for run in runs:
        by_day[run.day].append(run)

    def wrong_log(uid: str) -> Sequence[RecordedRange]:
        return logs[uid][wrong[uid][0]]

    def of_other(uid: str) -> OtherLevel:
        run, (signal_uid, (factor, level)) = of[uid], wrong[uid]
        log = wrong_log(uid)
        others = [other for other in by_day[run.day] if other is not run and is_of(log, other)]
        candidates = (
            [other.name for other in others if other.name == log[0].stated_run]
            or [other.name for other in others if other.uid in wrong and is_of(wrong_log(other.uid), run)]
            or [other.name for other in others if not _says_anything(logs.get(other.uid, {}), other, levels)]
        )
        has_own = any(contradiction(one, run) is None for one in logs[uid].values())
        of_run = candidates[0] if len(candidates) == 1 else None
        return OtherLevel(signal_uid, factor, run.levels[factor], level, of_run, bool(candidates) or has_own)

    return {uid: of_other(uid) for uid in wrong}


def _says_anything(logs: Mapping[str, Sequence[RecordedRange]], run: RunRow, levels: Mapping[str, _Levels]) -> bool:
    return any(_shown(one, run, levels[one.channel]) is not None for log in logs.values() for one in log)


def _is_comparable(known: Sequence[RecordedRange], of: Mapping[str, RunRow], levels: _Levels) -> bool:
    """Tell whether a channel has the levels of its factor: it shows two of them, and seldom 0 where there is a gain.

    0 is the same in every unit, and where nothing is logged.
    """
    pairs = [(of[one.run_uid].levels.get(one.channel, ""), _shown(one, of[one.run_uid], levels)) for one in known]
    shown = [(has, level) for has, level in pairs if level is not None]
    gains = sum(levels[level] != 0.0 for _has, level in shown)
    missing = sum(levels[level] == 0.0 != levels[has] for has, level in shown)
    return len({level for _has, level in shown}) > 1 and gains > missing


def _shown(one: RecordedRange, run: RunRow, levels: _Levels) -> str | None:
    """Return the level that a channel shows, which is that of a run where it can be; None where none is clear.

    A gain is in force in one half of a jump, and another, or none, in the other half; a gain of 0 never is.
    """
    has = run.levels.get(one.channel)
    if has is None or has not in levels or len(levels) < 2:
        return None
    lowest, highest = (_level_near(end, levels) for end in (one.lowest, one.highest))
    if levels[has] != 0.0 and has in (lowest, highest):
        return has
    return highest if abs(one.highest) >= abs(one.lowest) else lowest


def _level_near(value: float, levels: _Levels) -> str | None:
    label = min(levels, key=lambda name: abs(levels[name] - value))
    gap = min(abs(levels[label] - other) for name, other in levels.items() if name != label)
    return label if abs(levels[label] - value) <= _NEAR * gap else None
