"""Groups of one day each: a p that counts their runs cannot tell the groups from their days, however small it is."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from reports.wording import list_text

FROM_DAYS = "a difference between days"
"""What nothing can be told from where groups had one day each."""


def one_day_each(days: Mapping[str, Collection[str]]) -> str:
    """Say what a p over runs cannot tell, for groups by name with the days that each was measured on.

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
