"""Comparisons of treated with control runs, on run means: tests, differences, savings, analysis of variance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from data_schema.queries.results import ResultRow
from data_schema.vocabulary import Undefined
from labbook.analysis.conditions import NUMBER_OF, ConditionValues
from labbook.analysis.workbench import Algorithm, NewNumber, Outcome, Request, Workbench, rests_on_result
from reports.numbers import Quantity
from stats.anova import one_way_anova
from stats.savings import percent_savings
from stats.shared_error import SharedError, difference_with_shared, shared_of_mean
from stats.two_sample import compare_two

COMPARISON = Algorithm(
    "comparison",
    7,
    (
        "labbook.analysis.comparing",
        "stats.two_sample",
        "stats.savings",
        "stats.shared_error",
        "stats.sums",
        "stats.distributions",
    ),
)
ANOVA = Algorithm("anova", 7, ("labbook.analysis.comparing", "stats.anova", "stats.sums"))

LEVEL = 0.95
"""Level of all intervals."""


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


def compare(bench: Workbench, pairs: Sequence[Pair], quantity: Quantity, scope: Mapping[str, Any]) -> list[ResultRow]:
    """Ensure the comparison of every pair, in order."""
    return bench.ensure(
        [
            Request(
                COMPARISON,
                {"quantity": str(quantity), "family": pair.family, "label": pair.label, **scope},
                tuple(
                    rests_on_result(role, condition.result)
                    for role, side in (("a", pair.a), ("b", pair.b))
                    for condition in side
                ),
                {"with_savings": _has_savings(pair, quantity)},
                lambda pair=pair: _compared(pair, quantity),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


def analyse_variance(
    bench: Workbench,
    label: str,
    conditions: Sequence[ConditionValues],
    swept: str,
    quantity: Quantity,
    scope: Mapping[str, Any],
) -> ResultRow:
    """Ensure the one-way analysis of variance over the levels of the swept factor."""
    groups = {condition.levels.get(swept, condition.key): condition.values for condition in conditions}
    return bench.ensure_one(
        Request(
            ANOVA,
            {"quantity": str(quantity), "label": label, **scope},
            tuple(rests_on_result("group", condition.result) for condition in conditions),
            {},
            lambda: _analysed(groups),
        )
    )


def _compared(pair: Pair, quantity: Quantity) -> Outcome:
    a = [value for condition in pair.a for value in condition.values]
    b = [value for condition in pair.b for value in condition.values]
    unit = NUMBER_OF[quantity][1]
    test = compare_two(b, a)
    shared = _shared(pair.b).minus(_shared(pair.a))
    chosen = difference_with_shared(test.t, test.df, test.p, test.difference_ci, shared, LEVEL)
    welch = difference_with_shared(test.welch_t, test.welch_df, test.welch_p, test.welch_ci, shared, LEVEL)
    shown_se = shared.se if quantity is Quantity.JOULES else None
    total = len(a) + len(b)
    numbers = [
        NewNumber("f", test.f, "1", n=total),
        NewNumber("f_p", test.f_p, "1", n=total),
        NewNumber("brown_forsythe_p", test.brown_forsythe_p, "1", n=total),
        NewNumber("t", chosen.t, "1", df=chosen.df, n=total),
        NewNumber("p", chosen.p, "1", df=chosen.df, n=total),
        NewNumber(
            "difference", test.difference, unit, shared_se=shown_se, ci_low=chosen.ci_low, ci_high=chosen.ci_high,
            ci_level=LEVEL, df=chosen.df, n=total,
        ),
        NewNumber("welch_t", welch.t, "1", df=welch.df, n=total),
        NewNumber("welch_p", welch.p, "1", df=welch.df, n=total),
        NewNumber(
            "welch_difference", test.difference, unit, shared_se=shown_se, ci_low=welch.ci_low, ci_high=welch.ci_high,
            ci_level=LEVEL, df=welch.df, n=total,
        ),
        NewNumber("hedges_g", test.hedges_g, "1", n=total),
    ]  # fmt: skip
    if _has_savings(pair, quantity):
        numbers.append(_savings(pair, a, b))
    return Outcome(tuple(numbers), {"test": test.test, "n_a": len(a), "n_b": len(b)})


def _shared(side: Sequence[ConditionValues]) -> SharedError:
    """Return what the mean over a side's runs takes from the drain lines."""
    return shared_of_mean([item.shared for condition in side for item in condition.runs])


def _has_savings(pair: Pair, quantity: Quantity) -> bool:
    return pair.with_savings and quantity is Quantity.JOULES


def _savings(pair: Pair, a: Sequence[float], b: Sequence[float]) -> NewNumber:
    saved = percent_savings(a, b, shared_in_control=_shared(pair.a), shared_in_treated=_shared(pair.b))
    low, high = _interval(saved.percent_ci)
    shared_se = saved.shared_se_percent
    return NewNumber(
        "savings", saved.percent, "%", saved.se_percent, None if isinstance(shared_se, Undefined) else shared_se,
        low, high, saved.level, df=saved.df, n=len(a) + len(b),
    )  # fmt: skip


def _analysed(groups: Mapping[str, Sequence[float]]) -> Outcome:
    found = one_way_anova(groups)
    total = sum(found.group_ns)
    return Outcome(
        (
            NewNumber("f", found.f, "1", n=total),
            NewNumber("p", found.p, "1", n=total),
            NewNumber("eta_squared", found.eta_squared, "1", n=total),
        ),
        {"df_between": found.df_between, "df_within": found.df_within, "n": total},
    )


def _interval(ends: tuple[float, float] | Undefined) -> tuple[float | Undefined, float | Undefined]:
    return (ends, ends) if isinstance(ends, Undefined) else ends
