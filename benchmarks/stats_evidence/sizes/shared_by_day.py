"""Differences over days of runs that were all corrected with one line through idle runs, which has no days."""

from __future__ import annotations

import zlib
from dataclasses import replace

import numpy as np

from benchmarks.stats_evidence.sizes.design import Design, Groups, designs_over_days
from benchmarks.stats_evidence.sizes.idle_line import LONGEST, OF_CONTROL, corrected
from benchmarks.stats_evidence.sizes.method import Method, of_one_interval, there
from benchmarks.stats_evidence.sizes.over_days import fit_of
from stats.compare.shared_error import difference_with_shared
from stats.exact.numbers import as_interval

IDLE_RUNS = 6
"""Of each study, as many as a protocol has, scattering as runs of one day do."""
BALANCED = (
    *designs_over_days(2, "shared", times_a_day=(3, 10)),
    *designs_over_days(2, "own", times_a_day=(3, 10), fewest_days=2),
)
FEW = tuple(one for one in BALANCED if one.days in (2, 3, 6) and one.times[0] == 3)


def _with_line(groups: Groups, design: Design, *, exact: bool) -> tuple[float, float, bool]:
    """Return the interval of a difference with what is left of the line's error."""
    idle = np.random.default_rng(zlib.crc32(groups[0].tobytes())).standard_normal(IDLE_RUNS)
    runs, errors = corrected(idle, (groups[0], OF_CONTROL), (groups[1], LONGEST))
    fit = fit_of(runs, design)
    (contrast,) = there(fit.exact).contrasts if exact else fit.mixed.contrasts
    left = errors[1].minus(errors[0])
    found = difference_with_shared(contrast.t, contrast.df, contrast.p, contrast.interval, left)
    return of_one_interval(as_interval(found.ci_low, found.ci_high), 0.0)


def _exact(groups: Groups, design: Design) -> tuple[float, float, bool]:
    return _with_line(groups, design, exact=True)


def _mixed(groups: Groups, design: Design) -> tuple[float, float, bool]:
    return _with_line(groups, design, exact=False)


METHODS = (
    Method("blocked_by_day_exact_ci_six_idle_runs", "coverage", BALANCED, _exact, runs=2000),
    Method(
        "blocked_by_day_exact_ci_six_idle_runs",
        "coverage",
        tuple(replace(one, sd_ratio=2.0) for one in FEW),
        _exact,
        runs=1000,
    ),
    Method("blocked_by_day_ci_six_idle_runs", "coverage", FEW, _mixed, runs=1000),
)
