"""What needs attention in a book, gravest first: checks over the same facts, each with the command that mends it.

`labbook attention` tells it of all days or some runs, `labbook today` of one day. A check is a function, and a line of
`CHECKS`; nothing that it finds is stored.
"""

from __future__ import annotations

import datetime
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from data_schema.queries.history import void_reasons
from data_schema.queries.runs import RunRow, list_runs, refuse_empty_selection, where_columns
from data_schema.queries.signals import SignalRow, SourceColumn
from data_schema.reasons import Reason
from data_schema.vocabulary import FileRole, RunKind, RunState, Undefined
from data_schema.where import compile_where
from ingest.channels.names import parse_header
from ingest.declared import flag_names
from labbook.actions.files.stored_files import Waiting
from labbook.actions.runs.attention_facts import Facts, gather_facts
from labbook.actions.runs.finding import Blank, Cost, Finding, Gravity, Word, correcting, found
from labbook.actions.runs.remarks import RULES, correcting_charge
from labbook.analysis.outcomes.detection import BODY_HEIGHT, Detections, jumps_found
from labbook.analysis.outcomes.run_apexes import Judgement
from labbook.analysis.outcomes.run_energy import below_drain, recharge_of
from labbook.config.local_time import local_text
from labbook.config.model import HOW_TO_DECIDE, Configuration
from labbook.statements.ingesting import zero_declared
from labbook.terminal import listed
from stats.apexes.jumps import HEIGHT_DOUBTFUL


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
        runs=tuple(run.name for run in facts.runs),
        void={run.name: why_void.get(run.uid, "") for run in void},
        findings=tuple(findings),
    )


OfRun = Callable[[RunRow, Facts], Finding | None]


def _rule(name: str, costs: Callable[[RunRow, Facts], Cost] = lambda _run, _facts: ("", False)) -> OfRun:
    """Return the check that is a rule on what was written of a run."""

    def look(run: RunRow, facts: Facts) -> Finding | None:
        odd = RULES[name].odd(run, facts.about)
        cost, is_claim = ("", False) if odd is None else costs(run, facts)
        return replace(odd, costs=cost, costs_claim=is_claim) if odd is not None and cost else odd

    return look


def _joules_lost(run: RunRow, facts: Facts) -> Cost:
    """Return what it costs that a run has no charge."""
    line = facts.drains.get(run.robot_uid)
    if run.kind is RunKind.IDLE and isinstance(line, Undefined):
        return f"no run of robot {run.robot} has joules: {line.reason}", True
    if run.kind is RunKind.IDLE:
        return "the line of passive drain has a point less", False
    claim = facts.charge_costs.get(run.uid, "")
    return claim or "its joules a jump are missing", bool(claim)


def _heights_lost(run: RunRow, facts: Facts) -> Cost:
    """Return what it costs that a run has no heights."""
    claim = facts.log_costs.get(run.uid, "")
    return claim or "its apex heights are missing", bool(claim)


def _charge_missing(run: RunRow, facts: Facts) -> Finding | None:
    why = recharge_of(run, facts.about.charges.get(run.uid, ()))
    if not isinstance(why, Undefined) or why.code not in (Reason.NO_CHARGE, Reason.PART_OF_CHARGE):
        return None
    waits = facts.evidence.waits(run.uid, FileRole.CHARGE) is not None
    if run.kind not in (RunKind.JUMPS, RunKind.IDLE) or waits:
        return None
    what = f"run {run.name}{' (idle)' if run.kind is RunKind.IDLE else ''} has {why.reason}"
    return found(what, "charge", run.name, Blank.MAH, run=run, costs=_joules_lost(run, facts))


def _charges_several(run: RunRow, facts: Facts) -> Finding | None:
    charges = facts.about.charges.get(run.uid, ())
    why = recharge_of(run, charges)
    if not isinstance(why, Undefined) or why.code is not Reason.SEVERAL_CHARGES:
        return None
    words = correcting(f"charge:{charges[-1].uid}", "run=none")
    return found(f"run {run.name} has {why.reason}", *words, run=run, costs=_joules_lost(run, facts))


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
    if facts.about.called(name, "") == name:
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


def _charge_below_drain(run: RunRow, facts: Facts) -> Finding | None:
    charges = facts.evidence.charges.get(run.uid, [])
    both = below_drain(run, charges, facts.drains[run.robot_uid]) if run.kind is RunKind.JUMPS else None
    if both is None or both[0] == 0.0:
        return None
    what = (
        f"run {run.name} has a charge of {both[0]:g} mAh, and the electronics alone draw {both[1]:.1f} mAh in its "
        f"{(run.duration_s or 0.0) / 60.0:.3g} min"
    )
    return found(what, *correcting_charge(run, charges), run=run, costs="its joules a jump are below 0, and count")


