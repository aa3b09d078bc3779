"""What days leave unknown of groups that share few or none: what differs from day to day passes for their difference.

Where two groups had one day each and not the same, nothing is claimed of them. Where they share days in part a note
says how often Welch's test errs, by the record.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from data_schema.rounding import number_text
from labbook.analysis.observations import Observations
from labbook.presenting.report.day_layout import SHARED, WHOSE, joined_by_others, one_day_each, without_days
from labbook.presenting.report.error_rates import spreads_text
from stats.planning.recorded import Recorded, weak_point

HERE, LEFT_OUT = "here", "where days are left out"
_MOST_NAMED = 3
_LITTLE_KNOWN = "only days that are shared tell the groups from their days, so that little is known here."
_KNOWN_BY_OTHERS = (
    "days of other groups join theirs, so that their difference rests on the values of those groups as well."
)
_DAY_LEFT_OUT = (
    "Tests that leave days out take values for independent; `labbook stats blocked` has the day in its model."
)

_Runs = Mapping[str, Counter[str]]
"""Values of each day, by label of the group."""


def one_day_groups(observed: Observations, labels: Sequence[str] | None = None) -> str:
    """Say that a p on these groups, or on pairs of all, is confounded with days; "" where none is."""
    runs = _runs(observed)
    alone = {label: runs[label] for label in labels or runs if label in runs and len(runs[label]) == 1}
    return one_day_each({observed.name(label): days for label, days in alone.items()})


def with_confounding(sentence: str, confounded: str) -> str:
    """Return the sentence, followed by the one on confounding with days, if any."""
    return f"{sentence} {confounded}." if confounded else sentence


def day_notes(observed: Observations, *, by_day: bool = False, where: str = HERE) -> list[str]:
    """Name the groups that share fewer than half of the days of whichever has fewer, with the control.

    `where` names the test in which a difference between days may pass for one between groups.

    `by_day` tells that the analysis has the day in it; then a single day gets a note, too. Without it groups that share
    more days are named, too, where Welch's test errs by the record; the note says how often, and what helps.
    """
    runs = _runs(observed)
    if by_day and len(set().union(*runs.values())) == 1:
        return [
            "All values are of one day, so that no day is in the model: nothing tells how much days differ, and what "
            "is found holds for that day."
        ]
    control = runs.get(observed.control, Counter())
    few = {
        label: None if by_day else _errs(days, control)
        for label, days in runs.items()
        if label != observed.control
        and (2 * len({*days} & {*control}) < min(len(days), len(control)) or (not by_day and _errs(days, control)))
    }
    if not few:
        return []
    if by_day:
        joined = {label: joined_by_others(label, observed.control, runs) for label in few}
        return [
            f"{_shared(observed, runs, labels)}: {known}"
            for others, known in ((False, _LITTLE_KNOWN), (True, _KNOWN_BY_OTHERS))
            if (labels := [label for label in few if joined[label] == others])
        ]
    return [
        f"{_shared(observed, runs, [*few])}: what differs from day to day passes for a difference of the groups "
        f"{where}."
        f"{_simulated(few, observed)} {_what_helps(runs)}"
    ]


def day_left_out(observed: Observations, given: str | None) -> list[str]:
    """Say that tests leave the days out that a table's column (`given`) holds, where `day_notes` says nothing."""
    runs = _runs(observed)
    tested = given is not None and observed.control in runs and len(set().union(*runs.values())) > 1
    return [_DAY_LEFT_OUT] if tested and not day_notes(observed) else []


def _shared(observed: Observations, runs: _Runs, labels: Sequence[str]) -> str:
    """Say how many days each of these groups shares with the control, of many the first."""
    name, control = observed.name(observed.control), runs[observed.control]
    shared = [
        f"{observed.name(label)} and {name} "
        + (
            "hold the days that they share in unequal parts"
            if {*runs[label]} == {*control}
            else f"share {len({*runs[label]} & {*control})} of {len({*runs[label]} | {*control})} days"
        )
        for label in labels[:_MOST_NAMED]
    ]
    more = f"; so few are shared by {len(labels) - _MOST_NAMED} more groups" if len(labels) > _MOST_NAMED else ""
    return f"{'; '.join(shared)}{more}"


def has_days(observed: Observations) -> bool:
    """Tell whether every value has a day, and days are not themselves the groups."""
    return bool(_runs(observed))


def _runs(observed: Observations) -> _Runs:
    """Return every group's values by day; nothing where days are not known, or are themselves the groups."""
    known = observed.known()
    of_days = observed.by == "day" or all(row.day == row.label for row in known.rows)
    if of_days or not all(row.day for row in known.rows):
        return {}
    return {label: Counter(row.day for row in known.rows if row.label == label) for label in known.labels}


def _errs(days: Counter[str], control: Counter[str]) -> Recorded | None:
    """Return the size on record of Welch's test where groups share their days as these do, if it is too large."""
    if not control:  # all of its values are missing
        return None
    n, count, layout = without_days("welch", [days, control])
    return None if layout == SHARED else weak_point("welch", n, layout, count)


def _simulated(few: Mapping[str, Recorded | None], observed: Observations) -> str:
    """Say how often Welch's test errs at the worst of these groups, and of several which that is."""
    found = [(row, label) for label, row in few.items() if row is not None]
    if not found:
        return ""
    worst, label = max(found, key=lambda each: each[0].value)
    days = "a day" if worst.days == 1 else f"{worst.days} days"
    sizes = " and ".join(map(str, worst.n))
    as_much = "as much as" if worst.day_sd == 1.0 else f"{worst.day_sd:g} times as much as"
    # The record gives what days differ by in standard deviations of the second group.
    of = "within a group" if worst.sd_ratio == 1.0 else "of the second group"
    at_worst = f" At worst, for {observed.name(label)}: simulated" if len(few) > 1 else " Simulated"
    return (
        f"{at_worst} with {sizes} values{spreads_text(worst)}, each group on {days} {WHOSE[worst.layout]}, days "
        f"differing {as_much} values {of}, Welch's test at alpha = {worst.nominal:g} found a difference that is not "
        f"there in {number_text(100.0 * worst.value)} % of studies (docs/statistics.md)."
    )


def _what_helps(runs: _Runs) -> str:
    if all(len(days) == 1 for days in runs.values()):
        return (
            "Measuring the groups on shared days is what helps: with one day each `labbook stats blocked` gives no p "
            "either."
        )
    return "`labbook stats blocked` has the day in its model."
