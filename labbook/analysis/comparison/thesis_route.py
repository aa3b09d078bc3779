"""The thesis's own tests (5.2.1), which stand beside those that decide: F, then t, over runs; analysis of variance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.deciding import fingerprints_of_sides, record_for_pairs, runs_of
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.outcomes.run_apexes import RunApexes
from labbook.analysis.results import Algorithm, Results, interval_ends, result_fingerprint
from reports.content import Anova, ThesisRoute
from reports.numbers import Number
from stats.compare.two_sample import compare_two
from stats.groups.anova import one_way_anova

ROUTE = Algorithm("thesis_route", 1)
OVER_JUMPS = Algorithm("thesis_route_over_jumps", 1)
ANOVA = Algorithm("anova", 17)


def routes_over_runs(
    computed: Results, pairs: Sequence[Pair], quantity: Outcome, scope: Mapping[str, Any], alpha: float
) -> list[ThesisRoute]:
    """Compute the thesis's route of every pair over its runs, in order."""

    def route(pair: Pair) -> ThesisRoute:
        control, treated = ([item.value for item in runs_of(side)] for side in (pair.a, pair.b))
        return thesis_route(control, treated, quantity.unit, alpha)

    return record_for_pairs(computed, ROUTE, pairs, quantity, scope, {"alpha": alpha}, route, fingerprints_of_sides)


def routes_over_jumps(
    computed: Results, pairs: Sequence[Pair], scope: Mapping[str, Any], alpha: float
) -> list[ThesisRoute]:
    """Compute the thesis's route of every pair of apex heights over all their jumps, in order."""

    def heights_m(side: Sequence[ConditionValues]) -> list[float]:
        results = [item.result for item in runs_of(side)]
        return [height_m for one in results if isinstance(one, RunApexes) for height_m in one.heights_m]

    return record_for_pairs(
        computed,
        OVER_JUMPS,
        pairs,
        Outcome.APEX,
        scope,
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
    computed: Results, conditions: Sequence[ConditionValues], swept: str, quantity: Outcome, scope: Mapping[str, Any]
) -> list[Anova]:
    """Compute the one-way analysis of variance over the treated levels of every group that has several."""
    groups = [
        (group, treated)
        for group, items in pairing.groups(conditions, swept)
        for treated, _control in [pairing.treated_and_control(items)]
        if len(treated) > 1
    ]
    return [
        computed.record(
            ANOVA,
            {"quantity": str(quantity), "label": pairing.group_label(group), **scope},
            [result_fingerprint("group", condition.result) for condition in treated],
            _analysed(group, treated, swept, quantity),
        )
        for group, treated in groups
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
