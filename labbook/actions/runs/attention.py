"""What needs attention in a book, gravest first: checks over the same facts, each with the command that mends it.

`labbook attention` tells it of all days or some runs, `labbook today` of one day; commands remark by the same checks on
what they state. A check is a function, and a line of `CHECKS`; nothing that it finds is stored. `Facts` are what checks
look at, each thing read when the first check asks for it.
"""

from __future__ import annotations

import datetime
import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from typing import TypeAlias
from zoneinfo import ZoneInfo

import sqlalchemy as sa

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.queries.charges import ChargeOfRun, charges_of_runs
from data_schema.queries.detections import verdicts_waiting
from data_schema.queries.files import LEG, imported_names, inbox, last_imports, refused_files, values_found
from data_schema.queries.history import first_measurement, void_reasons
from data_schema.queries.runs import RunRow, list_runs, refuse_empty_selection, where_columns
from data_schema.queries.signals import (
    RecordedRange,
    SignalRow,
    SourceColumn,
    calibrated_channels,
    recorded_ranges,
    same_samples,
    signals_of_runs,
    source_columns,
)
from data_schema.queries.study import checks_by_day, days_with_runs, planned_runs
from data_schema.reasons import Reason
from data_schema.vocabulary import FileRole, RunKind, RunState, Undefined
from data_schema.where import comparing, compile_where
from ingest.channels.names import parse_header
from ingest.declared import flag_names
from labbook.actions.files.stored_files import Waiting, why_waiting
from labbook.analysis.outcomes.control_limits import joule_limits, runs_outside
from labbook.analysis.outcomes.detection import BODY_HEIGHT, Detections, jumps_found
from labbook.analysis.outcomes.log_dates import differing_day
from labbook.analysis.outcomes.run_apexes import (
    Judgement,
    as_protocol,
    calibrated_for_other_day,
    judge_runs,
    logs_that_count,
    usable_logs,
)
from labbook.analysis.outcomes.run_energy import (
    above_capacity,
    below_drain,
    drain_lines,
    joules_per_jump,
    only_charge_missing,
    recharge_of,
    usable_charge,
)
from labbook.analysis.study_data import StudyData, gather
from labbook.book.naming import study_of
from labbook.config.local_time import local_text, today_in
from labbook.config.model import HOW_TO_DECIDE, Configuration
from labbook.statements.ingesting import zero_declared
from labbook.terminal import NOT_IN_JSON, listed
from stats.apexes.jumps import HEIGHT_DOUBTFUL
from stats.lines.passive_drain import PassiveDrain

Lines: TypeAlias = Mapping[str, PassiveDrain | Undefined]
"""The lines of passive drain, or why there is none, by the robot's uid."""


