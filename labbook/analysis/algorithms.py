"""Every kind of result that is stored, in one list: what is checked of one is checked of all."""

from __future__ import annotations

from typing import Any

from labbook.analysis.comparison import comparing, comparing_by_day, comparing_jumps, equivalent_heights, family
from labbook.analysis.outcomes import (
    budget,
    conditions,
    packs,
    passive_drain,
    run_apexes,
    run_energy,
    run_force,
)
from labbook.analysis.prediction import checking, predicting
from labbook.analysis.results.codec import Algorithm

ALGORITHMS: tuple[Algorithm[Any], ...] = (
    passive_drain.ALGORITHM,
    run_energy.ALGORITHM,
    run_apexes.ALGORITHM,
    run_force.ALGORITHM,
    conditions.SUMMARY,
    packs.ALGORITHM,
    budget.ALGORITHM,
    comparing.COMPARISON,
    comparing.ANOVA,
    comparing_jumps.ALGORITHM,
    conditions.DAY_MEANS,
    comparing_by_day.ALGORITHM,
    family.ALGORITHM,
    equivalent_heights.ALGORITHM,
    predicting.ALGORITHM,
    checking.ALGORITHM,
)
"""The registry: a new kind of result is a new file and a line here."""
