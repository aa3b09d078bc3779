"""What days cannot tell: sentences on comparisons whose conditions and days go together."""

from __future__ import annotations

from data_schema.outcomes import Outcome
from reports.content import Comparison, ReportContent
from reports.naming import level_of, levels_name
from reports.wording import count_text

_LISTED = 4
"""Comparisons that a sentence names before it only counts them."""


def by_day_sentences(content: ReportContent, quantity: Outcome) -> list[str]:
    """Return what is confounded with days, or left out of the model, and in which comparisons."""
    blocked = [c for c in content.comparisons if c.quantity is quantity and c.by_day is not None]
    said: dict[str, list[Comparison]] = {}
    for comparison in blocked:
        if comparison.by_day is not None:
            # That sides of one day each are confounded with their days is said once, among the claims.
            confounding = "" if comparison.one_day_each else comparison.by_day.confounding
            for text in filter(None, (confounding, *comparison.by_day.notes)):
                said.setdefault(text, []).append(comparison)
    return [f"{text} This holds for{_which(content, found, len(blocked))}." for text, found in said.items()]


def _which(content: ReportContent, found: list[Comparison], total: int) -> str:
    if len(found) == total:
        return " the only comparison by day" if total == 1 else f" all {count_text(total, 'comparison')} by day"
    if len(found) > _LISTED:
        return f" {len(found)} of {count_text(total, 'comparison')} by day"
    names = (f"{levels_name(content, c.group) or 'all runs'}, {level_of(content, c)}" for c in found)
    return f": {'; '.join(names)}"