class Facts:
    """What checks look at: some `runs`, and the whole book; mappings are by the uid of a run where nothing is said.

    `detections` are needed for what looks at jumps, `day` is looked at without runs, too. A log that recorded another
    level is looked for among those of `days`, or of the whole book.
    """

    def __init__(
        self,
        connection: sa.Connection,
        configuration: Configuration,
        runs: Sequence[RunRow],
        *,
        days: Sequence[str] | None = None,
        day: str | None = None,
        detections: Detections | None = None,
    ) -> None:
        self.connection, self.configuration, self.runs = connection, configuration, runs
        self.days, self.day, self.detections = days, day, detections
        self.study, self._uids = study_of(connection), [run.uid for run in runs]

    @cached_property
    def charges(self) -> Mapping[str, Sequence[ChargeOfRun]]:
        """The charges of the runs."""
        return charges_of_runs(self.connection, self._uids)

    @cached_property
    def signals(self) -> Mapping[str, Sequence[SignalRow]]:
        """The signals of the runs."""
        signals = signals_of_runs(self.connection, run_uids=self._uids)
        found = grouped(signals, [signal.run_uid for signal in signals])
        return {uid: found.get(uid, []) for uid in self._uids}

    def logs(self, run: RunRow) -> list[SignalRow]:
        """Return the signals of a run's logs, whatever their channels."""
        return [one for one in self.signals[run.uid] if one.role == FileRole.LOG]

    def height_logs(self, run: RunRow) -> list[SignalRow]:
        """Return the logs of a run with a body height."""
        return [one for one in self.logs(run) if BODY_HEIGHT in one.channels]

    @cached_property
    def positions(self) -> Mapping[tuple[str, int], str]:
        """Whose each position of a day is."""
        return {(run.day, run.position_in_day): run.name for run in list_runs(self.connection)}

    @cached_property
    def file_names(self) -> Mapping[str, int]:
        """How many files have a name."""
        return Counter(imported_names(self.connection))

    def called(self, name: str, uid: str) -> str:
        """Return how a command names a file: its name, or what names it alone."""
        return name if self.file_names.get(name, 0) == 1 and not name.startswith("-") else uid

    def log_called(self, log: SignalRow) -> str:
        """Return how a command names a log."""
        return self.called(log.file_name, log.file_sha256[:12])

    @cached_property
    def other_levels(self) -> Mapping[str, OtherLevel]:
        """The logs that recorded another level."""
        declared = {
            name: {level.label: level.value for level in factor.levels if level.value is not None}
            for name, factor in self.configuration.factors.items()
        }
        recorded = recorded_ranges(self.connection, [name for name, levels in declared.items() if levels], self.days)
        runs = [
            run
            for run in (list_runs(self.connection) if recorded else ())
            if run.kind is RunKind.JUMPS
            and run.state is not RunState.VOID
            and (self.days is None or run.day in self.days)
        ]
        return other_levels(recorded, runs, declared)

    @cached_property
    def evidence(self) -> StudyData:
        """What the report would look at, of the whole book."""
        return gather(self.connection, self.configuration, None)

    @cached_property
    def by_name(self) -> Mapping[str, RunRow]:
        """All runs by name."""
        return {run.name: run for run in self.evidence.selected}

    @cached_property
    def waiting(self) -> Sequence[Waiting]:
        """What waits in the inbox."""
        return why_waiting(self.connection, inbox(self.connection))

    @cached_property
    def drains(self) -> Lines:
        """The lines of passive drain by the robot's uid."""
        return drain_lines(self.evidence)

    @cached_property
    def joules(self) -> Mapping[str, float]:
        """The joules a jump that are known."""
        return known_joules(self.evidence, self.drains)

    @cached_property
    def _counting(self) -> tuple[dict[str, tuple[SignalRow, ...]], dict[str, Undefined]]:
        """The logs that count, and why those of other runs do not."""
        return logs_that_count(self.evidence.runs, self.evidence.logs, self.evidence.calibrated)

    @property
    def no_heights(self) -> Mapping[str, Undefined]:
        """Why the logs of a run do not count."""
        return self._counting[1]

    @cached_property
    def judgements(self) -> Mapping[str, Judgement]:
        """The jumps of the runs."""
        assert self.detections is not None  # noqa: S101 - who looks at jumps has said by what
        logs, evidence = self._counting[0], self.evidence
        jumped = [run for run in self.runs if run.kind is RunKind.JUMPS]
        some = {run.uid: logs[run.uid] for run in jumped if run.uid in logs}
        judged = judge_runs(self.detections, jumped, some, evidence.decisions, as_protocol(evidence))
        return {uid: found.judgement for uid, found in judged.items()}

    @property
    def judged(self) -> Iterator[tuple[RunRow, Judgement]]:
        """The runs whose jumps were looked for, with these."""
        return ((run, self.judgements[run.uid]) for run in self.runs if run.uid in self.judgements)

    @cached_property
    def columns_in_doubt(self) -> Mapping[str, SourceColumn]:
        """The columns of heights with such a zero, and of those without a jump, by the signal's uid."""
        in_doubt = [
            log.uid
            for uid, judgement in self.judgements.items()
            if judgement.zero_doubtful or not jumps_found(one.jump for one in judgement.jumps)
            for log in self._counting[0][uid]
        ]
        return source_columns(self.connection, in_doubt, BODY_HEIGHT)

    @cached_property
    def charge_costs(self) -> Mapping[str, str]:
        """The claims that missing charges cost."""
        lacking = only_charge_missing(self.evidence.runs, self.evidence.charges)
        return _claims_lost(self.evidence, self.joules, lacking, Outcome.JOULES, "charge")

    @cached_property
    def log_costs(self) -> Mapping[str, str]:
        """The claims that missing logs cost."""
        lacking = [run for run in self.evidence.runs if run.uid in self.no_heights]
        return _claims_lost(self.evidence, self._counting[0], lacking, Outcome.APEX, "log")


def joules_of(run: RunRow, evidence: StudyData, drains: Lines) -> float | Undefined:
    """Return a run's joules a jump, or why there are none."""
    charge = usable_charge(run, evidence.charges.get(run.uid, []))
    if isinstance(charge, Undefined):
        return charge
    drain = drains[run.robot_uid]
    if isinstance(drain, Undefined):
        return Undefined(Reason.NO_DRAIN_FIT_YET)
    passive = drain.charge_at(run.duration_s or 0.0)
    return joules_per_jump(charge.charge_mah, passive, evidence.study.reference_voltage_v, run.jumps_made)


def known_joules(evidence: StudyData, drains: Lines) -> dict[str, float]:
    """Return the joules a jump of all runs that have any, by uid."""
    every = {run.uid: joules_of(run, evidence, drains) for run in evidence.runs}
    return {uid: joules for uid, joules in every.items() if not isinstance(joules, Undefined)}


def _claims_lost(
    evidence: StudyData, having: Iterable[str], lacking: Sequence[RunRow], outcome: Outcome, source: str
) -> dict[str, str]:
    """Return what each run's missing charge, or log, costs, by its uid: the claim that its group would make with it.

    `having` are the uids of the runs that have the outcome; where none has it, no claim is looked for.
    """
    from labbook.analysis.comparison.deciding import deciding_runs, makes_claim  # which remarks do not need
    from labbook.analysis.comparison.pairing import group_label, swept_factor

    swept, has = swept_factor(evidence.configuration), frozenset(having)
    if swept is None or not has or not lacking:
        return {}

    def by_group(runs: Iterable[RunRow]) -> dict[str, list[RunRow]]:
        """Return the runs by their levels of all factors but the swept one."""
        some = [run for run in runs if swept in run.levels]
        others = ({name: of for name, of in run.levels.items() if name != swept} for run in some)
        return grouped(some, map(group_label, others))

    costs: dict[str, str] = {}
    measured = by_group(run for run in evidence.runs if run.uid in has)
    for group, without in by_group(lacking).items():
        known = measured.get(group, [])
        if makes_claim(known):
            continue
        alone = deciding_runs(known, without)
        together = without if not alone and makes_claim([*known, *without]) else []
        sides = [{run.day for run in known if run.is_control is side} for side in (True, False)]
        days = len(sides[0] & sides[1])
        said = f"{group} has {days} shared day{'' if days == 1 else 's'} and makes no claim on {outcome.plural}"
        costs |= {run.uid: f"{said}; with this {source} it would" for run in alone}
        all_of = listed([run.name for run in together], 6)
        costs |= {run.uid: f"{said}; with the {source}s of {all_of} it would" for run in together}
    return costs


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
    of_runs = [one for one in recorded if one.run_uid in of]
    by_channel = grouped(of_runs, [one.channel for one in of_runs])
    levels = {name: declared[name] for name, some in by_channel.items() if _is_comparable(some, of, declared[name])}
    comparable = [one for name in levels for one in by_channel[name]]
    logs = {
        uid: grouped(several, [one.signal_uid for one in several])
        for uid, several in grouped(comparable, [one.run_uid for one in comparable]).items()
    }

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
    by_day = grouped(runs, [run.day for run in runs])

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