def _log_missing(run: RunRow, facts: Facts) -> Finding | None:
    waits = facts.evidence.waits(run.uid, FileRole.LOG) is not None
    if run.kind is not RunKind.JUMPS or facts.logs(run) or waits:
        return None
    words = "ingest", Blank.FILE, "--run", run.name
    return found(f"run {run.name} has no log", *words, run=run, costs=_heights_lost(run, facts))


def _log_without_height(run: RunRow, facts: Facts) -> Finding | None:
    why, logs = facts.no_heights.get(run.uid), facts.logs(run)
    if why is None or why.code is not Reason.NO_HEIGHT_LOG or run.kind is not RunKind.JUMPS or not logs:
        return None
    if facts.evidence.waits(run.uid, FileRole.LOG) is not None:
        return None
    name = logs[0].file_name
    what = f"{name}, the log of run {run.name}, has no {BODY_HEIGHT}: no jump can be found in it"
    words = *_rereading(facts, logs[0]), "--column", (Blank.COLUMN, f"={BODY_HEIGHT}:", Blank.UNIT)
    return found(what, *words, run=run, file=name, costs=_heights_lost(run, facts))


def _zero_doubtful(run: RunRow, facts: Facts) -> Finding | None:
    judgement = facts.judgements.get(run.uid)
    if judgement is None or not judgement.zero_doubtful:
        return None
    log = facts.evidence.logs[run.uid][0]
    zero_m, column = facts.zeros.get(log.file_sha256), facts.heights[log.uid]
    flag = _flag(column)
    declared: Word = flag, f"={BODY_HEIGHT}:{column.unit or 'm'},offset=", Blank.OFFSET
    if zero_m is not None and not column.calibrated and not isinstance(flag, Blank):
        declared = zero_declared(flag, column.unit, column.sign, column.scale, zero_m)
    about = "" if zero_m is None else f", by about {1e3 * zero_m:.0f} mm"
    what = (
        f"heights of run {run.name} are measured from too low a level{about}: its body stands higher than the leg is "
        "long"
    )
    words = *_rereading(facts, log), "--column", declared
    return found(what, *words, run=run, file=log.file_name, costs="its apex heights are too high, and count")


def _rereading(facts: Facts, log: SignalRow) -> tuple[Word, ...]:
    return "files", "reread", facts.about.log_called(log)


def _flag(column: SourceColumn) -> str:
    """Return how `--column` names a column, to be filled in where its name cannot stand on a command line."""
    (flag,) = flag_names([column.name])
    return flag if flag in (column.name, parse_header(column.name).base) else Blank.COLUMN


def _no_jump_found(run: RunRow, facts: Facts) -> Finding | None:
    judgement = facts.judgements.get(run.uid)
    if judgement is None or not run.jumps_made or _found_in(judgement):
        return None
    log = facts.evidence.logs[run.uid][0]
    what = (
        f"none of the {run.jumps_made} jumps of run {run.name} is found in {log.file_name}: unit, scale or zero of its "
        "height do not fit the leg of the robot, or the sensor was loose"
    )
    declared = _flag(facts.heights[log.uid]), f"={BODY_HEIGHT}:", Blank.UNIT
    words = *_rereading(facts, log), "--column", declared, "--override-units"
    return found(what, *words, run=run, file=log.file_name, costs=_heights_lost(run, facts))


def _found_in(judgement: Judgement) -> int:
    return jumps_found(one.jump for one in judgement.jumps)


def _jumps_differ(run: RunRow, facts: Facts) -> Finding | None:
    """Set jumps found beside jumps made; a stance that was not jumped from, a misfire, is a jump made."""
    judgement, made = facts.judgements.get(run.uid), run.jumps_made
    if judgement is None or not made:
        return None
    n_found, at_most = _found_in(judgement), len(judgement.jumps)
    if not n_found or n_found <= made <= at_most:
        return None
    how = f"{made - at_most} missing, misfires counted" if made > at_most else f"{n_found - made} too many"
    what = f"{n_found} jumps are found in run {run.name} and {made} were made ({how})"
    words = correcting(run.name, ("jumps=", Blank.JUMPS))
    return found(what, *words, run=run, costs="joules a jump are of the jumps made")


