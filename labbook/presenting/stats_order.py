"""The order in which a comparison over days tells its groups: the one that every other command of statistics has."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

from stats.blocked_result import BlockedByDay, ConditionMean, Contrast, ExactTest

_Told = TypeVar("_Told", ConditionMean, Contrast)


def in_order(found: BlockedByDay, names: Sequence[str]) -> BlockedByDay:
    """Return means, differences and lists of conditions in the order of `names`; no number is another.

    The comparison itself sorts names by alphabet, where "gain 10" stands before "gain 9".
    """
    exact = found.exact
    if isinstance(exact, ExactTest):
        exact = replace(exact, contrasts=_sorted(exact.contrasts, names))
    return replace(
        found,
        conditions=_sorted(found.conditions, names),
        contrasts=_sorted(found.contrasts, names),
        exact=exact,
        confounding=_lists_sorted(found.confounding, names),
    )


def _sorted(items: Sequence[_Told], names: Sequence[str]) -> tuple[_Told, ...]:
    return tuple(sorted(items, key=lambda item: names.index(item.condition)))


def _lists_sorted(text: str, names: Sequence[str]) -> str:
    """Sort every list of names in a text, as in "c 1, c 10, c 9"; a list of anything else stays as it is."""
    one = "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True))

    def listed(match: re.Match[str]) -> str:
        items = match[0].split(", ")
        return ", ".join(sorted(items, key=names.index)) if {*items} <= {*names} else match[0]

    return re.sub(rf"(?<!\w)(?:{one})(?:, (?:{one}))+(?!\w)", listed, text)
