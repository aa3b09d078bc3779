"""Groups that share few or no days: what differs from day to day is then taken for what differs between them."""

from __future__ import annotations

from labbook.analysis.observations import Observations
from stats.recorded import weak_points

_MOST_NAMED = 3


def day_notes(observed: Observations, *, by_day: bool = False) -> list[str]:
    """Name the groups that share fewer than half of the days of whichever has fewer, with the control.

    `by_day` where the analysis has the day in it; otherwise how often Welch's test errs at such a design is said, and
    which command has it.
    """
    known = observed.known()
    if observed.by == "day" or not all(row.day for row in known.rows):
        return []
    days = {label: {row.day for row in known.rows if row.label == label} for label in known.labels}
    control = days.get(observed.control, set())
    few = [
        label
        for label in known.labels
        if label != observed.control and 2 * len(days[label] & control) < min(len(days[label]), len(control))
    ]
    if not few:
        return []
    name = observed.name(observed.control)
    shared = [
        f"{observed.name(label)} and {name} share {len(days[label] & control)} of {len(days[label] | control)} days"
        for label in few[:_MOST_NAMED]
    ]
    more = f"; so few are shared by {len(few) - _MOST_NAMED} more groups" if len(few) > _MOST_NAMED else ""
    said = f"{'; '.join(shared)}{more}"
    if by_day:
        return [f"{said}: only days that are shared tell the groups from their days, so that little is known here."]
    n = [len(known.values(label)) for label in (few[0], observed.control)]
    return [
        f"{said}: what differs from day to day passes for a difference of the groups here.{_simulated(n, control)} "
        "`labbook stats blocked` has the day in its model."
    ]


def _simulated(n: list[int], days: set[str]) -> str:
    rows = [row for row in weak_points("welch", n, len(days), layout="own") if row.kind == "size"]
    if not rows:
        return ""
    worst = max(rows, key=lambda row: row.value)
    sizes = " and ".join(map(str, worst.n))
    each = "a day" if worst.days == 1 else f"{worst.days} days"
    return (
        f" Simulated with {sizes} values on {each} of each group's own, with an SD between days of {worst.day_sd:g} "
        f"times that within, Welch's test at alpha = {worst.nominal:g} found a difference that is not there in "
        f"{100 * worst.value:.0f} % of studies (docs/statistics.md)."
    )
