"""Every comparison of a study: the test that decides, with equivalence and Holm's p, and the thesis's route beside it.

Holm's p counts comparisons of the planned family that a report does not show: without them a report on one foot would
have smaller adjusted p-values than the report on both from the same data.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.vocabulary import Rule, StudyKind, Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.deciding import (
    decide,
    decide_equivalence,
    deciding_runs,
    fingerprints_of_sides,
    record_for_pairs,
    runs_of,
)
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues, conditions_by_outcome
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import RunApexes
from labbook.analysis.outcomes.run_energy import only_charge_missing
from labbook.analysis.preregistration.planned import FAMILY_OF, Planned
from labbook.analysis.results import Algorithm, Results, interval_ends, result_fingerprint
from labbook.analysis.study_data import StudyData
from labbook.config.model import Family
from reports.numbers import Number, NumberNames, Result
from reports.results import Anova, Comparison, Decision, MeansContrast, ThesisRoute
from stats.compare.two_sample import compare_two
from stats.groups.anova import one_way_anova
from stats.groups.multiple import holm


@dataclass(frozen=True, slots=True)
class FamilyResult(Result):
    """Holm's p of every test of a family by its label, and whether it is at most alpha.

    `rejected` is None where a test has no p.
    """

    adjusted_p: Annotated[Mapping[str, Number], NumberNames("adjusted_p, {}")]
    rejected: Mapping[str, bool | None]


FAMILY = Algorithm("decision_family", 2)


def adjust(
    computed: Results, tested: Mapping[str, Decision | MeansContrast], family: str, alpha: float, **about: str
) -> FamilyResult | None:
    """Compute the adjusted p of the tests of a family by their labels; None of a single one."""
    if len(tested) < 2:
        return None
    inputs = [result_fingerprint(label, one) for label, one in tested.items()]
    return computed.record(
        FAMILY, {"family": family, **about}, inputs, _adjusted(tested, family, alpha), {"alpha": alpha}
    )


def _adjusted(tested: Mapping[str, Decision | MeansContrast], family: str, alpha: float) -> FamilyResult:
    p = {label: one.p.value for label, one in tested.items()}
    result = holm(p, family, alpha=alpha)
    return FamilyResult(
        adjusted_p={label: Number(one, "1", n=len(p)) for label, one in zip(p, result.adjusted_p, strict=True)},
        rejected={
            label: None if isinstance(one, Undefined) else one for label, one in zip(p, result.rejected, strict=True)
        },
    )


def unselected_conditions(
    computed: Results,
    detections: Detections,
    evidence: StudyData,
    outcomes: Collection[Outcome],
) -> dict[Outcome, list[ConditionValues]]:
    """Compute the numbers of the conditions of which the selection takes no run."""
    if not evidence.beside:
        return {}
    return conditions_by_outcome(computed, detections, replace(evidence, runs=evidence.beside), outcomes)


@dataclass(frozen=True, slots=True)
class Compared:
    """A pair with its runs, what a report shows of it, and the family of tests that its p is adjusted in."""

    pair: Pair
    shown: Comparison
    family: FamilyResult | None


def compare_all(
    computed: Results,
    conditions: Mapping[Outcome, Sequence[ConditionValues]],
    swept: str,
    planned: Planned,
    evidence: StudyData,
    beside: Mapping[Outcome, Sequence[ConditionValues]],
) -> list[Compared]:
    """Make every comparison of the study, outcome by outcome.

    `beside` are conditions that the selection leaves out whole: their comparisons count in Holm's p.
    """
    found: list[Compared] = []
    for outcome, several in conditions.items():
        pairs = pairing.pairs_with_control(several, swept)
        further = pairing.pairs_with_control([*several, *beside[outcome]], swept) if beside.get(outcome) else []
        found += _compared(computed, pairs, further, outcome, planned, evidence)
    return found


def _compared(
    computed: Results,
    pairs: Sequence[Pair],
    every: Sequence[Pair],
    quantity: Outcome,
    planned: Planned,
    evidence: StudyData,
) -> list[Compared]:
    """Compare treatments with controls, and adjust the p of the family that was decided on, with those not shown."""
    settings, labels = planned.settings, {pair.label for pair in pairs}
    family = FAMILY_OF[settings.family]
    further = [pair for pair in every if pair.label not in labels and pair.family == family]
    decisions = dict(zip(labels_of(pairs), decide(computed, pairs, quantity, settings), strict=True))
    of_family = {pair.label: decisions[pair.label] for pair in pairs if pair.family == family}
    beside = zip(labels_of(further), decide(computed, further, quantity, settings), strict=True)
    adjusted = None
    if of_family:
        tests = {**of_family, **dict(beside)}
        adjusted = adjust(computed, tests, family, settings.alpha, quantity=str(quantity))
    if adjusted is not None:
        for label in of_family:
            p, rejected = adjusted.adjusted_p[label], adjusted.rejected[label]
            decisions[label] = replace(decisions[label], adjusted=p, adjusted_rejected=rejected)
    if quantity.has_equivalence and settings.apex_bounds is not None:
        within = decide_equivalence(computed, pairs, settings.apex_bounds, settings.alpha)
        for pair, test in zip(pairs, within, strict=True):
            why = planned.exploratory_equivalence(pair.family, conditions_of(pair)) or ""
            decisions[pair.label] = replace(decisions[pair.label], equivalence=replace(test, exploratory=why))
    for pair in pairs:
        if pair.family == pairing.POOLED and quantity.has_savings and decisions[pair.label].rule is Rule.NONE:
            missing = _charge_missing(pair, evidence)
            decisions[pair.label] = replace(decisions[pair.label], charge_missing=missing)
    over_runs = routes_over_runs(computed, pairs, quantity, settings.alpha)
    over_jumps = {}
    if quantity is Outcome.APEX and evidence.configuration.study.kind is StudyKind.BED:  # the study of thesis 5.2
        pooled = [pair for pair in pairs if pair.family == pairing.POOLED]
        routes = routes_over_jumps(computed, pooled, settings.alpha)
        over_jumps = dict(zip(labels_of(pooled), routes, strict=True))
    found = [
        Compared(
            pair,
            Comparison(
                label=pair.label,
                quantity=quantity,
                group=pair.group,
                level=pair.level,
                family=pair.family,
                decision=decisions[pair.label],
                over_runs=route,
                over_jumps=over_jumps.get(pair.label),
                exploratory=planned.exploratory(quantity, pair.family, conditions_of(pair)) or "",
            ),
            adjusted if pair.family == family else None,
        )
        for pair, route in zip(pairs, over_runs, strict=True)
    ]
    return _as_each(found) if settings.family is Family.EACH and one_level_each(pairs) else found


def _charge_missing(pair: Pair, evidence: StudyData) -> tuple[str, ...]:
    """Name the runs whose charge would give savings without a claim one."""
    without = only_charge_missing(evidence.runs, evidence.charges)
    of_group = [run for run in without if pair.group.items() <= run.levels.items()]
    return tuple(run.name for run in deciding_runs([one.run for one in runs_of((*pair.a, *pair.b))], of_group))


def groups_without_charges(
    evidence: StudyData, swept: str | None, compared: Sequence[Compared]
) -> tuple[tuple[Mapping[str, str], tuple[str, ...]], ...]:
    """Return the groups in which no control, or nothing beside it, has a charge, with the runs that lack theirs."""
    known = {
        pairing.group_label(item.pair.group)
        for item in compared
        if item.pair.family == pairing.POOLED and item.shown.quantity is Outcome.JOULES
    }
    runs = [run for run in evidence.runs if swept in run.levels]
    groups = grouped(runs, [tuple(item for item in run.levels.items() if item[0] != swept) for run in runs])
    return tuple(
        (dict(group), names)
        for group, of_group in groups.items()
        if pairing.group_label(dict(group)) not in known and len({run.is_control for run in of_group}) == 2
        for names in [tuple(run.name for run in only_charge_missing(of_group, evidence.charges))]
        if names
    )


def labels_of(pairs: Sequence[Pair]) -> list[str]:
    """Return the labels of pairs."""
    return [pair.label for pair in pairs]


def conditions_of(pair: Pair) -> tuple[str, ...]:
    """Return the keys of the conditions compared."""
    return tuple(item.key for item in (*pair.a, *pair.b))


def one_level_each(pairs: Sequence[Pair]) -> bool:
    """Whether each group has one treated level, so that its comparison and that of all levels are the same."""
    pooled = [pair for pair in pairs if pair.family == pairing.POOLED]
    return bool(pooled) and all(len(pair.b) == 1 for pair in pooled)


def _as_each(found: Sequence[Compared]) -> list[Compared]:
    """Return comparisons of all levels as those planned level by level, where each group has one treated level."""
    each = {pairing.group_label(one.pair.group): one for one in found if one.pair.family == pairing.EACH}
    return [
        replace(one, shown=replace(own.shown, label=pair.label, level=pair.level, family=pair.family,
                                   decision=replace(own.shown.decision,
                                                    charge_missing=one.shown.decision.charge_missing),
                                   over_jumps=one.shown.over_jumps), family=own.family)
        if pair.family == pairing.POOLED
        else one
        for one in found
        for pair in [one.pair]
        for own in [each[pairing.group_label(pair.group)]]
    ]  # fmt: skip


ROUTE = Algorithm("thesis_route", 1)
OVER_JUMPS = Algorithm("thesis_route_over_jumps", 1)
ANOVA = Algorithm("anova", 17)


def routes_over_runs(computed: Results, pairs: Sequence[Pair], quantity: Outcome, alpha: float) -> list[ThesisRoute]:
    """Compute the thesis's route of every pair over its runs, in order."""

    def route(pair: Pair) -> ThesisRoute:
        control, treated = ([item.value for item in runs_of(side)] for side in (pair.a, pair.b))
        return thesis_route(control, treated, quantity.unit, alpha)

    return record_for_pairs(computed, ROUTE, pairs, quantity, {"alpha": alpha}, route, fingerprints_of_sides)


