"""The same comparisons with the day as a random effect: runs of one day have that day in common."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.queries.results import InputRow, ResultRow
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparing import Pair, fingerprints_of_sides
from labbook.analysis.comparison.day_weights import day_ratio, shared_by_day
from labbook.analysis.results.result_cache import Algorithm, Computed, NewNumber, Request, ResultCache, fingerprint
from stats.compare.shared_error import difference_with_shared
from stats.days.blocked import blocked_by_day

ALGORITHM = Algorithm("comparison_by_day", 9)

CONTROL, TREATED = "the control", "the treatment"


def compare_by_day(
    cache: ResultCache, pairs: Sequence[Pair], quantity: Outcome, scope: Mapping[str, Any], alpha: float
) -> list[ResultRow]:
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


def _compared(pair: Pair, quantity: Outcome, alpha: float) -> Computed:
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
    return Computed(
        (
            NewNumber("t", test.t, "1", df=test.df, n=n),
            NewNumber("p", test.p, "1", df=test.df, n=n),
            NewNumber(
                "difference", contrast.difference, unit, contrast.se, shared_se, test.ci_low, test.ci_high, found.level,
                df=test.df, n=n,
            ),
            NewNumber("day_sd", _root(found.day_variance), unit, n=found.n_days),
            NewNumber("run_sd", _root(found.residual_variance), unit, n=n),
        ),
        {"days": found.n_days, "method": found.method, "confounding": found.confounding, "notes": list(found.notes)},
    )  # fmt: skip


def _root(variance: float | Undefined) -> float | Undefined:
    return variance if isinstance(variance, Undefined) else math.sqrt(variance)
