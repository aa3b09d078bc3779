"""What needs attention in a book, gravest first: checks over the same facts, each with the command that mends it.

`labbook attention` tells it of all days or some runs, `labbook today` of one day. A check is a function, and a line of
`CHECKS`; nothing that it finds is stored.
"""

from __future__ import annotations

import datetime
import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from enum import StrEnum
from typing import TypeAlias, TypedDict

from data_schema.queries.charges import ChargeOfRun
from data_schema.queries.history import void_reasons
from data_schema.queries.runs import RunRow, list_runs, refuse_empty_selection, where_columns
from data_schema.queries.signals import SignalRow, SourceColumn
from data_schema.reasons import Reason
from data_schema.vocabulary import FileRole, RunKind, RunState, Undefined
from data_schema.where import compile_where
from ingest.channels.names import parse_header
from ingest.declared import flag_names
from labbook.actions.files.stored_files import Waiting
from labbook.actions.runs import remarks
from labbook.actions.runs.attention_facts import Facts, gather_facts
from labbook.analysis.outcomes.detection import BODY_HEIGHT, Detections, jumps_found
from labbook.analysis.outcomes.log_dates import differing_day
from labbook.analysis.outcomes.run_apexes import Judgement
from labbook.analysis.outcomes.run_energy import (
    above_capacity,
    below_drain,
    recharge_of,
)
from labbook.config.local_time import local_text
from labbook.config.model import HOW_TO_DECIDE, Configuration
from labbook.statements.ingesting import zero_declared
from labbook.terminal import NOT_IN_JSON, listed
from stats.apexes.jumps import HEIGHT_DOUBTFUL


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
class Found:
    """What one check found: what is wrong, in a sentence, and the words behind `labbook` that mend it.

    `day` is None where it is of no day, `run` and `file` are names. `costs` says what the report lacks for it, and
    `costs_claim` that this is a claim.
    """

    what: str
    words: tuple[Word, ...] = field(metadata=NOT_IN_JSON)
    day: str | None = None
    run: str | None = None
    file: str | None = None
    costs: str = ""
    costs_claim: bool = False

    @property
    def command(self) -> str:
        """The command that mends it, quoted for a shell."""
        return shlex.join(["labbook", *map("".join, self.words)])

    @property
    def fill_in(self) -> tuple[str, ...]:
        """The words in the command that a person puts others for."""
        parts = (part for word in self.words for part in ([word] if isinstance(word, str) else word))
        return tuple(dict.fromkeys(str(part) for part in parts if isinstance(part, Blank)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding(Found):
    """What needs attention: by which check it was found, and how grave it is."""

    code: str
    gravity: Gravity


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
    facts = gather_facts(detections, configuration, asked, day)
    selected = {run.name for run in asked}
    found = [
        one
        for code, check in CHECKS.items()
        for one in check.findings(code, facts)
        if not check.of_book or (one.day is None or day in (None, one.day))
        if not check.of_book or where is None or one.run in selected
    ]
    order, codes = list(Gravity), list(CHECKS)
    found.sort(key=lambda one: (order.index(one.gravity), codes.index(one.code), one.day or ""))
    why_void = void_reasons(connection, [run.uid for run in asked if run.state is RunState.VOID])
    return Attention(
        day=day,
        where=where,
        runs=tuple(run.name for run in facts.runs),
        void={run.name: why_void.get(run.uid, "") for run in asked if run.state is RunState.VOID},
        findings=tuple(found),
    )


class Costs(TypedDict):
    """What a finding costs the report."""

    costs: str
    costs_claim: bool


def _found(
    what: str,
    *words: Word,
    run: RunRow | None = None,
    day: str | None = None,
    file: str | None = None,
    costs: str = "",
    costs_claim: bool = False,
) -> Found:
    """Return what was found, of the run's day where one is named, and the words that mend it."""
    return Found(
        what=what.removesuffix("."),
        words=words,
        day=run.day if run is not None else day,
        run=None if run is None else run.name,
        file=file,
        costs=costs,
        costs_claim=costs_claim,
    )


def _correct(run: RunRow, *fields_given: Word) -> tuple[Word, ...]:
    """Return the words that correct a run."""
    return "correct", run.name, *fields_given, "--why", Blank.WHY


def _redate(facts: Facts, run: RunRow, date: str) -> tuple[Word, ...]:
    """Return the words that give a run another date, and a position there that is free."""
    there = facts.positions.get(date, {})
    taken = there.get(run.position_in_day, run.name) != run.name
    return _correct(run, f"date={date}", *([f"position={max(there) + 1}"] if taken else []))


def _charge_missing(facts: Facts) -> Iterator[Found]:
    for run in facts.runs:
        why = recharge_of(run, facts.about.charges.get(run.uid, ()))
        if not isinstance(why, Undefined) or why.code not in (Reason.NO_CHARGE, Reason.PART_OF_CHARGE):
            continue
        if run.kind in (RunKind.JUMPS, RunKind.IDLE) and facts.evidence.waits(run.uid, FileRole.CHARGE) is None:
            idle = " (idle)" if run.kind is RunKind.IDLE else ""
            what = f"run {run.name}{idle} has {why.reason}"
            yield _found(what, "charge", run.name, Blank.MAH, run=run, **_costs_joules(facts, run))


def _costs_joules(facts: Facts, run: RunRow) -> Costs:
    """Return what it costs that a run has no charge."""
    line = facts.drains.get(run.robot_uid)
    if run.kind is RunKind.IDLE and isinstance(line, Undefined):
        return {"costs": f"no run of robot {run.robot} has joules: {line.reason}", "costs_claim": True}
    if run.kind is RunKind.IDLE:
        return {"costs": "the line of passive drain has a point less", "costs_claim": False}
    claim = facts.charge_costs.get(run.uid, "")
    return {"costs": claim or "its joules a jump are missing", "costs_claim": bool(claim)}


def _charges_several(facts: Facts) -> Iterator[Found]:
    for run in facts.runs:
        charges = facts.about.charges.get(run.uid, ())
        why = recharge_of(run, charges)
        if isinstance(why, Undefined) and why.code is Reason.SEVERAL_CHARGES:
            words = "correct", f"charge:{charges[-1].uid}", "run=none", "--why", Blank.WHY
            yield _found(f"run {run.name} has {why.reason}", *words, run=run, **_costs_joules(facts, run))


def _charge_waits(facts: Facts) -> Iterator[Found]:
    for each in facts.waiting:
        if each.contradicts:
            item, run = each.item, facts.by_name.get(each.item.stated_run or "")
            what = (
                f"{item.name} ({item.detail}) waits in the inbox, since {each.why}: if that one is wrong correct it, "
                "if both are parts of one add this, else dismiss it"
            )
            yield _found(what, "runs", "dismiss", _item_word(facts, each), "--why", Blank.WHY, run=run, file=item.name)


def _item_word(facts: Facts, each: Waiting) -> str:
    """Return how a command names an item of the inbox: as the inbox does, where that is of one file alone."""
    name, mark, place = each.item.name.rpartition("#") if each.item.what != "file" else (each.item.name, "", "")
    if facts.called(name, "") == name:
        return each.item.name
    return f"charge:{each.item.uid}" if each.item.what == "charge" else f"{each.item.uid}{mark}{place}"


def _inbox(facts: Facts) -> Iterator[Found]:
    for each in facts.waiting:
        item, run = each.item, facts.by_name.get(each.item.stated_run or "")
        if each.contradicts:
            continue
        words: tuple[Word, ...] = "assign", _item_word(facts, each), Blank.RUN
        why = "it names no run, or two"
        if run is not None:
            words, why = (
                ("assign", _item_word(facts, each), run.name),
                "it was taken off the run that it names",
            )
        elif item.stated_run is not None:
            words, why = ("runs", "import", Blank.FILE), f"the book has no run {item.stated_run}"
        costs = "no number rests on it"
        yield _found(f"{item.name} waits in the inbox: {why}", *words, run=run, file=item.name, costs=costs)


def _charge_below_drain(facts: Facts) -> Iterator[Found]:
    for run in facts.jumped:
        charges = facts.evidence.charges.get(run.uid, [])
        found = below_drain(run, charges, facts.drains[run.robot_uid])
        if found is not None:
            what = (
                f"run {run.name} has a charge of {found[0]:g} mAh, and the electronics alone draw {found[1]:.1f} mAh "
                f"in its {(run.duration_s or 0.0) / 60.0:.3g} min"
            )
            yield _found(
                what, *_correct_charge(run, charges), run=run, costs="its joules a jump are below 0, and count"
            )


def _charge_above_pack(facts: Facts) -> Iterator[Found]:
    for run in facts.runs:
        charges = facts.about.charges.get(run.uid, ())
        found = above_capacity(run, charges, facts.evidence.configuration)
        if found is not None:
            yield _found(f"run {run.name} has {found}", *_correct_charge(run, charges), run=run)


def _correct_charge(run: RunRow, charges: Sequence[ChargeOfRun]) -> tuple[Word, ...]:
    """Return the words that correct the only charge of a run, or the largest of several."""
    if len(charges) == 1:
        return _correct(run, ("mah=", Blank.MAH))
    largest = max(charges, key=lambda one: one.charge_mah)
    return "correct", f"charge:{largest.uid}", ("charge_mah=", Blank.MAH), "--why", Blank.WHY


def _charge_zero(facts: Facts) -> Iterator[Found]:
    for run in facts.runs:
        charges = facts.about.charges.get(run.uid, ())
        if any(one.charge_mah == 0 for one in charges) and run.kind is RunKind.IDLE:
            what = f"run {run.name} (idle) has a charge of 0 mAh"
            yield _found(what, *_correct_charge(run, charges), run=run, costs="it pulls the drain line down")


_RECHARGED_WITHIN = datetime.timedelta(days=7)
"""A pack is recharged at most so long after its run."""


def _charge_date(facts: Facts) -> Iterator[Found]:
    """Question a recharge that ended before its run, or long after it: one of both dates is wrong."""
    for run in facts.runs:
        before = remarks.RULES["charge_before_run"].odd(run, facts.about)
        for charge in facts.about.charges.get(run.uid, ()):
            other = differing_day(charge.ended_utc, run.day, facts.evidence.study.time_zone)
            late = other is not None and other.of_log - other.of_run > _RECHARGED_WITHIN
            if charge.ended_utc is None or (before is None and not late):
                continue
            instant = ("ended_utc=", Blank.INSTANT)
            words: tuple[Word, ...] = "correct", f"charge:{charge.uid}", instant, "--why", Blank.WHY
            if other is not None and not other.swapped:
                words = _redate(facts, run, str(other.of_log))
            what = before or f"run {run.name} is of {run.day} and its charge ended at {charge.ended_original}"
            yield _found(what, *words, run=run)
            break


def _log_missing(facts: Facts) -> Iterator[Found]:
    for run in facts.jumped:
        if not facts.logs(run) and facts.evidence.waits(run.uid, FileRole.LOG) is None:
            words = "ingest", Blank.FILE, "--run", run.name
            yield _found(f"run {run.name} has no log", *words, run=run, **_costs_heights(facts, run))


def _costs_heights(facts: Facts, run: RunRow) -> Costs:
    """Return what it costs that a run has no heights."""
    claim = facts.log_costs.get(run.uid, "")
    return {"costs": claim or "its apex heights are missing", "costs_claim": bool(claim)}


def _log_without_height(facts: Facts) -> Iterator[Found]:
    for run in _without_heights(facts, Reason.NO_HEIGHT_LOG):
        logs = facts.logs(run)
        if logs and facts.evidence.waits(run.uid, FileRole.LOG) is None:
            name = logs[0].file_name
            declared = Blank.COLUMN, f"={BODY_HEIGHT}:", Blank.UNIT
            what = f"{name}, the log of run {run.name}, has no {BODY_HEIGHT}: no jump can be found in it"
            words = *_reread(facts, logs[0]), "--column", declared
            yield _found(what, *words, run=run, file=name, **_costs_heights(facts, run))


def _logs_too_many(facts: Facts) -> Iterator[Found]:
    for run in _without_heights(facts, Reason.MORE_LOGS_THAN_STARTS):
        logs, other = facts.evidence.logs[run.uid], facts.about.other_levels().get(run.uid)
        one = next((log for log in logs if other is not None and log.uid == other.signal_uid), logs[-1])
        names = listed(list(dict.fromkeys(log.file_name for log in logs)), 4)
        what = f"run {run.name} has {facts.no_heights[run.uid].reason}, so none of them counts: {names}"
        words = "assign", _file_word(facts, one), "none", "--why", Blank.WHY
        yield _found(what, *words, run=run, file=one.file_name, **_costs_heights(facts, run))


def _calibration_of_other_day(facts: Facts) -> Iterator[Found]:
    for run in _without_heights(facts, Reason.CALIBRATION_OF_OTHER_DAY):
        log = facts.evidence.logs[run.uid][0]
        what = (
            f"{log.file_name} was read with a calibration that does not hold on {run.day}, when run {run.name} was made"
        )
        yield _found(what, *_reread(facts, log), run=run, file=log.file_name, **_costs_heights(facts, run))


def _without_heights(facts: Facts, why: Reason) -> list[RunRow]:
    return [run for run in facts.jumped if run.uid in facts.no_heights and facts.no_heights[run.uid].code is why]


def _samples_twice(facts: Facts) -> Iterator[Found]:
    for run in facts.runs:
        same = facts.about.same_samples.get(run.uid)
        if same is not None:
            of_run = f" of run {same.other_run}" if same.other_run != run.name else ""
            words = "files", "withdraw", facts.called(same.file_name, same.file_sha256[:12]), "--why", Blank.WHY
            what = f"{same.file_name} of run {run.name} has the samples of {same.other_file}{of_run}: one is a copy"
            yield _found(what, *words, run=run, file=same.file_name)


def _level_differs(facts: Facts) -> Iterator[Found]:
    for run in facts.runs:
        other = facts.about.other_levels().get(run.uid)
        if other is None:
            continue
        log = next(one for one in facts.about.signals[run.uid] if one.uid == other.signal_uid)
        what, words = other.sentence(log.file_name, run.name), _correct(run, f"{other.factor}={other.level}")
        if other.of_run is not None:
            what += f": it can be of {other.of_run}"
            words = "assign", _file_word(facts, log), other.of_run, "--why", Blank.WHY
        elif other.is_of_another:
            words = "assign", _file_word(facts, log), Blank.RUN, "--why", Blank.WHY
        yield _found(what, *words, run=run, file=log.file_name)


def _log_day_differs(facts: Facts) -> Iterator[Found]:
    zone = facts.evidence.study.time_zone
    for run in facts.runs:
        for log in facts.about.signals[run.uid]:
            other = differing_day(log.start_utc, run.day, zone)
            if other is not None:
                swapped = ", with day and month the other way round" if other.swapped else ""
                what = (
                    f"{log.file_name} begins on {other.of_log} and its run {run.name} is of {run.day}{swapped}: the "
                    "date of the run is wrong, it is the log of another run, or the clock of the logger was wrong"
                )
                yield _found(what, *_redate(facts, run, str(other.of_log)), run=run, file=log.file_name)
                break


def _zero_doubtful(facts: Facts) -> Iterator[Found]:
    for run, judgement in _judged(facts):
        if judgement.zero_doubtful:
            log = facts.evidence.logs[run.uid][0]
            zero_m, column = facts.zeros.get(log.file_sha256), facts.heights[log.uid]
            flag = _flag(column)
            declared: Word = flag, f"={BODY_HEIGHT}:{column.unit or 'm'},offset=", Blank.OFFSET
            if zero_m is not None and not column.calibrated and not isinstance(flag, Blank):
                declared = zero_declared(flag, column.unit, column.sign, column.scale, zero_m)
            about = "" if zero_m is None else f", by about {1e3 * zero_m:.0f} mm"
            what = (
                f"heights of run {run.name} are measured from too low a level{about}: its body stands higher than the "
                "leg is long"
            )
            words = *_reread(facts, log), "--column", declared
            yield _found(what, *words, run=run, file=log.file_name, costs="its apex heights are too high, and count")


def _reread(facts: Facts, log: SignalRow) -> tuple[Word, ...]:
    """Return the words that read a log again."""
    return "files", "reread", _file_word(facts, log)


def _file_word(facts: Facts, log: SignalRow) -> str:
    return facts.called(log.file_name, log.file_sha256[:12])


def _flag(column: SourceColumn) -> str:
    """Return how `--column` names a column, to be filled in where its name cannot stand on a command line."""
    (flag,) = flag_names([column.name])
    return flag if flag in (column.name, parse_header(column.name).base) else Blank.COLUMN


def _no_jump_found(facts: Facts) -> Iterator[Found]:
    for run, judgement in _judged(facts):
        if run.jumps_made and not jumps_found(one.jump for one in judgement.jumps):
            log = facts.evidence.logs[run.uid][0]
            declared = _flag(facts.heights[log.uid]), f"={BODY_HEIGHT}:", Blank.UNIT
            what = (
                f"none of the {run.jumps_made} jumps of run {run.name} is found in {log.file_name}: unit, scale or "
                "zero of its height do not fit the leg of the robot, or the sensor was loose"
            )
            words = *_reread(facts, log), "--column", declared, "--override-units"
            yield _found(what, *words, run=run, file=log.file_name, **_costs_heights(facts, run))


def _judged(facts: Facts) -> Iterator[tuple[RunRow, Judgement]]:
    return ((run, facts.judgements[run.uid]) for run in facts.jumped if run.uid in facts.judgements)


def _jumps_differ(facts: Facts) -> Iterator[Found]:
    """Set jumps found beside jumps made; a stance that was not jumped from, a misfire, is a jump made."""
    for run, judgement in _judged(facts):
        found, at_most = jumps_found(one.jump for one in judgement.jumps), len(judgement.jumps)
        if found and run.jumps_made and not found <= run.jumps_made <= at_most:
            off = run.jumps_made - at_most
            how = f"{off} missing, misfires counted" if off > 0 else f"{found - run.jumps_made} too many"
            what = f"{found} jumps are found in run {run.name} and {run.jumps_made} were made ({how})"
            costs = "joules a jump are of the jumps made"
            yield _found(what, *_correct(run, ("jumps=", Blank.JUMPS)), run=run, costs=costs)


def _no_jump_counts(facts: Facts) -> Iterator[Found]:
    for run, judgement in _judged(facts):
        open_ones = [one for one in judgement.jumps if one.jump.apex_height_m is not None and one.decision is None]
        if open_ones and not judgement.counted:
            why = ", ".join(dict.fromkeys(str(one.excluded) for one in open_ones))
            words = "jumps", "accept", run.name, *(str(one.jump.number) for one in open_ones)
            yield _found(f"no jump of run {run.name} counts: {why}", *words, run=run, **_costs_heights(facts, run))


def _jumps_doubtful(facts: Facts) -> Iterator[Found]:
    for run, judgement in _judged(facts):
        flags = {
            one.jump.number: HEIGHT_DOUBTFUL.intersection(one.jump.flags)
            for one in judgement.jumps
            if one.excluded is None and one.decision is None
        }
        numbers = [str(number) for number, raised in flags.items() if raised]
        if numbers:
            why = ", ".join(sorted(set().union(*flags.values())))
            what = f"of run {run.name} nobody has looked at jump{'s' * (len(numbers) > 1)} {listed(numbers)} ({why})"
            yield _found(what, "jumps", "accept", run.name, *numbers, run=run)


def _verdict_waits(facts: Facts) -> Iterator[Found]:
    lost = Counter(one.run for one in facts.verdicts_waiting)
    unfit = {run.name: len(judgement.waiting) for run, judgement in _judged(facts)}
    for run in facts.runs:
        counts = {"on samples that are not in force": lost[run.name], "that fit no jump found": unfit.get(run.name, 0)}
        waiting = " and ".join(f"{count} {why}" for why, count in counts.items() if count)
        if waiting:
            what = f"verdicts of run {run.name} wait ({waiting}): give them again, then take these back"
            yield _found(what, "jumps", "clear", run.name, "waiting", run=run)


def _outside_limits(facts: Facts) -> Iterator[Found]:
    for run in facts.jumped:
        if run.uid in facts.outside:
            words = _correct_charge(run, facts.about.charges[run.uid])
            what = f"joules a jump of run {run.name} lie outside the control limits of {run.condition_key}"
            yield _found(what, *words, run=run)


def _run_open(facts: Facts) -> Iterator[Found]:
    for run in facts.runs:
        if run.state is RunState.OPEN:
            costs = "its joules a jump are missing" if run.kind is RunKind.JUMPS else ""
            what = f"run {run.name} is open: fill in its duration and jumps on the run sheet"
            yield _found(what, "runs", "import", Blank.FILE, run=run, costs=costs)


def _no_drain_line(facts: Facts) -> Iterator[Found]:
    for robot in dict.fromkeys(run.robot for run in facts.jumped):
        of_robot = [run for run in facts.jumped if run.robot == robot and run.uid in facts.about.charges]
        line = facts.drains[of_robot[0].robot_uid] if of_robot else None
        if isinstance(line, Undefined):
            idle = [run for run in facts.evidence.idle if run.robot == robot and run.uid not in facts.evidence.charges]
            words: tuple[Word, ...] = ("charge", idle[0].name, Blank.MAH) if idle else ("runs", "import", Blank.FILE)
            costs = f"no run of robot {robot} has joules a jump ({listed([run.name for run in of_robot], 4)})"
            yield _found(
                f"robot {robot} has no line of passive drain: {line.reason}", *words, costs=costs, costs_claim=True
            )


def _odd(rule: str, *fields_given: Word) -> Callable[[Facts], Iterator[Found]]:
    """Return the check that is a rule on what was written of a run, mended by a correction of these fields."""

    def look(facts: Facts) -> Iterator[Found]:
        for run in facts.runs:
            message = remarks.RULES[rule].odd(run, facts.about)
            if message is not None:
                yield _found(message, *_correct(run, *fields_given), run=run)

    return look


def _file_waits(facts: Facts) -> Iterator[Found]:
    by_uid = {run.uid: run for run in facts.evidence.selected}
    for file in facts.evidence.waiting:
        runs = [by_uid[uid] for uid in file.runs if uid in by_uid]
        of = f" of {listed([run.name for run in runs], 4)}" if runs else ""
        mend: tuple[Word, ...] = ("files", "reread", facts.called(file.name, file.file_uid))
        if file.lost:
            mend = ("ingest", Blank.FILE)
        yield _found(
            f"{file.name} {'is lost' if file.lost else 'waits for a declaration'}: {file.message}",
            *mend,
            run=runs[0] if runs else None,
            file=file.name,
            costs=f"what it holds{of} is missing",
        )


_REFUSED_WITHIN = datetime.timedelta(days=7)
"""A refused file that states no run of the book is forgotten then: it may be no instrument's. One that states a run is
so when a file of that run came in since, whatever it is called."""


def _file_refused(facts: Facts) -> Iterator[Found]:
    oldest = (datetime.datetime.now(datetime.UTC) - _REFUSED_WITHIN).isoformat()
    for file in facts.refused:
        run = facts.by_name.get(file.stated_run or "")
        if run is None:
            is_open = file.at_utc >= oldest
        else:
            is_open = run.state is not RunState.VOID and facts.last_imports.get(run.uid, "") < file.at_utc
        if is_open:
            day = local_text(file.at_utc, facts.evidence.study.time_zone)[:10]
            what = f"{file.name} was refused on {day}: {file.why}"
            yield _found(what, "ingest", Blank.FILE, run=run, day=day, file=file.name, costs="what it holds is missing")


def _file_outdated(facts: Facts) -> Iterator[Found]:
    for name in facts.evidence.outdated:
        what = f"{name} was read with a profile that labbook.toml has otherwise now, and counts as it was read"
        yield _found(what, "files", "reread", "--all", file=name)


def _check_not_made(facts: Facts) -> Iterator[Found]:
    for date in facts.days:
        for kind in facts.evidence.configuration.protocol.checks:
            if kind not in facts.checks_made.get(date, ()):
                yield _found(f"the check {kind} was not made", "check", kind, "--day", date, day=date)


def _planned(facts: Facts) -> Iterator[Found]:
    for name in facts.planned_not_made:
        found = _found(f"run {name} is planned and not made", "runs", "import", Blank.FILE)
        yield replace(found, run=name)


def _analysis_undecided(facts: Facts) -> Iterator[Found]:
    if facts.undecided:
        yield _found(f"nothing is decided about the analysis: {HOW_TO_DECIDE}", "config")


@dataclass(frozen=True, slots=True)
class Check:
    """A check: how grave what it finds is, where that costs no claim, and how it looks at the facts.

    `of_book`: it looks at the whole book, whichever runs and days are asked about.
    """

    gravity: Gravity
    look: Callable[[Facts], Iterable[Found]]
    of_book: bool = False

    def findings(self, code: str, facts: Facts) -> list[Finding]:
        """Return what it finds, under the check's code."""
        return [
            Finding(
                code=code,
                gravity=Gravity.CLAIM if one.costs_claim else self.gravity,
                **{each.name: getattr(one, each.name) for each in fields(Found)},
            )
            for one in self.look(facts)
        ]


CHECKS: Mapping[str, Check] = {
    "charge_below_drain": Check(Gravity.WRONG, _charge_below_drain),
    "charge_above_pack": Check(Gravity.WRONG, _charge_above_pack),
    "charge_zero": Check(Gravity.WRONG, _charge_zero),
    "samples_twice": Check(Gravity.WRONG, _samples_twice),
    "level_differs": Check(Gravity.WRONG, _level_differs),
    "zero_doubtful": Check(Gravity.WRONG, _zero_doubtful),
    "no_drain_line": Check(Gravity.CLAIM, _no_drain_line),
    "charge_missing": Check(Gravity.MISSING, _charge_missing),
    "charges_several": Check(Gravity.MISSING, _charges_several),
    "log_missing": Check(Gravity.MISSING, _log_missing),
    "logs_too_many": Check(Gravity.MISSING, _logs_too_many),
    "log_without_height": Check(Gravity.MISSING, _log_without_height),
    "no_jump_found": Check(Gravity.MISSING, _no_jump_found),
    "no_jump_counts": Check(Gravity.MISSING, _no_jump_counts),
    "calibration_of_other_day": Check(Gravity.MISSING, _calibration_of_other_day),
    "file_waits": Check(Gravity.MISSING, _file_waits, of_book=True),
    "run_open": Check(Gravity.MISSING, _run_open),
    "log_day_differs": Check(Gravity.DOUBTFUL, _log_day_differs),
    "charge_date": Check(Gravity.DOUBTFUL, _charge_date),
    "date_in_future": Check(Gravity.DOUBTFUL, _odd("date_in_future", ("date=", Blank.DATE))),
    "date_long_ago": Check(Gravity.DOUBTFUL, _odd("date_long_ago", ("date=", Blank.DATE))),
    "outside_limits": Check(Gravity.DOUBTFUL, _outside_limits),
    "charge_waits": Check(Gravity.DOUBTFUL, _charge_waits, of_book=True),
    "pack_differs": Check(Gravity.DOUBTFUL, _odd("pack_differs", ("battery=", Blank.PACK))),
    "jumps_differ": Check(Gravity.DOUBTFUL, _jumps_differ),
    "jumps_unusual": Check(Gravity.DOUBTFUL, _odd("jumps_unusual", ("jumps=", Blank.JUMPS))),
    "duration_unusual": Check(Gravity.DOUBTFUL, _odd("duration_unusual", ("minutes=", Blank.MINUTES))),
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
