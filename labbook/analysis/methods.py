"""What a report says of its methods and of their limits, written from what was done."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import Rule, Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparisons import Compared
from labbook.analysis.measured import Measured
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.outcomes.run_energy import above_capacity, below_drain, unused_idle
from labbook.analysis.outcomes.run_force import RunForce, push_off_rules
from labbook.analysis.study_data import StudyData, outdated_sentence
from labbook.config.model import AnalysisSettings
from reports.display import MINUS, list_text
from reports.naming import levels_name, swept_words
from reports.results import Assumed, Source, StudyResults
from stats.apexes.detectors import DETECTORS
from stats.single_jump import QUIET_S

_LISTED = 8
"""Runs that a sentence names before it goes on with an ellipsis."""
FEW = 1
"""Runs that a sentence names where the table of each run has them all."""


def methods(measured: Measured, study: StudyResults) -> tuple[str, ...]:
    """Return the methods paragraphs."""
    evidence = measured.evidence
    protocol, swept_name = evidence.configuration.protocol, pairing.swept_factor(evidence.configuration)
    swept = None if swept_name is None else pairing.study_factor(evidence.configuration, swept_name)
    control, treatment = swept_words(swept).control, (swept.treatment if swept else "") or "treatment"
    ratio = f"({control} {MINUS} {treatment}) / {control}"
    return (
        f"Joules a jump are 3.6 C/mAh times {evidence.study.reference_voltage_v:g} V times (charge minus passive "
        "charge) divided by the jumps made. The passive charge is read at each run's duration, power on to power off, "
        "from the straight line fitted to its robot's idle runs; the line's error, common to the robot's runs, counts "
        "in intervals and p.",
        f"Apexes come from the {protocol.detector} detector, version {DETECTORS[protocol.detector].version}, applied "
        f"to the body height; {_rules(evidence)} A person's verdict comes first.",
        *_calibrations(evidence),
        *_single_jumps(measured),
        f"A value is one run, never a jump. {_tests(study, swept is not None, ratio)}",
    )


def _calibrations(evidence: StudyData) -> list[str]:
    """Name the calibrations of the analysed runs' sensors, each with its source, its person and its runs."""
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


def _tests(study: StudyResults, is_swept: bool, ratio: str) -> str:
    """Return the test that decides, and what stands beside it; or why nothing was compared."""
    if not study.comparisons:
        none = "no group has a control and a treatment" if is_swept else "no factor names a control level"
        return f"Nothing is compared: {none}."
    rules = {one.decision.rule for one in study.comparisons}
    used = [text for rule, text in _BY_RULE.items() if rule in rules]
    weighted = "" if study.one_level else ", pooled levels weighted by their runs"
    sentences = [
        f"Treatment and control are compared on the days that hold runs of both{weighted}: "
        f"{list_text(used) or f'no test decides ({_why_no_test(study)})'}.",
        f"Savings are {ratio} with Fieller's interval by the same contrast." if _has_savings(study) else "",
        _holm(study),
        "Equivalence of apex heights is tested by two one-sided tests by that contrast (TOST), unadjusted."
        if _equivalence(study)
        else "",
        "The overall effect is the mean of the groups' savings (delta method), days' errors added before squaring. "
        "An F by the same errors (Box) tests whether groups agree."
        if study.overall
        else "",
    ]
    return " ".join(filter(None, sentences))


def _why_no_test(study: StudyResults) -> str:
    """Return the reasons for which the days of the comparisons allow no test, each once."""
    tests = (one.decision.t.value for one in study.comparisons)
    return "; ".join(dict.fromkeys(t.reason for t in tests if isinstance(t, Undefined)))


def _has_savings(study: StudyResults) -> bool:
    return any(one.decision.savings is not None for one in study.comparisons)


def _holm(study: StudyResults) -> str:
    """Say which family p is adjusted over, and how many tests of it the report does not show."""
    counts, named = [], ""
    for quantity in Outcome:
        adjusted = [(one.family, one.decision.adjusted) for one in study.comparisons if one.quantity is quantity]
        tests = [(family, p.n or 0) for family, p in adjusted if p is not None]
        if tests:
            named, n = tests[0]
            left_out = n - sum(family == named for family, _n in tests)
            not_shown = f" ({left_out} not in this selection)" if left_out else ""
            counts.append(f"{n} of {quantity}{not_shown}")
    return f"P is adjusted by Holm's method over the family, {named}: {list_text(counts)}." if counts else ""