def routes_over_jumps(computed: Results, pairs: Sequence[Pair], alpha: float) -> list[ThesisRoute]:
    """Compute the thesis's route of every pair of apex heights over all their jumps, in order."""

    def heights_m(side: Sequence[ConditionValues]) -> list[float]:
        results = [item.result for item in runs_of(side)]
        return [height_m for one in results if isinstance(one, RunApexes) for height_m in one.heights_m]

    return record_for_pairs(
        computed,
        OVER_JUMPS,
        pairs,
        Outcome.APEX,
        {"alpha": alpha},
        lambda pair: thesis_route(heights_m(pair.a), heights_m(pair.b), Outcome.APEX.unit, alpha),
        lambda pair: tuple(
            result_fingerprint(role, item.result)
            for role, side in (("a", pair.a), ("b", pair.b))
            for item in runs_of(side)
        ),
    )


def thesis_route(control: Sequence[float], treated: Sequence[float], unit: str, alpha: float) -> ThesisRoute:
    """Compare two samples by the t-test that an F-test at alpha chooses; the interval has level 1 - alpha."""
    found = compare_two(treated, control, "f_then_t", alpha, names=("of the treatment", "of the control"))
    n, (low, high) = len(control) + len(treated), interval_ends(found.difference_ci)

    def tested(value: float | Undefined, df: float | Undefined | None = None) -> Number:
        return Number(value, "1", df=df, n=n)

    return ThesisRoute(
        f=tested(found.f),
        f_p=tested(found.f_p),
        test=found.test,
        t=tested(found.t, found.df),
        p=tested(found.p, found.df),
        difference=Number(found.difference, unit, ci_low=low, ci_high=high, ci_level=1.0 - alpha, df=found.df, n=n),
        n_control=len(control),
        n_treatment=len(treated),
    )


def analyses_of_variance(
    computed: Results, conditions: Sequence[ConditionValues], swept: str, quantity: Outcome
) -> list[Anova]:
    """Compute the one-way analysis of variance over the treated levels of every group that has several."""
    return [
        computed.record(
            ANOVA,
            {"quantity": str(quantity), "label": pairing.group_label(group)},
            [result_fingerprint("group", condition.result) for condition in treated],
            _analysed(group, treated, swept, quantity),
        )
        for group, items in pairing.groups(conditions, swept)
        for treated, _control in [pairing.treated_and_control(items)]
        if len(treated) > 1
    ]


def _analysed(group: Mapping[str, str], treated: Sequence[ConditionValues], swept: str, quantity: Outcome) -> Anova:
    found = one_way_anova({condition.levels.get(swept, condition.key): condition.values for condition in treated})
    n = sum(found.group_ns)
    return Anova(
        label=pairing.group_label(group),
        quantity=quantity,
        group=group,
        f=Number(found.f, "1", n=n),
        p=Number(found.p, "1", n=n),
        df_between=found.df_between,
        df_within=found.df_within,
        n=n,
    )
