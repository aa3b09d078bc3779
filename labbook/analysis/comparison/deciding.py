"""The one test that decides each comparison, by the days that both sides share, and the effect over all groups."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.queries.results import InputRow
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparing import (
    EquivalenceResult,
    ensure_equivalence,
    estimate_within,
    fingerprints_of_days,
    fingerprints_of_sides,
    one_sided,
)
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber
from labbook.analysis.results.codec import Algorithm, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, interval_ends
from labbook.config.model import Bounds
from reports.numbers import Number
from stats.days.decision import Bounded, Contrast, Estimate, Rule, contrast_by_day
from stats.days.overall import (
    OverallSavings,
    overall_equivalence,
    overall_savings,
)
from stats.exact.tails import t_upper


@dataclass(frozen=True, slots=True)
class DecisionResult(StoredResult):
    """A treatment against its control by `stats.days.decision`; `difference` is treatment less control.

    `t` and `p` are those of no difference, t positive for a saving where there are savings; `one_sided` where p is that
    of no saving, against a saving alone. `n_control` and `n_treated`
    count the runs that the means are of: those on the shared `days`, all where there is none. `other` counts the
    runs that enter nothing. `rejected` is None where nothing is tested.
    """

    rule: Rule
    days: tuple[str, ...]
    difference: Number
    t: Number
    p: Number
    n_control: int
    n_treated: int
    other: int
    rejected: bool | None
    savings: Number | None = None
    one_sided: bool = False


@dataclass(frozen=True, slots=True)
class OverallResult(StoredResult):
    """The mean of the groups' savings, in percent, each group counted once; groups without a claim are `left_out`.

    `spread` is the standard deviation of the savings, `heterogeneity_p` the p of the test that all groups saved the
    same; `differ` is None where that is not tested. `one_sided` as in `DecisionResult`.
    """

    savings: Number
    t: Number
    p: Number
    spread: Number
    heterogeneity_p: Number
    groups: tuple[str, ...]
    left_out: tuple[str, ...]
    days: tuple[str, ...]
    days_measured_only: bool
    rejected: bool | None
    differ: bool | None
    one_sided: bool = False


@dataclass(frozen=True, slots=True)
class OverallEquivalenceResult(EquivalenceResult):
    """The same of the mean change of the groups, in percent of each group's control."""

    groups: tuple[str, ...]
    left_out: tuple[str, ...]
    days: tuple[str, ...]
    days_measured_only: bool


DECISION = Algorithm("decision", 4, DecisionResult)
DECISION_EQUIVALENCE = Algorithm("decision_equivalence", 3, EquivalenceResult)
OVERALL = Algorithm("overall_savings", 3, OverallResult)
OVERALL_EQUIVALENCE = Algorithm("overall_equivalence", 3, OverallEquivalenceResult)


def contrast_of(pair: Pair, *, by_day: bool = True) -> Contrast:
    """Return the contrast of a pair's runs by the rule that fits their days, or of all runs as if of one day."""
    control, treated = _runs(pair.a), _runs(pair.b)
    return contrast_by_day(
        [item.value for item in treated],
        [item.value for item in control],
        days_treated=[item.run.day for item in treated] if by_day else None,
        days_control=[item.run.day for item in control] if by_day else None,
        shared_treated=[item.shared for item in treated],
        shared_control=[item.shared for item in control],
    )


def _runs(side: Sequence[ConditionValues]) -> list[RunNumber]:
    return [item for condition in side for item in condition.runs]


def deciding_runs(pair: Pair, without: Sequence[RunRow]) -> tuple[str, ...]:
    """Name the runs of a pair's group without a value any of which, had it one, would give a pair without a claim one.

    Which days hold which runs decides that, whatever their values.
    """
    days = [[item.run.day for item in _runs(side)] for side in (pair.a, pair.b)]

    def claims(more: RunRow) -> bool:
        control, treated = ([*each, *([more.day] if more.is_control is is_control else [])]
                            for each, is_control in zip(days, (True, False), strict=True))  # fmt: skip
        layout = contrast_by_day([0.0] * len(treated), [0.0] * len(control), days_treated=treated, days_control=control)
        return layout.rule is not Rule.NONE

    return tuple(run.name for run in without if pair.group.items() <= run.levels.items() and claims(run))


