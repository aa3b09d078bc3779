"""What was decided about the analysis, when and by whom, and what departs from it, in sentences."""

from __future__ import annotations

from collections.abc import Mapping

from data_schema.vocabulary import ReasonCode
from labbook.analysis.preregistration.planned import FAMILY_OF, NOTHING_DECIDED, Planned
from labbook.config.model import AnalysisSettings, UnitOfAnalysis

HOW_TO_DECIDE = (
    "write [analysis] in labbook.toml (the one that `labbook init` writes has an example) before the first file or "
    "charge comes in, or the report calls every comparison exploratory."
)

NOT_WATCHED = (
    "Not watched: runs never made or never entered, whether a value was corrected to please (that it was is listed), "
    "the study, the rest of labbook.toml (beside [analysis] and which jumps count), and what was looked at without a "
    "report; the journal has all but the first and the last of these."
)
"""What could depart from the plan and is not looked for."""

_UNITS: Mapping[UnitOfAnalysis, str] = {UnitOfAnalysis.RUN: "the run", UnitOfAnalysis.DAY: "the mean of a day's runs"}


def planned_sentences(planned: Planned) -> tuple[str, ...]:
    """Say what rules the analysis and since when, then each departure."""
    said = _settings(planned.settings)
    by = "" if planned.stated_utc is None else f" on {planned.stated_utc[:10]} by {planned.stated_by}"
    if planned.first_measured_utc is None:
        if not planned.stated:
            return (f"Nothing is decided about the analysis yet: {HOW_TO_DECIDE}",)
        kept = by or " in labbook.toml, which the book takes over with the next statement"
        return (f"Decided{kept}, and nothing is measured yet: {said}",)
    first = planned.first_measured_utc[:10]
    if not planned.stated:
        return (
            f"Nothing was decided about the analysis before the first measurement came into the book on {first}, so "
            f"every comparison is exploratory. Used are: {said}",
            *_departures(planned),
        )
    decided = f"Decided{by}, before the first measurement came into the book on {first}: {said}"
    return (decided, *made_before(planned), *_departures(planned))


def made_before(planned: Planned) -> tuple[str, ...]:
    """Say that runs are dated before the decision, which the book cannot place before their numbers; or nothing."""
    if planned.run_before is None or planned.stated_utc is None:
        return ()
    return (
        f"The first run is dated {planned.run_before}, before the decision was stated on {planned.stated_utc[:10]}: "
        "nothing shows that it was made before the data were seen.",
    )


def _departures(planned: Planned) -> tuple[str, ...]:
    return tuple(departure_sentence(said) for said in planned.departures if said != NOTHING_DECIDED)


def departure_sentence(said: str) -> str:
    """Write a departure of `Planned` as a sentence."""
    return f"Departure: {said}."


def _settings(settings: AnalysisSettings) -> str:
    bounds = settings.apex_bounds
    unit = "" if bounds is None else "% of the control's" if bounds.percent else "m"
    within = (
        "no bounds of apex height"
        if bounds is None
        else f"differences of apex height from {bounds.low:g} to {bounds.high:g} {unit} count as none"
    )
    return (
        f"the primary outcome is {settings.primary_outcome}, the family of comparisons "
        f"{FAMILY_OF[settings.family]}, alpha {settings.alpha:g}, the unit of analysis "
        f"{_UNITS[settings.unit_of_analysis]}; {within}; {_exclusions(settings)}."
    )


def _exclusions(settings: AnalysisSettings) -> str:
    if ReasonCode.OTHER in settings.exclusions:
        return "a person may leave out jumps and runs for any reason"
    listed = ", ".join(str(reason).replace("_", " ") for reason in settings.exclusions)
    return f"a person may leave out jumps and runs for: {listed or 'no reason'}"
