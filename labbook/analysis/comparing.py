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
from stats.two_sample import compare_two

COMPARISON = Algorithm(
    "comparison",
    1,
    ("labbook.analysis.comparing", "stats.two_sample", "stats.savings", "stats.sums", "stats.distributions"),
)
ANOVA = Algorithm("anova", 1, ("labbook.analysis.comparing", "stats.anova", "stats.sums"))


@dataclass(frozen=True, slots=True)
class Pair:
    """Two sets of conditions to compare: `a` is the control or the first level, `b` what is compared with it."""

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
                {"with_savings": pair.with_savings},
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
    low, high = _interval(test.difference_ci)
    welch_low, welch_high = _interval(test.welch_ci)
    total = len(a) + len(b)
    numbers = [
        NewNumber("f", test.f, "1", n=total),
        NewNumber("f_p", test.f_p, "1", n=total),
        NewNumber("brown_forsythe_p", test.brown_forsythe_p, "1", n=total),
        NewNumber("t", test.t, "1", df=test.df, n=total),
        NewNumber("p", test.p, "1", df=test.df, n=total),
        NewNumber("difference", test.difference, unit, ci_low=low, ci_high=high, ci_level=0.95, df=test.df, n=total),
        NewNumber("welch_t", test.welch_t, "1", df=test.welch_df, n=total),
        NewNumber("welch_p", test.welch_p, "1", df=test.welch_df, n=total),
        NewNumber(
            "welch_difference", test.difference, unit, ci_low=welch_low, ci_high=welch_high, ci_level=0.95,
            df=test.welch_df, n=total,
        ),
        NewNumber("hedges_g", test.hedges_g, "1", n=total),
    ]  # fmt: skip
    if pair.with_savings:
        numbers.append(_savings(pair, a, b))
    return Outcome(tuple(numbers), {"test": test.test, "n_a": len(a), "n_b": len(b)})


def _savings(pair: Pair, a: Sequence[float], b: Sequence[float]) -> NewNumber:
    shared = [item for condition in pair.a for item in condition.runs]
    treated = [item for condition in pair.b for item in condition.runs]
    control_se = _mean([item.shared_se for item in shared])
    treated_se = _mean([item.shared_se for item in treated])
    saved = percent_savings(
        a,
        b,
        shared_se=control_se or treated_se,
        shared_df=shared[0].shared_df if shared and control_se else float("inf"),
        shared_in_control=1.0 if control_se else 0.0,
        shared_in_treated=treated_se / control_se if control_se else 1.0,
    )
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


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values) if values else 0.0
