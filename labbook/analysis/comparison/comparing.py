"""Comparisons of treated with control runs, on run means: tests, differences, savings, analysis of variance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.queries.results import InputRow, ResultRow
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.results.result_cache import (
    Algorithm,
    Computed,
    NewNumber,
    Request,
    ResultCache,
    ends_of,
    result_fingerprint,
)
from stats.compare.savings import Savings, percent_savings
from stats.compare.shared_error import SharedError, difference_with_shared, shared_of_mean
from stats.compare.summary import describe
from stats.compare.two_sample import compare_two
from stats.groups.anova import one_way_anova
from stats.groups.variances import brown_forsythe

COMPARISON = Algorithm("comparison", 16)
ANOVA = Algorithm("anova", 16)


@dataclass(frozen=True, slots=True)
class Pair:
    """Two sets of conditions to compare: `a` is the control or the first level, `b` what is compared with it.

    Savings are stored where `with_savings` is set and the quantity is joules.
    """

    family: str
    label: str
    group: Mapping[str, str]
    level: str
    a: tuple[ConditionValues, ...]
    b: tuple[ConditionValues, ...]
    with_savings: bool = True


def compare(
    cache: ResultCache, pairs: Sequence[Pair], quantity: Outcome, scope: Mapping[str, Any], alpha: float = 0.05
) -> list[ResultRow]:
    """Ensure the comparison of every pair, in order; the F-test decides at alpha, intervals have level 1 - alpha.

    The payload says whether Welch's p is at most alpha (`rejected`), and whether the interval of the savings, which is
    not that of the difference, shows a saving or a cost (`savings_shown`).
    """
    return cache.ensure(
        [
            Request(
                COMPARISON,
                {"quantity": str(quantity), "family": pair.family, "label": pair.label, **scope},
                fingerprints_of_sides(pair),
                {"with_savings": _has_savings(pair, quantity), "alpha": alpha},
                lambda pair=pair: _compared(pair, quantity, alpha),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


def analyse_variance(
    cache: ResultCache,
    label: str,
    conditions: Sequence[ConditionValues],
    swept: str,
    quantity: Outcome,
    scope: Mapping[str, Any],
) -> ResultRow:
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


def values_of(side: Sequence[ConditionValues]) -> list[float]:
    """Return the numbers of a side's runs."""
    return [value for condition in side for value in condition.values]


def shared_by(side: Sequence[ConditionValues]) -> SharedError:
    """Return what the mean over a side's runs takes from the drain lines."""
    return shared_of_mean([item.shared for condition in side for item in condition.runs])


def _compared(pair: Pair, quantity: Outcome, alpha: float) -> Computed:
    a, b, level = values_of(pair.a), values_of(pair.b), 1.0 - alpha
    unit = quantity.unit
    test, spreads = compare_two(b, a, "f_then_t", alpha), brown_forsythe({"a": b, "b": a})
    shared = shared_by(pair.b).minus(shared_by(pair.a))
    chosen = difference_with_shared(test.t, test.df, test.p, test.difference_ci, shared, level)
    welch = difference_with_shared(test.welch_t, test.welch_df, test.welch_p, test.welch_ci, shared, level)
    shown_se = shared.se if quantity.shares_error else None
    total = len(a) + len(b)
    numbers = [
        NewNumber("f", test.f, "1", n=total),
        NewNumber("f_p", test.f_p, "1", n=total),
        NewNumber("brown_forsythe", spreads.statistic, "1", n=total),
        NewNumber("brown_forsythe_p", spreads.p, "1", n=total),
        NewNumber("t", chosen.t, "1", df=chosen.df, n=total),
        NewNumber("p", chosen.p, "1", df=chosen.df, n=total),
        NewNumber(
            "difference", test.difference, unit, shared_se=shown_se, ci_low=chosen.ci_low, ci_high=chosen.ci_high,
            ci_level=level, df=chosen.df, n=total,
        ),
        NewNumber("welch_t", welch.t, "1", df=welch.df, n=total),
        NewNumber("welch_p", welch.p, "1", df=welch.df, n=total),
        NewNumber(
            "welch_difference", test.difference, unit, shared_se=shown_se, ci_low=welch.ci_low, ci_high=welch.ci_high,
            ci_level=level, df=welch.df, n=total,
        ),
        NewNumber("hedges_g", test.hedges_g, "1", n=total),
    ]  # fmt: skip
    for name, about in (("a", describe(a)), ("b", describe(b))):
        numbers.append(NewNumber(f"mean_{name}", about.mean, unit, n=about.n))
        numbers.append(NewNumber(f"sd_{name}", about.sd, unit, n=about.n))
    rejected = None if isinstance(welch.p, Undefined) else welch.p <= alpha
    payload = {"test": test.test, "n_a": len(a), "n_b": len(b), "rejected": rejected}
    if _has_savings(pair, quantity):
        saved = percent_savings(
            a, b, shared_in_control=shared_by(pair.a), shared_in_treated=shared_by(pair.b), level=level
        )
        numbers.append(_savings(saved))
        payload["savings_shown"] = None if isinstance(saved.shown, Undefined) else saved.shown
    return Computed(tuple(numbers), payload)


def _has_savings(pair: Pair, quantity: Outcome) -> bool:
    return pair.with_savings and quantity.has_savings


def _savings(saved: Savings) -> NewNumber:
    low, high = ends_of(saved.percent_ci)
    shared_se = saved.shared_se_percent
    return NewNumber(
        "savings", saved.percent, "%", saved.se_percent, None if isinstance(shared_se, Undefined) else shared_se,
        low, high, saved.level, df=saved.df, n=saved.n_control + saved.n_treated,
    )  # fmt: skip


def _analysed(groups: Mapping[str, Sequence[float]]) -> Computed:
    found = one_way_anova(groups)
    total = sum(found.group_ns)
    return Computed(
        (
            NewNumber("f", found.f, "1", n=total),
            NewNumber("p", found.p, "1", n=total),
            NewNumber("eta_squared", found.eta_squared, "1", n=total),
        ),
        {"df_between": found.df_between, "df_within": found.df_within, "n": total},
    )