def _equivalence(study: StudyResults) -> bool:
    tests = (one.decision.equivalence for one in study.comparisons)
    return any(test is not None and test.p.known is not None for test in tests)


def sources(study: StudyResults) -> tuple[Source, ...]:
    """Return the sources of the methods that the report uses."""
    routed = [one.over_runs for one in study.comparisons if isinstance(one.over_runs.t.value, float)]
    used = {
        Source.THESIS: bool(routed),
        Source.FIELLER: _has_savings(study),
        Source.HOLM: bool(_holm(study)),
        Source.PAIRED_ON_DAY_MEANS: any(one.decision.rule is Rule.PAIRED for one in study.comparisons),
        Source.TOST: _equivalence(study),
        Source.WELCH: any(route.test == "Welch" for route in routed),
    }
    return tuple(source for source, is_used in used.items() if is_used)


def no_equivalence(study: StudyResults, settings: AnalysisSettings) -> str:
    """Say why apex heights are not tested for equality, and how that is asked for; "" where they are."""
    if settings.apex_bounds is not None or not any(one.quantity.has_equivalence for one in study.comparisons):
        return ""
    return (
        "That a difference of apex height is not told from zero does not show that heights are equal. No test of "
        "equivalence is made, because labbook.toml states no bounds within which a difference counts as none: write, "
        "before the first run, `apex_bounds_percent = [-3, 3]` (of the control's mean) or `apex_bounds_m = [-0.005, "
        "0.005]` under [analysis]."
    )


def _single_jumps(measured: Measured) -> list[str]:
    """Say how single jumps on a plate were measured, where a run has one."""
    found = measured.results.get(Outcome.IMPULSE_HEIGHT)
    if found is None or not any(isinstance(one, RunForce) and one.single_jumps for one in found.results.values()):
        return []
    return [
        "Single jumps out of quiet standing on a plate are measured from "
        f"{push_off_rules(measured.evidence)}: weight from the {QUIET_S:g} s before, height from the impulse since, "
        "and from the time of flight. Contact time is that from onset to take-off."
    ]


def limitations(measured: Measured, fits_lost: Mapping[str, Sequence[str]] = {}) -> tuple[str, ...]:
    """Return what a reader should know before believing the numbers.

    `fits_lost` has, by a day, the robots without a drain line where its idle runs are left out.
    """
    evidence = measured.evidence
    notes = [
        f"There is no passive-drain fit for robot {drain.robot} ({drain.line.reason}), so there are no joules a jump."
        for drain in measured.drains.values()
        if isinstance(drain.line, Undefined)
    ]
    if evidence.outdated:
        notes.insert(0, f"{outdated_sentence(evidence.outdated)}.")
    idle = {run.uid: reason for run, reason in unused_idle(evidence)}
    for cause, names in _by_cause(idle, evidence.idle).items():
        notes.append(
            f"{_count(len(names), 'idle run is', 'idle runs are')} not in the drain fit: {cause} ({_names(names)})."
        )
    notes += _doubtful_zeros(measured)
    for outcome, found in measured.results.items():
        for cause, names in _by_cause(found.missing, evidence.runs).items():
            have = "has" if len(names) == 1 else "have"
            notes.append(f"{_count(len(names), 'run', 'runs')} ({_names(names)}) {have} no {outcome.plural}: {cause}.")
    notes += [*_same_logs(evidence), *_impossible_charges(measured), *_lost_fits(fits_lost, len(measured.drains))]
    found_in = {uid: apexes.jumps_found.n for uid, apexes in measured.apexes.items()}
    odd = [run for run in evidence.runs if found_in.get(run.uid, run.jumps_made) != run.jumps_made]
    if differing := [f"{run.name}: {found_in[run.uid]} of {run.jumps_made}" for run in odd]:
        none = not all(run.jumps_made for run in odd)
        unknown = ", and unknown where none was made (`labbook correct RUN jumps=N --why ...`)" if none else ""
        notes.append(
            f"In {_count(len(differing), 'run', 'runs')} the jumps found are not the jumps made "
            f"({_listed(differing, FEW)}); joules are divided by the jumps made{unknown}."
        )
    waiting = sum(len(judgement.waiting) for judgement in measured.judgements.values())
    if waiting:
        notes.append(
            f"{_count(waiting, 'verdict on a jump fits no jump', 'verdicts on jumps fit no jump')} any more and "
            f"{'waits' if waiting == 1 else 'wait'} for review (`labbook jumps list RUN`)."
        )
    judged = [item for judgement in measured.judgements.values() for item in judgement.jumps]
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


