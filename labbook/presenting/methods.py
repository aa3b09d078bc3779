"""What a report says of its methods and their limits, written from what was done."""

from __future__ import annotations

import json
from collections import Counter

from data_schema.vocabulary import Undefined
from labbook.analysis.passive_drain import fitted
from labbook.analysis.study import StudyAnalysis
from labbook.analysis.workbench import number
from reports.content import Assumed
from stats.apexes import DETECTORS


def methods(analysis: StudyAnalysis) -> tuple[str, ...]:
    """Return the methods paragraphs."""
    evidence = analysis.evidence
    protocol = evidence.configuration.protocol
    paragraphs = [
        f"Joules a jump are 3.6 C/mAh times {evidence.study.reference_voltage_v:g} V times (charge minus passive "
        "charge) divided by the jumps made. The passive charge is read at each run's own duration, power on to power "
        "off, from one straight line fitted to all idle runs; its error is common to all runs, is stated apart, "
        "cancels in differences at equal duration and enters savings through the control.",
        f"Apexes come from the {protocol.detector} detector, version {DETECTORS[protocol.detector].version}, applied "
        f"to the body height; {_rules(analysis)} A person's verdict on a jump comes before these rules.",
        "Runs are the unit of analysis: a run's joules, and the mean of a run's apex heights. Each comparison is an "
        "F-test for equal variances, then Student's t-test or Welch's (thesis 5.2.1); Welch's test stands beside it in "
        "any case. Savings are the ratio of means (CE - AD) / CE with Fieller's interval. Intervals are at 95 %.",
    ]
    return tuple(paragraphs)


def limitations(analysis: StudyAnalysis) -> tuple[str, ...]:
    """Return what a reader should know before believing the numbers."""
    notes = []
    drain = fitted(analysis.evidence)
    if isinstance(drain, Undefined):
        notes.append(f"There is no passive-drain fit ({drain.reason}), so there are no joules a jump.")
    for cause, runs in Counter(analysis.energies.missing.values()).items():
        notes.append(f"{runs} run{'s have' if runs > 1 else ' has'} no joules: {cause}.")
    for cause, runs in Counter(analysis.apexes.missing.values()).items():
        notes.append(f"{runs} run{'s have' if runs > 1 else ' has'} no apex heights: {cause}.")
    mismatched = jumps_mismatched(analysis)
    if mismatched:
        notes.append(
            f"In {len(mismatched)} runs the jumps found are not the jumps made ({', '.join(mismatched[:8])}"
            f"{', ...' if len(mismatched) > 8 else ''}); joules are divided by the jumps made."
        )
    waiting = sum(len(judgement.waiting) for judgement in analysis.apexes.judgements.values())
    if waiting:
        notes.append(
            f"{waiting} verdicts on jumps fit no jump any more and wait for review (`labbook jumps list RUN`)."
        )
    notes.append(
        "The charger states what it put in; charge efficiency and the pack's voltage under load are not measured, so "
        "joules are on the scale of the reference voltage."
    )
    return tuple(notes)


def jumps_mismatched(analysis: StudyAnalysis) -> list[str]:
    """Return the runs, with counts, in which the jumps found are not the jumps made."""
    found = []
    for run in analysis.evidence.runs:
        row = analysis.apexes.results.get(run.uid)
        if row is not None:
            count = number(row, "jumps_found").n or 0
            if count != run.jumps_made:
                found.append(f"{run.name}: {count} of {run.jumps_made}")
    return found


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


def drain_sentence(analysis: StudyAnalysis) -> str:
    """Return what the drain line gives at the run duration, and whether that is an extrapolation."""
    return str(json.loads(analysis.drain.payload_json).get("sentence", ""))


def _rules(analysis: StudyAnalysis) -> str:
    protocol = analysis.evidence.configuration.protocol
    rules = []
    if protocol.exclude_first_jumps:
        rules.append(f"the first {protocol.exclude_first_jumps} jumps of a run are left out")
    rules.append(
        "jumps that touch a dropped packet are left out"
        if protocol.exclude_gap_jumps
        else "jumps that touch a dropped packet are kept"
    )
    return "; ".join(rules) + "."
