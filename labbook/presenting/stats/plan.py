"""Whether what is asked on the command line is what was decided before the first measurement, as notes say it."""

from __future__ import annotations

from collections.abc import Sequence

from labbook.analysis.comparison import pairing
from labbook.analysis.observations import Observations
from labbook.analysis.preregistration.planned import NOTHING_DECIDED, Planned, Reason, not_allowed
from labbook.config.model import UnitOfAnalysis

NO_ANOVA = "the plan compares with the control only, not all groups or all pairs"
NO_OTHER_BOUNDS = "the plan has bounds of apex height only"

Bounded = tuple[float | None, float | None, bool]
"""Both bounds, None for one that is not there, and whether they are in percent."""


def plan_notes(
    observed: Observations, pooled: bool, alpha: float, beside: str = "", bounds: Bounded | None = None
) -> list[str]:
    """Say whether the comparisons of a book's values are planned; `beside` is why the plan has no such comparison.

    Tests against `bounds` are planned where these are the bounds decided on, for apex heights.
    """
    plan = observed.plan
    if plan is None:
        return []
    if bounds is not None and not observed.measured.has_equivalence:
        beside = NO_OTHER_BOUNDS
    family = pairing.POOLED if pooled else pairing.EACH
    beside, planned_bounds = _beside(plan, observed, beside), plan.settings.apex_bounds
    of_family = plan.reason(observed.measured, family) if bounds is None else plan.reason_of_equivalence(family)
    reasons = [beside, _other_alpha(plan, alpha), "" if bounds else _other_side(plan, observed)]
    if bounds is not None and planned_bounds is not None and plan.stated and not beside:
        decided = planned_bounds.low, planned_bounds.high, planned_bounds.percent
        other = f"the bounds decided on are {_bounds_text(decided)}, and here {_bounds_text(bounds)} are used"
        reasons.append(other if decided != bounds else "")
    return _notes(plan, reasons, family, None if beside else of_family)


def _beside(plan: Planned, observed: Observations, beside: str) -> str:
    """Return why the plan has no such comparison; where nothing was decided, that alone is the reason."""
    if not plan.stated:
        return NOTHING_DECIDED
    of_days = plan.settings.unit_of_analysis is UnitOfAnalysis.DAY
    return beside or observed.why_not_planned or (
        "the unit of analysis decided on is the mean of a day's runs, and these are single runs" if of_days else ""
    )  # fmt: skip


def _other_alpha(plan: Planned, alpha: float) -> str:
    decided = plan.settings.alpha
    return (
        f"alpha decided on is {decided:g}, and {alpha:g} is used here"
        if plan.stated and abs(alpha - decided) > 1e-12
        else ""
    )


def _other_side(plan: Planned, observed: Observations) -> str:
    """Say that Welch's test here is two-sided where the plan counts runs or days and tests savings one-sided."""
    settings = plan.settings
    welch = settings.unit_of_analysis is not UnitOfAnalysis.SHARED_DAYS
    decided = plan.stated and settings.one_sided and observed.measured.has_savings
    return "a saving is tested one-sided by the plan, and two-sided here" if decided and welch else ""


def _bounds_text(bounds: Bounded) -> str:
    low, high, percent = bounds
    ends = " to ".join("none" if end is None else f"{end:g}" for end in (low, high))
    return f"{ends} {'%' if percent else 'm'}"


def _notes(plan: Planned, reasons: Sequence[str], family: str, reason: Reason | None) -> list[str]:
    """Say that all is as decided, or why it is exploratory, then each departure that is not part of that reason."""
    texts = [text for text in (reason.text if reason else "", *reasons) if text]
    if texts:
        return [f"Exploratory: {'; '.join(texts)}.", *_departures(plan, reason)]
    since = "" if plan.stated_utc is None else f" on {plan.stated_utc[:10]} by {plan.stated_by}"
    return [f"As decided{since}, before the first measurement: {family}.", *_departures(plan)]


def _departures(plan: Planned, reason: Reason | None = None) -> list[str]:
    """Return the departures of the plan as sentences, but for those that the reason names already.

    A reason names exclusions that were not allowed; it names other departures only where there are no such exclusions.
    """
    named = set(reason.departures) if reason else set()
    named = named & set(map(not_allowed, plan.disallowed_exclusions)) or named
    return [f"{text[:1].upper()}{text[1:]}." for text in plan.departures if text not in named] if plan.stated else []
