"""How far runs of one condition lie apart, and the mean of the controls: what a plan of further runs rests on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from scipy import special

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.conditions import RunNumber, days_of, mean_of, run_numbers
from labbook.analysis.outcomes.detections import Detections
from labbook.analysis.outcomes.measuring import measure
from labbook.analysis.results.result_cache import ResultCache
from labbook.analysis.study_data import StudyData
from labbook.config.model import UnitOfAnalysis
from stats.compare.summary import describe

LEVEL = 0.95
"""Level of the standard deviation's interval."""


@dataclass(frozen=True, slots=True)
class Spread:
    """Standard deviation within conditions with its interval, in the quantity's unit, from `n` values of the book.

    The values are runs, or means of a day's runs of one condition. `control_mean` is None without a control.
    """

    n: int
    df: int
    sd: float
    sd_low: float
    sd_high: float
    control_mean: float | None
    control_n: int


def run_spread(
    cache: ResultCache, detections: Detections, evidence: StudyData, quantity: Outcome, unit: UnitOfAnalysis
) -> Spread | Undefined:
    """Pool the scatter of the runs so far within their conditions; nothing is stored.

    The interval is that of a normal variance, by chi-squared.
    """
    numbers = run_numbers(evidence.runs, measure(quantity, cache, detections, evidence).results, quantity)
    samples: dict[tuple[str, bool], list[RunNumber]] = {}
    for item in numbers:
        samples.setdefault((item.run.condition_key, item.run.is_control), []).append(item)
    values = {key: _values(items, unit) for key, items in samples.items()}
    controls = [value for (_key, is_control), several in values.items() if is_control for value in several]
    df = sum(len(several) - 1 for several in values.values())
    unit_text = quantity.unit
    if df < 1:
        return Undefined(f"no condition has two {unit}s with {quantity} ({unit_text}) yet")
    sd = math.sqrt(sum(_squares(several) for several in values.values()) / df)
    if sd == 0.0:
        return Undefined(f"the {quantity} of each condition do not differ at all")
    tail = (1.0 - LEVEL) / 2.0
    low, high = (sd * math.sqrt(df / float(special.chdtri(df, p))) for p in (tail, 1.0 - tail))
    mean = describe(controls).mean if controls else None
    return Spread(
        n=sum(map(len, values.values())),
        df=df,
        sd=sd,
        sd_low=low,
        sd_high=high,
        control_mean=mean if isinstance(mean, float) else None,
        control_n=len(controls),
    )


def _values(items: Sequence[RunNumber], unit: UnitOfAnalysis) -> list[float]:
    if unit is UnitOfAnalysis.RUN:
        return [item.value for item in items]
    return [mean_of(of_day) for of_day in days_of(items).values()]


def _squares(values: Sequence[float]) -> float:
    sd = describe(values).sd
    return 0.0 if isinstance(sd, Undefined) else (len(values) - 1) * sd**2
