"""What a report says of what was decided beforehand: the settings, what departs from them, what they leave untested."""

from __future__ import annotations

from collections.abc import Sequence

from labbook.analysis.study import StudyAnalysis
from labbook.presenting.planned import made_before, planned_sentences
from reports.content import Comparison, Quantity


def decided(analysis: StudyAnalysis) -> tuple[str, ...]:
    """Return what was decided and when, and what nothing shows of that."""
    return planned_sentences(analysis.planned)[: 1 + len(made_before(analysis.planned))]


def departures(analysis: StudyAnalysis, compared: Sequence[Comparison]) -> tuple[str, ...]:
    """Return what departs from it, and which comparisons are exploratory for what reason."""
    planned = analysis.planned
    said = planned_sentences(planned)[len(decided(analysis)) :]
    if not planned.stated:
        return said
    reasons: dict[str, dict[str, None]] = {}
    for item in compared:
        if item.exploratory:
            reasons.setdefault(item.exploratory, {})[f"{item.family} ({item.quantity})"] = None
        if item.equivalence is not None and item.equivalence.exploratory:
            name = f"{item.family} (equivalence of {item.quantity})"
            reasons.setdefault(item.equivalence.exploratory, {})[name] = None
    for tested in analysis.anovas:
        name = f"one-way analysis of variance ({tested.quantity})"
        reasons.setdefault(planned.exploratory_anova(), {})[name] = None
    for jumps in analysis.jump_tests:
        reasons.setdefault(planned.exploratory_jumps(), {})[f"{jumps.pair.family}, over single jumps"] = None
    found = (f"Exploratory, because {reason}: {', '.join(families)}." for reason, families in reasons.items())
    return (*said, *found)


def no_equivalence(analysis: StudyAnalysis) -> str:
    """Say why apex heights are not tested for equality, and how that is asked for; "" where they are."""
    compared = any(item.quantity is Quantity.APEX for item in analysis.compared)
    if not compared or analysis.planned.settings.apex_bounds is not None:
        return ""
    return (
        "That a difference of apex height is not told from zero does not show that heights are equal. No test of "
        "equivalence is made, because labbook.toml states no bounds within which a difference counts as none: write, "
        "before the first run, `apex_bounds_percent = [-3, 3]` (of the control's mean) or `apex_bounds_m = [-0.005, "
        "0.005]` under [analysis]."
    )
