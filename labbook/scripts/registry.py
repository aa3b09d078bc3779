"""Which kinds of numbers have a script, by the kind of their result."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from labbook.scripts.facts import Facts
from labbook.scripts.kinds import (
    anova,
    conditions,
    contrasts,
    decisions,
    drains,
    equivalence,
    families,
    hypotheses,
    overall,
    packs,
    two_samples,
)
from labbook.scripts.script import Asked, Script


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of numbers: what they are called, and what makes the script of one; None where it has none."""

    about: str
    script: Callable[[Asked, Facts], Script | None]


KINDS: Mapping[str, Kind] = {
    "condition_summary": Kind(conditions.ABOUT, conditions.script),
    "passive_drain": Kind(drains.ABOUT, drains.script),
    "decision": Kind(decisions.ABOUT, decisions.script),
    "decision_family": Kind(families.ABOUT, families.script),
    "decision_equivalence": Kind(equivalence.ABOUT, equivalence.script),
    "contrast": Kind(contrasts.ABOUT, contrasts.script),
    "overall_savings": Kind(overall.ABOUT, overall.script),
    "overall_equivalence": Kind(overall.ABOUT, overall.script_of_equivalence),
    "thesis_route": Kind(two_samples.ABOUT, two_samples.script),
    "thesis_route_over_jumps": Kind(two_samples.ABOUT, two_samples.script_over_jumps),
    "anova": Kind(anova.ABOUT, anova.script),
    "pack_deviation": Kind(packs.ABOUT, packs.script),
    "hypothesis": Kind(hypotheses.ABOUT, hypotheses.script),
}
"""By the kind of result, as `numbers.json` has it."""


def kinds_in_words() -> str:
    """Return which numbers have a script."""
    *most, last = dict.fromkeys(kind.about for kind in KINDS.values())
    return f"{', '.join(most)} and {last}"
