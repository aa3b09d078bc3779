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
    """Say whether the comparisons of a book's values are planned; `beside` is why the plan has no such question.

    Tests against `bounds` are planned with the bounds that were stated, on apex heights.
    """
    plan = observed.plan
    if plan is None:
        return []
    if bounds is not None and not observed.measured.has_equivalence:
        beside = NO_OTHER_BOUNDS
    family = pairing.POOLED if pooled else pairing.EACH
    beside, stated = _beside(plan, observed, beside), plan.settings.apex_bounds
    of_family = plan.reason(observed.measured, family) if bounds is None else plan.reason_of_equivalence(family)
    reasons = [beside, _other_alpha(plan, alpha)]
    if bounds is not None and stated is not None and plan.stated and not beside:
        decided = stated.low, stated.high, stated.percent
        other = f"the bounds decided on are {_bounds_text(decided)}, and here {_bounds_text(bounds)} are used"
        reasons.append(other if decided != bounds else "")
    return _notes(plan, reasons, family, None if beside else of_family)


def _beside(plan: Planned, observed: Observations, beside: str) -> str:
    """Return why the plan has no such question; where nothing was decided, that alone is the reason."""
    if not plan.stated:
        return NOTHING_DECIDED
    of_days = plan.settings.unit_of_analysis is UnitOfAnalysis.DAY
    return beside or observed.beside_plan or (
        "the unit of analysis decided on is the mean of a day's runs, and these are single runs" if of_days else ""
    )  # fmt: skip


def _other_alpha(plan: Planned, alpha: float) -> str:
    decided = plan.settings.alpha
    return (
        f"alpha decided on is {decided:g}, and {alpha:g} is used here"
        if plan.stated and abs(alpha - decided) > 1e-12
        else ""
    )


def _bounds_text(bounds: Bounded) -> str:
    low, high, percent = bounds
    ends = " to ".join("none" if end is None else f"{end:g}" for end in (low, high))
    return f"{ends} {'%' if percent else 'm'}"


def _notes(plan: Planned, reasons: Sequence[str], family: str, reason: Reason | None) -> list[str]:
    """Say that all is as decided, or why it is exploratory, then each departure that this has not told."""
    given = [said for said in (reason.text if reason else "", *reasons) if said]
    if given:
        return [f"Exploratory: {'; '.join(given)}.", *_departures(plan, reason)]
    since = "" if plan.stated_utc is None else f" on {plan.stated_utc[:10]} by {plan.stated_by}"
    return [f"As decided{since}, before the first measurement: {family}.", *_departures(plan)]


def _departures(plan: Planned, reason: Reason | None = None) -> list[str]:
    """Say what labbook.toml says otherwise now, and what was left out that was not to be, unless the reason names it.

    A reason names what was left out for a reason that was not allowed, and only where nothing was the rest.
    """
    named = set(reason.departures) if reason else set()
    named = named & set(map(not_allowed, plan.disallowed_exclusions)) or named
    return [f"{said[:1].upper()}{said[1:]}." for said in plan.departures if said not in named] if plan.stated else []
