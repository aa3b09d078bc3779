"""Comparisons of treated with control runs, on run means: tests, differences, savings, equivalence, variance."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.queries.results import InputRow
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues, by_day
from labbook.analysis.outcomes.run_apexes import RunApexes
from labbook.analysis.results.codec import Algorithm, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, fingerprint, interval_ends, result_fingerprint
from labbook.config.model import AnalysisSettings, Bounds, UnitOfAnalysis
from reports.numbers import Number
from stats.compare.equivalence import equivalence
from stats.compare.savings import Savings, percent_savings
from stats.compare.shared_error import SharedError, SharedTest, difference_with_shared, shared_of_mean
from stats.compare.summary import describe
from stats.compare.two_sample import compare_two
from stats.exact.tails import t_upper
from stats.groups.anova import one_way_anova
from stats.groups.variances import brown_forsythe


@dataclass(frozen=True, slots=True)
class ComparisonResult(StoredResult):
    """A comparison on run means: a is the control, b what is compared with it, a difference b - a.

    `test` is what the F-test chose, "Student" or "Welch", and `t`, `p`, `difference` are its; Welch's stand beside.
    `rejected` says whether Welch's p is at most alpha, `savings_shown` whether the interval of the savings, which is
    not that of the difference, shows a saving or a cost; None where there is no such p or interval. `one_sided` where
    Welch's p is against a saving alone: intervals have level 1 - 2 alpha, and no cost is shown.
    """

    f: Number
    f_p: Number
    brown_forsythe: Number
    brown_forsythe_p: Number
    t: Number
    p: Number
    difference: Number
    welch_t: Number
    welch_p: Number
    welch_difference: Number
    hedges_g: Number
    mean_a: Number
    sd_a: Number
    mean_b: Number
    sd_b: Number
    test: str
    n_a: int
    n_b: int
    rejected: bool | None
    savings: Number | None = None
    savings_shown: bool | None = None
    one_sided: bool = False


@dataclass(frozen=True, slots=True)
class AnovaResult(StoredResult):
    """A one-way analysis of variance over `n` values."""

    f: Number
    p: Number
    eta_squared: Number
    df_between: int
    df_within: int
    n: int


COMPARISON = Algorithm("comparison", 18, ComparisonResult)
ANOVA = Algorithm("anova", 16, AnovaResult)


def compare(
    cache: ResultCache,
    pairs: Sequence[Pair],
    quantity: Outcome,
    scope: Mapping[str, Any],
    alpha: float = 0.05,
    *,
    one_sided: bool = False,
) -> list[ComparisonResult]:
    """Ensure the comparison of every pair, in order; see `compare_pair`."""
    return cache.ensure(
        [
            Request(
                COMPARISON,
                {"quantity": str(quantity), "family": pair.family, "label": pair.label, **scope},
                fingerprints_of_sides(pair),
                {"with_savings": quantity.has_savings, "alpha": alpha, "one_sided": one_sided},
                lambda pair=pair: compare_pair(pair, quantity, alpha, one_sided=one_sided),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


def welch_one_sided(settings: AnalysisSettings) -> bool:
    """Whether Welch's test of a saving is one-sided; where shared days decide, it stands beside, two-sided."""
    return settings.one_sided and settings.unit_of_analysis is not UnitOfAnalysis.SHARED_DAYS


def analyse_variance(
    cache: ResultCache,
    label: str,
    conditions: Sequence[ConditionValues],
    swept: str,
    quantity: Outcome,
    scope: Mapping[str, Any],
) -> AnovaResult:
    """Ensure the one-way analysis of variance over the levels of the swept factor."""
    groups = {condition.levels.get(swept, condition.key): condition.values for condition in conditions}
    return cache.ensure_one(
        Request(
            ANOVA,
            {"quantity": str(quantity), "label": label, **scope},
            tuple(result_fingerprint("group", condition.result) for condition in conditions),
            {},
            lambda: _analysed(groups),
        )
    )


