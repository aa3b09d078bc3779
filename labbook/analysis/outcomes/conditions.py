"""One quantity in one condition: its values of runs or days, their mean and interval, and how far they lie apart.

How an outcome is computed from a run stands in the file that it names in `data_schema.outcomes`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module

from scipy import special

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.charger_step import ENOUGH_SCATTER, rounding_in, scatter_in_steps, with_rounding
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import ApexVariant, RunApexes, as_protocol
from labbook.analysis.outcomes.run_energy import RunEnergy
from labbook.analysis.results import (
    Algorithm,
    Results,
    RunResults,
    condition_input,
    result_fingerprint,
)
from labbook.analysis.study_data import StudyData
from reports.numbers import Number, Result
from reports.results import CoarseCharger, ConditionSummary
from stats.compare.shared_error import SharedError, describe_shared, shared_of_mean
from stats.compare.summary import describe


def measure(
    outcome: Outcome,
    computed: Results,
    detections: Detections,
    data: StudyData,
    variant: ApexVariant | None = None,
) -> RunResults[Result]:
    """Compute the outcome of every selected jump run that has what it takes, by the function `measured` of its file.

    Jumps are found and counted as the protocol says, or as a variant does.
    """
    of_file = import_module(f"labbook.analysis.outcomes.{outcome.file}")
    found: RunResults[Result] = of_file.measured(computed, detections, data, variant or as_protocol(data))
    return found


def measure_all(
    outcomes: Iterable[Outcome], computed: Results, detections: Detections, data: StudyData
) -> dict[Outcome, RunResults[Result]]:
    """Compute several outcomes; those that come from the same measurement are measured once."""
    found: dict[Outcome, RunResults[Result]] = {}
    measured: dict[str, RunResults[Result]] = {}
    for outcome in outcomes:
        if outcome.file not in measured:
            measured[outcome.file] = measure(outcome, computed, detections, data)
        found[outcome] = measured[outcome.file]
    return found


SUMMARY = Algorithm("condition_summary", 14)


@dataclass(frozen=True, slots=True)
class RunNumber:
    """What one run contributes: its number, the error it shares with other runs, and the result it comes from."""

    run: RunRow
    value: float
    shared: SharedError
    result: Result


@dataclass(frozen=True, slots=True)
class ConditionValues:
    """The runs of one condition, and their summary."""

    key: str
    is_control: bool
    levels: Mapping[str, str]
    runs: tuple[RunNumber, ...]
    result: ConditionSummary

    @property
    def values(self) -> list[float]:
        """The runs' numbers."""
        return [item.value for item in self.runs]


def run_numbers(runs: Sequence[RunRow], results: Mapping[str, Result], quantity: Outcome) -> list[RunNumber]:
    """Return the runs that have the quantity; joules of repeats that a charger rounds alike share that error."""
    found = []
    for run in runs:
        result = results.get(run.uid)
        value = None if result is None else number_of(result, quantity).value
        if result is not None and isinstance(value, float):
            shared = result.shared_error if isinstance(result, RunEnergy | RunApexes) else SharedError()
            found.append(RunNumber(run, value, shared, result))
    if coarse_scatter(found) is None:
        return found
    return [
        replace(item, shared=with_rounding(item.shared, _step_j(item.result), _reading(item.run, item.result)))
        if isinstance(item.result, RunEnergy)
        else item
        for item in found
    ]


def coarse_scatter(items: Sequence[RunNumber]) -> float | None:
    """Return the scatter of charges within conditions, in steps of the charger, where that is too little to trust.

    None where rounding errs from run to run, and of other values than joules.
    """
    energies = [(item.run, item.result) for item in items if isinstance(item.result, RunEnergy)]
    scatter = scatter_in_steps(
        [item.value for item in items if isinstance(item.result, RunEnergy)],
        [_step_j(energy) for _run, energy in energies],
        [run.condition_key for run, _energy in energies],
        [run.day for run, _energy in energies],
    )
    return None if scatter is None or scatter >= ENOUGH_SCATTER else scatter


def coarse_charger(conditions: Iterable[ConditionValues]) -> CoarseCharger | None:
    """Return the charger's step and the scatter of charges where that is too little to trust; None where it is not."""
    runs = [item for condition in conditions for item in condition.runs]
    scatter = coarse_scatter(runs)
    if scatter is None:
        return None
    step_mah = max(item.result.step_mah for item in runs if isinstance(item.result, RunEnergy))
    return CoarseCharger(step_mah, scatter * step_mah)


def _step_j(energy: RunEnergy) -> float:
    """Return what a step of the charger is worth in a run's joules a jump."""
    se = energy.joules_per_jump.se
    assert isinstance(se, float)  # noqa: S101 - that of rounding
    return se * math.sqrt(12.0)


def _reading(run: RunRow, energy: RunEnergy) -> str:
    return f"{energy.charge_mah!r} mAh, {run.condition_key}"


