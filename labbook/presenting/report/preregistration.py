"""What was decided about the analysis beforehand, what departs from it, and what that leaves untested."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from data_schema.queries.runs import RunRow
from data_schema.vocabulary import ReasonCode
from labbook.analysis.preregistration.departures import first_named
from labbook.analysis.preregistration.planned import (
    AS_A_WHOLE,
    FAMILY_OF,
    NOTHING_DECIDED,
    Planned,
)
from labbook.analysis.study import StudyAnalysis
from labbook.config.model import HOW_TO_DECIDE, AnalysisSettings
from reports.display import list_text, sentence_start

NOT_WATCHED = (
    "Not watched: runs never made or never entered, whether a value was corrected to please (that it was is listed), "
    "the study, the rest of labbook.toml (beside [analysis] and which jumps count), and what was looked at without a "
    "report; the journal has all but the first and the last of these."
)
"""What could depart from the plan and is not looked for."""

_UNIT = "the day where four or more are shared, else the run within shared days"


def planned_sentences(planned: Planned) -> tuple[str, ...]:
    """Say what rules the analysis and since when, then each departure."""
    return (*decision_sentences(planned), *_departures(planned))


def decision_sentences(planned: Planned) -> tuple[str, ...]:
    """Say what was decided and when; then, where it is so, that nothing shows that this was before the data were seen.

    So it is where runs are dated before the decision, which the book cannot place before their numbers.
    """
    settings = _settings(planned)
    by = "" if planned.stated_utc is None else f" on {planned.stated_utc[:10]} by {planned.stated_by}"
    if planned.first_measured_utc is None:
        if not planned.stated:
            return (f"Nothing is decided about the analysis yet: {HOW_TO_DECIDE}",)
        where = by or " in labbook.toml, which the book takes over with the next statement"
        return (f"Decided{where}, and nothing is measured yet: {settings}",)
    first = planned.first_measured_utc[:10]
    if not planned.stated:
        return (
            f"Nothing was decided about the analysis before the first measurement came into the book on {first}, so "
            f"every comparison is exploratory. Used are: {settings}",
        )
    in_time = f"Decided{by}, before the first measurement came into the book on {first}: {settings}"
    if planned.run_before is None or planned.stated_utc is None:
        return (in_time,)
    return (
        in_time,
        f"The first run is dated {planned.run_before}, before the decision: "
        "nothing shows that the decision was made before the data were seen.",
    )


def _departures(planned: Planned) -> tuple[str, ...]:
    return tuple(_departure_sentence(text) for text in planned.departures if text != NOTHING_DECIDED)


def _departure_sentence(text: str) -> str:
    """Write a departure of `Planned` as a sentence."""
    return f"Departure: {text}."


def _settings(planned: Planned) -> str:
    settings, look = planned.settings, planned.look
    alpha = f"{settings.alpha if look is None else look.alpha:g}"
    if look is not None and look.planned > 1:
        alpha += f" over {look.planned} looks by Lan and DeMets' spending of O'Brien and Fleming's type"
    bounds, one_sided = settings.apex_bounds, " one-sided of a saving" if settings.one_sided else ""
    unit = "" if bounds is None else "% of the control's" if bounds.percent else "m"
    within = (
        "no bounds of apex height"
        if bounds is None
        else f"differences of apex height from {bounds.low:g} to {bounds.high:g} {unit} count as none"
    )
    return (
        f"the primary outcome is {settings.primary_outcome}, the family "
        f"{FAMILY_OF[settings.family]}, alpha {alpha}{one_sided}, the unit "
        f"{_UNIT}; {within}; {_exclusions(settings)}{_contrasts(settings)}."
    )


def _contrasts(settings: AnalysisSettings) -> str:
    return f"; contrasts: {', '.join(map(str, settings.contrasts))}" if settings.contrasts else ""


def _exclusions(settings: AnalysisSettings) -> str:
    if ReasonCode.OTHER in settings.exclusions:
        return "a person may leave out jumps and runs for any reason"
    listed = ", ".join(str(reason).replace("_", " ") for reason in settings.exclusions)
    return f"a person may leave out jumps and runs for: {listed or 'no reason'}"


def departures(analysis: StudyAnalysis) -> tuple[str, ...]:
    """Return what departs from it, each with the outcomes that are exploratory for it."""
    planned = analysis.planned
    found = []
    for text in planned.departures if planned.stated else ():
        of = next((item.quantities for item in planned.further if item.sentence == text), ())
        exploratory = f" Exploratory for it: {list_text([outcome.plural for outcome in of])}." if of else ""
        found.append(f"{_departure_sentence(text)}{exploratory}")
    as_a_whole = (f"{sentence_start(AS_A_WHOLE)}.",) if planned.disallowed_exclusions else ()
    return (*(found if planned.stated else _departures(planned)), *as_a_whole)


def void_sentence(void: Sequence[RunRow], reasons: Mapping[str, str]) -> str:
    """Name runs that are void by the `reasons` (by uid); "" without one."""
    names: dict[str, list[str]] = {}
    for run in void:
        names.setdefault(reasons.get(run.uid, ""), []).append(run.name)
    listed = [f"{first_named(several)} ({reason})" for reason, several in names.items()]
    return f"Void: {'; '.join(listed)}." if listed else ""


def no_equivalence(analysis: StudyAnalysis) -> str:
    """Say why apex heights are not tested for equality, and how that is asked for; "" where they are."""
    compared = any(item.shown.quantity.has_equivalence for item in analysis.compared)
    if not compared or analysis.planned.settings.apex_bounds is not None:
        return ""
    return (
        "That a difference of apex height is not told from zero does not show that heights are equal. No test of "
        "equivalence is made, because labbook.toml states no bounds within which a difference counts as none: write, "
        "before the first run, `apex_bounds_percent = [-3, 3]` (of the control's mean) or `apex_bounds_m = [-0.005, "
        "0.005]` under [analysis]."
    )
