"""How groups share their days, and the simulated design that stands for them: the nearest that errs no less often.

What a difference of means takes from days is the variance between days times the sum, over the days, of the squared
difference of both groups' shares of their runs: 0 where every day holds the same share of both, 2 where each had one
day of its own. Set against what the difference takes from runs it decides how often tests err that know no days.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations

from stats.recorded import SEVERAL, Recorded, recorded

OWN, PARTLY, MOSTLY, SHARED = "own", "partly", "mostly", "shared"
WHOSE: Mapping[str, str] = {
    OWN: "of its own",
    PARTLY: "of which all groups share one",
    MOSTLY: "of which all groups share all but one",
    SHARED: "that all groups share",
}
"""By layout: the days of each group in words."""
_APART: Mapping[str, Callable[[int], float]] = {
    OWN: lambda days: 2.0 / days,
    PARTLY: lambda days: 2.0 * (days - 1) / days**2,
    MOSTLY: lambda days: 2.0 / days**2,
}
"""By layout of the record: what the difference of two groups takes from days, in variances between days."""
_FEWEST_MOSTLY = 3
"""Days of which all but one are shared; of two that is one shared day."""
_ROUNDING = 1.0 - 1e-9

Found = tuple[tuple[int, ...], int, str]
"""Group sizes, days and layout of a design to look up."""
Runs = Sequence[Counter[str]]
"""Each group's runs by day."""


def layout_of(days: Sequence[set[str]]) -> str:
    """Return "own" where no two groups share a day, "shared" where all have the same days; between them by the most.

    "mostly" is where no group has more than a third of its days that is not a day of all, "partly" the rest.
    """
    if sum(map(len, days)) == len(set().union(*days)):
        return OWN
    if all(each == days[0] for each in days):
        return SHARED
    return MOSTLY if _days_an_unshared(days) >= _FEWEST_MOSTLY else PARTLY


def with_days(groups: Runs) -> Found:
    """Return the design to look up for an analysis that has the day in it."""
    days = [set(group) for group in groups]
    layout = layout_of(days)
    count = _days_an_unshared(days) if layout == MOSTLY else max(map(len, days))
    return tuple(group.total() for group in groups), count, layout


def without_days(method: str, groups: Runs) -> Found:
    """Return the design to look up for a method that knows no days: on record, and taking no less from days.

    That is so in itself and against what is taken from runs; of those designs it is one whose groups are about as
    unequal in size, with the groups' own layout where there is one, and takes least. "shared" is where nothing is taken
    from days.
    """
    days = [set(group) for group in groups]
    sizes, most, layout = tuple(group.total() for group in groups), max(map(len, days)), layout_of(days)
    pairs = [(_between(a, b), a.total(), b.total()) for a, b in combinations(groups, 2)]
    taken = max(apart for apart, _a, _b in pairs)
    if taken == 0.0:
        return sizes, most, SHARED
    rows = [
        row
        for row in recorded()
        if row.method == method
        and row.layout in _APART
        and min(len(row.n), SEVERAL) == min(len(sizes), SEVERAL)
        and _taken(row) >= taken * _ROUNDING
    ]
    if not rows:
        return sizes, most, layout
    ratio = max(apart / (1.0 / a + 1.0 / b) for apart, a, b in pairs)
    enough = [row for row in rows if _ratio(row) >= ratio * _ROUNDING]
    chosen = min(
        enough or [row for row in rows if _ratio(row) == max(map(_ratio, rows))],
        key=lambda row: (
            round(abs(_inequality(row.n) - _inequality(sizes)), 6),
            row.layout != layout,
            round(_ratio(row), 6),
            _taken(row),
        ),
    )
    return chosen.n, chosen.days or most, chosen.layout


def _between(a: Counter[str], b: Counter[str]) -> float:
    """Return what the difference of two groups' means takes from days, in variances between days."""
    return sum((a[day] / a.total() - b[day] / b.total()) ** 2 for day in {*a, *b})


def _taken(row: Recorded) -> float:
    return _APART[row.layout](row.days or 1)


def _ratio(row: Recorded) -> float:
    """Return what a difference takes from days over what it takes from runs at most, where both vary alike."""
    most, next_to_most = sorted(row.n)[:-3:-1]
    return _taken(row) / (1.0 / most + 1.0 / next_to_most)


def _inequality(n: Sequence[int]) -> float:
    """Return the logarithm of how many times larger the largest group is than the smallest."""
    return math.log(max(n) / min(n))


def _days_an_unshared(days: Sequence[set[str]]) -> int:
    """Return of how many days one is not shared by all groups, in the group that shares least."""
    common = set.intersection(*days)
    return min(len(each) // (len(each) - len(common)) for each in days if each != common)
