"""The one test that decides each comparison, by the days that both sides share, and the effect over all groups."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.queries.sources import InputRow
from data_schema.vocabulary import Rule, Undefined
from labbook.analysis.comparison.pairing import POOLED, Pair, group_label
from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber
from labbook.analysis.preregistration.planned import Planned
from labbook.analysis.results import Algorithm, Results, T, fingerprint, interval_ends, result_fingerprint
from labbook.config.model import AnalysisSettings, Bounds
from reports.numbers import Number
from reports.results import Decision, Equivalence, OverallEquivalence, OverallSavings
from stats.days.decision import Bounded, Contrast, Estimate, contrast_by_day, rule_of_days
from stats.days.overall import overall_equivalence, overall_savings
from stats.tails import t_upper

DECISION = Algorithm("decision", 5)
EQUIVALENCE = Algorithm("decision_equivalence", 4)
OVERALL = Algorithm("overall_savings", 5)
OVERALL_EQUIVALENCE = Algorithm("overall_equivalence", 5)


def runs_of(side: Sequence[ConditionValues]) -> list[RunNumber]:
    """Return the runs of a side with their numbers."""
    return [item for condition in side for item in condition.runs]


def contrast_of(pair: Pair) -> Contrast:
    """Return the contrast of a pair's runs by the rule that fits their days."""
    control, treated = runs_of(pair.a), runs_of(pair.b)
    return contrast_by_day(
        [item.value for item in treated],
        [item.value for item in control],
        days_treated=[item.run.day for item in treated],
        days_control=[item.run.day for item in control],
        shared_treated=[item.shared for item in treated],
        shared_control=[item.shared for item in control],
    )


def fingerprints_of_sides(pair: Pair) -> tuple[InputRow, ...]:
    """Name the conditions of both sides."""
    sides = (("a", pair.a), ("b", pair.b))
    return tuple(result_fingerprint(role, condition.result) for role, side in sides for condition in side)


def fingerprints_of_contrast(pair: Pair) -> tuple[InputRow, ...]:
    """Name the inputs of a contrast: the conditions of both sides, and the day of every run."""
    runs = {item.run.uid: item.run for item in (*runs_of(pair.a), *runs_of(pair.b))}
    return (
        *fingerprints_of_sides(pair),
        *(fingerprint("day", "run", run.uid, run.day) for run in runs.values()),
    )


def makes_claim(runs: Iterable[RunRow]) -> bool:
    """Tell whether the control's runs and the others would give a claim: their days decide, whatever their values."""
    days: dict[bool, list[str]] = {True: [], False: []}
    for run in runs:
        days[run.is_control].append(run.day)
    return rule_of_days(days[False], days[True]) is not Rule.NONE


def deciding_runs(with_value: Sequence[RunRow], without: Sequence[RunRow]) -> tuple[RunRow, ...]:
    """Return the runs without a value any of which, had it one, would give a group without a claim one.

    `with_value` are the group's runs with a value, `without` others of the group.
    """
    places: dict[tuple[str, bool], bool] = {}
    for run in without:
        place = run.day, run.is_control
        if place not in places:
            places[place] = makes_claim([*with_value, run])
    return tuple(run for run in without if places[run.day, run.is_control])


def about_pair(pair: Pair, quantity: Outcome) -> dict[str, str]:
    """Return what a result of a pair is about."""
    return {"quantity": str(quantity), "family": pair.family, "label": pair.label}


def record_for_pairs(
    computed: Results,
    algorithm: Algorithm,
    pairs: Sequence[Pair],
    quantity: Outcome,
    settings: Mapping[str, Any],
    compute: Callable[[Pair], T],
    inputs: Callable[[Pair], tuple[InputRow, ...]] = fingerprints_of_contrast,
) -> list[T]:
    """Compute a result of every pair, in order."""
    return [
        computed.record(algorithm, about_pair(pair, quantity), inputs(pair), compute(pair), settings) for pair in pairs
    ]


def depends_on(settings: AnalysisSettings) -> dict[str, Any]:
    """Return the settings that a decision depends on."""
    return {"alpha": settings.alpha, "one_sided": settings.one_sided}


