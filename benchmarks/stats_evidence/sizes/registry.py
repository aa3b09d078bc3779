"""All methods whose size or coverage is recorded, in the order of the record."""

from __future__ import annotations

from benchmarks.stats_evidence.sizes import (
    bounds,
    exact_over_days,
    families,
    lines,
    over_days,
    planes,
    ratios,
    resampled,
    scatter,
    several_columns,
    several_groups,
    shared_by_day,
    single,
    two_groups,
    unlike_over_days,
    with_shared,
)

METHODS = (
    *scatter.METHODS,
    *two_groups.METHODS,
    *several_groups.METHODS,
    *families.METHODS,
    *bounds.METHODS,
    *ratios.METHODS,
    *single.METHODS,
    *over_days.METHODS,
    *resampled.METHODS,
    *with_shared.METHODS,
    *shared_by_day.METHODS,
    *lines.METHODS,
    *planes.METHODS,
    *several_columns.METHODS,
    *exact_over_days.METHODS,
    *unlike_over_days.METHODS,
)
