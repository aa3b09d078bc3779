"""What a report says of its methods and of their limits, written from what was done."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import Rule, Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.outcomes.control_limits import exchanged, runs_outside
from labbook.analysis.outcomes.run_energy import (
    above_capacity,
    below_drain,
    joules_per_mah,
    unused_idle,
    usable_charge,
)
from labbook.analysis.outcomes.run_force import RunForce, push_off_rules
from labbook.analysis.preregistration.planned import FAMILY_OF
from labbook.analysis.study import StudyAnalysis
from labbook.analysis.study_data import StudyData, outdated_sentence
from reports.content import Assumed, Source
from reports.display import MINUS, list_text
from reports.naming import swept_words
from stats.apexes.detectors import DETECTORS
from stats.single_jump import QUIET_S

_LISTED = 8
"""Runs that a sentence names before it goes on with an ellipsis."""
FEW = 1
"""Runs that a sentence names where the table of each run has them all."""


def methods(analysis: StudyAnalysis) -> tuple[str, ...]:
    """Return the methods paragraphs."""
    evidence = analysis.evidence
    protocol = evidence.configuration.protocol
    swept = None if analysis.swept is None else pairing.study_factor(evidence.configuration, analysis.swept)
    control, treatment = swept_words(swept).control, (swept.treatment if swept else "") or "treatment"
    ratio = f"({control} {MINUS} {treatment}) / {control}"
    return (
        f"Joules a jump are 3.6 C/mAh times {evidence.study.reference_voltage_v:g} V times (charge minus passive "
        "charge) divided by the jumps made. The passive charge is read at each run's duration, power on to power off, "
        "from the straight line fitted to its robot's idle runs; the line's error, common to the robot's runs, counts "
        "in intervals and p.",
        f"Apexes come from the {protocol.detector} detector, version {DETECTORS[protocol.detector].version}, applied "
        f"to the body height; {_rules(analysis)} A person's verdict comes first.",
        *_calibrations(analysis),
        *_single_jumps(analysis),
        f"A value is one run, never a jump. {_tests(analysis, ratio)}",
    )


def _calibrations(analysis: StudyAnalysis) -> list[str]:
    """Name the calibrations of the analysed runs' sensors, each with its source, its person and its runs."""
    evidence = analysis.evidence
    runs: dict[str, list[RunRow]] = {}
    for run in evidence.runs:
        signals = (*evidence.logs.get(run.uid, []), *evidence.forces.get(run.uid, []))
        channels = [channel for signal in signals for channel in evidence.calibrated.get(signal.uid, ())]
        for line in dict.fromkeys(f"{each.sentence()}, declared by {each.person}" for each in channels):
            runs.setdefault(line, []).append(run)
    if not runs:
        return []
    lines = [f"{line}{'' if len(runs) == 1 else f' ({_names(of)})'}" for line, of in runs.items()]
    return [
        f"Sensors were calibrated: {'; '.join(lines)}. Its error is common to its runs and counts in intervals and p."
    ]


_BY_RULE = {
    Rule.PAIRED: "paired t on day means from four such days on",
    Rule.WITHIN: "a contrast within days on one to three, which holds for these days",
}


def _tests(analysis: StudyAnalysis, ratio: str) -> str:
    """Return the test that decides, and what stands beside it; or why nothing was compared."""
    if not analysis.compared:
        none = "no factor names a control level" if analysis.swept is None else "no group has a control and a treatment"
        return f"Nothing is compared: {none}."
    rules = {item.shown.decision.rule for item in analysis.compared}
    used = [text for rule, text in _BY_RULE.items() if rule in rules]
    several = any(item.pair.family == pairing.POOLED and len(item.pair.b) > 1 for item in analysis.compared)
    weighted = ", pooled levels weighted by their runs" if several else ""
    sentences = [
        f"Treatment and control are compared on the days that hold runs of both{weighted}: "
        f"{list_text(used) or 'there are none'}.",
        f"Savings are {ratio} with Fieller's interval by the same contrast." if _has_savings(analysis) else "",
        _holm(analysis),
        "Equivalence of apex heights is tested by two one-sided tests by that contrast (TOST), unadjusted."
        if _equivalence(analysis)
        else "",
        "The overall effect is the mean of the groups' savings (delta method), days' errors added before squaring. "
        "An F by the same errors (Box) tests whether groups agree."
        if analysis.overall.savings
        else "",
    ]
    return " ".join(filter(None, sentences))


def _has_savings(analysis: StudyAnalysis) -> bool:
    return any(item.shown.decision.savings is not None for item in analysis.compared)


def _holm(analysis: StudyAnalysis) -> str:
    """Say which family p is adjusted over, and how many tests of it the report does not show."""
    counts = []
    for quantity in Outcome:
        of_quantity = [item for item in analysis.compared if item.shown.quantity is quantity]
        family = next((item.family for item in of_quantity if item.family is not None), None)
        if family is not None:
            left_out = len(family.adjusted_p.keys() - {item.pair.label for item in of_quantity})
            not_shown = f" ({left_out} not in this selection)" if left_out else ""
            counts.append(f"{len(family.adjusted_p)} of {quantity}{not_shown}")
    if not counts:
        return ""
    named = FAMILY_OF[analysis.planned.settings.family]
    return f"P is adjusted by Holm's method over the family, {named}: {list_text(counts)}."


