"""Many comparisons in a sentence: those with a small p and a count, where all of them would hide the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

from data_schema.rounding import alpha_beside
from data_schema.vocabulary import Undefined
from stats.dunnett import AgainstControl, Dunnett
from stats.multiple import HolmFamily
from stats.tukey import AllPairs, PairDifference

Compared = TypeVar("Compared", PairDifference, AgainstControl)

MOST_IN_WORDS = 10
"""More comparisons than these stand in the table only, but for those with a small p; five groups have so many pairs."""


def all_pairs_text(found: AllPairs, unit: str) -> str:
    """Say all pairs, or of many those whose adjusted p is at most 1 - level, and how many there are."""
    if len(found.pairs) <= MOST_IN_WORDS:
        return found.sentence(unit)
    small = _small(found.pairs, found.level)
    shown = replace(found, pairs=_first(small)).sentence(unit)
    head = replace(found, pairs=found.pairs[:1]).sentence(unit).partition(": ")[0]
    return _counted(head, shown, small, found.pairs, found.level, "pairs")


def against_control_text(found: Dunnett, unit: str) -> str:
    """Say all comparisons with the control, or of many those with an adjusted p of at most 1 - level, and how many."""
    if len(found.comparisons) <= MOST_IN_WORDS:
        return found.sentence(unit)
    small = _small(found.comparisons, found.level)
    shown = replace(found, comparisons=_first(small)).sentence(unit)
    return _counted(shown.partition(": ")[0], shown, small, found.comparisons, found.level, "groups")


def family_text(family: HolmFamily) -> str:
    """Say the family; where tests of it could not be made, how many were and why the others were not."""
    untested = [(name, p.reason) for name, p in zip(family.names, family.p, strict=True) if isinstance(p, Undefined)]
    if not untested:
        return family.sentence()
    tested, holm = len(family.names) - len(untested), f" at {family.alpha:g}: "
    head, _holm, verdicts = family.sentence().removesuffix(".").partition(holm)
    if not tested:
        return f"{head}{holm}none tested{_why_none(untested)}."
    return f"{head}{holm}{tested} tested, {verdicts}; not tested: {_with_reasons(untested)}."


def _why_none(untested: Sequence[tuple[str, str]]) -> str:
    """Say why nothing was tested: once where all have one reason, else with the names."""
    reasons = {reason for _name, reason in untested}
    return f", because {reasons.pop()}" if len(reasons) == 1 else f": {_with_reasons(untested)}"


def _with_reasons(untested: Sequence[tuple[str, str]]) -> str:
    """Return names with the reason behind all that share it."""
    names: dict[str, list[str]] = {}
    for name, reason in untested:
        names.setdefault(reason, []).append(name)
    return "; ".join(f"{_some_of(own)}, because {reason}" for reason, own in names.items())


def _some_of(names: Sequence[str]) -> str:
    """Return all names, or of many the first and how many more there are."""
    more = f" and {len(names) - MOST_IN_WORDS} more" if len(names) > MOST_IN_WORDS else ""
    return f"{', '.join(names[:MOST_IN_WORDS])}{more}"


def _small(items: Sequence[Compared], level: float) -> tuple[Compared, ...]:
    return tuple(item for item in items if isinstance(item.p, float) and item.p <= alpha_beside(level))


def _first(small: tuple[Compared, ...]) -> tuple[Compared, ...]:
    """Return those with the smallest p, in their order."""
    named = sorted(range(len(small)), key=lambda place: _size(small[place]))[:MOST_IN_WORDS]
    return tuple(small[place] for place in sorted(named))


def _size(item: PairDifference | AgainstControl) -> float:
    return item.log10_p if isinstance(item.log10_p, float) else 0.0


def _counted(
    head: str,
    shown: str,
    small: Sequence[PairDifference | AgainstControl],
    items: Sequence[PairDifference | AgainstControl],
    level: float,
    what: str,
) -> str:
    untested = [(_name(item), item.p.reason) for item in items if isinstance(item.p, Undefined)]
    tested = len(items) - len(untested)
    if not tested:
        return f"{head}: none of {len(items)} {what} is tested{_why_none(untested)}; the table below has all."
    of = f"{tested} {what} tested" if untested else f"{len(items)} {what}"
    lacking = f"; {len(untested)} of {len(items)} have no test: {_with_reasons(untested)}" if untested else ""
    listed = ""
    if small:
        which = "" if len(small) <= MOST_IN_WORDS else f"the {MOST_IN_WORDS} smallest: "
        listed = f" ({which}{shown.partition(': ')[2].removesuffix('.')})"
    has = "has" if len(small) < 2 else "have"
    return (
        f"{head}: {len(small) or 'none'} of {of} {has} an adjusted p of at most "
        f"{alpha_beside(level):g}{listed}"
        f"{lacking}; the table below has all."
    )


def _name(item: PairDifference | AgainstControl) -> str:
    return f"{item.a} minus {item.b}" if isinstance(item, PairDifference) else item.treatment
