"""The one test that decides each comparison, by the days that both sides share, and the effect over all groups."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparing import Pair, fingerprints_of_days, fingerprints_of_sides
from labbook.analysis.comparison.equivalence import EquivalenceResult
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.results.codec import Algorithm, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, ends_of
from labbook.config.model import Bounds
from reports.numbers import Number
from stats.days.decision import Contrast, Rule, contrast_by_day
from stats.days.decision_result import Bounded, Estimate
from stats.days.overall import OverallSavings, overall_equivalence, overall_savings


@dataclass(frozen=True, slots=True)
class DecisionResult(StoredResult):
    """A treatment against its control by `stats.days.decision`; `difference` is treatment less control.

    `t` and `p` are those of no difference, t positive for a saving where there are savings. `n_control` and `n_treated`
    count the runs on the shared `days`, which alone enter; the others are counted beside. `rejected` is None where
    nothing is tested.
    """

    rule: Rule
    days: tuple[str, ...]
    difference: Number
    t: Number
    p: Number
    n_control: int
    n_treated: int
    other_control: int
    other_treated: int
    rejected: bool | None
    savings: Number | None = None


@dataclass(frozen=True, slots=True)
class OverallResult(StoredResult):
    """The mean of the groups' savings, in percent, each group counted once; groups without a claim are `left_out`.

    `spread` is the standard deviation of the savings, `spread_of_errors` what the groups' errors alone make of it.
    """

    savings: Number
    t: Number
    p: Number
    spread: Number
    spread_of_errors: Number
    groups: tuple[str, ...]
    left_out: tuple[str, ...]
    days: tuple[str, ...]
    days_measured_only: bool
    rejected: bool | None


DECISION = Algorithm("decision", 1, DecisionResult)
DECISION_EQUIVALENCE = Algorithm("decision_equivalence", 1, EquivalenceResult)
OVERALL = Algorithm("overall_savings", 1, OverallResult)
OVERALL_EQUIVALENCE = Algorithm("overall_equivalence", 1, EquivalenceResult)


def contrast_of(pair: Pair) -> Contrast:
    """Return the contrast of a pair's runs by the rule that fits their days."""
    control, treated = _runs(pair.a), _runs(pair.b)
    return contrast_by_day(
        [item.value for item in treated],
        [item.value for item in control],
        days_treated=[item.run.day for item in treated],
        days_control=[item.run.day for item in control],
        shared_treated=[item.shared for item in treated],
        shared_control=[item.shared for item in control],
    )


