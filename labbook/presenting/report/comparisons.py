"""Comparisons, effects over groups and recomputed headlines as a report shows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.reasons import Reason
from data_schema.vocabulary import Rule, Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparisons import Compared
from labbook.analysis.comparison.deciding import deciding_runs
from labbook.analysis.comparison.order import ADJUSTED, OVER_GROUPS
from labbook.analysis.comparison.robustness import WITHOUT_EXCLUSIONS, Varied
from labbook.analysis.outcomes.run_energy import recharge_of
from labbook.analysis.study import StudyAnalysis
from reports.content import ReportContent
from reports.evidence import Comparison, Decision, Favoured, OverallEquivalence, OverallSavings, Sensitivity, Variant
from reports.naming import levels_name
from reports.numbers import Number
from stats.days.order import PositionsCompared


def comparisons(analysis: StudyAnalysis) -> tuple[Comparison, ...]:
    """Return all comparisons; those of savings without a claim name the runs whose charge would give one."""
    without_charge = [run for run in analysis.evidence.runs if _only_charge_missing(analysis, run)]
    found = []
    for item in analysis.compared:
        one, decision = item.shown, item.shown.decision
        if decision.rule is Rule.NONE and item.pair.family == pairing.POOLED and one.quantity.has_savings:
            missing = deciding_runs(item.pair, without_charge)
            one = replace(one, decision=replace(decision, charge_missing=missing))
        found.append(one)
    return tuple(found)


def one_level(analysis: StudyAnalysis) -> bool:
    """Tell whether each group has one treated level, so that its comparison and that of all levels are the same."""
    pooled = [item.pair for item in analysis.compared if item.pair.family == pairing.POOLED]
    return bool(pooled) and all(len(pair.b) == 1 for pair in pooled)


def overall(analysis: StudyAnalysis) -> tuple[OverallSavings, ...]:
    """Return the savings over all groups."""
    return tuple(
        replace(result, exploratory=analysis.planned.exploratory(outcome, pairing.POOLED) or "")
        for outcome, result in analysis.overall.savings.items()
    )


def overall_equivalence(analysis: StudyAnalysis) -> OverallEquivalence | None:
    """Return the test over all groups that apex heights changed within the bounds."""
    result = analysis.overall.equivalent
    if result is None:
        return None
    return replace(result, exploratory=analysis.planned.exploratory_equivalence(pairing.POOLED) or "")


def sensitivity(analysis: StudyAnalysis, content: ReportContent) -> tuple[Sensitivity, ...]:
    """Return every pooled headline with its recomputations; `content` knows what groups are called."""
    found = []
    pooled = [item for item in analysis.compared if item.pair.family == pairing.POOLED]
    for item in sorted(pooled, key=lambda item: content.place_of(item.pair.group)):
        quantity = item.shown.quantity
        recomputed = [
            varied
            for varied in analysis.variations.varied
            if varied.headline == item.pair.label and varied.quantity is quantity
        ]
        group = levels_name(content, item.pair.group)
        found.append(
            Sensitivity(
                f"{'savings' if quantity.has_savings else f'difference of {quantity}'}, {group}",
                _headline_number(item.shown.decision),
                tuple(
                    Variant(
                        varied.variant,
                        _headline_number(varied.result),
                        varied.day,
                        varied.by_rules,
                    )
                    for varied in recomputed
                ),
                _rule_of_all_runs(item, recomputed),
                group,
            )
        )
    return tuple(found)


def _rule_of_all_runs(item: Compared, recomputed: Sequence[Varied]) -> str:
    """Return the rule by which the days of all runs would decide, where exclusions changed it; else ""."""
    rule = next((one.result.rule for one in recomputed if one.variant == WITHOUT_EXCLUSIONS), None)
    return "" if rule in (None, item.shown.decision.rule) else str(rule)


def _headline_number(decision: Decision) -> Number:
    """Return the number that the claim states, with the interval it states."""
    return decision.savings or decision.difference


def favoured(analysis: StudyAnalysis) -> tuple[Favoured, ...]:
    """Return the headlines that the order within days favours, adjusted: that over all groups, else those of groups."""
    tests = analysis.favoured
    if OVER_GROUPS in tests:
        effects = analysis.overall_adjusted
        adjusted = {outcome: result.savings for outcome, result in effects.savings.items()}
        if effects.equivalent is not None:
            adjusted[Outcome.APEX] = effects.equivalent.estimate
        return (_favoured(None, tests[OVER_GROUPS], adjusted),)
    pooled = {item.pair.label: item.pair for item in analysis.compared if item.pair.family == pairing.POOLED}
    return tuple(
        _favoured(
            pair.group,
            tests[pairing.group_label(pair.group)],
            {
                varied.quantity: _headline_number(varied.result)
                for varied in analysis.variations.varied
                if varied.variant == ADJUSTED and varied.headline == label
            },
        )
        for label, pair in pooled.items()
        if pairing.group_label(pair.group) in tests
    )


def _favoured(group: Mapping[str, str] | None, test: PositionsCompared, adjusted: Mapping[Outcome, Number]) -> Favoured:
    claimed = {outcome: adjusted[outcome] for outcome in (Outcome.JOULES, Outcome.APEX) if outcome in adjusted}
    return Favoured(group, test.control, test.treated, test.p, claimed)


def groups_without_charges(analysis: StudyAnalysis) -> tuple[tuple[Mapping[str, str], tuple[str, ...]], ...]:
    """Return the groups in which no control, or nothing beside it, has a charge, with the runs that lack theirs."""
    compared = {
        pairing.group_label(item.pair.group)
        for item in analysis.compared
        if item.pair.family == pairing.POOLED and item.shown.quantity is Outcome.JOULES
    }
    groups: dict[str, list[RunRow]] = {}
    for run in analysis.evidence.runs:
        label = pairing.group_label(_without_swept(analysis, run))
        if analysis.swept in run.levels and label not in compared:
            groups.setdefault(label, []).append(run)
    return tuple(
        (_without_swept(analysis, runs[0]), names)
        for runs in groups.values()
        if len({run.is_control for run in runs}) == 2
        for names in [tuple(run.name for run in runs if _only_charge_missing(analysis, run))]
        if names
    )


def _without_swept(analysis: StudyAnalysis, run: RunRow) -> dict[str, str]:
    return {name: label for name, label in run.levels.items() if name != analysis.swept}


def _only_charge_missing(analysis: StudyAnalysis, run: RunRow) -> bool:
    why = recharge_of(run, analysis.evidence.charges.get(run.uid, []))
    known = bool(run.duration_s and run.jumps_made)
    return known and isinstance(why, Undefined) and why.code is Reason.NO_CHARGE