def number_of(result: Result, quantity: Outcome) -> Number:
    """Return an outcome's number of a run's result, whose field has the name that the outcome declares."""
    found: Number = getattr(result, quantity.number_name)
    return found


def conditions_by_outcome(
    computed: Results, detections: Detections, evidence: StudyData, outcomes: Iterable[Outcome]
) -> dict[Outcome, list[ConditionValues]]:
    """Compute the numbers of the selected runs' conditions in each outcome."""
    selected = computed.about(selection=evidence.selection)
    return {
        outcome: condition_values(selected, evidence.runs, found.results, outcome)
        for outcome, found in measure_all(outcomes, computed, detections, evidence).items()
    }


def condition_values(
    computed: Results, runs: Sequence[RunRow], results: Mapping[str, Result], quantity: Outcome
) -> list[ConditionValues]:
    """Compute the summary of every condition of the runs that have the quantity, in order of first occurrence."""
    numbers = run_numbers(runs, results, quantity)
    by_condition = grouped(numbers, [item.run.condition_key for item in numbers])
    return [
        ConditionValues(
            key,
            items[0].run.is_control,
            items[0].run.levels,
            tuple(items),
            computed.record(
                SUMMARY,
                {"quantity": str(quantity), "condition": key},
                (condition_input(items[0].run), *(result_fingerprint(item.run.name, item.result) for item in items)),
                _summary(items, quantity),
                _rounded_alike(items),
            ),
        )
        for key, items in by_condition.items()
    ]


def same_conditions(
    computed: Results, conditions: Sequence[ConditionValues], quantity: Outcome
) -> list[ConditionValues]:
    """Return conditions as `condition_values` has them of the same runs and results, for what `computed` is about."""
    return [
        replace(
            one,
            result=computed.record(
                SUMMARY,
                {"quantity": str(quantity), "condition": one.key},
                one.result.origin.inputs,
                one.result,
                _rounded_alike(one.runs),
            ),
        )
        for one in conditions
    ]


def _rounded_alike(items: Sequence[RunNumber]) -> dict[str, bool]:
    """Return what names results whose runs share the error of rounding, which runs of other conditions decide."""
    return {"rounded_alike": True} if any(rounding_in(item.shared).se for item in items) else {}


def _summary(items: Sequence[RunNumber], quantity: Outcome) -> ConditionSummary:
    mean = describe_shared([item.value for item in items], shared_of_mean([item.shared for item in items]))
    about = mean.scatter
    return ConditionSummary(
        mean=Number(
            about.mean,
            quantity.unit,
            about.se,
            mean.shared_se if quantity.shares_error or mean.shared_se else None,
            mean.ci_low,
            mean.ci_high,
            mean.level,
            df=about.n - 1,
            n=about.n,
        ),
        sd=Number(about.sd, quantity.unit, n=about.n),
        runs=tuple((item.run.name, item.value) for item in items),
    )


SPREAD_LEVEL = 0.95
"""Level of the standard deviation's interval."""


@dataclass(frozen=True, slots=True)
class Spread:
    """Standard deviation within conditions with its interval, in the quantity's unit, from `n` values of the book.

    The values are runs. `control_mean` is None without a control.
    """

    n: int
    df: int
    sd: float
    sd_low: float
    sd_high: float
    control_mean: float | None
    control_n: int


def run_spread(computed: Results, detections: Detections, evidence: StudyData, quantity: Outcome) -> Spread | Undefined:
    """Pool the scatter of the runs so far within their conditions.

    The interval is that of a normal variance, by chi-squared.
    """
    numbers = run_numbers(evidence.runs, measure(quantity, computed, detections, evidence).results, quantity)
    by_condition = grouped(numbers, [item.run.condition_key for item in numbers])
    values = [[item.value for item in several] for several in by_condition.values()]
    controls = [item.value for several in by_condition.values() for item in several if item.run.is_control]
    df = sum(len(several) - 1 for several in values)
    if df < 1:
        return Undefined(Reason.NO_TWO_OF_A_CONDITION, of="run", quantity=str(quantity), in_unit=quantity.unit)
    sd = math.sqrt(sum(map(_squares, values)) / df)
    if sd == 0.0:
        return Undefined(Reason.ALL_CONDITIONS_CONSTANT, quantity=str(quantity))
    tail = (1.0 - SPREAD_LEVEL) / 2.0
    low, high = (sd * math.sqrt(df / float(special.chdtri(df, p))) for p in (tail, 1.0 - tail))
    mean = describe(controls).mean if controls else None
    return Spread(
        n=sum(map(len, values)),
        df=df,
        sd=sd,
        sd_low=low,
        sd_high=high,
        control_mean=mean if isinstance(mean, float) else None,
        control_n=len(controls),
    )


def _squares(values: Sequence[float]) -> float:
    sd = describe(values).sd
    return 0.0 if isinstance(sd, Undefined) else (len(values) - 1) * sd**2
