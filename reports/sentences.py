"""What claims are made of: groups, bounds and families in words, and the words for what is missing."""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports.content import Claim, Comparison, ReportContent
from reports.display import (
    common_places,
    count_text,
    given_text,
    list_text,
    shown_unit,
    value_text,
    with_unit,
)
from reports.evidence import Decision, Equivalence
from reports.naming import (
    control_name,
    level_names,
    level_of,
    levels_name,
    swept_factor,
    treatment_name,
)
from reports.numbers import Number


def where_text(content: ReportContent, comparison: Comparison) -> str:
    """Say for which group a claim holds: " with the small foot and k = 1091 N/m"; "" for all runs."""
    names = level_names(content, comparison.group)
    parts = [name if "=" in name else f"the {name}" for name in names]
    return f" with {list_text(parts)}" if parts else ""


def holm_clause(lead: Decision) -> str:
    """Say that the family's tests leave nothing shown, " once the 4 tests ..."; "" where they do not, or are one.

    An interval of level 1 - alpha is not adjusted: what it shows alone, Holm's p may not.
    """
    adjusted = lead.adjusted
    if adjusted is None or isinstance(adjusted.value, Undefined) or lead.adjusted_rejected:
        return ""
    return f" once the {adjusted.n} tests of the family are counted by Holm"


def exploratory_text(why: str, what: str = "comparison") -> str:
    """End the sentence on what was not planned."""
    return f", an exploratory {what}" if why else ""


def bounds_text(item: Equivalence) -> str:
    """Write the bounds as "-5 to 5 mm"."""
    unit, factor = shown_unit(item.estimate.unit)
    low, high = (given_text(bound * factor) for bound in (item.low, item.high))
    return with_unit(f"{low} to {high}", unit)


def sides_text(content: ReportContent, comparison: Comparison) -> tuple[str, str]:
    """Return " against the control (sand)" and " between" both sides; "" where the control has a name of its own."""
    if _has_named_control(content):
        return "", ""
    control = control_name(content)
    return f" against {control}", f" between {treatment_name(content, comparison.group)} and {control}"


def _has_named_control(content: ReportContent) -> bool:
    """Whether labbook.toml gives the control a name, which the page says once."""
    swept = swept_factor(content)
    return swept is not None and bool(swept.control_name)


def family_claim(content: ReportContent, planned: Sequence[Comparison], *, pooled: bool = True) -> Claim:
    """Say which comparisons of the family that was decided on are shown, where the claims are not of that family.

    `pooled` tells whether these pool levels.
    """
    by_quantity, ids = [], []
    any_planned = not all(item.exploratory for item in planned)
    for quantity in Outcome:
        family = [item for item in planned if item.quantity is quantity]
        shown = [item for item in family if item.decision.adjusted_rejected is True]
        if family:
            n_untested = sum(item.decision.rejected is None for item in family)
            saved = [item.decision.savings for item in shown if item.decision.savings is not None]
            notes = [_named(content, shown)] if 0 < len(shown) <= min(_MOST_NAMED, len(family) - (not saved)) else []
            notes += [f"savings of {_range_text(saved)}"] if saved and not notes else []
            notes += [f"{n_untested} without a test"] if n_untested else []
            beside = "in exploratory ones " if any_planned and family[0].exploratory else ""
            counted = f"{beside}{len(shown) or 'none'} of {count_text(len(family), 'comparison')}"
            by_quantity.append(f"{counted} of {quantity}" + (f" ({'; '.join(notes)})" if notes else ""))
            adjusted = [item.decision.adjusted for item in family]
            ids += [one.provenance for one in adjusted if one is not None][:1]
    named = "Decided on beforehand was" if any_planned else "The family of comparisons is"
    text = (
        f"{named} {planned[0].family}. A difference is shown, counted by Holm, in {list_text(by_quantity)}."
        f"{' The levels are pooled in what follows, which is exploratory.' if pooled else ''}"
    )
    return Claim(text, tuple(filter(None, ids)))


_MOST_NAMED = 4
"""Comparisons that a sentence names; of more it says how many there are."""


def _named(content: ReportContent, comparisons: Sequence[Comparison]) -> str:
    """Name comparisons by group and level, with what was saved: "small foot, 80 kg/s: saving 5.1 %"."""
    named = []
    for each in comparisons:
        level, savings = "" if each.opens else level_of(content, each), each.decision.savings
        names = ", ".join(filter(None, (levels_name(content, each.group), level)))
        named.append(names if savings is None else f"{names}: saving {_range_text([savings])}")
    return "; ".join(named)


def _range_text(savings: Sequence[Number]) -> str:
    """Write savings as "5.1 %", several from the least to the greatest."""
    values = sorted({number.value for number in savings if isinstance(number.value, float)})
    ends = dict.fromkeys(value_text(value, common_places(savings)) for value in values[:: max(len(values) - 1, 1)])
    return with_unit(" to ".join(ends), "%")


def absence_text(content: ReportContent, what: str) -> str:
    """Say that something is missing without guessing why: the reasons are in the list of limitations."""
    reasons = "; the reasons are listed under Limitations" if content.limitations else ""
    return f"There {what} for this selection{reasons}."
