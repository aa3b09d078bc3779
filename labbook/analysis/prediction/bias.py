"""Predictions judged by their signed bias: of each group of conditions by day, and of all groups jointly."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.queries.sources import InputRow
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.pairing import group_label, place
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.results import Algorithm, Results, fingerprint, result_fingerprint
from reports.numbers import Number, Result
from reports.results import Judged, JudgedGroup, Limits, Prediction
from stats.compare.agreement import (
    FEWEST_DIFFERENCES,
    Bias,
    Interval,
    PredictedRun,
    bias_by_day,
    joint_p,
    limits_of_agreement,
)


@dataclass(frozen=True, slots=True)
class JointBiasResult(Result):
    """Whether no group is biased; `tau` is Kendall's, of the measured and the predicted order of groups."""

    p: Number
    tau: Number | None = None


BIAS = Algorithm("prediction_bias", 2)
JOINT_BIAS = Algorithm("joint_bias", 1)
LIMITS = Algorithm("limits_of_agreement", 1)


def judge(
    computed: Results,
    conditions: Sequence[ConditionValues],
    checked: Sequence[Prediction],
    outcome: Outcome,
    known: Mapping[str, Sequence[str]],
) -> list[Judged]:
    """Compute the bias of every group, the joint test, and limits of agreement over three conditions or more.

    `checked` has the check of each condition, `known` the labels of each factor, in whose order groups are returned.
    Conditions without a prediction are left out; without one that has one, nothing is judged.
    """
    both = [(condition, check) for condition, check in zip(conditions, checked, strict=True) if _predicted(check)]
    groups = grouped(both, [group_label(check.group) for _condition, check in both])
    if not groups:
        return []
    about = {"quantity": str(outcome)}
    results = [
        computed.record(BIAS, {"group": label, **about}, _inputs(items), _bias(items, outcome))
        for label, items in groups.items()
    ]
    of_groups = [result_fingerprint(label, result) for label, result in zip(groups, results, strict=True)]
    joint = computed.record(JOINT_BIAS, about, of_groups, _joint(results))
    limits = _limits(computed, checked, about, outcome.unit)
    in_order = sorted(results, key=lambda one: place(known, None, one.group))
    return [Judged(checked[0].quantity, tuple(in_order), joint.p, joint.tau, limits)]


def _limits(computed: Results, checked: Sequence[Prediction], about: Mapping[str, Any], unit: str) -> Limits | None:
    known = [(check, value) for check in checked if isinstance(value := check.check.difference.value, float)]
    if len(known) < FEWEST_DIFFERENCES:
        return None
    inputs = [result_fingerprint("predicted", check.check) for check, _value in known]
    return computed.record(LIMITS, about, inputs, _limits_result([value for _check, value in known], unit))


def _limits_result(differences: Sequence[float], unit: str) -> Limits:
    found = limits_of_agreement(differences)
    n, level = found.n, found.level
    return Limits(
        Number(found.mean, unit, found.se, None, *found.ci, level, df=n - 1, n=n),
        Number(found.low, unit, found.limit_se, None, *found.low_ci, level, df=n - 1, n=n),
        Number(found.high, unit, found.limit_se, None, *found.high_ci, level, df=n - 1, n=n),
    )


def _inputs(items: Sequence[tuple[ConditionValues, Prediction]]) -> list[InputRow]:
    runs = [item for condition, _check in items for item in condition.runs]
    return [
        *(result_fingerprint("predicted", check.check) for _condition, check in items),
        *(result_fingerprint(item.run.name, item.result) for item in runs),
        *(fingerprint("day", "run", item.run.uid, item.run.day) for item in runs),
    ]


def _predicted(check: Prediction) -> tuple[float, float] | None:
    """Return a prediction with its standard uncertainty, None where there is none."""
    value, se = check.check.predicted.value, check.check.predicted.se
    return (value, se) if isinstance(value, float) and isinstance(se, float) else None


def _bias(items: Sequence[tuple[ConditionValues, Prediction]], outcome: Outcome) -> JudgedGroup:
    found = bias_by_day(
        [
            PredictedRun(item.run.day, item.value, item.shared, *predicted)
            for condition, check in items
            if (predicted := _predicted(check)) is not None
            for item in condition.runs
        ]
    )
    p = found.in_all if isinstance(found.in_all, Undefined) else found.in_all.p
    return JudgedGroup(
        group=items[0][1].group,
        bias=_number(found, found.in_all, outcome.unit),
        of_measured=_number(found, found.of_measured, outcome.unit),
        p=Number(p, "1", n=found.n),
        measured=Number(found.measured, outcome.unit, n=found.n),
        predicted=Number(found.predicted, outcome.unit, n=found.n),
        days=found.days,
    )


def _number(found: Bias, about: Interval | Undefined, unit: str) -> Number:
    if isinstance(about, Undefined):
        return Number(found.bias, unit, n=found.n)
    df = about.df if math.isfinite(about.df) else None
    return Number(found.bias, unit, about.se, None, *about.ci, df=df, n=found.n)


def _joint(results: Sequence[JudgedGroup]) -> JointBiasResult:
    p = joint_p([result.p.value for result in results])
    n = sum(result.bias.n or 0 for result in results)
    pairs = list(itertools.combinations(results, 2))
    if not pairs:
        return JointBiasResult(Number(p, "1", n=n))
    agreeing = sum(_order(a.measured, b.measured) * _order(a.predicted, b.predicted) for a, b in pairs)
    return JointBiasResult(Number(p, "1", n=n), Number(agreeing / len(pairs), "1", n=len(results)))


def _order(a: Number, b: Number) -> int:
    """Return 1 where the second is higher, -1 where it is lower, else 0."""
    one, other = a.value, b.value
    return 0 if isinstance(one, Undefined) or isinstance(other, Undefined) else (other > one) - (other < one)