def _no_jump_counts(run: RunRow, facts: Facts) -> Finding | None:
    judgement = facts.judgements.get(run.uid)
    every = () if judgement is None or judgement.counted else judgement.jumps
    open_ones = [one for one in every if one.jump.apex_height_m is not None and one.decision is None]
    if not open_ones:
        return None
    why = ", ".join(dict.fromkeys(str(one.excluded) for one in open_ones))
    words = "jumps", "accept", run.name, *(str(one.jump.number) for one in open_ones)
    return found(f"no jump of run {run.name} counts: {why}", *words, run=run, costs=_heights_lost(run, facts))


def _jumps_doubtful(run: RunRow, facts: Facts) -> Finding | None:
    judgement = facts.judgements.get(run.uid)
    flags = {
        str(one.jump.number): raised
        for one in (() if judgement is None else judgement.jumps)
        if one.excluded is None and one.decision is None and (raised := HEIGHT_DOUBTFUL.intersection(one.jump.flags))
    }
    if not flags:
        return None
    why = ", ".join(sorted(set().union(*flags.values())))
    what = f"of run {run.name} nobody has looked at jump{'s' * (len(flags) > 1)} {listed(list(flags))} ({why})"
    return found(what, "jumps", "accept", run.name, *flags, run=run)


def _verdict_waits(run: RunRow, facts: Facts) -> Finding | None:
    judgement = facts.judgements.get(run.uid)
    counts = {
        "on samples that are not in force": sum(one.run == run.name for one in facts.verdicts_waiting),
        "that fit no jump found": 0 if judgement is None else len(judgement.waiting),
    }
    waiting = " and ".join(f"{count} {why}" for why, count in counts.items() if count)
    if not waiting:
        return None
    what = f"verdicts of run {run.name} wait ({waiting}): give them again, then take these back"
    return found(what, "jumps", "clear", run.name, "waiting", run=run)


def _outside_limits(run: RunRow, facts: Facts) -> Finding | None:
    if run.uid not in facts.outside:
        return None
    what = f"joules a jump of run {run.name} lie outside the control limits of {run.condition_key}"
    return found(what, *correcting_charge(run, facts.about.charges[run.uid]), run=run)


def _run_open(run: RunRow, _facts: Facts) -> Finding | None:
    if run.state is not RunState.OPEN:
        return None
    costs = "its joules a jump are missing" if run.kind is RunKind.JUMPS else ""
    what = f"run {run.name} is open: fill in its duration and jumps on the run sheet"
    return found(what, "runs", "import", Blank.FILE, run=run, costs=costs)


def _no_drain_line(facts: Facts) -> Iterator[Finding]:
    jumped = [run for run in facts.runs if run.kind is RunKind.JUMPS and run.uid in facts.about.charges]
    for robot, uid in dict.fromkeys((run.robot, run.robot_uid) for run in jumped):
        line = facts.drains[uid]
        if isinstance(line, Undefined):
            idle = [run for run in facts.evidence.idle if run.robot == robot and run.uid not in facts.evidence.charges]
            words: tuple[Word, ...] = ("charge", idle[0].name, Blank.MAH) if idle else ("runs", "import", Blank.FILE)
            names = listed([run.name for run in jumped if run.robot == robot], 4)
            costs = f"no run of robot {robot} has joules a jump ({names})"
            yield found(f"robot {robot} has no line of passive drain: {line.reason}", *words, costs=(costs, True))


def _file_waits(facts: Facts) -> Iterator[Finding]:
    by_uid = {run.uid: run for run in facts.evidence.selected}
    for file in facts.evidence.waiting:
        runs = [by_uid[uid] for uid in file.runs if uid in by_uid]
        of = f" of {listed([run.name for run in runs], 4)}" if runs else ""
        reread: tuple[Word, ...] = "files", "reread", facts.about.called(file.name, file.file_uid)
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
    for file in facts.refused:
        run = facts.by_name.get(file.stated_run or "")
        if run is None:
            is_open = file.at_utc >= oldest
        else:
            is_open = run.state is not RunState.VOID and facts.last_imports.get(run.uid, "") < file.at_utc
        if is_open:
            day = local_text(file.at_utc, facts.evidence.study.time_zone)[:10]
            what = f"{file.name} was refused on {day}: {file.why}"
            yield found(what, "ingest", Blank.FILE, run=run, day=day, file=file.name, costs="what it holds is missing")


def _file_outdated(facts: Facts) -> Iterator[Finding]:
    for name in facts.evidence.outdated:
        what = f"{name} was read with a profile that labbook.toml has otherwise now, and counts as it was read"
        yield found(what, "files", "reread", "--all", file=name)


