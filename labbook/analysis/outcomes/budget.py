"""Where the uncertainty of a joule comes from, shown on the condition with the most runs."""

from __future__ import annotations

import math
from collections.abc import Sequence

from data_schema.queries.results import ResultRow
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.outcomes.energy import energy_budget
from labbook.analysis.outcomes.run_energy import usable_charge
from labbook.analysis.results.result_cache import (
    Algorithm,
    Computed,
    NewNumber,
    Request,
    ResultCache,
    fingerprint,
    result_fingerprint,
)
from labbook.analysis.study_data import StudyData
from stats.compare.shared_error import shared_of_mean

ALGORITHM = Algorithm("energy_budget", 14)

IN_ALL = "in all"
ONE_MAH = "1 mAh"
"""Names of numbers of the budget: the sum of all sources, and what a step of the charger is worth."""


def of_mean(name: str) -> str:
    """Name what a source gives the mean over the runs; its own name is what it gives one run."""
    return f"{name}, mean"


def budget(
    cache: ResultCache,
    evidence: StudyData,
    conditions: Sequence[ConditionValues],
    scope: dict[str, str],
) -> ResultRow | None:
    """Ensure the budget of one run's joules; None without joules."""
    if not conditions:
        return None
    condition = max(conditions, key=lambda item: len(item.runs))
    resolution_mah = _resolution_mah(evidence, condition)
    voltage_v = evidence.study.reference_voltage_v
    return cache.ensure_one(
        Request(
            ALGORITHM,
            {"condition": condition.key, **scope},
            (
                result_fingerprint("condition", condition.result),
                fingerprint("voltage", "study", evidence.study.uid, repr(voltage_v)),
            ),
            {"resolution_mah": resolution_mah},
            lambda: _outcome(condition, voltage_v, resolution_mah),
        )
    )


def _resolution_mah(evidence: StudyData, condition: ConditionValues) -> float:
    """Return the coarsest resolution among the charges that the condition's joules rest on."""
    charges = [usable_charge(item.run, evidence.charges.get(item.run.uid, [])) for item in condition.runs]
    return max(charge.resolution_mah for charge in charges if not isinstance(charge, str))


def _outcome(condition: ConditionValues, voltage_v: float, resolution_mah: float) -> Computed:
    found = energy_budget(
        condition.values,
        [item.run.jumps_made for item in condition.runs],
        reference_voltage_v=voltage_v,
        drain_se_run_j=math.sqrt(sum(item.shared.se**2 for item in condition.runs) / len(condition.runs)),
        drain_se_mean_j=shared_of_mean([item.shared for item in condition.runs]).se,
        resolution_mah=resolution_mah,
    )
    sources = [(term.name, term.one_run_j, term.mean_j) for term in found.terms]
    sources.append((IN_ALL, found.total_one_run_j, found.total_mean_j))
    numbers = [
        number
        for name, one_run_j, mean_j in sources
        for number in (NewNumber(name, one_run_j, "J", n=found.n), NewNumber(of_mean(name), mean_j, "J", n=found.n))
    ]
    numbers.append(NewNumber(ONE_MAH, found.joules_per_mah, "J", n=found.n))
    terms = [
        {"name": term.name, "shared": term.shared, "in_scatter": term.in_scatter, "assumed": term.assumed}
        for term in found.terms
    ]
    return Computed(tuple(numbers), {"terms": terms})