def fingerprints_of_sides(pair: Pair) -> tuple[InputRow, ...]:
    """Name the conditions of both sides."""
    sides = (("a", pair.a), ("b", pair.b))
    return tuple(result_fingerprint(role, condition.result) for role, side in sides for condition in side)


def fingerprints_of_days(pair: Pair) -> list[InputRow]:
    """Name the day of every run: a run's own number does not change with it."""
    runs = {item.run.uid: item.run for side in (pair.a, pair.b) for condition in side for item in condition.runs}
    return [fingerprint("day", "run", run.uid, run.day) for run in runs.values()]


def values_of(side: Sequence[ConditionValues]) -> list[float]:
    """Return the numbers of a side's runs."""
    return [value for condition in side for value in condition.values]


def shared_error_of_side(side: Sequence[ConditionValues]) -> SharedError:
    """Return what the mean over a side's runs takes from the drain lines."""
    return shared_of_mean([item.shared for condition in side for item in condition.runs])


def pairs_in_units(
    cache: ResultCache, pairs: Sequence[Pair], quantity: Outcome, unit: UnitOfAnalysis, scope: Mapping[str, Any]
) -> list[Pair]:
    """Return the pairs with one number a unit of analysis: as they are, or a mean of each day's runs on each side.

    Where levels are pooled, a day's runs of all of them make one mean: they have the day in common.
    """
    if unit is not UnitOfAnalysis.DAY:
        return list(pairs)
    sides = by_day(cache, [side for pair in pairs for side in (pair.a, pair.b)], quantity, scope)
    both = zip(sides[::2], sides[1::2], strict=True)
    return [replace(pair, a=(a,), b=(b,)) for pair, (a, b) in zip(pairs, both, strict=True)]


def compare_pair(pair: Pair, quantity: Outcome, alpha: float, *, one_sided: bool = False) -> ComparisonResult:
    """Compare the values of a pair; the F-test decides at alpha, intervals have level 1 - alpha.

    One-sided, savings are tested by Welch against a saving alone, and intervals have level 1 - 2 alpha.
    """
    with_savings = quantity.has_savings
    one_sided = one_sided and with_savings
    a, b, level = values_of(pair.a), values_of(pair.b), 1.0 - (2.0 * alpha if one_sided else alpha)
    test, spreads = compare_two(b, a, "f_then_t", alpha), brown_forsythe({"a": b, "b": a})
    welch_ci = compare_two(b, a, "f_then_t", 1.0 - level).welch_ci if one_sided else test.welch_ci
    shared = shared_error_of_side(pair.b).minus(shared_error_of_side(pair.a))
    chosen = difference_with_shared(test.t, test.df, test.p, test.difference_ci, shared, 1.0 - alpha)
    welch = difference_with_shared(test.welch_t, test.welch_df, test.welch_p, welch_ci, shared, level)
    welch_p = welch.p
    if one_sided and isinstance(welch.t, float) and isinstance(welch.df, float):
        welch_p = t_upper(-welch.t, welch.df).p
    saved = None
    if with_savings:
        saved = percent_savings(
            a,
            b,
            shared_in_control=shared_error_of_side(pair.a),
            shared_in_treated=shared_error_of_side(pair.b),
            level=level,
        )
    total, of_a, of_b = len(a) + len(b), describe(a), describe(b)

    def tested(value: float | Undefined, df: float | Undefined | None = None) -> Number:
        return Number(value, "1", df=df, n=total)

    def difference(by: SharedTest) -> Number:
        return Number(
            test.difference,
            quantity.unit,
            shared_se=shared.se if quantity.shares_error or shared.se else None,
            ci_low=by.ci_low,
            ci_high=by.ci_high,
            ci_level=by.level,
            df=by.df,
            n=total,
        )

    shown = None if saved is None or isinstance(saved.shown, Undefined) else saved.shown
    if one_sided and shown is not None and saved is not None and isinstance(saved.percent, float):
        shown = shown and saved.percent > 0.0
    return ComparisonResult(
        f=tested(test.f),
        f_p=tested(test.f_p),
        brown_forsythe=tested(spreads.statistic),
        brown_forsythe_p=tested(spreads.p),
        t=tested(chosen.t, chosen.df),
        p=tested(chosen.p, chosen.df),
        difference=difference(chosen),
        welch_t=tested(welch.t, welch.df),
        welch_p=tested(welch_p, welch.df),
        welch_difference=difference(welch),
        hedges_g=tested(test.hedges_g),
        mean_a=Number(of_a.mean, quantity.unit, n=of_a.n),
        sd_a=Number(of_a.sd, quantity.unit, n=of_a.n),
        mean_b=Number(of_b.mean, quantity.unit, n=of_b.n),
        sd_b=Number(of_b.sd, quantity.unit, n=of_b.n),
        test=test.test,
        n_a=len(a),
        n_b=len(b),
        rejected=None if isinstance(welch_p, Undefined) else welch_p <= alpha,
        savings=None if saved is None else _savings(saved),
        savings_shown=shown,
        one_sided=one_sided,
    )


