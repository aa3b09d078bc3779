"""The sentences that claim something: what the days decide of a group, over all groups, and of a family."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports.content import Claim, Comparison, Decision, Equivalence, OverallEquivalence, OverallSavings, ReportContent
from reports.display import (
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
from reports.naming import control_name, level_names, level_of, levels_name, swept_factor, treatment_name
from reports.numbers import Number

_MOST_NAMED = 3
"""Runs without a charge that a sentence names."""
ELSEWHERE = "That it holds on other days is not shown."
"""What follows a claim that holds for the days measured; where nothing is shown there is nothing to hold."""


def group_claim(content: ReportContent, comparison: Comparison) -> Claim:
    """Say what the treatment did to one outcome in one group, as far as the days measured show it."""
    lead = comparison.decision
    sentences = [_decided(content, comparison), _charge_missing(content, comparison)]
    if isinstance(lead.test.p, float):
        within = lead.equivalence is not None and lead.equivalence.shown
        sentences += [_within(lead.equivalence), ELSEWHERE if lead.unit != "day" and (lead.rejected or within) else ""]
    return Claim(" ".join(filter(None, sentences)), _id(as_shown(_number(lead))))


def _where(content: ReportContent, comparison: Comparison) -> str:
    """Say for which group a claim holds: " with the small foot and k = 1091 N/m"; "" for all runs."""
    parts = [name if "=" in name else f"the {name}" for name in level_names(content, comparison.group)]
    return f" with {list_text(parts)}" if parts else ""


def _against(content: ReportContent) -> str:
    """Return " against the control (sand)"; "" where the control has a name of its own, which the page says once."""
    swept = swept_factor(content)
    return "" if swept is not None and swept.control_name else f" against {control_name(content)}"


def _exploratory(why: str, what: str = "comparison") -> str:
    """End the sentence on what was not planned."""
    return f", an exploratory {what}" if why else ""


def bounds_text(item: Equivalence) -> str:
    """Write the bounds as "-5 to 5 mm"."""
    unit, factor = shown_unit(item.estimate.unit)
    low, high = (given_text(bound * factor) for bound in (item.low, item.high))
    return with_unit(f"{low} to {high}", unit)


def _charge_missing(content: ReportContent, comparison: Comparison) -> str:
    """Name the runs whose missing charge costs a group its claim; "" where it costs none."""
    names = comparison.decision.charge_missing
    if not names:
        return ""
    none, it = ("has no charge", "it") if len(names) == 1 else ("have no charge", "one of them")
    more = [f"{len(names) - _MOST_NAMED} more"] if len(names) > _MOST_NAMED else []
    listed, where = list_text([*names[:_MOST_NAMED], *more]), _where(content, comparison)
    return f"{listed} {none}: with {it} there would be a claim{where}."


OverGroups = OverallSavings | OverallEquivalence


def _decided(content: ReportContent, comparison: Comparison) -> str:
    """Say what the deciding test found, on which days, with interval, test and what is left out."""
    lead = comparison.decision
    number = as_shown(_number(lead))
    asked, unshown = _asked(content, comparison)
    if isinstance(number.value, Undefined):
        return f"Whether {asked} cannot be told: {number.value.reason}."
    size, signed = _sizes(number.value, _number(lead))
    if isinstance(lead.test.p, Undefined):
        left = f" ({_other_days(lead)})" if lead.other else ""
        return f"Whether {asked} cannot be told: {lead.test.p.reason}{left}; the means differ by {signed}."
    if not lead.shown:
        clause = f"{unshown} is not significant{' after Holm' if lead.rejected else ''}: {signed}"
    elif isinstance(number.ci_low, Undefined):
        clause = f"{unshown} is shown and cannot be bounded: {signed}"
    else:
        clause = _effect(content, comparison, number.value, size)
    days = len(lead.days)
    measured = "" if lead.unit == "day" else f"on the {days} days measured" if days > 1 else "on the one day measured"
    return f"{_opened(clause, measured)} ({'; '.join(_evidence(lead))}){_exploratory(comparison.exploratory)}."


def _number(lead: Decision) -> Number:
    return lead.headline


def groups_in_one_sentence(content: ReportContent, outcome: Outcome) -> str:
    """Say in a sentence what the groups' exploratory tests found beside a test of equivalence over groups.

    "" where a group must speak for itself: planned, within days only, without a test, or not shown to be equivalent.
    """
    leads = [
        (each.decision, each.decision.equivalence)
        for each in content.pooled
        if each.quantity is outcome and each.exploratory
    ]
    heights = content.overall_equivalence
    if any(lead.adjusted is None for lead, _ in leads):
        return ""
    if heights is None or len(leads) < len(heights.groups) or len(leads) < 2 or heights.left_out:
        return ""
    numbers = [as_shown(lead.difference) for lead, _ in leads]
    values = [number.value for number in numbers if isinstance(number.value, float)]
    equivalent = all(item is not None and item.shown for _, item in leads)
    if not equivalent or len(values) < len(leads) or any(lead.unit != "day" for lead, _ in leads):
        return ""
    shown = sum(bool(lead.shown) for lead, _ in leads)
    places = common_places(lead.difference for lead, _ in leads)
    span = with_unit(f"{value_text(min(values), places)} to {value_text(max(values), places)}", numbers[0].unit)
    bounds = next(bounds_text(item) for _, item in leads if item is not None)
    return (
        f"Group by group, exploratory: differences of {span}, {shown} of {len(leads)} significant after Holm; "
        f"all within {bounds} (TOST)."
    )


def overall_claims(content: ReportContent) -> list[tuple[Outcome, Claim]]:
    """Say what was saved over all groups, and whether apex height was lost, each where not one group alone claims."""
    found = [(each.quantity, _savings_claim(content, each)) for each in content.overall if len(each.groups) != 1]
    heights = content.overall_equivalence
    if heights is not None and len(heights.groups) != 1:
        found.append((Outcome.APEX, _equivalence_claim(content, heights)))
    return found


def _asked(content: ReportContent, comparison: Comparison) -> tuple[str, str]:
    """Return the question that a comparison answers, and what is not shown where it shows nothing."""
    where, treatment = _where(content, comparison), treatment_name(content, comparison.group)
    if comparison.decision.savings is not None:
        against = _against(content)
        return f"{treatment} saves energy{where}", f"a saving{against}{where}"
    what = _outcome(comparison.quantity)
    return f"{what}{where} changed", f"a change of {what}{where}"


def _effect(content: ReportContent, comparison: Comparison, value: float, size: str) -> str:
    where, treatment = _where(content, comparison), treatment_name(content, comparison.group)
    if comparison.decision.savings is None:
        comparative = comparison.quantity.comparative[0 if value >= 0 else 1]
        return f"{_outcome(comparison.quantity)} was {size} {comparative} under {treatment}{where}"
    against = _against(content)
    return _saving(treatment, value, size, f"{against}{where}")


def _saving(treatment: str, value: float, size: str, where: str) -> str:
    """Say what a treatment saved or cost."""
    if value > 0:
        return f"{treatment} saved {size} of the energy of a jump{where}"
    return f"{treatment} cost {size} more energy a jump{where}: a saving of {MINUS}{size}"


def _outcome(quantity: Outcome) -> str:
    return f"the {in_sentence(quantity.heading)}"


def _sizes(value: float, number: Number) -> tuple[str, str]:
    """Write a number with its unit, without its sign and with it."""
    size = with_unit(value_text(abs(value), places_of(number)), as_shown(number).unit)
    return size, f"{MINUS}{size}" if value < 0 else size


def _evidence(lead: Decision) -> list[str]:
    evidence = [*_interval(lead.headline), significance_text(lead.test, name=False)]
    if lead.adjusted is not None:
        evidence[-1] += f", Holm {p_text(lead.adjusted.value)}"
    return [*evidence, _other_days(lead)] if lead.other else evidence


def _other_days(lead: Decision) -> str:
    return f"{count_text(lead.other, 'run')} of other days left out"


def _interval(number: Number) -> list[str]:
    """Write the interval, or why there is none."""
    return [f"{level_text(number)} {interval_text(number)}"]


def _opened(clause: str, measured: str) -> str:
    return sentence_start(f"{measured}, {clause}" if measured else clause)


def _within(item: Equivalence | None) -> str:
    """Say whether a difference lies within the bounds; "" where that is not tested."""
    if item is None or isinstance(item.p.value, Undefined):
        return ""
    verdict = "" if item.shown else "not shown to be "
    of_mean = " of the control's mean" if item.estimate.unit == "%" else ""
    evidence = "; ".join([*_interval(item.estimate), f"TOST, {p_text(item.p.value)}"])
    return f"It is {verdict}within {bounds_text(item)}{of_mean} ({evidence}){_exploratory(item.exploratory, 'test')}."


def _savings_claim(content: ReportContent, overall: OverallSavings) -> Claim:
    savings = overall.savings
    treatment = treatment_name(content, {})
    if isinstance(savings.value, Undefined):
        text = f"Whether {treatment} saves energy cannot be told from these days: {savings.value.reason}."
        return Claim(" ".join((text, *_charges_missing(content, overall))), _id(savings))
    size, signed = _sizes(savings.value, savings)
    unlike = f" that differ ({p_text(overall.heterogeneity_p.value)})" if overall.differ else ""
    over = f"{_over(overall)}{unlike}, each counted once"
    clause = f"a saving is not shown{over}: {signed}"
    if overall.rejected:
        clause = _saving(treatment, savings.value, size, over)
    test = significance_text(overall.test, name=False)
    alike = ["the groups agree within their errors"] if overall.differ is False else []
    evidence = "; ".join([*_interval(savings), test, count_text(len(overall.days), "day"), *alike])
    exploratory = _exploratory(overall.exploratory, "effect")
    claim = _claim_over_groups(content, overall, f"{clause} ({evidence}){exploratory}", savings)
    beside = (
        claim.text,
        *_charges_missing(content, overall),
        _group_by_group(content, overall),
        _significant_alone(content, overall),
    )
    return replace(claim, text=" ".join(filter(None, beside)))


def _charges_missing(content: ReportContent, overall: OverallSavings) -> list[str]:
    """Name the runs whose missing charge leaves a group out, group by group."""
    left_out = [each for each in content.pooled if each.quantity is overall.quantity and each.group in overall.left_out]
    return [text for each in left_out if (text := _charge_missing(content, each))]


def _group_by_group(content: ReportContent, overall: OverallSavings) -> str:
    """Say what each group saved; "" where groups are not shown to differ."""
    if not overall.differ:
        return ""
    saved = [
        f"{with_unit(value_text(lead.savings.value, places_of(lead.savings)), '%')} ({name})"
        for name, lead in _leads(content, overall.quantity, overall).items()
        if lead.savings is not None
    ]
    return f"Group by group: {'; '.join(saved)}."


def _significant_alone(content: ReportContent, overall: OverallSavings) -> str:
    """Name the groups whose own savings or costs are significant, after Holm; "" where none is, or all save."""
    leads = _leads(content, overall.quantity, overall)
    significant = {name: lead.difference.value for name, lead in leads.items() if lead.shown}
    cost = [name for name, value in significant.items() if isinstance(value, float) and value > 0.0]
    if not significant or (len(significant) == len(leads) and not cost):
        return ""
    return f"Significant alone: {'; '.join(f'{name} (cost)' if name in cost else name for name in significant)}."


def _leads(content: ReportContent, quantity: Outcome, scope: OverGroups) -> dict[str, Decision]:
    """Return what decides each group of an effect over groups, by the group's name."""
    pooled = [each for each in content.pooled if each.quantity is quantity and each.group in scope.groups]
    return {levels_name(content, each.group): each.decision for each in pooled}


