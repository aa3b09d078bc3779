"""Groups of one day each: a p that counts their runs cannot tell the groups from their days, however small it is."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from labbook.analysis.observations import Observations
from reports.wording import list_text


def one_day_each(days: Mapping[str, Collection[str]]) -> str:
    """Say what a p over runs cannot tell, for groups by name with the days that each was measured on.

    "" where groups share their one day, so that runs differ as runs do, and where one of them has several days, which
    show by how much days differ.
    """
    found = [set(of_group) for of_group in days.values()]
    if any(len(each) != 1 for each in found) or len(set.union(*found)) == 1:
        return ""
    alike = "not the same one" if len(found) == 2 else "not all the same one"
    return (
        f"{list_text(list(days))} were measured on one day each, and {alike}, so that a p or an interval that counts "
        "runs cannot tell a difference between them from a difference between their days"
    )


def with_days_said(sentence: str, observed: Observations, label: str) -> str:
    """Return the sentence on a group and the control, followed by one on what its p cannot tell where there is any.

    There is none where days are not known, or are themselves the groups.
    """
    rows = [row for row in observed.known().rows if row.label in (label, observed.control)]
    if observed.by == "day" or not all(row.day for row in rows):
        return sentence
    sides = (label, observed.control)
    said = one_day_each({observed.name(one): {row.day for row in rows if row.label == one} for one in sides})
    return f"{sentence} {said}." if said else sentence