def decide(
    cache: ResultCache, pairs: Sequence[Pair], quantity: Outcome, scope: Mapping[str, Any], alpha: float
) -> list[DecisionResult]:
    """Ensure the deciding test of every pair, in order; intervals have level 1 - alpha."""
    return cache.ensure(
        [
            Request(
                DECISION,
                {"quantity": str(quantity), "family": pair.family, "label": pair.label, **scope},
                (*fingerprints_of_sides(pair), *fingerprints_of_days(pair)),
                {"with_savings": _has_savings(pair, quantity), "alpha": alpha},
                lambda pair=pair: _decided(pair, quantity, alpha),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


def decide_equivalence(
    cache: ResultCache, pairs: Sequence[Pair], bounds: Bounds, alpha: float, scope: Mapping[str, Any]
) -> list[EquivalenceResult]:
    """Ensure the two one-sided tests of apex heights of every pair, in order, by the same contrast."""
    return cache.ensure(
        [
            Request(
                DECISION_EQUIVALENCE,
                {"quantity": str(Outcome.APEX), "family": pair.family, "label": pair.label, **scope},
                (*fingerprints_of_sides(pair), *fingerprints_of_days(pair)),
                {"alpha": alpha, "bounds": asdict(bounds)},
                lambda pair=pair: _equivalent(pair, bounds, alpha),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


@dataclass(frozen=True, slots=True)
class Overall:
    """The effect over all groups: savings by outcome, and whether apex heights changed within the bounds."""

    savings: Mapping[Outcome, OverallResult] = field(default_factory=dict)
    equivalent: EquivalenceResult | None = None


def overall_effects(
    cache: ResultCache,
    pairs: Mapping[Outcome, Mapping[str, Pair]],
    bounds: Bounds | None,
    alpha: float,
    scope: Mapping[str, Any],
) -> Overall:
    """Ensure the effects over all groups; `pairs` has those of each outcome by group. One group has none."""
    several = {outcome: of_group for outcome, of_group in pairs.items() if len(of_group) > 1}
    heights = several.get(Outcome.APEX)
    within = heights is not None and bounds is not None and bounds.percent
    return Overall(
        {
            outcome: _overall_savings(cache, of_group, outcome, scope, alpha)
            for outcome, of_group in several.items()
            if outcome.has_savings
        },
        _overall_within(cache, heights, bounds, alpha, scope) if within and heights and bounds else None,
    )


def _overall_savings(
    cache: ResultCache, pairs: Mapping[str, Pair], quantity: Outcome, scope: Mapping[str, Any], alpha: float
) -> OverallResult:
    return cache.ensure_one(
        Request(
            OVERALL,
            {"quantity": str(quantity), **scope},
            _fingerprints(pairs),
            {"alpha": alpha, "groups": list(pairs)},
            lambda: _overall(overall_savings(_contrasts(pairs), 1.0 - alpha), alpha, _n(pairs)),
        )
    )


def _overall_within(
    cache: ResultCache, pairs: Mapping[str, Pair], bounds: Bounds, alpha: float, scope: Mapping[str, Any]
) -> EquivalenceResult:
    return cache.ensure_one(
        Request(
            OVERALL_EQUIVALENCE,
            {"quantity": str(Outcome.APEX), **scope},
            _fingerprints(pairs),
            {"alpha": alpha, "bounds": asdict(bounds), "groups": list(pairs)},
            lambda: _bounded(
                overall_equivalence(_contrasts(pairs), bounds.low, bounds.high, alpha), bounds, _n(pairs), alpha
            ),
        )
    )


def _runs(side: Sequence[ConditionValues]) -> list[Any]:
    return [item for condition in side for item in condition.runs]


def _has_savings(pair: Pair, quantity: Outcome) -> bool:
    return pair.against_control and quantity.has_savings


def _contrasts(pairs: Mapping[str, Pair]) -> dict[str, Contrast]:
    return {name: contrast_of(pair) for name, pair in pairs.items()}


def _fingerprints(pairs: Mapping[str, Pair]) -> tuple[Any, ...]:
    return tuple(one for pair in pairs.values() for one in (*fingerprints_of_sides(pair), *fingerprints_of_days(pair)))


def _n(pairs: Mapping[str, Pair]) -> int:
    return sum(len(_runs(side)) for pair in pairs.values() for side in (pair.a, pair.b))


def _decided(pair: Pair, quantity: Outcome, alpha: float) -> DecisionResult:
    found, level = contrast_of(pair), 1.0 - alpha
    n = found.counts.entering
    difference = found.difference(level)
    savings = found.savings(level) if _has_savings(pair, quantity) else None
    tested = difference if savings is None else savings
    return DecisionResult(
        rule=found.rule,
        days=found.days,
        difference=_number(difference, quantity.unit, n, shares_error=quantity.shares_error),
        t=Number(tested.t, "1", df=tested.df, n=n),
        p=Number(tested.p, "1", df=tested.df, n=n),
        n_control=found.counts.control,
        n_treated=found.counts.treated,
        other_control=found.counts.other_control,
        other_treated=found.counts.other_treated,
        rejected=_rejected(tested.p, alpha),
        savings=None if savings is None else _number(savings, "%", n, shares_error=quantity.shares_error),
    )


def _number(found: Estimate, unit: str, n: int, *, shares_error: bool) -> Number:
    low, high = ends_of(found.ci)
    shared = found.shared_se if shares_error else None
    return Number(found.value, unit, found.se, shared, low, high, found.level, df=found.df, n=n)


def _rejected(p: float | Undefined, alpha: float) -> bool | None:
    return None if isinstance(p, Undefined) else p <= alpha


def _equivalent(pair: Pair, bounds: Bounds, alpha: float) -> EquivalenceResult:
    contrast = contrast_of(pair)
    found = contrast.equivalence(bounds.low, bounds.high, alpha, percent=bounds.percent)
    return _bounded(found, bounds, contrast.counts.entering, alpha)


def _bounded(found: Bounded, bounds: Bounds, n: int, alpha: float) -> EquivalenceResult:
    low, high = ends_of(found.ci)
    unit = "%" if bounds.percent else "m"

    def tested(value: float | Undefined) -> Number:
        return Number(value, "1", df=found.df, n=n)

    return EquivalenceResult(
        estimate=Number(found.value, unit, ci_low=low, ci_high=high, ci_level=1.0 - 2.0 * alpha, n=n),
        t_low=tested(found.t_low),
        p_low=tested(found.p_low),
        t_high=tested(found.t_high),
        p_high=tested(found.p_high),
        p=Number(found.p, "1", n=n),
        equivalent=None if isinstance(found.equivalent, Undefined) else found.equivalent,
        low=bounds.low,
        high=bounds.high,
        percent=bounds.percent,
    )


def _overall(found: OverallSavings, alpha: float, n: int) -> OverallResult:
    low, high = ends_of(found.ci)
    return OverallResult(
        savings=Number(
            found.percent, "%", found.se_percent, found.shared_se_percent, low, high, found.level, df=found.df, n=n
        ),
        t=Number(found.t, "1", df=found.df, n=n),
        p=Number(found.p, "1", df=found.df, n=n),
        spread=Number(found.spread_percent, "%", n=len(found.groups)),
        spread_of_errors=Number(found.spread_of_errors_percent, "%", n=len(found.groups)),
        groups=found.groups,
        left_out=found.left_out,
        days=found.days,
        days_measured_only=found.days_measured_only,
        rejected=_rejected(found.p, alpha),
    )
