"""What a report says of what was decided beforehand: the settings, what departs from them, what they leave untested."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from labbook.analysis.preregistration.planned import AS_A_WHOLE, Reason, not_allowed
from labbook.analysis.study import StudyAnalysis
from labbook.presenting.report.planned import departure_sentence, made_before, planned_sentences
from reports.content import Comparison
from reports.wording import sentence_start


def decided(analysis: StudyAnalysis) -> tuple[str, ...]:
    """Return what was decided and when, and what nothing shows of that."""
    return planned_sentences(analysis.planned)[: 1 + len(made_before(analysis.planned))]


def departures(analysis: StudyAnalysis, compared: Sequence[Comparison]) -> tuple[str, ...]:
    """Return what departs from it, each with what is exploratory for it; then what was not planned at all, and why.

    `compared` shows the analysis's comparisons in their order.
    """
    planned = analysis.planned
    said = planned_sentences(planned)[len(decided(analysis)) :]
    if not planned.stated:
        return said
    departing: dict[str, dict[str, None]] = {}
    others: dict[str, dict[str, None]] = {}
    for reason, name in _exploratory(analysis, compared):
        for departure in reason.departures:
            departing.setdefault(departure_sentence(departure), {})[name] = None
        if not reason.departures:
            others.setdefault(reason.text, {})[name] = None
    concerning = departing.keys() & {departure_sentence(not_allowed(item)) for item in planned.disallowed_exclusions}
    as_a_whole = (f"{sentence_start(AS_A_WHOLE)}.",) if concerning else ()
    return (
        *(_with_exploratory(sentence, departing.get(sentence, ())) for sentence in said),
        *as_a_whole,
        *(f"Exploratory, because {reason}: {', '.join(names)}." for reason, names in others.items()),
    )


def _with_exploratory(sentence: str, names: Collection[str]) -> str:
    return f"{sentence} Exploratory for it: {', '.join(names)}." if names else sentence


def _exploratory(analysis: StudyAnalysis, compared: Sequence[Comparison]) -> Iterator[tuple[Reason, str]]:
    """Give a reason and what is exploratory for it, comparison by comparison, then what no plan can have."""
    planned = analysis.planned
    for item, shown in zip(analysis.compared, compared, strict=True):
        asked = (item.pair.family, item.conditions)
        if reason := planned.reason(item.quantity, *asked):
            yield reason, f"{shown.family} ({shown.quantity})"
        if shown.equivalence is not None and (reason := planned.reason_of_equivalence(*asked)):
            yield reason, f"{shown.family} (equivalence of {shown.quantity})"
    for tested in analysis.anovas:
        yield Reason(planned.exploratory_anova()), f"one-way analysis of variance ({tested.quantity})"
    for jumps in analysis.jump_tests:
        yield Reason(planned.exploratory_jumps()), f"{jumps.pair.family}, over single jumps"


def no_equivalence(analysis: StudyAnalysis) -> str:
    """Say why apex heights are not tested for equality, and how that is asked for; "" where they are."""
    compared = any(item.quantity.has_equivalence for item in analysis.compared)
    if not compared or analysis.planned.settings.apex_bounds is not None:
        return ""
    return (
        "That a difference of apex height is not told from zero does not show that heights are equal. No test of "
        "equivalence is made, because labbook.toml states no bounds within which a difference counts as none: write, "
        "before the first run, `apex_bounds_percent = [-3, 3]` (of the control's mean) or `apex_bounds_m = [-0.005, "
        "0.005]` under [analysis]."
    )