def decide(
    cache: ResultCache,
    pairs: Sequence[Pair],
    quantity: Outcome,
    scope: Mapping[str, Any],
    alpha: float,
    *,
    one_sided: bool = False,
) -> list[DecisionResult]:
    """Ensure the deciding test of every pair, in order; see `decide_by_contrast`."""
    return cache.ensure(
        [
            Request(
                DECISION,
                {"quantity": str(quantity), "family": pair.family, "label": pair.label, **scope},
                fingerprints_of_contrast(pair),
                {"with_savings": quantity.has_savings, "alpha": alpha, "one_sided": one_sided},
                lambda pair=pair: decide_pair(pair, quantity, alpha, one_sided=one_sided),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


def decide_equivalence(
    cache: ResultCache, pairs: Sequence[Pair], bounds: Bounds, alpha: float, scope: Mapping[str, Any]
) -> list[EquivalenceResult]:
    """Ensure the two one-sided tests of apex heights of every pair, in order, by the same contrast."""
    return ensure_equivalence(
        cache, DECISION_EQUIVALENCE, pairs, bounds, alpha, scope, fingerprints_of_contrast, _equivalent
    )


@dataclass(frozen=True, slots=True)
class Overall:
    """The effect over all groups: savings by outcome, and whether apex heights changed within the bounds."""

    savings: Mapping[Outcome, OverallResult] = field(default_factory=dict)
    equivalent: OverallEquivalenceResult | None = None


def overall_effects(
    cache: ResultCache,
    pairs: Mapping[Outcome, Mapping[str, Pair]],
    bounds: Bounds | None,
    alpha: float,
    scope: Mapping[str, Any],
    rests_on: Callable[[Iterable[Pair]], tuple[InputRow, ...]] = lambda _pairs: (),
    *,
    one_sided: bool = False,
) -> Overall:
    """Ensure the effects over all groups; `pairs` has those of each outcome by group. One group has none.

    `rests_on` names what pairs rest on beside their values and days.
    """
    several = {outcome: of_group for outcome, of_group in pairs.items() if len(of_group) > 1}
    heights = several.get(Outcome.APEX)
    equivalent = None
    if heights is not None and bounds is not None and bounds.percent:
        equivalent = _overall_within(cache, heights, bounds, alpha, scope, rests_on(heights.values()))
    savings = {
        outcome: _overall_savings(cache, of_group, outcome, scope, alpha, one_sided, rests_on(of_group.values()))
        for outcome, of_group in several.items()
        if outcome.has_savings
    }
    return Overall(savings, equivalent)


def _overall_savings(
    cache: ResultCache,
    pairs: Mapping[str, Pair],
    quantity: Outcome,
    scope: Mapping[str, Any],
    alpha: float,
    one_sided: bool,
    inputs: Sequence[InputRow],
) -> OverallResult:
    contrasts, level = _contrasts(pairs), 1.0 - (2.0 * alpha if one_sided else alpha)
    return cache.ensure_one(
        Request(
            OVERALL,
            {"quantity": str(quantity), **scope},
            (*_fingerprints(pairs), *inputs),
            {"alpha": alpha, "one_sided": one_sided, "groups": list(contrasts)},
            lambda: _overall(overall_savings(contrasts, level), alpha, one_sided),
        )
    )


def _overall_within(
    cache: ResultCache,
    pairs: Mapping[str, Pair],
    bounds: Bounds,
    alpha: float,
    scope: Mapping[str, Any],
    inputs: Sequence[InputRow],
) -> OverallEquivalenceResult:
    contrasts = _contrasts(pairs)
    return cache.ensure_one(
        Request(
            OVERALL_EQUIVALENCE,
            {"quantity": str(Outcome.APEX), **scope},
            (*_fingerprints(pairs), *inputs),
            {"alpha": alpha, "bounds": asdict(bounds), "groups": list(contrasts)},
            lambda: _overall_equivalent(contrasts, bounds, alpha),
        )
    )


def _contrasts(pairs: Mapping[str, Pair]) -> dict[str, Contrast]:
    return {name: contrast_of(pair) for name, pair in pairs.items()}


def fingerprints_of_contrast(pair: Pair) -> tuple[InputRow, ...]:
    """Return the inputs of a contrast: the conditions of both sides, and the day of every run."""
    return (*fingerprints_of_sides(pair), *fingerprints_of_days(pair))


def _fingerprints(pairs: Mapping[str, Pair]) -> tuple[InputRow, ...]:
    return tuple(one for pair in pairs.values() for one in fingerprints_of_contrast(pair))


def decide_pair(
    pair: Pair, quantity: Outcome, alpha: float, contrast: Contrast | None = None, *, one_sided: bool = False
) -> DecisionResult:
    """Decide about a pair by the rule that fits its days, or by another contrast; see `decide_by_contrast`."""
    found = contrast_of(pair) if contrast is None else contrast
    with_savings = quantity.has_savings
    return decide_by_contrast(found, quantity.unit, alpha, with_savings, quantity.shares_error, one_sided=one_sided)


def decide_by_contrast(
    found: Contrast, unit: str, alpha: float, with_savings: bool, shares_error: bool, *, one_sided: bool = False
) -> DecisionResult:
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
    return DecisionResult(
        rule=found.rule,
        days=found.days,
        difference=_number(difference, unit, n, shares_error=shares_error),
        t=Number(tested.t, "1", df=tested.df, n=n),
        p=Number(p, "1", df=tested.df, n=n),
        n_control=found.n[0],
        n_treated=found.n[1],
        other=found.counts.control + found.counts.treated + found.counts.other_control + found.counts.other_treated - n,
        rejected=_rejected(p, alpha),
        savings=None if savings is None else _number(savings, "%", n, shares_error=shares_error),
        one_sided=one_sided,
    )


def p_of(tested: Estimate, one_sided: bool) -> float | Undefined:
    """Return the p of an estimate against any difference, or against one above 0 alone."""
    if not one_sided or isinstance(tested.t, Undefined) or isinstance(tested.df, Undefined):
        return tested.p
    return t_upper(tested.t, tested.df).p


def _number(found: Estimate, unit: str, n: int, *, shares_error: bool) -> Number:
    low, high = interval_ends(found.ci)
    errs = shares_error or (isinstance(found.shared_se, float) and found.shared_se > 0.0)
    shared = found.shared_se if errs else None
    return Number(found.value, unit, found.se, shared, low, high, found.level, df=found.df, n=n)


def _rejected(p: float | Undefined, alpha: float) -> bool | None:
    return None if isinstance(p, Undefined) else p <= alpha


def _equivalent(pair: Pair, bounds: Bounds, alpha: float) -> EquivalenceResult:
    return equivalence_by_contrast(contrast_of(pair), bounds, alpha)


def equivalence_by_contrast(contrast: Contrast, bounds: Bounds, alpha: float) -> EquivalenceResult:
    """Test by a contrast of values in m whether the difference lies within the bounds."""
    found = contrast.equivalence(bounds.low, bounds.high, alpha, percent=bounds.percent)
    return EquivalenceResult(**_within(found, bounds, alpha, sum(contrast.n)))


def _overall_equivalent(groups: Mapping[str, Contrast], bounds: Bounds, alpha: float) -> OverallEquivalenceResult:
    found = overall_equivalence(groups, bounds.low, bounds.high, alpha)
    scope = found.scope
    return OverallEquivalenceResult(
        **_within(found.bounded, bounds, alpha, scope.n),
        groups=scope.groups,
        left_out=scope.left_out,
        days=scope.days,
        days_measured_only=scope.days_measured_only,
    )


def _within(found: Bounded, bounds: Bounds, alpha: float, n: int) -> dict[str, Any]:
    """Return the fields of `EquivalenceResult`."""
    t_low, p_low = one_sided(found.t_low, found.p_low, found.df, n)
    t_high, p_high = one_sided(found.t_high, found.p_high, found.df, n)
    return {
        "estimate": estimate_within(found.value, found.ci, bounds, alpha, n),
        "t_low": t_low,
        "p_low": p_low,
        "t_high": t_high,
        "p_high": p_high,
        "p": Number(found.p, "1", n=n),
        "equivalent": None if isinstance(found.equivalent, Undefined) else found.equivalent,
        **asdict(bounds),
    }


def _overall(found: OverallSavings, alpha: float, one_sided: bool) -> OverallResult:
    estimate, scope = found.estimate, found.scope
    p = p_of(estimate, one_sided)
    apart = found.heterogeneity
    p_same = apart if isinstance(apart, Undefined) else apart.p
    return OverallResult(
        savings=_number(estimate, "%", scope.n, shares_error=True),
        t=Number(estimate.t, "1", df=estimate.df, n=scope.n),
        p=Number(p, "1", df=estimate.df, n=scope.n),
        spread=Number(found.spread_percent, "%", n=len(scope.groups)),
        heterogeneity_p=Number(p_same, "1", n=len(scope.groups)),
        groups=scope.groups,
        left_out=scope.left_out,
        days=scope.days,
        days_measured_only=scope.days_measured_only,
        rejected=_rejected(p, alpha),
        differ=_rejected(p_same, alpha),
        one_sided=one_sided,
    )
