"""What belongs to the planned family beside a selection: Holm's p counts comparisons that a report does not show.

Without it a report on one foot would have smaller adjusted p-values than the report on both from the same data.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

from data_schema.outcomes import Outcome
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues, condition_values, run_numbers
from labbook.analysis.outcomes.detections import Detections
from labbook.analysis.outcomes.measuring import measure
from labbook.analysis.results.result_cache import ResultCache
from labbook.analysis.study_data import StudyData


def unselected_conditions_of(
    cache: ResultCache,
    detections: Detections,
    evidence: StudyData,
    outcomes: Collection[Outcome],
    scope: Mapping[str, Any],
) -> dict[Outcome, list[ConditionValues]]:
    """Ensure the numbers of the conditions of which the selection takes no run."""
    if not evidence.beside:
        return {}
    other = replace(evidence, runs=evidence.beside)
    return {
        outcome: condition_values(cache, run_numbers(other.runs, found.results, outcome), outcome, scope)
        for outcome in outcomes
        for found in [measure(outcome, cache, detections, other)]
    }


def unselected_pairs(
    pairs: Sequence[Pair], conditions: Sequence[ConditionValues], beside: Sequence[ConditionValues], swept: str
) -> list[Pair]:
    """Return the comparisons with the control that the conditions of all make, and those of the selection do not."""
    shown = {pair.label for pair in pairs}
    every = pairing.pairs_with_control([*conditions, *beside], swept) if beside else []
    return [pair for pair in every if pair.label not in shown]
