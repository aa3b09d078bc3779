"""The sentences of comparisons that are decided by shared days, one group at a time and over all groups."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports.content import Claim, Comparison, ReportContent
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
    significance_text,
    value_text,
    with_unit,
)
from reports.evidence import Decision, Equivalence, OverallEquivalence, OverallSavings
from reports.naming import levels_name, treatment_name
from reports.numbers import Number
from reports.sentences import bounds_text, exploratory_text, holm_clause, sides_text, where_text

_MOST_NAMED = 3
"""Runs without a charge that a sentence names."""
ELSEWHERE = "That it holds on other days is not shown."
"""What follows a claim that holds for the days measured; where nothing is shown there is nothing to hold."""


def group_claim(content: ReportContent, comparison: Comparison) -> Claim:
    """Say what the treatment did to one outcome in one group, as far as the days measured show it."""
    lead = comparison.decision
    sentences = [decided_text(lead, _words(content, comparison), exploratory_text(comparison.exploratory))]
    sentences.append(_charge_missing(content, comparison))
    if isinstance(lead.test.p, float):
        within = lead.equivalence is not None and lead.equivalence.shown
        sentences += [_within(lead.equivalence), ELSEWHERE if lead.unit != "day" and (lead.rejected or within) else ""]
    return Claim(" ".join(filter(None, sentences)), _id(as_shown(_number(lead))))


def _charge_missing(content: ReportContent, comparison: Comparison) -> str:
    """Name the runs whose missing charge costs a group its claim; "" where it costs none."""
    names = comparison.decision.charge_missing
    if not names:
        return ""
    none, it = ("has no charge", "it") if len(names) == 1 else ("have no charge", "one of them")
    more = [f"{len(names) - _MOST_NAMED} more"] if len(names) > _MOST_NAMED else []
    listed, where = list_text([*names[:_MOST_NAMED], *more]), where_text(content, comparison)
    return f"{listed} {none}: with {it} there would be a claim{where}."


OverGroups = OverallSavings | OverallEquivalence


@dataclass(frozen=True, slots=True)
class Words:
    """A comparison's words: `asked` after "whether", `unshown` what is not shown, `effect` of a value and its size."""

    asked: str
    unshown: str
    effect: Callable[[float, str], str]


def decided_text(lead: Decision, words: Words, exploratory: str = "") -> str:
    """Say what the deciding test found, on which days, with interval, test and what is left out."""
    number = as_shown(_number(lead))
    if isinstance(number.value, Undefined):
        return f"Whether {words.asked} cannot be told: {number.value.reason}."
    size, signed = _sizes(number.value, _number(lead))
    if isinstance(lead.test.p, Undefined):
        left = f" ({_other_days(lead)})" if lead.other else ""
        return f"Whether {words.asked} cannot be told: {lead.test.p.reason}{left}; the means differ by {signed}."
    once = "significant after Holm" if lead.rejected and holm_clause(lead) else ""
    if not lead.rejected or once:
        clause = f"{words.unshown} is not {once or 'significant'}: {signed}"
    elif isinstance(number.ci_low, Undefined):
        clause = f"{words.unshown} is shown and cannot be bounded: {signed}"
    else:
        clause = words.effect(number.value, size)
    days = len(lead.days)
    measured = "" if lead.unit == "day" else f"on the {days} days measured" if days > 1 else "on the one day measured"
    return f"{_opened(clause, measured)} ({'; '.join(_evidence(lead))}){exploratory}."


def _number(lead: Decision) -> Number:
    return lead.savings or lead.difference


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
    shown = sum(bool(lead.rejected) and not holm_clause(lead) for lead, _ in leads)
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


def _words(content: ReportContent, comparison: Comparison) -> Words:
    asked, unshown = _asked(content, comparison)
    return Words(asked, unshown, lambda value, size: _effect(content, comparison, value, size))


def _asked(content: ReportContent, comparison: Comparison) -> tuple[str, str]:
    """Return the question that a comparison answers, and what is not shown where it shows nothing."""
    where, treatment = where_text(content, comparison), treatment_name(content, comparison.group)
    if comparison.decision.savings is not None:
        against, _between = sides_text(content, comparison)
        return f"{treatment} saves energy{where}", f"a saving{against}{where}"
    what = _outcome(comparison.quantity)
    return f"{what}{where} changed", f"a change of {what}{where}"


def _effect(content: ReportContent, comparison: Comparison, value: float, size: str) -> str:
    where, treatment = where_text(content, comparison), treatment_name(content, comparison.group)
    if comparison.decision.savings is None:
        comparative = comparison.quantity.comparative[0 if value >= 0 else 1]
        return f"{_outcome(comparison.quantity)} was {size} {comparative} under {treatment}{where}"
    against, _between = sides_text(content, comparison)
    return saving_text(treatment, value, size, f"{against}{where}")


def saving_text(treatment: str, value: float, size: str, where: str) -> str:
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
    evidence = [*_interval(lead.savings or lead.difference), significance_text(lead.test, name=False)]
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
    return "" if item is None or isinstance(item.p.value, Undefined) else within_text(item, "It is")


def within_text(item: Equivalence, lead: str, control: str = "the control") -> str:
    """Say after the lead whether what was tested lies within the bounds."""
    verdict = "" if item.shown else "not shown to be "
    of_mean = f" of {control}'s mean" if item.estimate.unit == "%" else ""
    evidence = "; ".join([*_interval(item.estimate), f"TOST, {p_text(item.p.value)}"])
    exploratory = exploratory_text(item.exploratory, "test")
    return f"{lead} {verdict}within {bounds_text(item)}{of_mean} ({evidence}){exploratory}."


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
        clause = saving_text(treatment, savings.value, size, over)
    test = significance_text(overall.test, name=False)
    alike = ["the groups agree within their errors"] if overall.differ is False else []
    evidence = "; ".join([*_interval(savings), test, count_text(len(overall.days), "day"), *alike])
    exploratory = exploratory_text(overall.exploratory, "effect")
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
    """Name the groups whose own savings are significant, after Holm; "" where none is, or all are in one direction."""
    leads = _leads(content, overall.quantity, overall)
    significant = {name: lead for name, lead in leads.items() if lead.rejected and not holm_clause(lead)}
    saved = [name for name, lead in significant.items() if not _cost(lead)]
    cost = [name for name in significant if name not in saved]
    if not significant or (len(significant) == len(leads) and not (saved and cost)):
        return ""
    if not cost:
        return f"Significant alone: {'; '.join(saved)}."
    directions = [("saving", saved), ("cost", cost)]
    return " ".join(f"Significant {what} alone: {'; '.join(names)}." for what, names in directions if names)


def _leads(content: ReportContent, quantity: Outcome, scope: OverGroups) -> dict[str, Decision]:
    """Return what decides each group of an effect over groups, by the group's name."""
    pooled = [each for each in content.pooled if each.quantity is quantity and each.group in scope.groups]
    return {levels_name(content, each.group): each.decision for each in pooled}


def _cost(lead: Decision) -> bool:
    """Tell whether a treatment took more than its control."""
    value = lead.difference.value
    return isinstance(value, float) and value > 0.0


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
    exploratory = exploratory_text(item.exploratory, "test")
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
