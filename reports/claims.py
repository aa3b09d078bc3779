"""The sentences that claim something: what the days decide of a group, over all groups, and of a family."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from data_schema.outcomes import Outcome
from data_schema.vocabulary import ContrastKind, Undefined
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
from reports.naming import control_name, level_names, level_of, levels_name, swept_factor, title_of, treatment_name
from reports.numbers import Number
from reports.results import (
    Claim,
    Comparison,
    Equivalence,
    MeansContrast,
    OverallEquivalence,
    OverallSavings,
    StudyResults,
)

_MOST_NAMED = 3
"""Runs without a charge that a sentence names."""
ELSEWHERE = "That it holds on other days is not shown."
"""What follows a claim that holds for the days measured; where nothing is shown there is nothing to hold."""


def claims(results: StudyResults) -> tuple[Claim, ...]:
    """One sentence over all groups, or one a pooled comparison, outcome by outcome.

    Where another family was decided on, what that shows comes before all of them, but for one group of one level, whose
    claims are of that family.
    """
    planned = [one for one in results.comparisons if not one.opens and one.decision.adjusted is not None]
    if results.one_level and len(planned) == len({one.quantity for one in planned}):
        planned = []  # one group, whose claims are those of the family
    over_groups = overall_claims(results)
    claimed = {outcome for outcome, _claim in over_groups}
    wanted = {Outcome.JOULES, Outcome.APEX} - claimed if over_groups else set(Outcome)
    narrow = [
        (one.quantity, group_claim(results, one)) for one in results.comparisons if one.opens and one.quantity in wanted
    ]
    opening = [family_claim(results, planned, pooled=not results.one_level)] if planned else []
    by_outcome = sorted((*over_groups, *narrow), key=lambda each: list(Outcome).index(each[0]))
    found = (*opening, *(claim for _outcome, claim in by_outcome), *contrast_claims(results))
    return _warned(results, found)


def _warned(results: StudyResults, found: tuple[Claim, ...]) -> tuple[Claim, ...]:
    """Say behind the first claim that it cannot stand without what is said of order or charger below."""
    why = [
        *(["the order within days"] if results.favoured else []),
        *(["the charger's step"] if results.coarse_charger is not None else []),
    ]
    if not why or not found:
        return found
    first = replace(found[0], text=f"{found[0].text} Read with what is said of {' and '.join(why)} below.")
    return (first, *found[1:])


def _claim(sentences: Sequence[str], number: Number) -> Claim:
    return Claim(" ".join(filter(None, sentences)), tuple(filter(None, (number.provenance,))))


def group_claim(results: StudyResults, comparison: Comparison) -> Claim:
    """Say what the treatment did to one outcome in one group, as far as the days measured show it."""
    lead = comparison.decision
    sentences = [_decided(results, comparison), _charge_missing(results, comparison)]
    if isinstance(lead.test.p, float):
        within = lead.equivalence is not None and lead.equivalence.shown
        sentences += [_within(lead.equivalence), ELSEWHERE if lead.unit != "day" and (lead.rejected or within) else ""]
    return _claim(sentences, lead.headline)


def _where(results: StudyResults, comparison: Comparison) -> str:
    """Say for which group a claim holds: " with the small foot and k = 1091 N/m"; "" for all runs."""
    parts = [name if "=" in name else f"the {name}" for name in level_names(results, comparison.group)]
    return f" with {list_text(parts)}" if parts else ""


def _against(results: StudyResults) -> str:
    """Return " against the control (sand)"; "" where the control has a name of its own, which the page says once."""
    swept = swept_factor(results)
    return "" if swept is not None and swept.control_name else f" against {control_name(results)}"


def _exploratory(why: str, what: str = "comparison") -> str:
    """End the sentence on what was not planned."""
    return f", an exploratory {what}" if why else ""


def bounds_text(item: Equivalence) -> str:
    """Write the bounds as "-5 to 5 mm"."""
    unit, factor = shown_unit(item.estimate.unit)
    return with_unit(f"{given_text(item.low * factor)} to {given_text(item.high * factor)}", unit)


def _charge_missing(results: StudyResults, comparison: Comparison) -> str:
    """Name the runs whose missing charge costs a group its claim; "" where it costs none."""
    names = comparison.decision.charge_missing
    if not names:
        return ""
    none, it = ("has no charge", "it") if len(names) == 1 else ("have no charge", "one of them")
    more = [f"{len(names) - _MOST_NAMED} more"] if len(names) > _MOST_NAMED else []
    listed, where = list_text([*names[:_MOST_NAMED], *more]), _where(results, comparison)
    return f"{listed} {none}: with {it} there would be a claim{where}."


def _decided(results: StudyResults, comparison: Comparison) -> str:
    """Say what the deciding test found, on which days, with interval, test and what is left out."""
    lead, number = comparison.decision, comparison.decision.headline
    where, treatment = _where(results, comparison), treatment_name(results, comparison.group)
    what = f"the {in_sentence(comparison.quantity.heading)}"
    asked, unshown = f"{what}{where} changed", f"a change of {what}{where}"
    if lead.savings is not None:
        asked, unshown = f"{treatment} saves energy{where}", f"a saving{_against(results)}{where}"
    if isinstance(number.value, Undefined):
        return f"Whether {asked} cannot be told: {number.value.reason}."
    size, signed = _sizes(number)
    other = f"{count_text(lead.other, 'run')} of other days left out" if lead.other else ""
    if isinstance(lead.test.p, Undefined):
        left = f" ({other})" if other else ""
        return f"Whether {asked} cannot be told: {lead.test.p.reason}{left}; the means differ by {signed}."
    if not lead.shown:
        clause = f"{unshown} is not significant{' after Holm' if lead.rejected else ''}: {signed}"
    elif isinstance(number.ci_low, Undefined):
        clause = f"{unshown} is shown and cannot be bounded: {signed}"
    elif lead.savings is not None:
        clause = _saving(treatment, number.value, size, f"{_against(results)}{where}")
    else:
        comparative = comparison.quantity.comparative[0 if number.value >= 0 else 1]
        clause = f"{what} was {size} {comparative} under {treatment}{where}"
    days = len(lead.days)
    measured = "" if lead.unit == "day" else f"on the {days} days measured" if days > 1 else "on the one day measured"
    test = significance_text(lead.test, name=False)
    test += "" if lead.adjusted is None else f", Holm {p_text(lead.adjusted.value)}"
    evidence = "; ".join(filter(None, (_interval(number), test, other)))
    return f"{_opened(clause, measured)} ({evidence}){_exploratory(comparison.exploratory)}."


def groups_in_one_sentence(results: StudyResults, outcome: Outcome) -> str:
    """Say in a sentence what the groups' exploratory tests found beside a test of equivalence over groups.

    "" where a group must speak for itself: planned, within days only, without a test, or not shown to be equivalent.
    """
    leads = [each.decision for each in results.pooled if each.quantity is outcome and each.exploratory]
    heights = results.overall_equivalence
    if heights is None or heights.left_out or len(leads) < max(len(heights.groups), 2):
        return ""
    tested = [lead.equivalence for lead in leads if lead.equivalence is not None and lead.equivalence.shown]
    values = [as_shown(lead.difference).known for lead in leads if lead.adjusted is not None and lead.unit == "day"]
    known = [value for value in values if value is not None]
    if min(len(tested), len(known)) < len(leads):
        return ""
    places = common_places(lead.difference for lead in leads)
    unit = as_shown(leads[0].difference).unit
    span = with_unit(f"{value_text(min(known), places)} to {value_text(max(known), places)}", unit)
    shown = sum(bool(lead.shown) for lead in leads)
    return (
        f"Group by group, exploratory: differences of {span}, {shown} of {len(leads)} significant after Holm; "
        f"all within {bounds_text(tested[0])} (TOST)."
    )


def overall_claims(results: StudyResults) -> list[tuple[Outcome, Claim]]:
    """Say what was saved over all groups, and whether apex height was lost, each where not one group alone claims."""
    found = [(each.quantity, _savings_claim(results, each)) for each in results.overall if len(each.groups) != 1]
    heights = results.overall_equivalence
    if heights is not None and len(heights.groups) != 1:
        found.append((Outcome.APEX, _equivalence_claim(results, heights)))
    return found


def _saving(treatment: str, value: float, size: str, where: str) -> str:
    """Say what a treatment saved or cost."""
    if value > 0:
        return f"{treatment} saved {size} of the energy of a jump{where}"
    return f"{treatment} cost {size} more energy a jump{where}: a saving of {MINUS}{size}"


def _sizes(number: Number) -> tuple[str, str]:
    """Write a number with its unit, without its sign and with it."""
    shown = as_shown(number)
    size = with_unit(value_text(abs(shown.known or 0.0), places_of(number)), shown.unit)
    return size, f"{MINUS}{size}" if (shown.known or 0.0) < 0 else size


def _interval(number: Number) -> str:
    """Write the interval, or why there is none."""
    return f"{level_text(number)} {interval_text(number)}"


def _opened(clause: str, measured: str) -> str:
    return sentence_start(f"{measured}, {clause}" if measured else clause)


def _within(item: Equivalence | None) -> str:
    """Say whether a difference lies within the bounds; "" where that is not tested."""
    if item is None or item.p.known is None:
        return ""
    verdict = "" if item.shown else "not shown to be "
    of_mean = " of the control's mean" if item.estimate.unit == "%" else ""
    evidence = f"{_interval(item.estimate)}; TOST, {p_text(item.p.value)}"
    return f"It is {verdict}within {bounds_text(item)}{of_mean} ({evidence}){_exploratory(item.exploratory, 'test')}."


def _savings_claim(results: StudyResults, overall: OverallSavings) -> Claim:
    """Say what was saved over all groups, what that does not hold for, and which groups have no claim."""
    savings, treatment = overall.savings, treatment_name(results, {})
    left_out = [each for each in results.pooled if each.quantity is overall.quantity and each.group in overall.left_out]
    missing = [_charge_missing(results, each) for each in left_out]
    if isinstance(savings.value, Undefined):
        none = f"Whether {treatment} saves energy cannot be told from these days: {savings.value.reason}."
        return _claim([none, *missing], savings)
    size, signed = _sizes(savings)
    unlike = f" that differ ({p_text(overall.heterogeneity_p.value)})" if overall.differ else ""
    over = f" over {count_text(len(overall.groups), 'group')}{unlike}, each counted once"
    clause = f"a saving is not shown{over}: {signed}"
    if overall.rejected:
        clause = _saving(treatment, savings.value, size, over)
    alike = ["the groups agree within their errors"] if overall.differ is False else []
    test, days = significance_text(overall.test, name=False), count_text(len(overall.days), "day")
    evidence = "; ".join([_interval(savings), test, days, *alike])
    ended = f"{clause} ({evidence}){_exploratory(overall.exploratory, 'effect')}"
    return _claim([*_over_groups(results, overall, ended), *missing], savings)


def _equivalence_claim(results: StudyResults, heights: OverallEquivalence) -> Claim:
    """Say whether apex height stayed within the bounds over all groups."""
    change = heights.estimate
    for undefined in (change.value, heights.p.value):
        if isinstance(undefined, Undefined):
            return _claim([f"Whether apex height was lost cannot be told: {undefined.reason}."], change)
    if not heights.shown:
        clause = "that apex height stayed within the bounds is not shown"
    elif change.interval is not None and change.interval[0] >= 0.0:
        clause = "no apex height was lost"
    elif heights.low == -heights.high:
        clause = f"apex height changed by less than {with_unit(given_text(heights.high), change.unit)}"
    else:
        clause = f"apex height stayed within {bounds_text(heights)}"
    tost, days = f"TOST within {bounds_text(heights)}, {p_text(heights.p.value)}", count_text(len(heights.days), "day")
    sign = "+" if (change.known or 0.0) > 0.0 else ""
    over = f" over {count_text(len(heights.groups), 'group')}: {sign}{_sizes(change)[1]}"
    evidence = f" ({_interval(change)}; {tost}; {days}){_exploratory(heights.exploratory, 'test')}"
    return _claim(_over_groups(results, heights, f"{clause}{over}{evidence}"), change)


def _over_groups(results: StudyResults, scope: OverallSavings | OverallEquivalence, clause: str) -> list[str]:
    """Close a sentence over groups with what it does not hold for, and with the groups that it leaves out."""
    sentences = [f"{_opened(clause, 'on the days measured' if scope.days_measured_only else '')}."]
    sentences += [ELSEWHERE] if scope.days_measured_only else []
    if scope.left_out:
        names = list_text([levels_name(results, group) or "all runs" for group in scope.left_out])
        sentences.append(f"Left out, without a claim of their own: {names}.")
    return sentences


_MOST_COMPARISONS = 4
"""Comparisons that a sentence names; of more it says how many there are."""


def family_claim(results: StudyResults, planned: Sequence[Comparison], *, pooled: bool = True) -> Claim:
    """Say which comparisons of the family that was decided on are shown, where the claims are not of that family.

    `pooled` tells whether these pool levels.
    """
    by_quantity, ids = [], []
    any_planned = not all(item.exploratory for item in planned)
    for quantity in dict.fromkeys(item.quantity for item in planned):
        family = [item for item in planned if item.quantity is quantity]
        shown = [item for item in family if item.decision.adjusted_rejected is True]
        saved = [item.decision.savings for item in shown if item.decision.savings is not None]
        notes = [f"savings of {_range_text(saved)}"] if saved else []
        if 0 < len(shown) <= min(_MOST_COMPARISONS, len(family) - (not saved)):
            notes = ["; ".join(_named(results, each) for each in shown)]
        n_untested = sum(item.decision.rejected is None for item in family)
        notes += [f"{n_untested} without a test"] if n_untested else []
        beside = "in exploratory ones " if any_planned and family[0].exploratory else ""
        counted = f"{beside}{len(shown) or 'none'} of {count_text(len(family), 'comparison')}"
        by_quantity.append(f"{counted} of {quantity}" + (f" ({'; '.join(notes)})" if notes else ""))
        ids += [one.provenance for item in family if (one := item.decision.adjusted) is not None][:1]
    named = "Decided on beforehand was" if any_planned else "The family of comparisons is"
    text = (
        f"{named} {planned[0].family}. A difference is shown, counted by Holm, in {list_text(by_quantity)}."
        f"{' The levels are pooled in what follows, which is exploratory.' if pooled else ''}"
    )
    return Claim(text, tuple(filter(None, ids)))


def _named(results: StudyResults, one: Comparison) -> str:
    """Name a comparison by group and level, with what was saved: "small foot, 80 kg/s: saving 5.1 %"."""
    level, savings = "" if one.opens else level_of(results, one), one.decision.savings
    name = ", ".join(filter(None, (levels_name(results, one.group), level)))
    return name if savings is None else f"{name}: saving {_range_text([savings])}"


def _range_text(savings: Sequence[Number]) -> str:
    """Write savings as "5.1 %", several from the least to the greatest."""
    values = sorted({number.known for number in savings if number.known is not None})
    ends = dict.fromkeys(value_text(value, common_places(savings)) for value in values[:: max(len(values) - 1, 1)])
    return with_unit(" to ".join(ends), "%")


def contrast_claims(results: StudyResults) -> tuple[Claim, ...]:
    """Say what the planned contrasts show, a sentence each."""
    planned = [one for one in results.contrasts if not one.exploratory]
    return tuple(Claim(_sentence(results, one), tuple(filter(None, (one.estimate.provenance,)))) for one in planned)


def _sentence(results: StudyResults, one: MeansContrast) -> str:
    """Say what a contrast is by its name: "Saving with small foot less that with large foot: 3.1 points (...)."."""
    number, name = as_shown(one.estimate), sentence_start(contrast_name(results, one))
    for undefined in (number.value, one.test.p):
        if isinstance(undefined, Undefined):
            return f"{name} cannot be told: {undefined.reason}."
    size = with_unit(value_text(number.value, places_of(one.estimate)), contrast_unit(one))
    test, holm = one.test, ""
    if one.adjusted is not None:  # the p that decides
        test, holm = replace(test, p=one.adjusted.value), " by Holm"
    evidence = [
        f"{level_text(number)} {interval_text(one.estimate, unit=False)}",
        f"{significance_text(test, name=False)}{holm}",
        "on the days measured" if one.unit == "run" and one.days else "",
        f"{count_text(one.left_out, 'condition')} of one side alone left out" if one.left_out else "",
    ]
    shown = "" if one.rejected else ", not significant"
    return f"{name}: {size}{shown} ({'; '.join(filter(None, evidence))})."


def contrast_name(results: StudyResults, one: MeansContrast) -> str:
    """Name a contrast: "saving with the small foot less that with the large foot"."""
    effect = "saving" if one.quantity.has_savings else f"difference of {one.quantity}"
    if one.kind is ContrastKind.DIFFERENCE:
        return f"{one.quantity} with {_less(results, one)}, {one.side} runs"
    if one.kind is ContrastKind.INTERACTION:
        return f"{effect} with {_less(results, one, ' less that with ')}"
    step = f"for each {given_text(one.per)} of the {_swept(results)}"
    if one.at is not None:
        return f"{effect} {step}: up to {given_text(one.at)} less from there on"
    return f"{effect} {step}" + (f" from {one.levels[0]} to {one.levels[-1]}" if len(one.levels) > 1 else "")


def _less(results: StudyResults, one: MeansContrast, less: str = " less ") -> str:
    """Write the second level less the first; without two of them what they are levels of."""
    names = [level_names(results, {one.factor: label})[0] for label in reversed(one.levels)]
    title = next((title_of(factor) for factor in results.factors if factor.name == one.factor), one.factor)
    return less.join(names) if names else f"one level{less}another of the {in_sentence(title)}"


def _swept(results: StudyResults) -> str:
    swept = swept_factor(results)
    return "treatment's level" if swept is None else in_sentence(title_of(swept))


def contrast_unit(one: MeansContrast) -> str:
    """Return the unit that a contrast is shown in: percentage points of savings, or that of its outcome."""
    unit = as_shown(one.estimate).unit
    return "points" if unit == "%" else unit
