"""How groups share their days, and the simulated design that stands for them: the nearest that errs no less often.

What a difference of means takes from days is the variance between days times the sum, over the days, of the squared
difference of both groups' shares of their runs: 0 where every day holds the same share of both, 2 where each had one
day of its own. A test that knows no days expects of the difference what the runs' own scatter lets it, which holds
what days make runs of a group differ by. How many times the variance exceeds what is expected (`_excess`, days and
runs varying alike) decides how often such a test errs: on days of one run each it is 1, whosever the days are.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cache
from itertools import combinations

from reports.display import list_text
from stats.planning.recorded import SEVERAL, Recorded, records

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
_AS_UNEQUAL = 0.05
"""Groups of 3 and 10 values a day and of 10 and 33 are as unequal."""

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
    return tuple(group.total() for group in groups), _days_counted(days, layout), layout


def without_days(method: str, groups: Runs) -> Found:
    """Return the design to look up for a method that knows no days: on record, and exceeding no less what is expected.

    It is one of the designs whose groups are about as unequal in size; of these one with the groups' own layout and
    number of days where there is one, which exceeds it least; beyond them, the one that exceeds it most. "shared" is
    where nothing is taken from days.
    """
    days = [set(group) for group in groups]
    sizes, layout = tuple(group.total() for group in groups), layout_of(days)
    count, pairs = _days_counted(days, layout), list(combinations(groups, 2))
    if not any(_between(a, b) for a, b in pairs):
        return sizes, max(map(len, days)), SHARED
    excess = _excess_by_design(method, sizes)
    if not excess:
        return sizes, max(map(len, days)), layout
    own = max(_excess(_between(a, b), (a.total(), _within(a)), (b.total(), _within(b))) for a, b in pairs)
    needed = min(own, max(excess.values())) * _ROUNDING
    chosen = min(
        (row for row, found in excess.items() if found >= needed),
        key=lambda row: (row.layout != layout, abs((row.days or 1) - count), excess[row]),
    )
    return chosen.n, chosen.days or 1, chosen.layout


@cache
def _excess_by_design(method: str, sizes: tuple[int, ...]) -> dict[Recorded, float]:
    """Return the designs on record of a method whose groups do not share all days and are about as unequal in size."""
    of_method = [row for row in records() if row.method == method and row.layout in _APART]
    rows = [row for row in of_method if min(len(row.n), SEVERAL) == min(len(sizes), SEVERAL)]
    most = min((_unlike(row.n, sizes) for row in rows), default=0.0) + _AS_UNEQUAL
    return {row: _excess_on_record(row) for row in rows if _unlike(row.n, sizes) <= most}


def _between(a: Counter[str], b: Counter[str]) -> float:
    """Return what the difference of two groups' means takes from days, in variances between days."""
    n_a, n_b = a.total(), b.total()
    return sum((a[day] / n_a - b[day] / n_b) ** 2 for day in {*a, *b})


def _within(group: Counter[str]) -> float:
    """Return what the sample variance of a group is expected to hold of days, in variances between days."""
    n = group.total()
    return (n * n - sum(runs * runs for runs in group.values())) / (n * (n - 1)) if n > 1 else 0.0


def _excess(between: float, *groups: tuple[int, float]) -> float:
    """Return the variance of a difference over what is expected of it; of each group its size and what is `_within`."""
    return (sum(1.0 / n for n, _within in groups) + between) / sum((1.0 + within) / n for n, within in groups)


@cache
def _excess_on_record(row: Recorded) -> float:
    """Return the same of the two groups of a recorded design that exceed it most; its days hold as many runs each."""
    days = row.days or 1
    pairs = combinations([(n, n * (1.0 - 1.0 / days) / (n - 1)) for n in row.n], 2)
    return max(_excess(_APART[row.layout](days), *pair) for pair in pairs)


def _unlike(n: tuple[int, ...], sizes: tuple[int, ...]) -> float:
    """Return how far apart designs are by the logarithm of the largest group over the smallest."""
    return abs(_inequality(n) - _inequality(sizes))


@cache
def _inequality(n: tuple[int, ...]) -> float:
    return math.log(max(n) / min(n))


def _days_counted(days: Sequence[set[str]], layout: str) -> int:
    """Return how many days a design of this layout has that stands for these; "mostly" leaves one of them unshared."""
    return _days_an_unshared(days) if layout == MOSTLY else max(map(len, days))


def _days_an_unshared(days: Sequence[set[str]]) -> int:
    """Return of how many days one is not shared by all groups, in the group that shares least."""
    common = set.intersection(*days)
    return min(len(each) // (len(each) - len(common)) for each in days if each != common)


def joined_by_others(label: str, control: str, days: Mapping[str, Collection[str]]) -> bool:
    """Whether days of other groups join a group and the control; `days` are those of every group.

    So it is where a chain of shared days leads from the one to the other over a third group.
    """
    others = {name: set(of_group) for name, of_group in days.items() if name != label}
    for day in days[label]:
        reached: set[str] = set()
        grown = {name for name, held in others.items() if name != control and day in held}
        while grown > reached:
            reached = grown
            held = set().union(*(others[name] for name in reached)) - {day}
            grown = reached | {name for name, of_group in others.items() if of_group & held}
        if control in reached:
            return True
    return False


FROM_DAYS = "a difference between days"
"""What a difference is confounded with where groups had one day each."""


def one_day_each(days: Mapping[str, Collection[str]]) -> str:
    """Say that a p over runs is confounded with days; `days` has those of each group by name.

    "" where groups share their one day, so that runs differ as runs do, and where one of them has several days, which
    show by how much days differ.
    """
    found = [set(of_group) for of_group in days.values()]
    if any(len(each) != 1 for each in found) or len(set().union(*found)) < 2:
        return ""
    alike = "not the same one" if len(found) == 2 else "not all the same one"
    return (
        f"{list_text(list(days))} were measured on one day each, and {alike}, so that a p or an interval that counts "
        "runs cannot tell a difference between them from a difference between their days"
    )