def decide(
    computed: Results,
    pairs: Sequence[Pair],
    quantity: Outcome,
    settings: AnalysisSettings,
    inputs: Callable[[Pair], tuple[InputRow, ...]] = fingerprints_of_contrast,
) -> list[Decision]:
    """Compute the deciding test of every pair, in order; see `decide_by_contrast`."""

    def decision(pair: Pair) -> Decision:
        return decide_pair(pair, quantity, settings)

    return record_for_pairs(computed, DECISION, pairs, quantity, depends_on(settings), decision, inputs)


def decide_pair(
    pair: Pair, quantity: Outcome, settings: AnalysisSettings, contrast: Contrast | None = None
) -> Decision:
    """Decide about a pair by the rule that fits its days, or by another contrast; see `decide_by_contrast`."""
    return decide_by_contrast(
        contrast_of(pair) if contrast is None else contrast,
        quantity.unit,
        settings.alpha,
        with_savings=quantity.has_savings,
        shares_error=quantity.shares_error,
        one_sided=settings.one_sided,
    )


def decide_by_contrast(
    found: Contrast, unit: str, alpha: float, *, with_savings: bool, shares_error: bool, one_sided: bool = False
) -> Decision:
    """Decide by a contrast of values in `unit`; intervals have level 1 - alpha.

    One-sided, savings are tested against a saving alone, and intervals have level 1 - 2 alpha, which lie above 0 just
    where p is below alpha.
    """
    one_sided = one_sided and with_savings
    n, level = sum(found.n), 1.0 - (2.0 * alpha if one_sided else alpha)
    difference = found.difference(level)
    savings = found.savings(level) if with_savings else None
    tested = difference if savings is None else savings
    p = p_of(tested, one_sided)
    return Decision(
        rule=found.rule,
        days=found.days,
        difference=estimate_number(difference, unit, n, shares_error=shares_error),
        t=Number(tested.t, "1", df=tested.df, n=n),
        p=Number(p, "1", df=tested.df, n=n),
        control_mean=Number(found.control_mean, unit, n=found.n[0]),
        run_sd=Number(found.run_sd, unit, n=n),
        n_control=found.n[0],
        n_treatment=found.n[1],
        other=found.counts.control + found.counts.treated + found.counts.other_control + found.counts.other_treated - n,
        rejected=_rejected(p, alpha),
        savings=None if savings is None else estimate_number(savings, "%", n, shares_error=shares_error),
        one_sided=one_sided,
    )


def p_of(tested: Estimate, one_sided: bool) -> float | Undefined:
    """Return the p of an estimate against any difference, or against one above 0 alone."""
    if not one_sided or isinstance(tested.t, Undefined) or isinstance(tested.df, Undefined):
        return tested.p
    return t_upper(tested.t, tested.df)


def estimate_number(found: Estimate, unit: str, n: int, *, shares_error: bool) -> Number:
    """Return an estimate as a number; without `shares_error` an error in common that is 0 is none."""
    low, high = interval_ends(found.ci)
    errs = shares_error or (isinstance(found.shared_se, float) and found.shared_se > 0.0)
    shared = found.shared_se if errs else None
    return Number(found.value, unit, found.se, shared, low, high, found.level, df=found.df, n=n)


def _rejected(p: float | Undefined, alpha: float) -> bool | None:
    return None if isinstance(p, Undefined) else p <= alpha


def decide_equivalence(computed: Results, pairs: Sequence[Pair], bounds: Bounds, alpha: float) -> list[Equivalence]:
    """Compute the two one-sided tests of apex heights of every pair, in order, by the same contrast."""
    return record_for_pairs(
        computed,
        EQUIVALENCE,
        pairs,
        Outcome.APEX,
        {"alpha": alpha, "bounds": asdict(bounds)},
        lambda pair: equivalence_by_contrast(contrast_of(pair), bounds, alpha),
    )


def equivalence_by_contrast(contrast: Contrast, bounds: Bounds, alpha: float) -> Equivalence:
    """Test by a contrast of values in m whether the difference lies within the bounds."""
    found = contrast.equivalence(bounds.low, bounds.high, alpha, percent=bounds.percent)
    return Equivalence(**_within(found, bounds, alpha, sum(contrast.n)))