class Gravity(StrEnum):
    """How grave a finding is; the gravest stands first."""

    WRONG = "wrong"
    """What is stored cannot be so, and counts."""
    CLAIM = "claim lost"
    """The report makes no claim for want of it."""
    MISSING = "missing"
    """A run has no number for want of it."""
    DOUBTFUL = "doubtful"
    """It may be wrong: a person has to look."""
    TO_DO = "to do"
    """It waits to be done, and no number of a run is known to lack it."""


class Blank(StrEnum):
    """What a person puts in its place in a command."""

    COLUMN = "COLUMN"
    DATE = "DATE"
    FILE = "FILE"
    INSTANT = "INSTANT"
    JUMPS = "JUMPS"
    MAH = "MAH"
    MINUTES = "MINUTES"
    OFFSET = "OFFSET"
    PACK = "PACK"
    RUN = "RUN"
    UNIT = "UNIT"
    WHY = "WHY"


Word: TypeAlias = "str | tuple[str, ...]"
"""A word of a command, or the parts of one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """What one check found: what is wrong, in a sentence, and the words behind `labbook` that mend it.

    `day` is None where it is of no day, `run` and `file` are names. `costs` says what the report lacks for it, and
    `costs_claim` that this is a claim. `code` names the check.
    """

    what: str
    words: tuple[Word, ...] = field(metadata=NOT_IN_JSON)
    day: str | None = None
    run: str | None = None
    file: str | None = None
    costs: str = ""
    costs_claim: bool = False
    code: str = ""
    gravity: Gravity = Gravity.DOUBTFUL

    @property
    def command(self) -> str:
        """The command that mends it, quoted for a shell."""
        return shlex.join(["labbook", *map("".join, self.words)])

    @property
    def fill_in(self) -> tuple[str, ...]:
        """The words in the command that a person puts others for."""
        parts = (part for word in self.words for part in ([word] if isinstance(word, str) else word))
        return tuple(dict.fromkeys(str(part) for part in parts if isinstance(part, Blank)))


def found(
    what: str, *words: Word, run: RunRow | None = None, day: str | None = None, file: str | None = None, costs: str = ""
) -> Finding:
    """Return a finding, of the run's day where a run is given."""
    name = None if run is None else run.name
    return Finding(
        what=what.removesuffix("."), words=words, day=run.day if run else day, run=name, file=file, costs=costs
    )


def correcting(target: str, *fields_given: Word) -> tuple[Word, ...]:
    """Return the words that correct a run or a charge."""
    return "correct", target, *fields_given, "--why", Blank.WHY


@dataclass(frozen=True, slots=True)
class Attention:
    """What needs attention of one day, or of all days (`day` is None), of all runs or of those that fulfil `where`.

    `runs` are those that count, by name, and `void` those that do not, with the reason. The gravest of `findings` stand
    first, those of a check by day.
    """

    day: str | None
    where: str | None
    runs: tuple[str, ...]
    void: Mapping[str, str]
    findings: tuple[Finding, ...]

    @property
    def by_day(self) -> dict[str, dict[Gravity, int]]:
        """How many findings of each gravity a day has, the days with the gravest, and with most of these, first."""
        counts: dict[str, Counter[Gravity]] = {}
        for one in self.findings:
            if one.day is not None:
                counts.setdefault(one.day, Counter())[one.gravity] += 1
        ordered = {date: {each: of_day[each] for each in Gravity if of_day[each]} for date, of_day in counts.items()}
        return dict(sorted(ordered.items(), key=lambda item: ([-counts[item[0]][each] for each in Gravity], item[0])))


def attention(
    detections: Detections, configuration: Configuration, *, day: str | None = None, where: str | None = None
) -> Attention:
    """Look at the whole book, at one day, or at the runs that fulfil `where`; then what is of no run is left out.

    Raises `UsageError` for a `where` that no run fulfils.
    """
    connection = detections.connection
    refuse_empty_selection(connection, where)
    rows = list_runs(connection, compile_where(where, where_columns(connection)) if where else None)
    asked = [run for run in rows if day in (None, run.day)]
    counting = [run for run in asked if run.state is not RunState.VOID]
    facts = Facts(connection, configuration, counting, day=day, detections=detections)
    selected = {run.name for run in asked}
    findings = [
        replace(one, code=code, gravity=Gravity.CLAIM if one.costs_claim else check.gravity)
        for code, check in CHECKS.items()
        for one in check.findings(facts)
        if not check.of_book or ((one.day is None or day in (None, one.day)) and (where is None or one.run in selected))
    ]
    order, codes = list(Gravity), list(CHECKS)
    findings.sort(key=lambda one: (order.index(one.gravity), codes.index(one.code), one.day or ""))
    void = [run for run in asked if run.state is RunState.VOID]
    why_void = void_reasons(connection, [run.uid for run in void])
    return Attention(
        day=day,
        where=where,
        runs=tuple(run.name for run in counting),
        void={run.name: why_void.get(run.uid, "") for run in void},
        findings=tuple(findings),
    )


