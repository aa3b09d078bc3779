"""Groups of one day each, all not the same: said once on the page, and marked in a few words wherever a p stands."""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.vocabulary import Undefined
from reports.content import Claim, Comparison, ReportContent
from reports.wording import count_text, list_text

NOT_FROM_DAYS = "cannot be told from a difference between days"
"""The mark in claims and other sentences."""
FOOTNOTE = f"groups of one day each, whose difference {NOT_FROM_DAYS}"
"""The mark in tables; their files say in full what the row's groups are."""


def all_on_one_day_each(comparisons: Sequence[Comparison]) -> bool:
    """Tell whether there are tests, and the groups of each had one day, and not the same."""
    tested = [item for item in comparisons if not isinstance(item.test.statistic, Undefined)]
    return bool(tested) and all(item.one_day_each for item in tested)


def days_claim(content: ReportContent) -> Claim | None:
    """Say what a p over runs cannot tell, of how many tests that is so, and what would help; None where of none."""
    tested = (
        ("comparison", "", content.comparisons),
        ("test over single jumps", "tests over single jumps", content.jump_comparisons),
        ("analysis of variance", "analyses of variance", content.anovas),
    )
    counted = [
        count_text(count, one, several)
        for one, several, items in tested
        if (count := sum(bool(item.one_day_each) for item in items))
    ]
    if not counted:
        return None
    return Claim(
        f"In {list_text(counted)} the groups were measured on one day each, and not all on the same one, so that a p "
        "or an interval that counts runs or jumps cannot tell a difference between them from a difference between "
        "their days: measure the conditions on shared days. The tables mark each of them."
    )
