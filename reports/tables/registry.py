"""The tables of a report; a new one is a function and a line here."""

from __future__ import annotations

from reports.results import StudyResults
from reports.tables.comparisons import ANOVAS, COMPARISONS, EQUIVALENCE, TESTS, TESTS_JUMPS
from reports.tables.conditions import BY_CONDITION
from reports.tables.contrasts import CONTRASTS
from reports.tables.each_run import EACH_RUN
from reports.tables.headlines import HEADLINES
from reports.tables.hypotheses import HYPOTHESES, HYPOTHESES_IN_FULL
from reports.tables.measured import (
    ASSUMED,
    DAYS,
    FLOW,
    IDLE_RUNS,
    PACKS,
    PASSIVE_DRAIN,
    PROVENANCE_IDS,
    SENSITIVITY,
    UNCERTAINTY_BUDGET,
)
from reports.tables.predictions import LIMITS_OF_AGREEMENT, PREDICTED, PREDICTED_INPUTS, PREDICTION_BIAS
from reports.tables.table import TableKind

TABLES: dict[str, TableKind] = {
    kind.name: kind
    for kind in (
        HEADLINES,
        *BY_CONDITION,
        *(kind for of_outcome in zip(COMPARISONS, TESTS, strict=True) for kind in of_outcome),
        CONTRASTS,
        EQUIVALENCE,
        TESTS_JUMPS,
        ANOVAS,
        HYPOTHESES,
        HYPOTHESES_IN_FULL,
        PREDICTION_BIAS,
        LIMITS_OF_AGREEMENT,
        *PREDICTED,
        PREDICTED_INPUTS,
        UNCERTAINTY_BUDGET,
        PASSIVE_DRAIN,
        PACKS,
        DAYS,
        ASSUMED,
        PROVENANCE_IDS,
        EACH_RUN,
        IDLE_RUNS,
        FLOW,
        SENSITIVITY,
    )
}
"""Table name -> table; the name is also the file's."""


def tables_of(results: StudyResults) -> list[TableKind]:
    """Return the tables of a report, those of outcomes that it has not left out."""
    return [kind for kind in TABLES.values() if kind.outcome is None or kind.outcome in results.outcomes]