def _equivalence_claim(content: ReportContent, heights: OverallEquivalence) -> Claim:
    """Say whether apex height stayed within the bounds over all groups."""
    item, change = heights, heights.estimate
    for undefined in (change.value, item.p.value):
        if isinstance(undefined, Undefined):
            return Claim(f"Whether apex height was lost cannot be told: {undefined.reason}.", _id(change))
    assert isinstance(change.value, float)  # noqa: S101 - it is defined
    _size, signed = _sizes(change.value, change)
    if not item.shown:
        clause = "that apex height stayed within the bounds is not shown"
    elif isinstance(change.ci_low, float) and change.ci_low >= 0.0:
        clause = "no apex height was lost"
    elif item.low == -item.high:
        clause = f"apex height changed by less than {with_unit(given_text(item.high), change.unit)}"
    else:
        clause = f"apex height stayed within {bounds_text(item)}"
    tost = f"TOST within {bounds_text(item)}, {p_text(item.p.value)}"
    evidence = "; ".join([*_interval(change), tost, count_text(len(heights.days), "day")])
    sign = "+" if change.value > 0.0 else ""
    exploratory = _exploratory(item.exploratory, "test")
    claim = _claim_over_groups(
        content, heights, f"{clause}{_over(heights)}: {sign}{signed} ({evidence}){exploratory}", change
    )
    return replace(claim, text=" ".join(filter(None, (claim.text, _not_shown_alone(content, heights)))))


