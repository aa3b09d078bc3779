"""A remark where somebody leaves out jumps or a run for a reason that `[analysis]` does not allow; never a refusal."""

from __future__ import annotations

import sqlalchemy as sa

from labbook.analysis.preregistration.planned import AS_A_WHOLE, is_allowed, planned_analysis
from labbook.config.parsing import Configuration


def reason_remarks(
    connection: sa.Connection, configuration: Configuration, reason: str, concerned: str = "every comparison"
) -> list[str]:
    """Return what to say of a reason while it can still be thought over: nothing, or one remark.

    `concerned` are the comparisons that become exploratory: all by a void run, those of heights by a rejected jump.
    """
    planned = planned_analysis(connection, configuration)
    if not planned.stated or is_allowed(reason, planned.settings.exclusions):
        return []
    listed = ", ".join(map(str, planned.settings.exclusions)) or "no reason"
    return [f"[analysis] allows {listed}, so the report calls {concerned} exploratory ({reason}): {AS_A_WHOLE}."]