def _within(found: Bounded, bounds: Bounds, alpha: float, n: int) -> dict[str, Any]:
    """Return the fields of `Equivalence`."""
    low, high = interval_ends(found.ci)
    unit = "%" if bounds.percent else "m"
    numbers = {
        name: Number(getattr(found, name), "1", df=found.df, n=n) for name in ("t_low", "p_low", "t_high", "p_high")
    }
    return {
        "estimate": Number(found.value, unit, ci_low=low, ci_high=high, ci_level=1.0 - 2.0 * alpha, n=n),
        **numbers,
        "p": Number(found.p, "1", n=n),
        "shown": None if isinstance(found.equivalent, Undefined) else found.equivalent,
        **asdict(bounds),
    }


@dataclass(frozen=True, slots=True)
class Overall:
    """The effect over all groups: savings by outcome, and whether apex heights changed within the bounds."""

    savings: Mapping[Outcome, OverallSavings] = field(default_factory=dict)
    equivalent: OverallEquivalence | None = None


def overall_effects(
    computed: Results,
    pairs: Mapping[Outcome, Sequence[Pair]],
    planned: Planned,
    rests_on: Callable[[Iterable[Pair]], tuple[InputRow, ...]] = lambda _pairs: (),
) -> Overall:
    """Compute the effects over all groups; `pairs` has those of each outcome, one a group. One group has none.

    `rests_on` names what pairs rest on beside their values and days.
    """
    several = {outcome: of_groups for outcome, of_groups in pairs.items() if len(of_groups) > 1}
    contrasts_of = {
        outcome: {group_label(pair.group): contrast_of(pair) for pair in of_groups}
        for outcome, of_groups in several.items()
    }
    settings = planned.settings
    alpha, bounds = settings.alpha, settings.apex_bounds

    def recorded(algorithm: Algorithm, outcome: Outcome, result: T, about: Mapping[str, Any]) -> T:
        of_groups = several[outcome]
        inputs = (*(row for pair in of_groups for row in fingerprints_of_contrast(pair)), *rests_on(of_groups))
        about = {"alpha": alpha, "groups": list(contrasts_of[outcome]), **about}
        return computed.record(algorithm, {"quantity": str(outcome)}, inputs, result, about)

    def groups_of(outcome: Outcome, names: Iterable[str]) -> tuple[Mapping[str, str], ...]:
        by_name = {group_label(pair.group): pair.group for pair in several[outcome]}
        return tuple(by_name[name] for name in names)

    def saved(outcome: Outcome) -> OverallSavings:
        found = overall_savings(contrasts_of[outcome], 1.0 - settings.outside)
        estimate, over = found.estimate, found.scope
        p, n_groups = p_of(estimate, settings.one_sided), len(over.groups)
        p_same = found.heterogeneity if isinstance(found.heterogeneity, Undefined) else found.heterogeneity.p
        return OverallSavings(
            quantity=outcome,
            savings=estimate_number(estimate, "%", over.n, shares_error=True),
            t=Number(estimate.t, "1", df=estimate.df, n=over.n),
            p=Number(p, "1", df=estimate.df, n=over.n),
            spread=Number(found.spread_percent, "%", n=n_groups),
            heterogeneity_p=Number(p_same, "1", n=n_groups),
            groups=groups_of(outcome, over.groups),
            left_out=groups_of(outcome, over.left_out),
            days=over.days,
            days_measured_only=over.days_measured_only,
            rejected=_rejected(p, alpha),
            differ=_rejected(p_same, alpha),
            one_sided=settings.one_sided,
        )

    def within(bounds: Bounds) -> OverallEquivalence:
        found = overall_equivalence(contrasts_of[Outcome.APEX], bounds.low, bounds.high, alpha)
        over = found.scope
        return OverallEquivalence(
            **_within(found.bounded, bounds, alpha, over.n),
            groups=groups_of(Outcome.APEX, over.groups),
            left_out=groups_of(Outcome.APEX, over.left_out),
            days=over.days,
            days_measured_only=over.days_measured_only,
        )

    equivalent = None
    if Outcome.APEX in several and bounds is not None and bounds.percent:
        equivalent = recorded(OVERALL_EQUIVALENCE, Outcome.APEX, within(bounds), {"bounds": asdict(bounds)})
        equivalent = replace(equivalent, exploratory=planned.exploratory_equivalence(POOLED) or "")
    savings = {
        outcome: replace(
            recorded(OVERALL, outcome, saved(outcome), {"one_sided": settings.one_sided}),
            exploratory=planned.exploratory(outcome, POOLED) or "",
        )
        for outcome in several
        if outcome.has_savings
    }
    return Overall(savings, equivalent)
