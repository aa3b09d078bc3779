"""Every kind of result that is stored, in one list: what is checked of one is checked of all."""

from __future__ import annotations

from typing import Any

from labbook.analysis.comparison import comparisons, contrasts, deciding, thesis_route
from labbook.analysis.outcomes import budget, conditions, run_apexes, run_energy, run_force
from labbook.analysis.prediction import bias, checking, hypotheses, predicting
from labbook.analysis.results.codec import Algorithm
from stats.apexes.detectors import DETECTORS

ALGORITHMS: tuple[Algorithm[Any], ...] = (
    run_energy.DRAIN,
    run_energy.RUN_ENERGY,
    run_apexes.ALGORITHM,
    run_force.ALGORITHM,
    conditions.SUMMARY,
    budget.PACKS,
    budget.BUDGET,
    deciding.DECISION,
    comparisons.FAMILY,
    deciding.EQUIVALENCE,
    deciding.OVERALL,
    deciding.OVERALL_EQUIVALENCE,
    contrasts.ALGORITHM,
    thesis_route.ROUTE,
    thesis_route.OVER_JUMPS,
    thesis_route.ANOVA,
    predicting.ALGORITHM,
    checking.ALGORITHM,
    bias.BIAS,
    bias.JOINT_BIAS,
    bias.LIMITS,
    hypotheses.ALGORITHM,
)
"""The registry: a new kind of result is a dataclass, a function that makes it, and a line here."""


def versions_now() -> dict[str, int]:
    """Return the versions of all algorithms of this labbook, detectors among them, by name."""
    return {
        **{algorithm.kind: algorithm.version for algorithm in ALGORITHMS},
        **{name: detector.version for name, detector in DETECTORS.items()},
    }
