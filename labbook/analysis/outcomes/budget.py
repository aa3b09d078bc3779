"""Where the uncertainty of a joule comes from, and whether a battery pack matters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber
from labbook.analysis.outcomes.energy import energy_budget
from labbook.analysis.outcomes.run_energy import usable_charge
from labbook.analysis.results.codec import Algorithm, StoredAs, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, fingerprint, result_fingerprint
from labbook.analysis.study_data import StudyData
from reports.numbers import Number
from stats.compare.shared_error import shared_of_mean
from stats.compare.summary import describe

IN_ALL = "in all"
"""The sum of all sources of uncertainty."""


@dataclass(frozen=True, slots=True)
class BudgetSource:
    """A source of uncertainty by name; `shared`, `in_scatter` and `assumed` as in `energy.BudgetTerm`."""

    name: str
    shared: bool
    in_scatter: bool
    assumed: bool


@dataclass(frozen=True, slots=True)
class JouleBudget(StoredResult):
    """What each source gives a run's joules and the mean over runs, by its name and `IN_ALL`; what 1 mAh is worth."""

    terms: tuple[BudgetSource, ...]
    one_run: Annotated[Mapping[str, Number], StoredAs("{}")]
    mean: Annotated[Mapping[str, Number], StoredAs("{}, mean")]
    one_mah: Annotated[Number, StoredAs("1 mAh")]


BUDGET = Algorithm("energy_budget", 14, JouleBudget)


def budget(
    cache: ResultCache,
    evidence: StudyData,
    conditions: Sequence[ConditionValues],
    scope: dict[str, str],
) -> JouleBudget | None:
    """Ensure the budget of one run's joules; None without joules."""
    if not conditions:
        return None
    condition = max(conditions, key=lambda item: len(item.runs))
    resolution_mah = _resolution_mah(evidence, condition)
    voltage_v = evidence.study.reference_voltage_v
    return cache.ensure_one(
        Request(
            BUDGET,
            {"condition": condition.key, **scope},
            (
                result_fingerprint("condition", condition.result),
                fingerprint("voltage", "study", evidence.study.uid, repr(voltage_v)),
            ),
            {"resolution_mah": resolution_mah},
            lambda: _budget(condition, voltage_v, resolution_mah),
        )
    )


def _resolution_mah(evidence: StudyData, condition: ConditionValues) -> float:
    """Return the coarsest resolution among the charges that the condition's joules rest on."""
    charges = [usable_charge(item.run, evidence.charges.get(item.run.uid, [])) for item in condition.runs]
    return max(charge.resolution_mah for charge in charges if not isinstance(charge, Undefined))


def _budget(condition: ConditionValues, voltage_v: float, resolution_mah: float) -> JouleBudget:
    found = energy_budget(
        condition.values,
        [item.run.jumps_made for item in condition.runs],
        reference_voltage_v=voltage_v,
        drain_se_run_j=math.sqrt(sum(item.shared.se**2 for item in condition.runs) / len(condition.runs)),
        drain_se_mean_j=shared_of_mean([item.shared for item in condition.runs]).se,
        resolution_mah=resolution_mah,
    )

    def numbers(sizes_j: Sequence[float | Undefined], total_j: float | Undefined) -> dict[str, Number]:
        names = [*(term.name for term in found.terms), IN_ALL]
        return {name: Number(size, "J", n=found.n) for name, size in zip(names, [*sizes_j, total_j], strict=True)}

    return JouleBudget(
        terms=tuple(BudgetSource(term.name, term.shared, term.in_scatter, term.assumed) for term in found.terms),
        one_run=numbers([term.one_run_j for term in found.terms], found.total_one_run_j),
        mean=numbers([term.mean_j for term in found.terms], found.total_mean_j),
        one_mah=Number(found.joules_per_mah, "J", n=found.n),
    )


@dataclass(frozen=True, slots=True)
class PackDeviation(StoredResult):
    """Mean deviation of a pack's runs from the means of their conditions."""

    deviation: Number


PACKS = Algorithm("pack_deviation", 12, PackDeviation)


def pack_deviations(
    cache: ResultCache, conditions: Sequence[ConditionValues], scope: dict[str, str]
) -> dict[str, PackDeviation]:
    """Ensure the mean deviation of every pack, in joules a jump."""
    deviations: dict[str, list[tuple[RunNumber, float]]] = {}
    for condition in conditions:
        mean = sum(condition.values) / len(condition.values)
        for item in condition.runs:
            deviations.setdefault(item.run.battery, []).append((item, item.value - mean))
    packs = sorted(deviations)
    results = cache.ensure(
        [
            Request(
                PACKS,
                {"pack": pack, **scope},
                tuple(result_fingerprint("condition", condition.result) for condition in conditions),
                {"runs": [item.run.name for item, _value in deviations[pack]]},
                lambda values=[value for _item, value in deviations[pack]]: _deviation(values),  # type: ignore[misc]
            )
            for pack in packs
        ]
    )
    return dict(zip(packs, results, strict=True))


def _deviation(values: Sequence[float]) -> PackDeviation:
    about = describe(values)
    return PackDeviation(
        Number(about.mean, "J", about.se, ci_low=about.ci_low, ci_high=about.ci_high, ci_level=about.level, n=about.n)
    )
