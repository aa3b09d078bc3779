"""All methods whose size or coverage is recorded, in the order of the record."""

from __future__ import annotations

from benchmarks.stats_evidence.sizes import (
    bounds,
    families,
    over_days,
    ratios,
    resampled,
    scatter,
    several_groups,
    single,
    two_groups,
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
)