def _equivalence(analysis: StudyAnalysis) -> bool:
    tests = (item.shown.decision.equivalence for item in analysis.compared)
    return any(test is not None and test.p.known is not None for test in tests)


def sources(analysis: StudyAnalysis) -> tuple[Source, ...]:
    """Return the sources of the methods that the report uses."""
    routes = [item.shown.over_runs for item in analysis.compared]
    routed = [route for route in routes if isinstance(route.t.value, float)]
    used = {
        Source.THESIS: bool(routed),
        Source.FIELLER: _has_savings(analysis),
        Source.HOLM: bool(_holm(analysis)),
        Source.PAIRED_ON_DAY_MEANS: any(item.shown.decision.rule is Rule.PAIRED for item in analysis.compared),
        Source.TOST: _equivalence(analysis),
        Source.WELCH: any(route.test == "Welch" for route in routed),
    }
    return tuple(source for source, is_used in used.items() if is_used)


def _single_jumps(analysis: StudyAnalysis) -> list[str]:
    """Say how single jumps on a plate were measured, where a run has one."""
    found = analysis.results.get(Outcome.IMPULSE_HEIGHT)
    if found is None or not any(isinstance(one, RunForce) and one.single_jumps for one in found.results.values()):
        return []
    return [
        "Single jumps out of quiet standing on a plate are measured from "
        f"{push_off_rules(analysis.evidence)}: weight from the {QUIET_S:g} s before, height from the impulse since, "
        "and from the time of flight. Contact time is that from onset to take-off."
    ]


def limitations(analysis: StudyAnalysis) -> tuple[str, ...]:
    """Return what a reader should know before believing the numbers."""
    notes = [
        f"There is no passive-drain fit for robot {drain.robot} ({drain.line.reason}), so there are no joules a jump."
        for drain in analysis.drains.values()
        if isinstance(drain.line, Undefined)
    ]
    if analysis.evidence.outdated:
        notes.insert(0, f"{outdated_sentence(analysis.evidence.outdated)}.")
    idle = {run.uid: reason for run, reason in unused_idle(analysis.evidence)}
    for cause, names in _by_cause(idle, analysis.evidence.idle).items():
        notes.append(
            f"{_count(len(names), 'idle run is', 'idle runs are')} not in the drain fit: {cause} ({_names(names)})."
        )
    notes += _doubtful_zeros(analysis)
    for outcome, found in analysis.results.items():
        for cause, names in _by_cause(found.missing, analysis.evidence.runs).items():
            have = "has" if len(names) == 1 else "have"
            notes.append(f"{_count(len(names), 'run', 'runs')} ({_names(names)}) {have} no {outcome.plural}: {cause}.")
    notes += [*_same_logs(analysis.evidence), *_impossible_charges(analysis), *_lost_fits(analysis)]
    found_in = {uid: apexes.jumps_found.n for uid, apexes in analysis.apexes.items()}
    odd = [run for run in analysis.evidence.runs if found_in.get(run.uid, run.jumps_made) != run.jumps_made]
    if differing := [f"{run.name}: {found_in[run.uid]} of {run.jumps_made}" for run in odd]:
        none = not all(run.jumps_made for run in odd)
        unknown = ", and unknown where none was made (`labbook correct RUN jumps=N --why ...`)" if none else ""
        notes.append(
            f"In {_count(len(differing), 'run', 'runs')} the jumps found are not the jumps made "
            f"({_listed(differing, FEW)}); joules are divided by the jumps made{unknown}."
        )
    waiting = sum(len(judgement.waiting) for judgement in analysis.judgements.values())
    if waiting:
        notes.append(
            f"{_count(waiting, 'verdict on a jump fits no jump', 'verdicts on jumps fit no jump')} any more and "
            f"{'waits' if waiting == 1 else 'wait'} for review (`labbook jumps list RUN`)."
        )
    judged = [item for judgement in analysis.judgements.values() for item in judgement.jumps]
    if placed := [item for item in judged if item.placed is not None and item.excluded is None]:
        added = sum("added" in item.jump.flags for item in placed)
        notes.append(
            f"{_count(len(placed), 'jump counts', 'jumps count')} with an apex where a person put it, {added} of them "
            "where the detector has no jump (`labbook jumps list RUN`)."
        )
    notes.append(
        "Charge efficiency and the pack's voltage under load are not measured, so joules are on the scale of the "
        "reference voltage."
    )
    return tuple(notes)


def assumed(analysis: StudyAnalysis) -> tuple[Assumed, ...]:
    """Return the parameters that no source states."""
    return (
        Assumed(
            "reference voltage",
            f"{analysis.evidence.study.reference_voltage_v:g} V, without uncertainty",
            "the protocol's storage voltage stands for the mean voltage of a discharge; it scales all joules alike and "
            "cancels in savings",
        ),
    )


