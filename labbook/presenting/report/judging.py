"""Predictions judged by their signed bias, group by group and jointly, from the levels that a report shows.

Rows that pool levels are left out: they hold nothing that the levels do not. A level counts where its measured mean
and its prediction have errors.
"""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.vocabulary import Undefined
from reports.evidence import POOLED
from reports.predicted import Judged, JudgedGroup, PredictedQuantity, Prediction
from stats.compare.bias import PredictedLevel, bias_of_group, joint_bias

_JUDGED = (PredictedQuantity.JOULES, PredictedQuantity.APEX)
"""Quantities of a condition; savings are made of its joules, and judging them too would count these twice."""


def judged(items: Sequence[Prediction]) -> tuple[Judged, ...]:
    """Judge each quantity that was predicted; one without a level to compare is left out."""
    found = ((quantity, _groups([item for item in items if item.quantity is quantity])) for quantity in _JUDGED)
    return tuple(
        Judged(quantity, groups, joint_bias([group.found for group in groups])) for quantity, groups in found if groups
    )


def _groups(items: Sequence[Prediction]) -> tuple[JudgedGroup, ...]:
    of_group: dict[tuple[tuple[str, str], ...], list[Prediction]] = {}
    for item in items:
        if item.level != POOLED:
            of_group.setdefault(tuple(item.group.items()), []).append(item)
    found = ((group, [level for item in group if (level := _level(item)) is not None]) for group in of_group.values())
    return tuple(JudgedGroup(tuple(group), bias_of_group(levels)) for group, levels in found if levels)


def _level(item: Prediction) -> PredictedLevel | None:
    measured, predicted, shared = item.measured, item.predicted, item.measured.shared_se
    values = (measured.value, measured.se, predicted.value, predicted.se, shared or 0.0)
    numbers = [value for value in values if value is not None and not isinstance(value, Undefined)]
    return PredictedLevel(*numbers) if len(numbers) == len(values) else None
