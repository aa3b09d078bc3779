"""The sentences of comparisons that are decided by shared days, one group at a time and over all groups."""

from __future__ import annotations

from data_schema.vocabulary import Undefined
from reports.content import Claim, Comparison, ReportContent
from reports.display import (
    MINUS,
    as_shown,
    interval_text,
    level_text,
    p_text,
    places_of,
    significance_text,
    value_text,
    with_unit,
)
from reports.evidence import Decision, Equivalence, OverallSavings
from reports.naming import levels_name, swept_factor, swept_words, treatment_name
from reports.numbers import Number
from reports.sentences import bounds_text, exploratory_text, sides_text, where_text
from reports.wording import count_text, list_text, sentence_start

_ELSEWHERE = " That it holds on other days is not shown."


def group_claim(content: ReportContent, comparison: Comparison) -> Claim:
    """Say what the treatment did to one outcome in one group."""
    found = _saved(content, comparison) if comparison.lead.savings is not None else _differed(content, comparison)
    return Claim(found, _ids(comparison.lead))


def overall_claims(content: ReportContent) -> list[Claim]:
    """Say what was saved over all groups, and whether apex height was lost; nothing where one alone claims a saving."""
    found = [_overall(content, overall) for overall in content.overall if len(overall.groups) != 1]
    if content.overall_equivalence is not None and (found or not content.overall):
        found.append(_no_loss(content.overall_equivalence))
    return found


def _saved(content: ReportContent, comparison: Comparison) -> str:
    lead, where = comparison.lead, where_text(content, comparison)
    savings, treatment = lead.savings, treatment_name(content, comparison.group)
    against, _between = sides_text(content, comparison)
    if savings is None or isinstance(savings.value, Undefined):
        return f"The savings{where} are {value_text(None if savings is None else savings.value)}."
    size = with_unit(value_text(abs(savings.value), places_of(savings)), savings.unit)
    if isinstance(lead.test.p, Undefined):
        return (
            f"Whether {treatment} saves energy{where} cannot be told: {lead.test.p.reason}; the means differ by "
            f"{_signed(savings.value, size)}."
        )
    once = _lost_by_holm(lead)
    if not lead.rejected or once:
        said = f"a saving{against}{where} is not shown{once}: {_signed(savings.value, size)}"
    elif savings.value > 0:
        said = f"{treatment} saved {size} of the energy of a jump{against}{where}"
    else:
        said = f"{treatment} cost {size} more energy a jump{against}{where}"
    return _decided(said, lead, savings, comparison.exploratory)


def _differed(content: ReportContent, comparison: Comparison) -> str:
    lead, where, quantity = comparison.lead, where_text(content, comparison), comparison.quantity
    difference = as_shown(lead.difference)
    what = f"the {quantity.heading[0].lower()}{quantity.heading[1:]}"
    if isinstance(difference.value, Undefined):
        return f"{sentence_start(what)}{where}: the difference is {value_text(difference.value)}."
    size = with_unit(value_text(abs(difference.value), places_of(lead.difference)), difference.unit)
    if isinstance(lead.test.p, Undefined):
        return (
            f"Whether {what}{where} changed cannot be told: {lead.test.p.reason}; the means differ by "
            f"{_signed(difference.value, size)}."
        )
    once = _lost_by_holm(lead)
    if not lead.rejected or once:
        said = f"a change of {what}{where} is not shown{once}: {_signed(difference.value, size)}"
    else:
        comparative = quantity.comparative[0 if difference.value >= 0 else 1]
        said = f"{what} was {size} {comparative} under {treatment_name(content, comparison.group)}{where}"
    return _decided(said, lead, lead.difference, comparison.exploratory) + _within(lead.equivalence)