def _joules_lost(run: RunRow, facts: Facts) -> tuple[str, bool]:
    """Return what it costs that a run has no charge, and whether that is a claim."""
    line = facts.drains.get(run.robot_uid)
    if run.kind is RunKind.IDLE and isinstance(line, Undefined):
        return f"no run of robot {run.robot} has joules: {line.reason}", True
    if run.kind is RunKind.IDLE:
        return "the line of passive drain has a point less", False
    claim = facts.charge_costs.get(run.uid, "")
    return claim or "its joules a jump are missing", bool(claim)


def _heights_lost(run: RunRow, facts: Facts) -> tuple[str, bool]:
    """Return what it costs that a run has no heights, and whether that is a claim."""
    claim = facts.log_costs.get(run.uid, "")
    return claim or "its apex heights are missing", bool(claim)


def _charge_missing(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        why = recharge_of(run, facts.charges.get(run.uid, ()))
        if not isinstance(why, Undefined) or why.code not in (Reason.NO_CHARGE, Reason.PART_OF_CHARGE):
            continue
        waits = facts.evidence.waits(run.uid, FileRole.CHARGE) is not None
        if run.kind not in (RunKind.JUMPS, RunKind.IDLE) or waits:
            continue
        what = f"run {run.name}{' (idle)' if run.kind is RunKind.IDLE else ''} has {why.reason}"
        yield found(what, "charge", run.name, Blank.MAH, run=run)


def _charges_several(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        charges = facts.charges.get(run.uid, ())
        why = recharge_of(run, charges)
        if not isinstance(why, Undefined) or why.code is not Reason.SEVERAL_CHARGES:
            continue
        words = correcting(f"charge:{charges[-1].uid}", "run=none")
        yield found(f"run {run.name} has {why.reason}", *words, run=run)


def _charge_waits(facts: Facts) -> Iterator[Finding]:
    for each in facts.waiting:
        if each.contradicts:
            item, run = each.item, facts.by_name.get(each.item.stated_run or "")
            what = (
                f"{item.name} ({item.detail}) waits in the inbox, since {each.why}: if that one is wrong correct it, "
                "if both are parts of one add this, else dismiss it"
            )
            yield found(what, "runs", "dismiss", _item_word(facts, each), "--why", Blank.WHY, run=run, file=item.name)


def _item_word(facts: Facts, each: Waiting) -> str:
    """Return how a command names an item of the inbox: as the inbox does, where that is of one file alone."""
    name, mark, place = each.item.name.rpartition("#") if each.item.what != "file" else (each.item.name, "", "")
    if facts.called(name, "") == name:
        return each.item.name
    return f"charge:{each.item.uid}" if each.item.what == "charge" else f"{each.item.uid}{mark}{place}"


def _inbox(facts: Facts) -> Iterator[Finding]:
    for each in facts.waiting:
        item, run = each.item, facts.by_name.get(each.item.stated_run or "")
        if each.contradicts:
            continue
        words: tuple[Word, ...] = "assign", _item_word(facts, each), Blank.RUN if run is None else run.name
        why = "it names no run, or two" if run is None else "it was taken off the run that it names"
        if run is None and item.stated_run is not None:
            words, why = ("runs", "import", Blank.FILE), f"the book has no run {item.stated_run}"
        what = f"{item.name} waits in the inbox: {why}"
        yield found(what, *words, run=run, file=item.name, costs="no number rests on it")


def _charge_below_drain(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        charges = facts.evidence.charges.get(run.uid, [])
        both = below_drain(run, charges, facts.drains[run.robot_uid]) if run.kind is RunKind.JUMPS else None
        if both is None or both[0] == 0.0:
            continue
        what = (
            f"run {run.name} has a charge of {both[0]:g} mAh, and the electronics alone draw {both[1]:.1f} mAh in its "
            f"{(run.duration_s or 0.0) / 60.0:.3g} min"
        )
        yield found(what, *correcting_charge(run, charges), run=run, costs="its joules a jump are below 0, and count")


def _log_missing(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        waits = facts.evidence.waits(run.uid, FileRole.LOG) is not None
        if run.kind is not RunKind.JUMPS or facts.logs(run) or waits:
            continue
        words = "ingest", Blank.FILE, "--run", run.name
        yield found(f"run {run.name} has no log", *words, run=run)


def _log_without_height(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        why, logs = facts.no_heights.get(run.uid), facts.logs(run)
        if why is None or why.code is not Reason.NO_HEIGHT_LOG or run.kind is not RunKind.JUMPS or not logs:
            continue
        if facts.evidence.waits(run.uid, FileRole.LOG) is not None:
            continue
        name = logs[0].file_name
        what = f"{name}, the log of run {run.name}, has no {BODY_HEIGHT}: no jump can be found in it"
        words = *_rereading(facts, logs[0]), "--column", (Blank.COLUMN, f"={BODY_HEIGHT}:", Blank.UNIT)
        yield found(what, *words, run=run, file=name)


def _zero_doubtful(facts: Facts) -> Iterator[Finding]:
    zeros = values_found(facts.connection, LEG[0])
    for run, judgement in facts.judged:
        if not judgement.zero_doubtful:
            continue
        log = facts.evidence.logs[run.uid][0]
        zero, column = zeros.get(log.file_sha256), facts.columns_in_doubt[log.uid]
        zero_m = None if zero is None else float(zero)
        flag = _flag(column)
        declared: Word = flag, f"={BODY_HEIGHT}:{column.unit or 'm'},offset=", Blank.OFFSET
        if zero_m is not None and not column.calibrated and not isinstance(flag, Blank):
            declared = zero_declared(flag, column.unit, column.sign, column.scale, zero_m)
        about = "" if zero_m is None else f", by about {1e3 * zero_m:.0f} mm"
        what = (
            f"heights of run {run.name} are measured from too low a level{about}: its body stands higher than the leg "
            "is long"
        )
        words = *_rereading(facts, log), "--column", declared
        yield found(what, *words, run=run, file=log.file_name, costs="its apex heights are too high, and count")


def _rereading(facts: Facts, log: SignalRow) -> tuple[Word, ...]:
    return "files", "reread", facts.log_called(log)


def _flag(column: SourceColumn) -> str:
    """Return how `--column` names a column, to be filled in where its name cannot stand on a command line."""
    (flag,) = flag_names([column.name])
    return flag if flag in (column.name, parse_header(column.name).base) else Blank.COLUMN


def _no_jump_found(facts: Facts) -> Iterator[Finding]:
    for run, judgement in facts.judged:
        if not run.jumps_made or _found_in(judgement):
            continue
        log = facts.evidence.logs[run.uid][0]
        what = (
            f"none of the {run.jumps_made} jumps of run {run.name} is found in {log.file_name}: unit, scale or zero of "
            "its height do not fit the leg of the robot, or the sensor was loose"
        )
        declared = _flag(facts.columns_in_doubt[log.uid]), f"={BODY_HEIGHT}:", Blank.UNIT
        words = *_rereading(facts, log), "--column", declared, "--override-units"
        yield found(what, *words, run=run, file=log.file_name)


def _found_in(judgement: Judgement) -> int:
    return jumps_found(one.jump for one in judgement.jumps)


def _jumps_differ(facts: Facts) -> Iterator[Finding]:
    """Set jumps found beside jumps made; a stance that was not jumped from, a misfire, is a jump made.

    A rejected jump may be one that was made, and be badly measured, or none.
    """
    from labbook.actions.runs.jump_review import queued_jumps  # which remarks do not need

    for run, judgement in facts.judged:
        made = run.jumps_made
        if not made:
            continue
        n_found, at_most = _found_in(judgement), len(judgement.jumps)
        n_rejected = jumps_found(one.jump for one in judgement.jumps if one.rejected)
        too_many = n_found - n_rejected - made
        if not n_found or (too_many <= 0 and made <= at_most):
            continue
        how = f"{too_many} too many" if too_many > 0 else f"{made - at_most} missing, misfires counted"
        rejected = f", {n_rejected} of them rejected," if n_rejected else ""
        what = f"{n_found} jumps are found in run {run.name}{rejected} and {made} were made ({how})"
        words = correcting(run.name, ("jumps=", Blank.JUMPS))
        if too_many > 0:
            queued = (one for one in queued_jumps(run, judgement) if one.doubt and one.decision is None)
            doubtful = [str(one.number) for one in queued if one.apex_height_m is not None]
            if doubtful:
                what += f": look first at {_numbered(doubtful)}, and reject what is none"
                words = _looking_at(run)
        yield found(what, *words, run=run, costs="joules a jump are of the jumps made")


def _looking_at(run: RunRow) -> tuple[Word, ...]:
    """Return the words that show the jumps of a run on which nobody has given a verdict, the doubtful first."""
    return "jumps", "queue", "--where", comparing("run", run.name), "--unreviewed"


def _numbered(numbers: Sequence[str]) -> str:
    return f"jump{'s' * (len(numbers) > 1)} {listed(numbers)}"


def _no_jump_counts(facts: Facts) -> Iterator[Finding]:
    for run, judgement in facts.judged:
        every = () if judgement.counted else judgement.jumps
        open_ones = [one for one in every if one.jump.apex_height_m is not None and one.decision is None]
        if not open_ones:
            continue
        why = ", ".join(dict.fromkeys(str(one.excluded) for one in open_ones))
        words = "jumps", "accept", run.name, *(str(one.jump.number) for one in open_ones)
        yield found(f"no jump of run {run.name} counts: {why}", *words, run=run)


def _jumps_doubtful(facts: Facts) -> Iterator[Finding]:
    for run, judgement in facts.judged:
        flags = {
            str(one.jump.number): raised
            for one in judgement.jumps
            if one.excluded is None
            and one.decision is None
            and (raised := HEIGHT_DOUBTFUL.intersection(one.jump.flags))
        }
        if not flags:
            continue
        why = ", ".join(sorted(set().union(*flags.values())))
        what = f"of run {run.name} nobody has looked at {_numbered(list(flags))} ({why}): accept or reject each"
        yield found(what, *_looking_at(run), run=run)


def _verdict_waits(facts: Facts) -> Iterator[Finding]:
    on_others = Counter(one.run for one in verdicts_waiting(facts.connection))
    for run in facts.runs:
        judgement = facts.judgements.get(run.uid)
        counts = {
            "on samples that are not in force": on_others[run.name],
            "that fit no jump found": 0 if judgement is None else len(judgement.waiting),
        }
        waiting = " and ".join(f"{count} {why}" for why, count in counts.items() if count)
        if waiting:
            what = f"verdicts of run {run.name} wait ({waiting}): give them again, then take these back"
            yield found(what, "jumps", "clear", run.name, "waiting", run=run)


def _outside_limits(facts: Facts) -> Iterator[Finding]:
    limits = joule_limits(facts.evidence, facts.joules)
    outside = {run.uid for run in runs_outside(facts.evidence.runs, facts.joules, limits)}
    for run in facts.runs:
        if run.uid in outside:
            what = f"joules a jump of run {run.name} lie outside the control limits of {run.condition_key}"
            yield found(what, *correcting_charge(run, facts.charges[run.uid]), run=run)


def _run_open(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        if run.state is not RunState.OPEN:
            continue
        costs = "its joules a jump are missing" if run.kind is RunKind.JUMPS else ""
        what = f"run {run.name} is open: fill in its duration and jumps on the run sheet"
        yield found(what, "runs", "import", Blank.FILE, run=run, costs=costs)


def _no_drain_line(facts: Facts) -> Iterator[Finding]:
    jumped = [run for run in facts.runs if run.kind is RunKind.JUMPS and run.uid in facts.charges]
    for robot, uid in dict.fromkeys((run.robot, run.robot_uid) for run in jumped):
        line = facts.drains[uid]
        if isinstance(line, Undefined):
            idle = [run for run in facts.evidence.idle if run.robot == robot and run.uid not in facts.evidence.charges]
            words: tuple[Word, ...] = ("charge", idle[0].name, Blank.MAH) if idle else ("runs", "import", Blank.FILE)
            names = listed([run.name for run in jumped if run.robot == robot], 4)
            costs = f"no run of robot {robot} has joules a jump ({names})"
            one = found(f"robot {robot} has no line of passive drain: {line.reason}", *words, costs=costs)
            yield replace(one, costs_claim=True)


def _file_waits(facts: Facts) -> Iterator[Finding]:
    by_uid = {run.uid: run for run in facts.evidence.selected}
    for file in facts.evidence.waiting:
        runs = [by_uid[uid] for uid in file.runs if uid in by_uid]
        of = f" of {listed([run.name for run in runs], 4)}" if runs else ""
        reread: tuple[Word, ...] = "files", "reread", facts.called(file.name, file.file_uid)
        yield found(
            f"{file.name} {'is lost' if file.lost else 'waits for a declaration'}: {file.message}",
            *(("ingest", Blank.FILE) if file.lost else reread),
            run=runs[0] if runs else None,
            file=file.name,
            costs=f"what it holds{of} is missing",
        )


_REFUSED_WITHIN = datetime.timedelta(days=7)
"""A refused file that states no run of the book is forgotten then: it may be no instrument's. One that states a run is
so when a file of that run came in since, whatever it is called."""


def _file_refused(facts: Facts) -> Iterator[Finding]:
    oldest = (datetime.datetime.now(datetime.UTC) - _REFUSED_WITHIN).isoformat()
    refused = refused_files(facts.connection)
    last = last_imports(facts.connection) if any(one.stated_run for one in refused) else {}
    for file in refused:
        run = facts.by_name.get(file.stated_run or "")
        if run is None:
            is_open = file.at_utc >= oldest
        else:
            is_open = run.state is not RunState.VOID and last.get(run.uid, "") < file.at_utc
        if is_open:
            day = local_text(file.at_utc, facts.study.time_zone)[:10]
            what = f"{file.name} was refused on {day}: {file.why}"
            yield found(what, "ingest", Blank.FILE, run=run, day=day, file=file.name, costs="what it holds is missing")


def _file_outdated(facts: Facts) -> Iterator[Finding]:
    for name in facts.evidence.outdated:
        what = f"{name} was read with a profile that labbook.toml has otherwise now, and counts as it was read"
        yield found(what, "files", "reread", "--all", file=name)


def _check_not_made(facts: Facts) -> Iterator[Finding]:
    made = checks_by_day(facts.connection)
    for date in sorted({run.day for run in facts.runs} | ({facts.day} if facts.day else set())):
        for kind in facts.configuration.protocol.checks:
            if all(one.kind != kind for one in made.get(date, ())):
                yield found(f"the check {kind} was not made", "check", kind, "--day", date, day=date)


def _planned(facts: Facts) -> Iterator[Finding]:
    for row in planned_runs(facts.connection):
        if row.run_name is None:
            one = found(f"run {row.name} is planned and not made", "runs", "import", Blank.FILE)
            yield replace(one, run=row.name)


def _analysis_undecided(facts: Facts) -> Iterator[Finding]:
    if facts.configuration.analysis is None and first_measurement(facts.connection) is None:
        yield found(f"nothing is decided about the analysis: {HOW_TO_DECIDE}", "config")


YEAR = datetime.timedelta(days=365)
_RECHARGED_WITHIN = datetime.timedelta(days=7)
"""A pack is recharged at most so long after its run."""


def _duration(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        protocol = facts.configuration.protocol
        if run.kind is RunKind.IDLE:
            usual_s = [minutes * 60.0 for minutes in protocol.idle_minutes]
        else:
            usual_s = [protocol.run_duration_s] if run.kind is RunKind.JUMPS and protocol.run_duration_s else []
        if run.duration_s is None or not usual_s or min(usual_s) / 2 <= run.duration_s <= 2 * max(usual_s):
            continue
        usual = " to ".join(f"{value:g}" for value in dict.fromkeys((min(usual_s), max(usual_s))))
        what = f"run {run.name} lasted {run.duration_s:g} s where the protocol has {usual} s"
        yield found(what, *correcting(run.name, ("minutes=", Blank.MINUTES)), run=run)


def _future(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        if run.day <= today_in(facts.study.time_zone):
            continue
        what = f"run {run.name} is of {run.day}, which is yet to come"
        yield found(what, *correcting(run.name, ("date=", Blank.DATE)), run=run)


def _long_ago(facts: Facts) -> Iterator[Finding]:
    days = days_with_runs(facts.connection)
    for run in facts.runs:
        first = next((day for day in days if day != run.day), None)
        if first is None or datetime.date.fromisoformat(first) - datetime.date.fromisoformat(run.day) <= YEAR:
            continue
        what = f"run {run.name} is of {run.day}, more than a year before the other days, the first of them {first}"
        yield found(what, *correcting(run.name, ("date=", Blank.DATE)), run=run)


def _redating(run: RunRow, date: str, facts: Facts) -> tuple[Word, ...]:
    """Return the words that give a run another date, and a position there that is free."""
    there = {place: name for (day, place), name in facts.positions.items() if day == date}
    taken = there.get(run.position_in_day, run.name) != run.name
    return correcting(run.name, f"date={date}", *([f"position={max(there) + 1}"] if taken else []))


def _log_day(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        for log in facts.signals[run.uid]:
            other = differing_day(log.start_utc, run.day, facts.study.time_zone)
            if other is not None:
                swapped = ", with day and month the other way round" if other.swapped else ""
                what = (
                    f"{log.file_name} begins on {other.of_log} and its run {run.name} is of {run.day}{swapped}: the "
                    "date of the run is wrong, it is the log of another run, or the clock of the logger was wrong"
                )
                yield found(what, *_redating(run, str(other.of_log), facts), run=run, file=log.file_name)
                break


def _calibration(facts: Facts) -> Iterator[Finding]:
    calibrated = calibrated_channels(facts.connection)
    for run in facts.runs:
        heights = facts.height_logs(run)
        if run.kind is not RunKind.JUMPS or calibrated_for_other_day(run, heights, calibrated) is None:
            continue
        name = heights[0].file_name
        what = f"{name} was read with a calibration that does not hold on {run.day}, when run {run.name} was made"
        yield found(what, "files", "reread", facts.log_called(heights[0]), run=run, file=name)


def _logs(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        logs = facts.height_logs(run)
        why = usable_logs(run, logs) if logs and run.kind is RunKind.JUMPS else ()
        if not isinstance(why, Undefined):
            continue
        other = facts.other_levels.get(run.uid)
        one = next((log for log in logs if other is not None and log.uid == other.signal_uid), None)
        one = one or min(reversed(logs), key=lambda log: log.n_samples)  # what was cut off has the fewest
        names = listed(list(dict.fromkeys(log.file_name for log in logs)), 4)
        what = (
            f"run {run.name} has {why.reason}, so none of them counts: {names}; take one off, or correct how often it "
            "was started (starts=N)"
        )
        yield found(what, "assign", facts.log_called(one), "none", "--why", Blank.WHY, run=run, file=one.file_name)


def _levels(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        other = facts.other_levels.get(run.uid)
        if other is None:
            continue
        log = next(one for one in facts.signals[run.uid] if one.uid == other.signal_uid)
        what = f"{log.file_name} recorded {other.factor} {other.level}, and its run {run.name} has {other.has}"
        if other.of_run is not None:
            what += f": it can be of {other.of_run}"
        of_another: tuple[Word, ...] = "assign", facts.log_called(log), other.of_run or Blank.RUN, "--why", Blank.WHY
        words = of_another if other.is_of_another else correcting(run.name, f"{other.factor}={other.level}")
        yield found(what, *words, run=run, file=log.file_name)


def _samples(facts: Facts) -> Iterator[Finding]:
    copies = same_samples(facts.connection, [run.uid for run in facts.runs])
    for run in facts.runs:
        same = copies.get(run.uid)
        if same is None:
            continue
        of_run = f" of run {same.other_run}" if same.other_run != run.name else ""
        what = f"{same.file_name} of run {run.name} has the samples of {same.other_file}{of_run}: one is a copy"
        words = "files", "withdraw", facts.called(same.file_name, same.file_sha256[:12]), "--why", Blank.WHY
        yield found(what, *words, run=run, file=same.file_name)


def _jumps(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        nominal = facts.study.jumps_nominal
        if run.kind is not RunKind.JUMPS or run.state is RunState.OPEN or 0 < run.jumps_made <= 2 * nominal:
            continue
        what = f"run {run.name} has {run.jumps_made} jumps made where the protocol has {nominal}"
        yield found(what, *correcting(run.name, ("jumps=", Blank.JUMPS)), run=run)


def correcting_charge(run: RunRow, charges: Sequence[ChargeOfRun]) -> tuple[Word, ...]:
    """Return the words that correct the only charge of a run, or the largest of several."""
    if len(charges) == 1:
        return correcting(run.name, ("mah=", Blank.MAH))
    largest = max(charges, key=lambda one: one.charge_mah)
    return correcting(f"charge:{largest.uid}", ("charge_mah=", Blank.MAH))


def _above_pack(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        charges = facts.charges.get(run.uid, ())
        above = above_capacity(run, charges, facts.configuration)
        if above is None:
            continue
        yield found(f"run {run.name} has {above}", *correcting_charge(run, charges), run=run)


def _zero(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        charges = facts.charges.get(run.uid, ())
        if all(charge.charge_mah for charge in charges):
            continue
        is_idle = run.kind is RunKind.IDLE
        costs = "it pulls the drain line down" if is_idle else ""
        what = f"run {run.name}{' (idle)' if is_idle else ''} has a charge of 0 mAh"
        yield found(what, *correcting_charge(run, charges), run=run, costs=costs)


def _charge_date(facts: Facts) -> Iterator[Finding]:
    """Question a recharge that ended before its run began, or long after: one of both dates is wrong.

    Of a date alone midnight is stored, so that its day counts.
    """
    for run in facts.runs:
        zone = facts.study.time_zone
        for charge in facts.charges.get(run.uid, ()):
            if charge.ended_utc is None:
                continue
            ended, other = (
                datetime.datetime.fromisoformat(charge.ended_utc),
                differing_day(charge.ended_utc, run.day, zone),
            )
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
                how = "`labbook files reread FILE --dates ...` says their order"
                what += f", with day and month the other way round ({how})"
            elif other is not None:
                words = _redating(run, str(other.of_log), facts)
            yield found(what, *words, run=run)
            break


def _pack(facts: Facts) -> Iterator[Finding]:
    for run in facts.runs:
        for charge in facts.charges.get(run.uid, ()):
            if charge.stated_pack is not None and charge.stated_pack != run.battery:
                what = f"run {run.name} was made with pack {run.battery} and its charge is of pack {charge.stated_pack}"
                yield found(what, *correcting(run.name, ("battery=", Blank.PACK)), run=run)
                break


@dataclass(frozen=True, slots=True)
class Check:
    """A check: how grave what it finds is, where that costs no claim, and how it looks at the facts.

    `costs` says what the report lacks for what it finds of a run, and whether that is a claim. `of_book`: it looks at
    the whole book, whichever runs and days are asked about. One with `columns` remarks on runs, too, when one of these
    is stated; `alike`: one message holds for all runs that it concerns, so that they share one remark; else each has
    its own.
    """

    gravity: Gravity
    look: Callable[[Facts], Iterable[Finding]]
    costs: Callable[[RunRow, Facts], tuple[str, bool]] | None = None
    of_book: bool = False
    columns: str = ""
    alike: bool = True

    def findings(self, facts: Facts) -> Iterator[Finding]:
        """Yield what it finds."""
        by_name = {run.name: run for run in facts.runs}
        for one in self.look(facts):
            if self.costs is not None:
                costs, is_claim = self.costs(by_name[one.run or ""], facts)
                one = replace(one, costs=costs, costs_claim=is_claim)
            yield one


CHECKS: Mapping[str, Check] = {
    "charge_below_drain": Check(Gravity.WRONG, _charge_below_drain),
    "charge_above_pack": Check(Gravity.WRONG, _above_pack, columns="charge_mah battery run"),
    "charge_zero": Check(Gravity.WRONG, _zero, columns="charge_mah run"),
    "samples_twice": Check(Gravity.WRONG, _samples, columns="log samples", alike=False),
    "level_differs": Check(Gravity.WRONG, _levels, columns="condition log samples", alike=False),
    "zero_doubtful": Check(Gravity.WRONG, _zero_doubtful),
    "no_drain_line": Check(Gravity.CLAIM, _no_drain_line),
    "charge_missing": Check(Gravity.MISSING, _charge_missing, _joules_lost),
    "charges_several": Check(Gravity.MISSING, _charges_several, _joules_lost),
    "log_missing": Check(Gravity.MISSING, _log_missing, _heights_lost),
    "logs_too_many": Check(Gravity.MISSING, _logs, _heights_lost, columns="log starts", alike=False),
    "log_without_height": Check(Gravity.MISSING, _log_without_height, _heights_lost),
    "no_jump_found": Check(Gravity.MISSING, _no_jump_found, _heights_lost),
    "no_jump_counts": Check(Gravity.MISSING, _no_jump_counts, _heights_lost),
    "calibration_of_other_day": Check(Gravity.MISSING, _calibration, _heights_lost, columns="day log", alike=False),
    "file_waits": Check(Gravity.MISSING, _file_waits, of_book=True),
    "run_open": Check(Gravity.MISSING, _run_open),
    "log_day_differs": Check(Gravity.DOUBTFUL, _log_day, columns="day log", alike=False),
    "charge_date": Check(
        Gravity.DOUBTFUL, _charge_date, columns="charge_mah ended_utc started_utc day run", alike=False
    ),
    "date_in_future": Check(Gravity.DOUBTFUL, _future, columns="day"),
    "date_long_ago": Check(Gravity.DOUBTFUL, _long_ago, columns="day"),
    "outside_limits": Check(Gravity.DOUBTFUL, _outside_limits),
    "charge_waits": Check(Gravity.DOUBTFUL, _charge_waits, of_book=True),
    "pack_differs": Check(Gravity.DOUBTFUL, _pack, columns="battery stated_pack run"),
    "jumps_differ": Check(Gravity.DOUBTFUL, _jumps_differ),
    "jumps_unusual": Check(Gravity.DOUBTFUL, _jumps, columns="jumps_made kind state"),
    "duration_unusual": Check(Gravity.DOUBTFUL, _duration, columns="duration_s kind"),
    "verdict_waits": Check(Gravity.DOUBTFUL, _verdict_waits),
    "jumps_doubtful": Check(Gravity.DOUBTFUL, _jumps_doubtful),
    "file_outdated": Check(Gravity.DOUBTFUL, _file_outdated, of_book=True),
    "file_refused": Check(Gravity.TO_DO, _file_refused, of_book=True),
    "inbox": Check(Gravity.TO_DO, _inbox, of_book=True),
    "check_not_made": Check(Gravity.TO_DO, _check_not_made),
    "planned_not_made": Check(Gravity.TO_DO, _planned, of_book=True),
    "analysis_undecided": Check(Gravity.TO_DO, _analysis_undecided, of_book=True),
}
"""The checks by the code of what they find; of one gravity in this order."""
