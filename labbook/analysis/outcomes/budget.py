"""What the uncertainty of joules a jump is made of (thesis 5.1.4), and whether a battery pack matters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.rounding import number_text
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.charger_step import rounding_in
from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber
from labbook.analysis.outcomes.run_energy import joules_per_mah, usable_charge
from labbook.analysis.results.codec import Algorithm, StoredAs
from labbook.analysis.results.result_cache import Request, ResultCache, fingerprint, result_fingerprint
from labbook.analysis.study_data import StudyData
from reports.numbers import Number, StoredResult
from stats.checks import Missing, as_number, as_values, complete_rows
from stats.compare.shared_error import shared_of_mean
from stats.compare.summary import describe
from stats.exact.numbers import Floats, finite, moments, refuse_beyond
from stats.lines.passive_drain import rounding_sd_mah
from stats.results import Result, missing_text, with_unit

_TERM = "the standard error"


@dataclass(frozen=True, slots=True)
class BudgetTerm(Result):
    """One source of uncertainty of joules a jump, as standard errors in joules."""

    name: str
    """What errs."""
    one_run_j: float | Undefined
    """Standard error that it gives a single run, in joules a jump."""
    mean_j: float | Undefined
    """Standard error that it gives the mean of the condition, in joules a jump."""
    shared: bool
    """Whether it shifts all runs alike, so that more runs do not make it smaller."""
    in_scatter: bool
    """Whether the scatter between runs contains it already; such a term is shown and not added again."""
    assumed: bool
    """Whether its size is assumed, not measured or taken from a source."""


@dataclass(frozen=True, slots=True)
class EnergyBudget(Result):
    """Uncertainty budget of joules a jump in one condition."""

    n: int
    """Runs."""
    mean_j: float
    """Mean of the runs, in joules a jump."""
    terms: tuple[BudgetTerm, ...]
    """Scatter between runs, drain fit, charger resolution, reference voltage, in this order; shape (4,)."""
    total_one_run_j: float | Undefined
    """Scatter and shared terms of a single run, added in quadrature, in joules a jump."""
    total_mean_j: float | Undefined
    """Scatter and shared terms together, added in quadrature, in joules a jump."""
    joules_per_mah: float
    """What one mAh at the charger is worth in joules a jump (mean over the runs)."""
    missing: int = 0
    """Runs left out because a value was NaN."""

    def rows(self) -> tuple[BudgetTerm, ...]:
        """Return the terms, for `to_frame`."""
        return self.terms

    def sentence(self) -> str:
        """Return the budget in words: mean, its standard error, what each term adds to it, n."""
        terms = [
            f"{term.name} {number_text(term.mean_j, 2)}{with_unit('' if isinstance(term.mean_j, Undefined) else 'J')}"
            f"{' (assumed)' if term.assumed else ''}{' (in the scatter)' if term.in_scatter else ''}"
            for term in self.terms
        ]
        unit = "" if isinstance(self.total_mean_j, Undefined) else "J"
        return (
            f"The mean is {number_text(self.mean_j)} J a jump, standard error {number_text(self.total_mean_j, 2)}"
            f"{with_unit(unit)} ({', '.join(terms)}; n = {self.n}{missing_text(self.missing)})."
        )


def energy_budget(
    joules: ArrayLike,
    jumps_made: ArrayLike,
    *,
    reference_voltage_v: float,
    drain_se_run_j: float,
    drain_se_mean_j: float,
    resolution_mah: float,
    rounding_se_mean_j: float = 0.0,
    voltage_relative_se: float = 0.0,
    voltage_assumed: bool = True,
    missing: Missing = "refuse",
) -> EnergyBudget:
    """Return the budget of one condition from its runs' joules a jump and jumps made, both of shape (n,).

    `drain_se_run_j` and `drain_se_mean_j` are what the drain line's error makes of one run's joules and of their mean
    (`compare.shared_error`; the same at equal durations and jumps). A charger that counts in steps of `resolution_mah`
    errs by at most half a step, standard deviation step / sqrt(12). Where that differs from run to run the scatter
    holds it already; where repeats are rounded alike, the mean errs by `rounding_se_mean_j`. The voltage's relative
    standard error shifts all joules by one factor.
    Raises `InputRefused` for infinite values, for NaN unless `missing` is "drop" (which leaves out runs), lengths that
    differ, counts that are not positive, or no run.
    """
    values, counts, left_out = _checked_runs(joules, jumps_made, missing)
    relative = as_number("the voltage's relative standard error", voltage_relative_se, low=0.0)
    step_sd_mah = rounding_sd_mah(resolution_mah)
    about = describe(values)
    mean = moments(values).mean
    per_mah = joules_per_mah(reference_voltage_v, _harmonic_mean(counts))

    of_run = as_number("the drain fit's standard error of a run", drain_se_run_j, low=0.0)
    of_mean = as_number("the drain fit's standard error of the mean", drain_se_mean_j, low=0.0)
    voltage = relative * abs(mean)
    alike = rounding_se_mean_j > 0.0
    step = per_mah * step_sd_mah
    steps = rounding_se_mean_j if alike else step / math.sqrt(about.n)
    of_step, of_steps, of_voltage = (finite(size, _TERM) for size in (step, steps, voltage))
    return EnergyBudget(
        n=about.n,
        mean_j=mean,
        terms=(
            BudgetTerm("scatter between runs", about.sd, about.se, shared=False, in_scatter=False, assumed=False),
            BudgetTerm("drain fit", of_run, of_mean, shared=True, in_scatter=False, assumed=False),
            BudgetTerm("charger resolution", of_step, of_steps, shared=alike, in_scatter=not alike, assumed=False),
            BudgetTerm(
                "reference voltage", of_voltage, of_voltage, shared=True, in_scatter=False, assumed=voltage_assumed
            ),
        ),
        total_one_run_j=_in_quadrature(about.sd, of_run, voltage, step if alike else 0.0),
        total_mean_j=_in_quadrature(about.se, of_mean, voltage, steps if alike else 0.0),
        joules_per_mah=per_mah,
        missing=left_out,
    )


def _checked_runs(joules: ArrayLike, jumps_made: ArrayLike, missing: Missing) -> tuple[Floats, Floats, int]:
    """Return the joules and the counts of complete runs, each of shape (n,), and how many runs were left out."""
    (joules, jumps_made), left_out = complete_rows([joules, jumps_made], missing)
    values, counts = as_values("the joules", joules), as_values("jumps made", jumps_made)
    if values.size != counts.size:
        raise InputRefused(f"there are {values.size} joules and {counts.size} counts: give one count for each run.")
    if values.size == 0:
        raise InputRefused("there is no run: a budget needs the joules of at least one.")
    if float(counts.min()) <= 0.0:
        raise InputRefused("a run without jumps has no joules a jump: leave it out of the budget.")
    return values, counts, left_out


def _harmonic_mean(counts: Floats) -> float:
    """Return the number of jumps at which a mAh is worth what it is in the mean over runs."""
    with np.errstate(over="ignore"):
        shares = 1.0 / counts
    jumps = 1.0 / moments(shares).mean if np.isfinite(shares).all() else math.inf
    refuse_beyond("the jumps made or one over them", [jumps])
    return jumps


def _in_quadrature(scatter: float | Undefined, *shared: float) -> float | Undefined:
    return scatter if isinstance(scatter, Undefined) else finite(math.hypot(scatter, *shared), "the total")


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
    """Return the coarsest resolution among the charges that the condition's joules are computed from."""
    charges = [usable_charge(item.run, evidence.charges.get(item.run.uid, [])) for item in condition.runs]
    return max(charge.resolution_mah for charge in charges if not isinstance(charge, Undefined))


def _budget(condition: ConditionValues, voltage_v: float, resolution_mah: float) -> JouleBudget:
    drains = [rounding_in(item.shared, without=True) for item in condition.runs]
    found = energy_budget(
        condition.values,
        [item.run.jumps_made for item in condition.runs],
        reference_voltage_v=voltage_v,
        drain_se_run_j=math.sqrt(sum(drain.se**2 for drain in drains) / len(drains)),
        drain_se_mean_j=shared_of_mean(drains).se,
        resolution_mah=resolution_mah,
        rounding_se_mean_j=shared_of_mean([rounding_in(item.shared) for item in condition.runs]).se,
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