def assumed(evidence: StudyData) -> tuple[Assumed, ...]:
    """Return the parameters that no source states."""
    return (
        Assumed(
            "reference voltage",
            f"{evidence.study.reference_voltage_v:g} V, without uncertainty",
            "the protocol's storage voltage stands for the mean voltage of a discharge; it scales all joules alike and "
            "cancels in savings",
        ),
    )


def _doubtful_zeros(measured: Measured) -> list[str]:
    """Name the runs whose heights may be measured from too low a level."""
    runs = [run for run in measured.evidence.runs if run.uid in measured.judgements]
    runs = [run for run in runs if measured.judgements[run.uid].zero_doubtful]
    if not runs:
        return []
    file = shlex.quote(measured.evidence.logs[runs[0].uid][0].file_name)
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


def _impossible_charges(measured: Measured) -> list[str]:
    """Name the runs whose charge is below their passive charge, then those with more than their pack holds."""
    evidence, drains = measured.evidence, measured.drains
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


def _lost_fits(lost: Mapping[str, Sequence[str]], n_robots: int) -> list[str]:
    """Say which days' idle runs a drain line cannot do without."""
    days_by_robots = grouped(lost, [tuple(robots) for robots in lost.values()])
    return [
        f"Without the idle runs of {' or of '.join(days)} there is no passive-drain fit"
        + (
            f" for {' and '.join(robots)}: savings without that day rest on the other robots' runs."
            if len(robots) < n_robots
            else ", so the savings are not recomputed without that day."
        )
        for robots, days in days_by_robots.items()
    ]


def robot_limitations(compared: Iterable[Compared], study: StudyResults) -> tuple[str, ...]:
    """Say in which groups the control and the treated runs are not of the same robots; `study` names groups."""
    found = []
    for pair in (item.pair for item in compared if item.shown.opens):
        control, treated = _robots(pair.a), _robots(pair.b)
        if control.keys() != treated.keys():
            name = levels_name(study, pair.group)
            found.append(
                f"{f'With {name}' if name else 'In this selection'} the control runs are of {_counted(control)} and "
                f"the treated runs of {_counted(treated)}: the differences may be the robots'."
            )
    return tuple(dict.fromkeys(found))


def _robots(side: Iterable[ConditionValues]) -> Mapping[str, int]:
    return Counter(item.run.robot for condition in side for item in condition.runs)


def _counted(robots: Mapping[str, int]) -> str:
    return list_text([f"{robot} ({runs})" for robot, runs in robots.items()])


def _by_cause(causes: Mapping[str, Undefined], runs: Iterable[RunRow]) -> dict[str, list[RunRow]]:
    caused = [run for run in runs if run.uid in causes]
    return grouped(caused, [causes[run.uid].reason for run in caused])


def _count(count: int, one: str, several: str) -> str:
    return f"{count} {one if count == 1 else several}"


def _names(runs: Iterable[RunRow]) -> str:
    return _listed([run.name for run in runs])


def _listed(items: list[str], most: int = _LISTED) -> str:
    return f"{', '.join(items[:most])}{', ...' if len(items) > most else ''}"


def _rules(evidence: StudyData) -> str:
    protocol = evidence.configuration.protocol
    rules = []
    if protocol.exclude_first_jumps:
        rules.append(f"the first {protocol.exclude_first_jumps} jumps of a run are left out")
    rules.append(
        "jumps with a dropped packet in flight are left out"
        if protocol.exclude_gap_jumps
        else "jumps with a dropped packet in flight are kept"
    )
    return "; ".join(rules) + "."
