"""The tables of a report; a new one is a function and a line here."""

from __future__ import annotations

from reports.tables.by_day import BY_DAY_APEX, BY_DAY_JOULES
from reports.tables.comparisons import COMPARISONS_APEX, COMPARISONS_JOULES, HEADLINES
from reports.tables.conditions import APEX_BY_CONDITION, JOULES_BY_CONDITION, RUN_VALUES
from reports.tables.equivalence import EQUIVALENCE
from reports.tables.measured import ASSUMED, DAYS, FLOW, PROVENANCE_IDS
from reports.tables.predictions import PREDICTED_APEX, PREDICTED_INPUTS, PREDICTED_JOULES, PREDICTED_SAVINGS
from reports.tables.table import TableKind
from reports.tables.tests_in_full import ANOVAS, TESTS_APEX, TESTS_JOULES, TESTS_JUMPS
from reports.tables.uncertainty import IDLE_RUNS, PACKS, PASSIVE_DRAIN, RUNS, SENSITIVITY, UNCERTAINTY_BUDGET

TABLES: dict[str, TableKind] = {
    kind.name: kind
    for kind in (
        HEADLINES,
        JOULES_BY_CONDITION,
        APEX_BY_CONDITION,
        COMPARISONS_JOULES,
        BY_DAY_JOULES,
        TESTS_JOULES,
        COMPARISONS_APEX,
        BY_DAY_APEX,
        EQUIVALENCE,
        TESTS_APEX,
        TESTS_JUMPS,
        ANOVAS,
        PREDICTED_JOULES,
        PREDICTED_APEX,
        PREDICTED_SAVINGS,
        PREDICTED_INPUTS,
        UNCERTAINTY_BUDGET,
        PASSIVE_DRAIN,
        PACKS,
        DAYS,
        ASSUMED,
        PROVENANCE_IDS,
        RUN_VALUES,
        IDLE_RUNS,
        RUNS,
        FLOW,
        SENSITIVITY,
    )
}
"""Table name -> table; the name is also the file's."""
