"""Results that became stale, in words."""

from __future__ import annotations

import json
from typing import Any

SCOPES_NAMED = 6
"""Results of one kind that are named; --json lists them all."""


_ABOUT = ("run", "label", "condition", "pack", "robot", "study")


def stale_lines(stale: list[tuple[str, str]]) -> list[str]:
    """Return one line a kind of result: how many, and what the first are about."""
    if not stale:
        return ["No further results became stale."]
    by_kind: dict[str, list[str]] = {}
    for kind, scope in stale:
        by_kind.setdefault(kind, []).append(_scope_label(json.loads(scope)))
    lines = [
        f"{len(stale)} result{'s are' if len(stale) > 1 else ' is'} stale and will be computed anew by the next report:"
    ]
    for kind, about in by_kind.items():
        different = list(dict.fromkeys(filter(None, about)))
        more = f", and {len(different) - SCOPES_NAMED} more" if len(different) > SCOPES_NAMED else ""
        named = f": {', '.join(different[:SCOPES_NAMED])}{more}" if different else ""
        lines.append(f"  {kind.replace('_', ' ')} ({len(about)}){named}")
    return lines


def _scope_label(scope: dict[str, Any]) -> str:
    """Return the scope of a result in words: its label where it has many parts."""
    return str(next((scope[name] for name in _ABOUT if name in scope), ""))
