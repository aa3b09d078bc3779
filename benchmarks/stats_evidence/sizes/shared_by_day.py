"""Differences over days of runs that were all corrected with one line through idle runs, which has no days."""

from __future__ import annotations

import zlib

import numpy as np

from benchmarks.stats_evidence.sizes.design import Design, Groups, designs_over_days
from benchmarks.stats_evidence.sizes.idle_line import LONGEST, OF_CONTROL, corrected
from benchmarks.stats_evidence.sizes.method import Method, number, of_one_interval, there
from benchmarks.stats_evidence.sizes.over_days import fit_of
from stats.finite import as_interval
from stats.shared_test import difference_with_shared

IDLE_RUNS = 6
"""Of each study, as many as a protocol has, scattering as runs of one day do."""
DESIGNS = (
    *designs_over_days(2, "shared", times_a_day=(3, 10)),
    *designs_over_days(2, "own", times_a_day=(3, 10), fewest_days=2),
)


def _one(groups: Groups, design: Design) -> tuple[float, float, bool]:
    """Return the exact test's interval with what is left of the line's error, as a report of balanced runs has it."""
    idle = np.random.default_rng(zlib.crc32(groups[0].tobytes())).standard_normal(IDLE_RUNS)
    runs, errors = corrected(idle, (groups[0], OF_CONTROL), (groups[1], LONGEST))
    (contrast,) = there(fit_of(runs, design).exact).contrasts
    left = errors[1].minus(errors[0])
    found = difference_with_shared(number(contrast.t), number(contrast.df), contrast.p, contrast.interval, left)
    return of_one_interval(as_interval(found.ci_low, found.ci_high), 0.0)


METHODS = (Method("blocked_by_day_exact_ci_shared", "coverage", DESIGNS, _one, runs=2000),)
