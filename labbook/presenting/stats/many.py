"""Many comparisons in a sentence: those with a small p and a count, where all of them would hide the rest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from data_schema.rounding import alpha_beside
from data_schema.vocabulary import Undefined
from stats.groups.dunnett import AgainstControl, Dunnett
from stats.groups.multiple import none_text, reasons_text
from stats.groups.tukey import AllPairs, PairDifference

Compared = TypeVar("Compared", PairDifference, AgainstControl)

MOST_IN_WORDS = 10
"""Of more comparisons only those with a small p are said; five groups have so many pairs."""


def all_pairs_text(found: AllPairs, unit: str) -> str:
    """Say all pairs, or of many those whose adjusted p is at most 1 - level, and how many there are."""
    if len(found.pairs) <= MOST_IN_WORDS:
        return found.sentence(unit)
    names = [f"{pair.a} minus {pair.b}" for pair in found.pairs]
    said = _counted(found.pairs, names, lambda pair: found.pair_text(pair, unit), found.level, "pairs")
    return f"{found.head_text()}: {said}; --full lists them all."


def against_control_text(found: Dunnett, unit: str) -> str:
    """Say all comparisons with the control, or of many those with an adjusted p of at most 1 - level, and how many."""
    if len(found.comparisons) <= MOST_IN_WORDS:
        return found.sentence(unit)
    names = [item.treatment for item in found.comparisons]
    said = _counted(found.comparisons, names, lambda item: found.comparison_text(item, unit), found.level, "groups")
    return f"{found.head_text()}: {said}; --full lists them all."


def _counted(
    items: Sequence[Compared], names: Sequence[str], text: Callable[[Compared], str], level: float, what: str
) -> str:
    """Say how many of the items have a small p, the smallest of these, and which have none and why."""
    alpha = alpha_beside(level)
    untested = [(name, item.p.reason) for name, item in zip(names, items, strict=True) if isinstance(item.p, Undefined)]
    tested = len(items) - len(untested)
    if not tested:
        return f"none of {len(items)} {what} is tested{none_text(untested)}"
    small = [item for item in items if isinstance(item.p, float) and item.p <= alpha]
    of = f"{tested} {what} tested" if untested else f"{len(items)} {what}"
    has = "has" if len(small) < 2 else "have"
    which = "" if len(small) <= MOST_IN_WORDS else f"the {MOST_IN_WORDS} smallest: "
    listed = f" ({which}{'; '.join(map(text, _smallest(small)))})" if small else ""
    lacking = f"; {len(untested)} of {len(items)} have no test: {reasons_text(untested)}" if untested else ""
    return f"{len(small) or 'none'} of {of} {has} an adjusted p of at most {alpha:g}{listed}{lacking}"


def _smallest(small: Sequence[Compared]) -> list[Compared]:
    """Return those with the smallest p, in their order."""
    named = sorted(range(len(small)), key=lambda place: _size(small[place]))[:MOST_IN_WORDS]
    return [small[place] for place in sorted(named)]


def _size(item: PairDifference | AgainstControl) -> float:
    return item.log10_p if isinstance(item.log10_p, float) else 0.0