def _check_not_made(facts: Facts) -> Iterator[Finding]:
    for date in facts.days:
        for kind in facts.evidence.configuration.protocol.checks:
            if kind not in facts.checks_made.get(date, ()):
                yield found(f"the check {kind} was not made", "check", kind, "--day", date, day=date)


def _planned(facts: Facts) -> Iterator[Finding]:
    for name in facts.planned_not_made:
        yield replace(found(f"run {name} is planned and not made", "runs", "import", Blank.FILE), run=name)


def _analysis_undecided(facts: Facts) -> Iterator[Finding]:
    if facts.undecided:
        yield found(f"nothing is decided about the analysis: {HOW_TO_DECIDE}", "config")


@dataclass(frozen=True, slots=True)
class Check:
    """A check: how grave what it finds is, where that costs no claim, and how it looks at a run, or at all facts.

    `of_book`: it looks at the whole book, whichever runs and days are asked about.
    """

    gravity: Gravity
    of_run: OfRun | None = None
    of_all: Callable[[Facts], Iterable[Finding]] | None = None
    of_book: bool = False

    def findings(self, facts: Facts) -> Iterator[Finding]:
        """Yield what it finds."""
        if self.of_run is not None:
            yield from (one for run in facts.runs if (one := self.of_run(run, facts)) is not None)
        if self.of_all is not None:
            yield from self.of_all(facts)


CHECKS: Mapping[str, Check] = {
    "charge_below_drain": Check(Gravity.WRONG, _charge_below_drain),
    "charge_above_pack": Check(Gravity.WRONG, _rule("charge_above_pack")),
    "charge_zero": Check(Gravity.WRONG, _rule("charge_zero")),
    "samples_twice": Check(Gravity.WRONG, _rule("samples_twice")),
    "level_differs": Check(Gravity.WRONG, _rule("level_differs")),
    "zero_doubtful": Check(Gravity.WRONG, _zero_doubtful),
    "no_drain_line": Check(Gravity.CLAIM, of_all=_no_drain_line),
    "charge_missing": Check(Gravity.MISSING, _charge_missing),
    "charges_several": Check(Gravity.MISSING, _charges_several),
    "log_missing": Check(Gravity.MISSING, _log_missing),
    "logs_too_many": Check(Gravity.MISSING, _rule("logs_too_many", _heights_lost)),
    "log_without_height": Check(Gravity.MISSING, _log_without_height),
    "no_jump_found": Check(Gravity.MISSING, _no_jump_found),
    "no_jump_counts": Check(Gravity.MISSING, _no_jump_counts),
    "calibration_of_other_day": Check(Gravity.MISSING, _rule("calibration_of_other_day", _heights_lost)),
    "file_waits": Check(Gravity.MISSING, of_all=_file_waits, of_book=True),
    "run_open": Check(Gravity.MISSING, _run_open),
    "log_day_differs": Check(Gravity.DOUBTFUL, _rule("log_day_differs")),
    "charge_date": Check(Gravity.DOUBTFUL, _rule("charge_date")),
    "date_in_future": Check(Gravity.DOUBTFUL, _rule("date_in_future")),
    "date_long_ago": Check(Gravity.DOUBTFUL, _rule("date_long_ago")),
    "outside_limits": Check(Gravity.DOUBTFUL, _outside_limits),
    "charge_waits": Check(Gravity.DOUBTFUL, of_all=_charge_waits, of_book=True),
    "pack_differs": Check(Gravity.DOUBTFUL, _rule("pack_differs")),
    "jumps_differ": Check(Gravity.DOUBTFUL, _jumps_differ),
    "jumps_unusual": Check(Gravity.DOUBTFUL, _rule("jumps_unusual")),
    "duration_unusual": Check(Gravity.DOUBTFUL, _rule("duration_unusual")),
    "verdict_waits": Check(Gravity.DOUBTFUL, _verdict_waits),
    "jumps_doubtful": Check(Gravity.DOUBTFUL, _jumps_doubtful),
    "file_outdated": Check(Gravity.DOUBTFUL, of_all=_file_outdated, of_book=True),
    "file_refused": Check(Gravity.TO_DO, of_all=_file_refused, of_book=True),
    "inbox": Check(Gravity.TO_DO, of_all=_inbox, of_book=True),
    "check_not_made": Check(Gravity.TO_DO, of_all=_check_not_made),
    "planned_not_made": Check(Gravity.TO_DO, of_all=_planned, of_book=True),
    "analysis_undecided": Check(Gravity.TO_DO, of_all=_analysis_undecided, of_book=True),
}
"""The checks by the code of what they find; of one gravity in this order."""
