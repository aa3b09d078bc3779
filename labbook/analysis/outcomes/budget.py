"""What the uncertainty of joules a jump is made of (thesis 5.1.4), and whether a battery pack matters."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence

from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.charger_step import rounding_in
from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber
from labbook.analysis.outcomes.run_energy import joules_per_mah, usable_charge
from labbook.analysis.results import Algorithm, Results, fingerprint, result_fingerprint
from labbook.analysis.study_data import StudyData
from reports.numbers import Number
from reports.results import IN_ALL, OF_DRAIN, BudgetSource, JouleBudget, PackDeviation
from stats.compare.shared_error import shared_of_mean
from stats.compare.summary import describe
from stats.lines.passive_drain import rounding_sd_mah

BUDGET = Algorithm("energy_budget", 14)


def budget(computed: Results, evidence: StudyData, conditions: Sequence[ConditionValues]) -> JouleBudget | None:
    """Compute the budget of one run's joules; None without joules."""
    if not conditions:
        return None
    condition = max(conditions, key=lambda item: len(item.runs))
    resolution_mah = _resolution_mah(evidence, condition)
    voltage_v = evidence.study.reference_voltage_v
    return computed.record(
        BUDGET,
        {"condition": condition.key},
        (
            result_fingerprint("condition", condition.result),
            fingerprint("voltage", "study", evidence.study.uid, repr(voltage_v)),
        ),
        _budget(condition, voltage_v, resolution_mah),
        {"resolution_mah": resolution_mah},
    )


def _resolution_mah(evidence: StudyData, condition: ConditionValues) -> float:
    """Return the coarsest resolution among the charges that the condition's joules are computed from."""
    charges = [usable_charge(item.run, evidence.charges.get(item.run.uid, [])) for item in condition.runs]
    return max(charge.resolution_mah for charge in charges if not isinstance(charge, Undefined))


def _budget(condition: ConditionValues, voltage_v: float, resolution_mah: float) -> JouleBudget:
    """Compute the budget of a condition's joules.

    A charger that counts in steps errs by at most half a step, standard deviation step / sqrt(12). Where that differs
    from run to run the scatter holds it already; where repeats are rounded alike, their mean errs by it too.
    """
    drains = [rounding_in(item.shared, without=True) for item in condition.runs]
    rounding_j = shared_of_mean([rounding_in(item.shared) for item in condition.runs]).se
    about, alike = describe(condition.values), rounding_j > 0.0
    one_mah_j = statistics.fmean(joules_per_mah(voltage_v, item.run.jumps_made) for item in condition.runs)
    step_j = one_mah_j * rounding_sd_mah(resolution_mah)
    steps_j = rounding_j if alike else step_j / math.sqrt(about.n)
    drain_j, drains_j = math.sqrt(sum(drain.se**2 for drain in drains) / len(drains)), shared_of_mean(drains).se

    def numbers(scatter_j: float | Undefined, drain_j: float, step_j: float) -> dict[str, Number]:
        added_j = math.hypot(drain_j, step_j if alike else 0.0)
        total_j = scatter_j if isinstance(scatter_j, Undefined) else math.hypot(scatter_j, added_j)
        names = [*(source.name for source in sources), IN_ALL]
        sizes_j = (scatter_j, drain_j, step_j, 0.0, total_j)  # the voltage is taken as stated
        return {name: Number(size_j, "J", n=about.n) for name, size_j in zip(names, sizes_j, strict=True)}

    sources = (
        BudgetSource("scatter between runs", shared=False, in_scatter=False, assumed=False),
        BudgetSource(OF_DRAIN, shared=True, in_scatter=False, assumed=False),
        BudgetSource("charger resolution", shared=alike, in_scatter=not alike, assumed=False),
        BudgetSource("reference voltage", shared=True, in_scatter=False, assumed=True),
    )
    return JouleBudget(
        terms=sources,
        one_run=numbers(about.sd, drain_j, step_j),
        mean=numbers(about.se, drains_j, steps_j),
        one_mah=Number(one_mah_j, "J", n=about.n),
        levels=condition.levels,
    )


PACKS = Algorithm("pack_deviation", 12)


def pack_deviations(computed: Results, conditions: Sequence[ConditionValues]) -> dict[str, PackDeviation]:
    """Compute the mean deviation of every pack, in joules a jump."""
    deviations: dict[str, list[tuple[RunNumber, float]]] = {}
    for condition in conditions:
        mean = sum(condition.values) / len(condition.values)
        for item in condition.runs:
            deviations.setdefault(item.run.battery, []).append((item, item.value - mean))
    inputs = [result_fingerprint("condition", condition.result) for condition in conditions]
    return {
        pack: computed.record(
            PACKS,
            {"pack": pack},
            inputs,
            _deviation([value for _item, value in deviations[pack]]),
            {"runs": [item.run.name for item, _value in deviations[pack]]},
        )
        for pack in sorted(deviations)
    }


def _deviation(values: Sequence[float]) -> PackDeviation:
    about = describe(values)
    return PackDeviation(
        Number(about.mean, "J", about.se, ci_low=about.ci_low, ci_high=about.ci_high, ci_level=about.level, n=about.n)
    )
