"""Tests that could not be made, in words: which of many, and why."""

from __future__ import annotations

from collections.abc import Sequence

MOST_NAMED = 10
"""Of more tests than these with one reason only the first are named."""


def reasons_text(untested: Sequence[tuple[str, str]]) -> str:
    """Return names with the reason behind all that share it, from (name, reason)."""
    names: dict[str, list[str]] = {}
    for name, reason in untested:
        names.setdefault(reason, []).append(name)
    return "; ".join(f"{_some_of(own)}, because {reason}" for reason, own in names.items())


def none_text(untested: Sequence[tuple[str, str]]) -> str:
    """Return what follows "none tested", from (name, reason): the one reason that all have, or names and reasons."""
    reasons = {reason for _name, reason in untested}
    return f", because {reasons.pop()}" if len(reasons) == 1 else f": {reasons_text(untested)}"


def _some_of(names: Sequence[str]) -> str:
    """Return all names, or of many the first and how many more there are."""
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return f"{', '.join(names[:MOST_NAMED])}{more}"