def _not_shown_alone(content: ReportContent, scope: OverGroups) -> str:
    """Name the groups whose own change of apex height is not shown to be within the bounds; "" where all or none."""
    leads = _leads(content, Outcome.APEX, scope)
    unshown = [name for name, lead in leads.items() if lead.equivalence is not None and not lead.equivalence.shown]
    return f"Not shown alone: {'; '.join(unshown)}." if 0 < len(unshown) < len(leads) else ""


def _over(scope: OverGroups) -> str:
    return f" over {count_text(len(scope.groups), 'group')}"


def _claim_over_groups(content: ReportContent, scope: OverGroups, clause: str, number: Number) -> Claim:
    """Close a sentence over groups with what it does not hold for, and with the groups that it leaves out."""
    sentences = [f"{_opened(clause, 'on the days measured' if scope.days_measured_only else '')}."]
    sentences += [ELSEWHERE] if scope.days_measured_only else []
    if scope.left_out:
        names = list_text([levels_name(content, group) or "all runs" for group in scope.left_out])
        sentences.append(f"Left out, without a claim of their own: {names}.")
    return Claim(" ".join(sentences), _id(number))


def _id(number: Number) -> tuple[str, ...]:
    return tuple(filter(None, (number.provenance,)))


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
            notes = (
                [_named(content, shown)] if 0 < len(shown) <= min(_MOST_COMPARISONS, len(family) - (not saved)) else []
            )
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


_MOST_COMPARISONS = 4
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