def _doubtful_zeros(analysis: StudyAnalysis) -> list[str]:
    """Name the runs whose heights may be measured from too low a level."""
    runs = [run for run in analysis.evidence.runs if run.uid in analysis.judgements]
    runs = [run for run in runs if analysis.judgements[run.uid].zero_doubtful]
    if not runs:
        return []
    file = shlex.quote(analysis.evidence.logs[runs[0].uid][0].file_name)
    return [
        f"In {_count(len(runs), 'run', 'runs')} ({_names(runs)}) the body stands higher than its leg is long, so apex "
        f"heights may be too high by a wrong zero: `labbook files show {file}` says by how much and what corrects it."
    ]


def _same_logs(evidence: StudyData) -> list[str]:
    """Name the runs that have a log of the same samples, which is analysed for each of them."""
    by_samples: dict[str, dict[str, RunRow]] = {}
    for run in evidence.runs:
        for log in evidence.logs.get(run.uid, []):
            by_samples.setdefault(log.sha256, {})[run.uid] = run
    several = dict.fromkeys(_names(runs.values()) for runs in by_samples.values() if len(runs) > 1)
    return [
        f"Runs {names} have a log of the same samples, and its apexes count for each: take the copies out of use with "
        "`labbook files withdraw FILE --why ...`."
        for names in several
    ]


def _impossible_charges(analysis: StudyAnalysis) -> list[str]:
    """Name the runs whose charge is below their passive charge, then those with more than their pack holds."""
    evidence, drains = analysis.evidence, analysis.drains
    charges = {run.uid: evidence.charges.get(run.uid, []) for run in (*evidence.runs, *evidence.idle)}
    low = [
        run
        for run in evidence.runs
        if run.robot_uid in drains and below_drain(run, charges[run.uid], drains[run.robot_uid].line)
    ]
    high = [
        run for run in (*evidence.runs, *evidence.idle) if above_capacity(run, charges[run.uid], evidence.configuration)
    ]
    found = (
        (low, "below the passive charge: negative joules a jump."),
        (high, "more than the pack holds: check its unit."),
    )
    return [
        f"The charge of {_count(len(runs), 'run', 'runs')} ({_names(runs)}) is {what}" for runs, what in found if runs
    ]


def outside_limits(analysis: StudyAnalysis) -> tuple[str, ...]:
    """Name the runs whose joules are out of the control limits of their condition."""
    return tuple(run.name for run in runs_outside(analysis.evidence.runs, _joules(analysis)))


def exchanged_charges(analysis: StudyAnalysis) -> tuple[tuple[str, str], ...]:
    """Name pairs of runs out of their control limits that are inside with each other's charge."""
    evidence = analysis.evidence

    def with_charge_of(run: RunRow, other: RunRow) -> float:
        charge, line = usable_charge(other, evidence.charges[other.uid]), analysis.drains[run.robot_uid].line
        assert not isinstance(charge, Undefined)  # noqa: S101 - runs out of limits have joules
        assert not isinstance(line, Undefined)  # noqa: S101
        passive_mah = line.at(run.duration_s or 0.0).charge_mah
        return joules_per_mah(evidence.study.reference_voltage_v, run.jumps_made) * (charge.charge_mah - passive_mah)

    return tuple((one.name, other.name) for one, other in exchanged(evidence.runs, _joules(analysis), with_charge_of))


def _joules(analysis: StudyAnalysis) -> dict[str, float]:
    return {item.run.uid: item.value for each in analysis.conditions[Outcome.JOULES] for item in each.runs}


def _lost_fits(analysis: StudyAnalysis) -> list[str]:
    """Say which days' idle runs a drain line cannot do without."""
    lost = analysis.variations.fits_lost
    days_by_robots = grouped(lost, lambda day: lost[day])
    several = len(analysis.drains) > 1
    return [
        f"Without the idle runs of {' or of '.join(days)} there is no passive-drain fit"
        + (
            f" for {' and '.join(robots)}: savings without that day rest on the other robots' runs."
            if several and len(robots) < len(analysis.drains)
            else ", so the savings are not recomputed without that day."
        )
        for robots, days in days_by_robots.items()
    ]


def _by_cause(causes: Mapping[str, Undefined], runs: Iterable[RunRow]) -> dict[str, list[RunRow]]:
    return grouped((run for run in runs if run.uid in causes), lambda run: causes[run.uid].reason)


def _count(count: int, one: str, several: str) -> str:
    return f"{count} {one if count == 1 else several}"


def _names(runs: Iterable[RunRow]) -> str:
    return _listed([run.name for run in runs])


def _listed(items: list[str], most: int = _LISTED) -> str:
    return f"{', '.join(items[:most])}{', ...' if len(items) > most else ''}"


def _rules(analysis: StudyAnalysis) -> str:
    protocol = analysis.evidence.configuration.protocol
    rules = []
    if protocol.exclude_first_jumps:
        rules.append(f"the first {protocol.exclude_first_jumps} jumps of a run are left out")
    rules.append(
        "jumps with a dropped packet in flight are left out"
        if protocol.exclude_gap_jumps
        else "jumps with a dropped packet in flight are kept"
    )
    return "; ".join(rules) + "."
