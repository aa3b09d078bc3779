"""Methods that know no days, on groups over days that are large, or scatter or were measured unequally.

Tests of equal variances have no size where scatter is unequal: their groups scatter alike.
"""

from __future__ import annotations

from dataclasses import replace

from benchmarks.stats_evidence.sizes import bounds, families, over_days, ratios, scatter, several_groups, two_groups
from benchmarks.stats_evidence.sizes.design import by_layout_unlike
from benchmarks.stats_evidence.sizes.method import Method
from stats.compare.two_sample import ROUTES

RUNS = 10_000
OF_MEANS = (
    *two_groups.METHODS,
    *several_groups.METHODS,
    *families.METHODS,
    *bounds.METHODS,
    *ratios.METHODS,
    *(method for method in over_days.METHODS if method.name in ROUTES),
)
_THERE = {(method.name, design) for method in (*scatter.METHODS, *OF_MEANS) for design in method.designs}


def _more(method: Method, *, alike: bool) -> Method:
    numbers = sorted({len(design.n) for design in method.designs if design.days})
    designs = [design for groups in numbers for design in by_layout_unlike(groups)]
    if alike:
        designs = list(dict.fromkeys(replace(design, sd_ratio=1.0) for design in designs))
    return replace(method, designs=tuple(one for one in designs if (method.name, one) not in _THERE), runs=RUNS)


METHODS = (
    *(_more(method, alike=True) for method in scatter.METHODS),
    *(_more(method, alike=False) for method in OF_MEANS if any(design.days for design in method.designs)),
)
