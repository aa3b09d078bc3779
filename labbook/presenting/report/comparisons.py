"""Comparisons, analyses of variance and recomputed headlines as a report shows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.reasons import VALUE, Reason
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.by_day import DayComparison
from labbook.analysis.comparison.comparing import ComparisonResult, EquivalenceResult, JumpComparison
from labbook.analysis.comparison.comparisons import Compared, Decided, as_each
from labbook.analysis.comparison.deciding import (
    DecisionResult,
    OverallEquivalenceResult,
    OverallResult,
    deciding_runs,
)
from labbook.analysis.comparison.order import ADJUSTED, OVER_GROUPS
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.comparison.robustness import WITHOUT_EXCLUSIONS, Varied
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.outcomes.run_energy import recharge_of
from labbook.analysis.study import StudyAnalysis
from labbook.config.model import UnitOfAnalysis
from labbook.presenting.numbers import ShownNumbers
from labbook.presenting.report.day_layout import one_day_each
from reports.content import Anova, Comparison, ReportContent, Sensitivity, Variant
from reports.display import count_text
from reports.evidence import (
    ByDay,
    Decision,
    Equivalence,
    Favoured,
    OverallEquivalence,
    OverallSavings,
    OverGroups,
    Side,
)
from reports.naming import levels_name
from reports.numbers import Number, SignificanceTest
from stats.days.blocked_result import MIXED_MODEL, exact_method
from stats.days.decision import Rule
from stats.days.order import PositionsCompared

SIDES = ("the treatment", "the control")
"""What the side that is compared is called, and the one that it is compared with."""
UNITS = {Rule.PAIRED: "day", Rule.WITHIN: "run", Rule.NONE: ""}
"""What each rule counts."""
RUN = "run"
"""What a report calls the values of comparisons by day."""


def comparisons(analysis: StudyAnalysis, shown: ShownNumbers) -> tuple[Comparison, ...]:
    """Return all comparisons; where nothing is pooled, those of all levels are shown as the planned ones of each."""
    found = [_comparison(analysis, item, shown) for item in analysis.compared]
    if not planned_as_each(analysis):
        return tuple(found)
    each = {_key(item): item for item in found if item.family == pairing.EACH}
    return tuple(
        replace(each[_key(item)], label=item.label, level=item.level, family=item.family)
        if item.family == pairing.POOLED
        else item
        for item in found
    )


def _key(item: Comparison) -> tuple[Outcome, str]:
    return item.quantity, pairing.group_label(item.group)


def one_level(analysis: StudyAnalysis) -> bool:
    """Tell whether each group has one treated level, so that its comparison and that of all levels are the same."""
    pooled = [item.pair for item in analysis.compared if item.pair.family == pairing.POOLED]
    return bool(pooled) and all(len(pair.b) == 1 for pair in pooled)


def planned_as_each(analysis: StudyAnalysis) -> bool:
    """Tell whether comparisons of all levels are those that were planned level by level, for want of a second level."""
    return as_each(analysis.compared, analysis.planned.settings)


def overall(analysis: StudyAnalysis, shown: ShownNumbers) -> tuple[OverallSavings, ...]:
    """Return the savings over all groups."""
    return tuple(
        OverallSavings(
            quantity=outcome,
            savings=shown.number(result.savings),
            test=replace(shown.test("overall", result.t, result.p), one_sided=result.one_sided),
            spread=shown.number(result.spread),
            heterogeneity_p=shown.number(result.heterogeneity_p),
            differ=result.differ,
            rejected=result.rejected,
            scope=_over_groups(analysis, result),
            exploratory=analysis.planned.exploratory(outcome, pairing.POOLED) or "",
        )
        for outcome, result in analysis.overall.savings.items()
    )


def overall_equivalence(analysis: StudyAnalysis, shown: ShownNumbers) -> OverallEquivalence | None:
    """Return the test over all groups that apex heights changed within the bounds."""
    result = analysis.overall.equivalent
    why = analysis.planned.exploratory_equivalence(pairing.POOLED) or ""
    return (
        None if result is None else OverallEquivalence(equivalence(result, shown, why), _over_groups(analysis, result))
    )


def _over_groups(analysis: StudyAnalysis, result: OverallResult | OverallEquivalenceResult) -> OverGroups:
    levels = {pairing.group_label(item.pair.group): item.pair.group for item in analysis.compared}
    groups, left_out = (tuple(levels[name] for name in names) for names in (result.groups, result.left_out))
    return OverGroups(groups, left_out, result.days, result.days_measured_only)


def jump_comparisons(analysis: StudyAnalysis, shown: ShownNumbers) -> tuple[Comparison, ...]:
    """Return the thesis's route to apex heights: the pooled comparisons over single jumps."""
    why = analysis.planned.exploratory_jumps()
    return tuple(
        replace(_tested(item.pair, Outcome.APEX, item.result, shown), exploratory=why) for item in analysis.jump_tests
    )