def _decided(said: str, lead: Decision, number: Number, exploratory: str) -> str:
    """Put days before the sentence where it holds for them alone, and the evidence behind it."""
    evidence = [f"{level_text(number)} {interval_text(number)}", significance_text(lead.test, name=False)]
    if lead.adjusted is not None:
        evidence.append(f"{p_text(lead.adjusted.value)} by Holm over {count_text(lead.adjusted.n or 0, 'test')}")
    runs = f"{lead.n_control} runs against {lead.n_treatment}"
    days = len(lead.days)
    evidence.append(f"{count_text(days, 'day')} with both, {runs}" if lead.decided_by_days else runs)
    measured = "On the one day measured" if days == 1 else f"On the {days} days measured"
    opening, closing = (f"{measured}, ", _ELSEWHERE) if lead.decided_by_days and lead.unit == "run" else ("", "")
    sentence = f"{opening}{said} ({'; '.join(evidence)}){exploratory_text(exploratory)}."
    return f"{sentence_start(sentence)}{closing}"


def _lost_by_holm(lead: Decision) -> str:
    if lead.adjusted is None or not lead.rejected or lead.adjusted_rejected is not False:
        return ""
    return f" once the {lead.adjusted.n} tests of the family are counted by Holm"


def _signed(value: float, size: str) -> str:
    return f"{MINUS}{size}" if value < 0 else size


def _overall(content: ReportContent, overall: OverallSavings) -> Claim:
    savings = overall.savings
    treatment = treatment_name(content, {}) if swept_words(swept_factor(content)).of_active_damping else "the treatment"
    if isinstance(savings.value, Undefined):
        text = f"Whether {treatment} saves energy cannot be told from these days: {savings.value.reason}."
        return Claim(text, (savings.provenance,))
    size = with_unit(value_text(abs(savings.value), places_of(savings)), savings.unit)
    over = f" over {count_text(len(overall.groups), 'group')}"
    if not overall.rejected:
        said = f"a saving is not shown{over}: {_signed(savings.value, size)}"
    elif savings.value > 0:
        said = f"{treatment} saved {size} of the energy of a jump{over}"
    else:
        said = f"{treatment} cost {size} more energy a jump{over}"
    evidence = (
        f"{level_text(savings)} {interval_text(savings)}; {significance_text(overall.test, name=False)}; "
        f"{count_text(len(overall.days), 'day')}"
    )
    opening, closing = ("on the days measured, ", _ELSEWHERE) if overall.days_measured_only else ("", "")
    if overall.left_out:
        names = list_text([levels_name(content, group) or "all runs" for group in overall.left_out])
        closing += f" Left out, because their days claim nothing: {names}."
    sentence = f"{sentence_start(f'{opening}{said}')} ({evidence}){exploratory_text(overall.exploratory, 'effect')}."
    return Claim(f"{sentence}{closing}", (savings.provenance,))


def _no_loss(item: Equivalence) -> Claim:
    """Say whether apex height changed within the bounds over all groups."""
    if isinstance(item.p, Undefined) or isinstance(item.estimate.value, Undefined):
        reason = next(each.reason for each in (item.p, item.estimate.value) if isinstance(each, Undefined))
        return Claim(f"Whether apex height was lost cannot be told: {reason}.", (item.estimate.provenance,))
    change = value_text(item.estimate.value, places_of(item.estimate))
    sign = "+" if item.estimate.value > 0 else ""
    lead = "No apex height was lost" if item.shown else "That no apex height was lost is not shown"
    text = (
        f"{lead}: it changed by {sign}{with_unit(change, '%')} ({level_text(item.estimate)} "
        f"{interval_text(item.estimate)}; TOST within {bounds_text(item)}, {p_text(item.p)})"
    )
    return Claim(f"{text}{exploratory_text(item.exploratory, 'test')}.", (item.estimate.provenance,))


def _within(item: Equivalence | None) -> str:
    """Say whether a difference lies within the bounds; "" where none were stated."""
    if item is None:
        return ""
    if isinstance(item.p, Undefined):
        return ""
    verdict = "" if item.shown else "not shown to be "
    return f" It is {verdict}within {bounds_text(item)} (TOST, {p_text(item.p)})."


def _ids(lead: Decision) -> tuple[str, ...]:
    number = lead.savings or lead.difference
    return tuple(filter(None, (number.provenance,)))
