"""The sentence that a claim is made in, and the words for what is missing."""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports.content import Claim, Comparison, ReportContent
from reports.display import (
    EQUALS,
    MINUS,
    as_shown,
    common_places,
    count_text,
    given_text,
    in_sentence,
    interval_text,
    level_text,
    list_text,
    p_text,
    places_of,
    sentence_start,
    shown_unit,
    significance_text,
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
from reports.remarks import NOT_FROM_DAYS


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


def savings_claim(content: ReportContent, comparison: Comparison) -> Claim:
    """Say what the treatment saved: value, interval, group, n and the Welch test; no more than they show."""
    savings, where = comparison.savings, where_text(content, comparison)
    if savings is None or isinstance(savings.value, Undefined):
        reason = value_text(None if savings is None else savings.value)
        return Claim(f"The savings{where} are {reason}.", _ids(comparison))
    places = places_of(savings)
    size = with_unit(value_text(abs(savings.value), places), savings.unit)
    interval = interval_text(savings)
    counts = _counts(content, comparison)
    evidence = f"{level_text(savings)} {interval}; {counts}; {_tests(comparison)}" if interval else counts
    shown = False if comparison.one_day_each else comparison.savings_shown
    treatment = sentence_start(treatment_name(content, comparison.group))
    against, between = sides_text(content, comparison)
    once = holm_clause(comparison.lead) if shown else ""
    if shown is None and savings.value < 0:
        lead = (
            f"{treatment} cost {size} more energy a jump{against}{where} by the best estimate, which cannot be bounded"
        )
    elif shown is None:
        lead = f"The savings{against}{where} cannot be bounded: the best estimate is {size}"
    elif comparison.one_day_each:
        sign = MINUS if savings.value < 0 else ""
        lead = f"No saving{against}{where} can be told from a difference between days: the estimate is {sign}{size}"
    elif not shown or once:
        sign = MINUS if savings.value < 0 else ""
        lead = f"No difference in energy was shown{between}{where}{once}: the estimated saving is {sign}{size}"
    elif savings.value > 0:
        lead = f"{treatment} saved {size} of the energy of a jump{against}{where}"
    else:
        lead = f"{treatment} cost {size} more energy a jump{against}{where}: a saving of {MINUS}{size}"
    return Claim(f"{lead} ({evidence}){exploratory_text(comparison.exploratory)}.", _ids(comparison))


def _counts(content: ReportContent, comparison: Comparison) -> str:
    return f"n{EQUALS}{comparison.n_control} control and {comparison.n_treatment} treatment {content.counted}s"


def _tests(comparison: Comparison) -> str:
    """Write Welch's test, its p over the family, and the test by day where there are such.

    Where each side had one day the claim says so, and a test by day that is undefined for that says nothing more.
    """
    parts = [significance_text(comparison.welch)]
    if comparison.adjusted is not None:
        parts.append(
            f"{p_text(comparison.adjusted.value)} by Holm over {count_text(comparison.adjusted.n or 0, 'test')}"
        )
    if comparison.by_day is not None and not comparison.one_day_each:
        parts.append(significance_text(comparison.by_day.test))
    return "; ".join(parts)


def exploratory_text(why: str, what: str = "comparison") -> str:
    """End the sentence on what was not planned."""
    return f", an exploratory {what}" if why else ""


def bounds_text(item: Equivalence) -> str:
    """Write the bounds as "-5 to 5 mm"."""
    unit, factor = shown_unit(item.estimate.unit)
    low, high = (given_text(bound * factor) for bound in (item.low, item.high))
    return with_unit(f"{low} to {high}", unit)


def _equivalence(comparison: Comparison) -> str:
    """Say whether a difference was shown to lie within the bounds; "" where it was not tested."""
    item = comparison.equivalence
    if item is None:
        return ""
    of_mean = " of the control's mean" if item.estimate.unit == "%" else ""
    what = f"Equivalence within {bounds_text(item)}{of_mean}"
    if isinstance(item.p, Undefined):
        return f" {what} could not be tested: {item.p.reason}."
    evidence = f"{level_text(item.estimate)} {interval_text(item.estimate)}; TOST, {p_text(item.p)}"
    exploratory = exploratory_text(item.exploratory, "test")
    verdict = f"was {'shown' if item.shown else 'not shown'}"
    if comparison.one_day_each:
        verdict = NOT_FROM_DAYS
    return f" {what} {verdict} ({evidence}){exploratory}."


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


def difference_claim(content: ReportContent, comparison: Comparison) -> Claim:
    """Say how a quantity differed between control and treatment, and whether zero lies in the interval."""
    difference = as_shown(comparison.welch_difference)
    where = where_text(content, comparison)
    what = f"The {in_sentence(comparison.quantity.heading)}"
    if isinstance(difference.value, Undefined):
        return Claim(f"{what}{where}: the difference is {value_text(difference.value)}.", (difference.provenance,))
    comparative = comparison.quantity.comparative[0 if difference.value >= 0 else 1]
    size = with_unit(value_text(abs(difference.value), places_of(comparison.welch_difference)), difference.unit)
    interval = interval_text(comparison.welch_difference)
    evidence = (
        f"{level_text(difference)} of the difference {interval}; {_counts(content, comparison)}; {_tests(comparison)}"
        if interval
        else f"{count_text(comparison.n_control, f'control {content.counted}')} and "
        f"{count_text(comparison.n_treatment, f'treatment {content.counted}')} are too few for an interval"
    )
    once = holm_clause(comparison.lead)
    lost = f", which is not shown{once}" if once else ""
    verdict = {True: lost, False: ", which the interval does not tell from zero", None: ""}[comparison.rejected]
    if comparison.one_day_each:
        verdict = f", which {NOT_FROM_DAYS}"
    than = "" if _has_named_control(content) else f" than under {control_name(content)}"
    treatment = treatment_name(content, comparison.group)
    lead = f"{what} was {size} {comparative} under {treatment}{than}{where}{verdict}"
    sentence = f"{lead} ({evidence}){exploratory_text(comparison.exploratory)}.{_equivalence(comparison)}"
    return Claim(sentence, (*filter(None, (difference.provenance,)), *_ids_beside(comparison)))


def family_claim(content: ReportContent, planned: Sequence[Comparison], *, pooled: bool = True) -> Claim:
    """Say which comparisons of the family that was decided on are shown, where the claims are not of that family.

    `pooled` tells whether these pool levels.
    """
    by_quantity, ids = [], []
    any_planned = not all(item.exploratory for item in planned)
    for quantity in Outcome:
        family = [item for item in planned if item.quantity is quantity]
        shown = [item for item in family if item.lead.adjusted_rejected is True and not item.one_day_each]
        if family:
            n_untested = sum(
                item.decision.rejected is None if item.decision else bool(item.one_day_each) for item in family
            )
            why = "without a test" if family[0].decision else NOT_FROM_DAYS
            saved = [item.lead.savings for item in shown if item.lead.savings is not None]
            notes = [_named(content, shown)] if 0 < len(shown) <= min(_MOST_NAMED, len(family) - (not saved)) else []
            notes += [f"savings of {_range_text(saved)}"] if saved and not notes else []
            notes += [f"{n_untested} {why}"] if n_untested else []
            beside = "in exploratory ones " if any_planned and family[0].exploratory else ""
            counted = f"{beside}{len(shown) or 'none'} of {count_text(len(family), 'comparison')}"
            by_quantity.append(f"{counted} of {quantity}" + (f" ({'; '.join(notes)})" if notes else ""))
            ids += [item.lead.adjusted.provenance for item in family if item.lead.adjusted is not None][:1]
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
        level, savings = "" if each.opens else level_of(content, each), each.lead.savings
        names = ", ".join(filter(None, (levels_name(content, each.group), level)))
        named.append(names if savings is None else f"{names}: saving {_range_text([savings])}")
    return "; ".join(named)


def _range_text(savings: Sequence[Number]) -> str:
    """Write savings as "5.1 %", several from the least to the greatest."""
    values = sorted({number.value for number in savings if isinstance(number.value, float)})
    ends = dict.fromkeys(value_text(value, common_places(savings)) for value in values[:: max(len(values) - 1, 1)])
    return with_unit(" to ".join(ends), "%")


def _ids(comparison: Comparison) -> tuple[str, ...]:
    savings = comparison.savings
    ids = (savings.provenance if savings is not None else "", comparison.welch_difference.provenance)
    return (*filter(None, ids), *_ids_beside(comparison))


def _ids_beside(comparison: Comparison) -> tuple[str, ...]:
    """Return the ids of what a claim says beside the difference: adjusted p, test by day, equivalence."""
    by_day, equivalence = comparison.by_day, comparison.equivalence
    numbers = (
        comparison.adjusted,
        None if by_day is None or comparison.one_day_each else by_day.difference,
        None if equivalence is None else equivalence.estimate,
    )
    return tuple(number.provenance for number in numbers if number is not None and number.provenance)


def absence_text(content: ReportContent, what: str) -> str:
    """Say that something is missing without guessing why: the reasons are in the list of limitations."""
    reasons = "; the reasons are listed under Limitations" if content.limitations else ""
    return f"There {what} for this selection{reasons}."