def anovas(analysis: StudyAnalysis, shown: ShownNumbers) -> tuple[Anova, ...]:
    """Return the analyses of variance over the swept factor."""
    found = []
    for item in analysis.anovas:
        result = item.result
        test = shown.test("one-way ANOVA", result.f, result.p, (float(result.df_between), float(result.df_within)))
        p = shown.number(result.p)
        why = analysis.planned.exploratory_anova()
        levels = {one.levels.get(analysis.swept or "", one.key): (one,) for one in analysis.levels_of(item)}
        days = _confounding_with_days(test, {f"level {label}": side for label, side in levels.items()})
        found.append(Anova(item.label, item.quantity, item.group, test, result.n, p.provenance, why, days))
    return tuple(found)


def sensitivity(analysis: StudyAnalysis, shown: ShownNumbers, content: ReportContent) -> tuple[Sensitivity, ...]:
    """Return every pooled headline with its recomputations; `content` knows what groups are called."""
    found = []
    pooled = [item for item in analysis.compared if item.pair.family == pairing.POOLED]
    for item in sorted(pooled, key=lambda item: content.place_of(item.pair.group)):
        recomputed = [
            varied
            for varied in analysis.variations.varied
            if varied.headline == item.pair.label and varied.quantity is item.quantity
        ]
        group = levels_name(content, item.pair.group)
        found.append(
            Sensitivity(
                f"{'savings' if item.quantity.has_savings else f'difference of {item.quantity}'}, {group}",
                _headline_number(item.decided.result if item.decided else item.result, analysis, shown),
                tuple(
                    Variant(
                        varied.variant,
                        _headline_number(varied.result, analysis, shown),
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
    for varied in recomputed:
        if varied.variant == WITHOUT_EXCLUSIONS and isinstance(varied.result, DecisionResult) and item.decided:
            return "" if varied.result.rule is item.decided.result.rule else str(varied.result.rule)
    return ""


def _headline_number(result: ComparisonResult | DecisionResult, analysis: StudyAnalysis, shown: ShownNumbers) -> Number:
    """Return the number that the claim states, with the interval it states."""
    difference = result.welch_difference if isinstance(result, ComparisonResult) else result.difference
    return _of_sides(analysis, shown).number(result.savings or difference)


def _of_sides(analysis: StudyAnalysis, shown: ShownNumbers) -> ShownNumbers:
    """Call the sides of a comparison, and the values that it compares, what they are."""
    return shown.of_sides(SIDES, analysis.planned.settings.unit_of_analysis.noun)


def _comparison(analysis: StudyAnalysis, item: Compared, shown: ShownNumbers) -> Comparison:
    """Show a comparison on run means with everything that stands beside it."""
    result, label, on_units = item.result, item.pair.label, _of_sides(analysis, shown)
    df = (1.0, float(result.n_a + result.n_b - 2))
    why_not_planned = analysis.planned.exploratory_equivalence(item.pair.family, item.conditions) or ""
    return replace(
        _tested(item.pair, item.quantity, result, on_units),
        savings=None if result.savings is None else on_units.number(result.savings),
        welch=replace(on_units.test("Welch", result.welch_t, result.welch_p), one_sided=result.one_sided),
        brown_forsythe=on_units.test("Brown-Forsythe", result.brown_forsythe, result.brown_forsythe_p, df),
        sides=(
            Side(on_units.value(result.mean_a), on_units.value(result.sd_a)),
            Side(on_units.value(result.mean_b), on_units.value(result.sd_b)),
        ),
        by_day=None if item.by_day is None else _by_day(item.by_day, shown.of_sides(SIDES, RUN)),
        adjusted=None if item.adjusted is None else on_units.number(item.adjusted.adjusted_p[label]),
        rejected=result.rejected,
        adjusted_rejected=None if item.adjusted is None else item.adjusted.rejected[label],
        savings_shown=result.savings_shown,
        equivalence=None if item.equivalent is None else equivalence(item.equivalent, on_units, why_not_planned),
        decision=None if item.decided is None else _decision(analysis, item, item.decided, on_units, why_not_planned),
        exploratory=analysis.planned.exploratory(item.quantity, item.pair.family, item.conditions) or "",
    )


def _tested(
    pair: Pair, quantity: Outcome, result: ComparisonResult | JumpComparison, shown: ShownNumbers
) -> Comparison:
    """Show the thesis's route, and Welch's test beside it."""
    test = shown.test(result.test, result.t, result.p)
    df = (float(result.n_b - 1), float(result.n_a - 1))
    return Comparison(
        label=pair.label,
        quantity=quantity,
        group=pair.group,
        level=pair.level,
        n_control=result.n_a,
        n_treatment=result.n_b,
        variance_test=shown.test("F-test", result.f, result.f_p, df),
        test=test,
        difference=shown.number(result.difference),
        welch=shown.test("Welch", result.welch_t, result.welch_p),
        welch_difference=shown.number(result.welch_difference),
        family=pair.family,
        one_day_each=_confounding_with_days(test, dict(zip(SIDES, (pair.b, pair.a), strict=True))),
    )


def _confounding_with_days(test: SignificanceTest, sides: Mapping[str, Sequence[ConditionValues]]) -> str:
    """Say that a test confounds its sides with their days, where each had one day; "" where there is no test."""
    if isinstance(test.statistic, Undefined):
        return ""
    return one_day_each({name: {item.run.day for one in side for item in one.runs} for name, side in sides.items()})


def runs_of_different_days(analysis: StudyAnalysis) -> str:
    """Say that runs of days without the other side are compared, where the plan counts runs; "" where none are."""
    if analysis.planned.settings.unit_of_analysis is not UnitOfAnalysis.RUN:
        return ""
    both, days = set[tuple[str, str]](), set[tuple[str, str]]()
    for pair in [item.pair for item in analysis.compared if item.pair.family == pairing.POOLED]:
        group = pairing.group_label(pair.group)
        control, treated = ({(group, item.run.day) for one in side for item in one.runs} for side in (pair.a, pair.b))
        both |= control & treated
        days |= control | treated
    if both == days:
        return ""
    per_group = " of a group" if len({group for group, _day in days}) > 1 else ""
    return (
        f"The plan counts runs, so that runs of different days were compared: {len(both)} of "
        f"{count_text(len(days), 'day')}{per_group} hold both the control and the treatment, and what days differ by "
        "is in the differences."
    )


def favoured(analysis: StudyAnalysis, shown: ShownNumbers) -> tuple[Favoured, ...]:
    """Return the headlines that the order within days favours, adjusted: that over all groups, else those of groups."""
    tests = analysis.favoured
    if OVER_GROUPS in tests:
        effects = analysis.overall_adjusted
        adjusted = {outcome: shown.number(result.savings) for outcome, result in effects.savings.items()}
        if effects.equivalent is not None:
            adjusted[Outcome.APEX] = shown.number(effects.equivalent.estimate)
        return (_favoured(None, tests[OVER_GROUPS], adjusted),)
    pooled = {item.pair.label: item.pair for item in analysis.compared if item.pair.family == pairing.POOLED}
    return tuple(
        _favoured(
            pair.group,
            tests[pairing.group_label(pair.group)],
            {
                varied.quantity: _headline_number(varied.result, analysis, shown)
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


def _by_day(result: DayComparison, shown: ShownNumbers) -> ByDay:
    found = ByDay(
        difference=shown.number(result.difference),
        test=shown.test("by day", result.t, result.p),
        days=result.days,
        day_sd=shown.number(result.day_sd),
        run_sd=shown.number(result.run_sd),
        method=method_by_day(result),
        confounding="" if result.confounding is None else result.confounding.called({}, RUN).text,
        notes=tuple(remark.called({}, RUN).text for remark in result.notes),
    )
    untested = isinstance(found.test.statistic, Undefined)
    return found if untested else replace(found, test=replace(found.test, name=f"by day ({found.kind})"))


def method_by_day(result: DayComparison) -> str:
    """Name the test of a comparison by day, whose values are runs."""
    if result.counted is None:
        return MIXED_MODEL
    return exact_method(RUN if result.counted == VALUE else result.counted, result.held)


def _decision(
    analysis: StudyAnalysis, item: Compared, decided: Decided, shown: ShownNumbers, why_not_planned: str
) -> Decision:
    family = decided.adjusted
    missing: tuple[str, ...] = ()
    if decided.result.rule is Rule.NONE and item.pair.family == pairing.POOLED and item.quantity.has_savings:
        missing = deciding_runs(
            item.pair, [run for run in analysis.evidence.runs if _only_charge_missing(analysis, run)]
        )
    return replace(
        decision(decided.result, shown),
        adjusted=None if family is None else shown.number(family.adjusted_p[item.pair.label]),
        adjusted_rejected=None if family is None else family.rejected[item.pair.label],
        equivalence=None if decided.equivalent is None else equivalence(decided.equivalent, shown, why_not_planned),
        charge_missing=missing,
    )


def groups_without_charges(analysis: StudyAnalysis) -> tuple[tuple[Mapping[str, str], tuple[str, ...]], ...]:
    """Return the groups in which no control, or nothing beside it, has a charge, with the runs that lack theirs."""
    compared = {
        pairing.group_label(item.pair.group)
        for item in analysis.compared
        if item.pair.family == pairing.POOLED and item.quantity is Outcome.JOULES
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


def decision(result: DecisionResult, shown: ShownNumbers) -> Decision:
    """Return the test that decides as a report carries it."""
    return Decision(
        unit=UNITS[result.rule],
        days=result.days,
        n_control=result.n_control,
        n_treatment=result.n_treated,
        other=result.other,
        difference=shown.number(result.difference),
        savings=None if result.savings is None else shown.number(result.savings),
        test=replace(shown.test("by shared days", result.t, result.p), one_sided=result.one_sided),
        rejected=result.rejected,
    )


def equivalence(result: EquivalenceResult, shown: ShownNumbers, why_not_planned: str = "") -> Equivalence:
    """Return two one-sided tests as a report carries them."""
    return Equivalence(
        estimate=shown.number(result.estimate),
        low=result.low,
        high=result.high,
        at_low=shown.test("lower bound", result.t_low, result.p_low),
        at_high=shown.test("upper bound", result.t_high, result.p_high),
        p=shown.value(result.p),
        shown=result.equivalent,
        exploratory=why_not_planned,
    )
