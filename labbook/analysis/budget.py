"""Where the uncertainty of a joule comes from, shown on the condition with the most runs."""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.queries.results import ResultRow
from data_schema.vocabulary import Undefined
from labbook.analysis.conditions import ConditionValues
from labbook.analysis.gathering import Evidence
from labbook.analysis.passive_drain import fitted
from labbook.analysis.run_energy import usable_charge
from labbook.analysis.workbench import Algorithm, NewNumber, Outcome, Request, Workbench, rests_on, rests_on_result
from stats.energy import energy_budget
from stats.passive_drain import PassiveDrain

ALGORITHM = Algorithm(
    "energy_budget", 2, ("labbook.analysis.budget", "stats.energy", "stats.passive_drain", "stats.sums")
)


def budget(
    bench: Workbench,
    evidence: Evidence,
    drain_row: ResultRow,
    conditions: Sequence[ConditionValues],
    scope: dict[str, str],
) -> ResultRow | None:
    """Ensure the budget of one run's joules; None without joules or drain fit."""
    drain = fitted(evidence)
    if not conditions or isinstance(drain, Undefined):
        return None
    condition = max(conditions, key=lambda item: len(item.runs))
    resolution_mah = _resolution_mah(evidence, condition)
    voltage_v = evidence.study.reference_voltage_v
    return bench.ensure_one(
        Request(
            ALGORITHM,
            {"condition": condition.key, **scope},
            (
                rests_on_result("condition", condition.result),
                rests_on_result("drain", drain_row),
                rests_on("voltage", "study", evidence.study.uid, repr(voltage_v)),
            ),
            {"resolution_mah": resolution_mah},
            lambda: _outcome(condition, drain, voltage_v, resolution_mah),
        )
    )


def _resolution_mah(evidence: Evidence, condition: ConditionValues) -> float:
    """Return the coarsest resolution among the charges that the condition's joules rest on."""
    charges = [usable_charge(item.run, evidence.charges.get(item.run.uid, [])) for item in condition.runs]
    return max(charge.resolution_mah for charge in charges if not isinstance(charge, str))


def _outcome(condition: ConditionValues, drain: PassiveDrain, voltage_v: float, resolution_mah: float) -> Outcome:
    durations = [item.run.duration_s or 0.0 for item in condition.runs]
    found = energy_budget(
        condition.values,
        [item.run.jumps_made for item in condition.runs],
        reference_voltage_v=voltage_v,
        drain_se_mah=drain.at(sum(durations) / len(durations)).se,
        resolution_mah=resolution_mah,
    )
    numbers = [NewNumber(term.name, term.one_run_j, "J", n=found.n) for term in found.terms]
    numbers.append(NewNumber("one run in all", found.total_one_run_j, "J", n=found.n))
    terms = [
        {"name": term.name, "shared": term.shared, "in_scatter": term.in_scatter, "assumed": term.assumed}
        for term in found.terms
    ]
    return Outcome(tuple(numbers), {"terms": terms, "sentence": found.sentence()})