def _savings(saved: Savings) -> Number:
    low, high = interval_ends(saved.percent_ci)
    return Number(
        saved.percent, "%", saved.se_percent, saved.shared_se_percent, low, high, saved.level, df=saved.df,
        n=saved.n_control + saved.n_treated,
    )  # fmt: skip


def _analysed(groups: Mapping[str, Sequence[float]]) -> AnovaResult:
    found = one_way_anova(groups)
    n = sum(found.group_ns)
    return AnovaResult(
        f=Number(found.f, "1", n=n),
        p=Number(found.p, "1", n=n),
        eta_squared=Number(found.eta_squared, "1", n=n),
        df_between=found.df_between,
        df_within=found.df_within,
        n=n,
    )


@dataclass(frozen=True, slots=True)
class JumpComparison(StoredResult):
    """A comparison over single jumps, with the fields of `ComparisonResult` that it shares."""

    f: Number
    f_p: Number
    t: Number
    p: Number
    welch_t: Number
    welch_p: Number
    difference: Number
    welch_difference: Number
    test: str
    n_a: int
    n_b: int


OVER_JUMPS = Algorithm("jump_comparison", 12, JumpComparison)


def compare_jumps(
    cache: ResultCache, pairs: Sequence[Pair], scope: Mapping[str, Any], alpha: float = 0.05
) -> list[JumpComparison]:
    """Ensure the comparison of every pair of apex heights over all their jumps, in order."""
    return cache.ensure(
        [
            Request(
                OVER_JUMPS,
                {"label": pair.label, **scope},
                tuple(
                    result_fingerprint(role, item.result)
                    for role, side in (("a", pair.a), ("b", pair.b))
                    for condition in side
                    for item in condition.runs
                ),
                {"alpha": alpha},
                lambda pair=pair: _over_jumps(pair, alpha),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


def _over_jumps(pair: Pair, alpha: float) -> JumpComparison:
    a, b = _heights_m(pair.a), _heights_m(pair.b)
    test = compare_two(b, a, "f_then_t", alpha)
    total = len(a) + len(b)

    def tested(value: float | Undefined, df: float | Undefined | None = None) -> Number:
        return Number(value, "1", df=df, n=total)

    def difference(interval: tuple[float, float] | Undefined, df: float | Undefined) -> Number:
        low, high = interval_ends(interval)
        return Number(test.difference, "m", ci_low=low, ci_high=high, ci_level=1.0 - alpha, df=df, n=total)

    return JumpComparison(
        f=tested(test.f),
        f_p=tested(test.f_p),
        t=tested(test.t, test.df),
        p=tested(test.p, test.df),
        welch_t=tested(test.welch_t, test.welch_df),
        welch_p=tested(test.welch_p, test.welch_df),
        difference=difference(test.difference_ci, test.df),
        welch_difference=difference(test.welch_ci, test.welch_df),
        test=test.test,
        n_a=len(a),
        n_b=len(b),
    )


def _heights_m(side: Sequence[ConditionValues]) -> list[float]:
    results = [item.result for condition in side for item in condition.runs]
    return [height_m for result in results if isinstance(result, RunApexes) for height_m in result.heights_m]


@dataclass(frozen=True, slots=True)
class EquivalenceResult(StoredResult):
    """Two one-sided tests against bounds, in m or in % of the control's mean (`percent`); `estimate` in their unit.

    `equivalent` says whether both are rejected; None where there is no test.
    """

    estimate: Number
    t_low: Number
    p_low: Number
    t_high: Number
    p_high: Number
    p: Number
    equivalent: bool | None
    low: float
    high: float
    percent: bool


EQUIVALENCE = Algorithm("equivalence", 9, EquivalenceResult)


def within_bounds(
    cache: ResultCache, pairs: Sequence[Pair], bounds: Bounds, alpha: float, scope: Mapping[str, Any]
) -> list[EquivalenceResult]:
    """Ensure the test of every pair of apex heights by Welch, in order; its interval has level 1 - 2 alpha."""
    return ensure_equivalence(cache, EQUIVALENCE, pairs, bounds, alpha, scope, fingerprints_of_sides, _equivalence)


def ensure_equivalence(
    cache: ResultCache,
    algorithm: Algorithm[EquivalenceResult],
    pairs: Sequence[Pair],
    bounds: Bounds,
    alpha: float,
    scope: Mapping[str, Any],
    inputs: Callable[[Pair], tuple[InputRow, ...]],
    test: Callable[[Pair, Bounds, float], EquivalenceResult],
) -> list[EquivalenceResult]:
    """Ensure a test of every pair of apex heights against the bounds, in order."""
    return cache.ensure(
        [
            Request(
                algorithm,
                {"quantity": str(Outcome.APEX), "family": pair.family, "label": pair.label, **scope},
                inputs(pair),
                {"alpha": alpha, "bounds": asdict(bounds)},
                lambda pair=pair: test(pair, bounds, alpha),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


def one_sided(t: float | Undefined, p: float | Undefined, df: float | Undefined, n: int) -> tuple[Number, Number]:
    """Return the statistic and the p of a one-sided test."""
    return Number(t, "1", df=df, n=n), Number(p, "1", df=df, n=n)


def _equivalence(pair: Pair, bounds: Bounds, alpha: float) -> EquivalenceResult:
    found = equivalence(
        values_of(pair.b), values_of(pair.a), low=bounds.low, high=bounds.high,
        bounds="percent" if bounds.percent else "raw", alpha=alpha,
    )  # fmt: skip
    welch, n = found.welch, found.n_a + found.n_b
    return EquivalenceResult(
        estimate_within(found.estimate, welch.estimate_ci, bounds, alpha, n),
        *one_sided(welch.t_low, welch.p_low, welch.df_low, n),
        *one_sided(welch.t_high, welch.p_high, welch.df_high, n),
        Number(welch.p, "1", n=n),
        None if isinstance(welch.equivalent, Undefined) else welch.equivalent,
        bounds.low,
        bounds.high,
        bounds.percent,
    )


def estimate_within(
    value: float | Undefined, ci: tuple[float, float] | Undefined, bounds: Bounds, alpha: float, n: int
) -> Number:
    """Return an estimate in the unit of the bounds, with its interval of level 1 - 2 alpha."""
    low, high = interval_ends(ci)
    return Number(value, "%" if bounds.percent else "m", ci_low=low, ci_high=high, ci_level=1.0 - 2.0 * alpha, n=n)
