"""The same comparisons with the day as a random effect: runs of one day have that day in common."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.queries.results import InputRow
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparing import Pair, fingerprints_of_sides
from labbook.analysis.comparison.day_weights import day_ratio, shared_by_day
from labbook.analysis.results.codec import Algorithm, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, fingerprint
from reports.numbers import Number
from stats.compare.shared_error import difference_with_shared
from stats.days.blocked import blocked_by_day


@dataclass(frozen=True, slots=True)
class DayComparison(StoredResult):
    """A comparison with the day as a random effect: treatment less control over so many days.

    `method`, `confounding` and `notes` as `stats.days.BlockedByDay` has them.
    """

    t: Number
    p: Number
    difference: Number
    day_sd: Number
    run_sd: Number
    days: int
    method: str
    confounding: str
    notes: tuple[str, ...]


ALGORITHM = Algorithm("comparison_by_day", 9, DayComparison)

CONTROL, TREATED = "the control", "the treatment"


def compare_by_day(
    cache: ResultCache, pairs: Sequence[Pair], quantity: Outcome, scope: Mapping[str, Any], alpha: float
) -> list[DayComparison]:
    """Ensure y ~ condition + (1 | day) over the runs of every pair, in order; intervals have level 1 - alpha.

    Numbers are those that `BlockedByDay` states: of the exact test where the design is balanced; "method" names which.
    The spreads of days and of runs are the mixed model's.
    """
    return cache.ensure(
        [
            Request(
                ALGORITHM,
                {"quantity": str(quantity), "family": pair.family, "label": pair.label, **scope},
                (*fingerprints_of_sides(pair), *_days(pair)),
                {"alpha": alpha},
                lambda pair=pair: _compared(pair, quantity, alpha),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


def _days(pair: Pair) -> list[InputRow]:
    """Name the day of every run: a run's own number does not change with it."""
    runs = {item.run.uid: item.run for side in (pair.a, pair.b) for condition in side for item in condition.runs}
    return [fingerprint("day", "run", run.uid, run.day) for run in runs.values()]


def _compared(pair: Pair, quantity: Outcome, alpha: float) -> DayComparison:
    sides = ((CONTROL, pair.a), (TREATED, pair.b))
    rows = [(item, name) for name, side in sides for condition in side for item in condition.runs]
    names, days = [name for _item, name in rows], [item.run.day for item, _name in rows]
    found = blocked_by_day([item.value for item, _name in rows], names, days, control=CONTROL, level=1.0 - alpha)
    (contrast,) = found.contrasts
    unit, n = quantity.unit, found.n
    ratio = day_ratio(found, found.stated())
    shared = shared_by_day(contrast, ratio, names, days, [item.shared for item, _name in rows])
    shared_se = shared.se if quantity.shares_error else None
    test = difference_with_shared(contrast.t, contrast.df, contrast.p, contrast.interval, shared, found.level)
    return DayComparison(
        t=Number(test.t, "1", df=test.df, n=n),
        p=Number(test.p, "1", df=test.df, n=n),
        difference=Number(
            contrast.difference, unit, contrast.se, shared_se, test.ci_low, test.ci_high, found.level, df=test.df, n=n
        ),
        day_sd=Number(_root(found.day_variance), unit, n=found.n_days),
        run_sd=Number(_root(found.residual_variance), unit, n=n),
        days=found.n_days,
        method=found.method,
        confounding=found.confounding,
        notes=found.notes,
    )


def _root(variance: float | Undefined) -> float | Undefined:
    return variance if isinstance(variance, Undefined) else math.sqrt(variance)
