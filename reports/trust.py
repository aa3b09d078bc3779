"""What came of the runs, how robust the numbers are, and how far a reader may trust them, each in a sentence."""

from __future__ import annotations

import math
from collections.abc import Sequence

from data_schema.outcomes import Outcome
from reports.display import (
    SAVINGS,
    as_shown,
    common_places,
    count_text,
    decimal_text,
    general_text,
    given_text,
    in_sentence,
    interval_text,
    level_text,
    list_text,
    p_text,
    places_of,
    sentence_start,
    shown_unit,
    value_text,
    with_unit,
)
from reports.naming import headline_name, levels_name
from reports.numbers import Number
from reports.results import WITHOUT_EXCLUSIONS, Comparison, Favoured, StudyResults, Varied

_ONE_SLOPE = " (one drift for all groups)"
_MOST_FAVOURED = 2
"""So many groups that the order favours stand on page one."""
MOST_NAMED = 6
"""So many odd runs are named."""


def flow_sentence(results: StudyResults) -> str:
    """Say how many runs were planned, made, void and analysed, and how many jumps, or that no run was selected."""
    flow = results.flow
    if not flow.runs_done:
        return "No run matches this selection."
    planned = "" if flow.runs_planned is None else f"{count_text(flow.runs_planned, 'run')} planned, "
    parts = [f"{planned}{flow.runs_done if planned else count_text(flow.runs_done, 'run')} made"]
    parts += [f"{flow.runs_withdrawn} withdrawn from the plan"] if flow.runs_withdrawn else []
    parts += [f"{flow.runs_void} void"] if flow.runs_void else []
    parts += [f"{flow.runs_idle} idle, for the electronics' passive drain"] if flow.runs_idle else []
    parts += [f"{count} {why}" for why, count in flow.runs_other.items()]
    parts += [f"{outcome.plural} from {flow.runs_with[outcome]}" for outcome in results.outcomes]
    if flow.runs_with[Outcome.APEX]:
        parts.append(f"{flow.jumps_analysed} of {count_text(flow.jumps_made, 'jump')} analysed")
    parts += [
        f"exclusions changed the test of {headline_name(results, each)} (with all runs: {one.result.rule})"
        for each, varied in results.headlines
        for one in varied
        if one.variant == WITHOUT_EXCLUSIONS and one.result.rule is not each.decision.rule
    ]
    return f"{'; '.join(parts)}."


def review_sentence(results: StudyResults) -> str:
    """Say how many of the jumps analysed a person reviewed, and how many verdicts were blind; "" without jumps."""
    flow = results.flow
    if not flow.jumps_analysed:
        return ""
    verdicts = flow.jumps_reviewed + flow.jumps_with_the_rest + flow.jumps_rejected
    blind = flow.verdicts_blind
    analysed = count_text(flow.jumps_analysed, "jump")
    text = f"A person reviewed {flow.jumps_reviewed or 'none'} of the {analysed} analysed"
    if flow.jumps_with_the_rest:
        text += f", accepted {flow.jumps_with_the_rest} with the rest of their runs unseen"
    if flow.jumps_rejected:
        text += f" and rejected {flow.jumps_rejected} more"
    if verdicts == 1:
        text += f", {'' if blind else 'not '}blind"
    elif verdicts:
        text += f"; {blind or 'none'} of these {verdicts} verdicts {'were' if blind > 1 else 'was'} given blind"
    return f"{text}."


def trust_sentences(results: StudyResults) -> tuple[str, ...]:
    """Return how far to trust the answer: days, looks, order, charger, odd runs, plan, one day less, uncertainty."""
    plan = "No analysis was decided on before the first measurement: every comparison is exploratory."
    if results.plan.stated:
        when = "beforehand"
        if results.plan.run_before:
            when = f"before measurements came in, but after the first run ({results.plan.run_before})"
        what = "and nothing departs from it"
        if results.plan.departed:
            counted = count_text(results.plan.departed, "departure")
            what = f"with {counted} ({results.section('Plan and deviations')})"
        plan = f"The analysis was decided on {when}, {what}."
    sentences = (
        *_without_charges(results),
        _looks(results),
        _order_in_days(results),
        _coarse_charger(results),
        _odd_runs(results),
        plan,
        _one_day_less(results),
        _uncertainty(results),
    )
    return tuple(filter(None, sentences))


def _first_of(names: Sequence[str]) -> str:
    """Name runs, of many the first and how many more there are."""
    return list_text([*names[:MOST_NAMED], *([f"{len(names) - MOST_NAMED} more"] if len(names) > MOST_NAMED else [])])


def _without_charges(results: StudyResults) -> list[str]:
    """Name the groups that nothing is claimed of for want of charges."""
    return [
        f"Nothing is claimed of {levels_name(results, group) or 'all runs'}: {_first_of(runs)} "
        f"{'has' if len(runs) == 1 else 'have'} no charge."
        for group, runs in results.without_charges
    ]


def _looks(results: StudyResults) -> str:
    """Say which look at the data this is; "" where it is the only one so far and one was planned."""
    look = results.plan.look
    if look is None or (look.number == 1 and look.planned == 1):
        return ""
    if look.unplanned:
        planned = "one" if look.planned == 1 else f"{look.planned} looks at {look.runs_planned} runs"
        share = given_text(float(f"{100.0 * look.share_in_error:.2g}"))
        return (
            f"This is look {look.number} of a study planned for {planned}: with a test at each, {share} % of studies "
            "without an effect find one."
        )
    of = "" if look.runs_planned is None else f", at {look.runs} of {look.runs_planned} planned runs"
    return (
        f"This is look {look.number} of {look.planned} planned{of}: significant is p up to "
        f"{general_text(look.level, 3)}, and intervals are wider, so that all looks together err in "
        f"{given_text(100.0 * look.alpha)} %."
    )


def _order_in_days(results: StudyResults) -> str:
    """Say which headlines the order within days favours, and give them adjusted for it; "" where there are none."""
    if not results.favoured:
        return ""
    named, more = results.favoured[:_MOST_FAVOURED], len(results.favoured) - _MOST_FAVOURED
    texts = [_adjusted_text(results, each) for each in named]
    texts += [f"{count_text(more, 'more group')} ({results.section('Robustness')})"] if more > 0 else []
    return (
        "Control and treated runs lie farther apart in the day than in a random order, so that a drift over the day "
        f"shifts the difference: {'; '.join(texts)}{_ONE_SLOPE if len(results.pooled) > 2 else ''}."
    )


def _adjusted_text(results: StudyResults, item: Favoured) -> str:
    whose = "all groups" if item.group is None else levels_name(results, item.group)
    adjusted = [
        f"{'saving' if outcome.has_savings else f'change of {in_sentence(outcome.heading)}'} "
        f"{with_unit(value_text(as_shown(number).value, places_of(number)), as_shown(number).unit)} "
        f"({level_text(number)} {interval_text(number)})"
        for outcome, number in item.adjusted.items()
        if number.interval is not None
    ]
    positions = " against ".join(decimal_text(at, 1) for at in (item.positions.control, item.positions.treated))
    return (
        f"{f'{whose}, ' if whose else ''}mean position {positions} ({p_text(item.positions.p)}), "
        f"{f'adjusted {list_text(adjusted)}' if adjusted else 'no adjusted estimate'}"
    )


def _coarse_charger(results: StudyResults) -> str:
    """Say that intervals of joules cannot be trusted, and what to do; "" where the charger's step is fine enough."""
    found = results.coarse_charger
    if found is None:
        return ""
    step, scatter = general_text(found.step_mah, 3), general_text(found.scatter_mah, 2)
    return (
        f"The interval of the energy cannot be trusted: charges of a condition scatter by {scatter} mAh, less than "
        f"half the charger's step of {step} mAh; make runs longer, or take a finer meter."
    )


def _odd_runs(results: StudyResults) -> str:
    """Name the runs whose joules are unlike those of their condition; "" where there are none."""
    names = results.outside_limits
    if not names:
        return ""
    lie, whose = ("lies", "its condition") if len(names) == 1 else ("lie", "their conditions")
    swapped = "".join(
        f" {one} and {other} lie inside with each other's charge: were two rows of the sheet exchanged?"
        for one, other in results.exchanged_charges[:1]
    )
    return f"{count_text(len(names), 'run')} {lie} outside the control limits of {whose}: {_first_of(names)}.{swapped}"


def _uncertainty(results: StudyResults) -> str:
    """Say what most of the answer's standard error comes from, and so what narrows it; "" where it has none.

    Scatter of runs alone gives sigma^2 (1 / n_t + rho^2 / n_c), sigma being that within days; what is more comes from
    days that act on both sides differently.
    """
    overall = next(iter(results.overall), None)
    of_pooled = min((one.quantity for one in results.pooled), key=list(Outcome).index, default=None)
    quantity = overall.quantity if overall else of_pooled
    several = [each for each in results.pooled if each.quantity is quantity]
    if quantity is None:
        return ""
    if overall is not None:
        several = [each for each in several if each.group in overall.groups]
    elif len(several) > 1:  # of several groups without an effect over all, none is the answer
        return ""
    number = overall.savings if overall is not None else several[0].decision.headline
    squares = [square for each in several if (square := _of_runs(each)) is not None]
    coarse = results.coarse_charger is not None and quantity.shares_error  # the runs' scatter is not known
    if not isinstance(number.se, float) or not number.se or coarse or not 0 < len(several) == len(squares):
        return ""
    of_runs = math.sqrt(math.fsum(squares)) / len(squares)
    shown, factor = shown_unit(number.unit)
    of_drain = number.shared_se if isinstance(number.shared_se, float) else 0.0
    unit = "points" if shown == "%" else shown
    total, drain = (
        with_unit(general_text(each * factor, 2), unit) for each in (math.hypot(number.se, of_drain), of_drain)
    )
    mostly, helps = ("runs' scatter", "runs") if 2.0 * of_runs**2 >= number.se**2 else ("days acting unlike", "days")
    if of_drain > number.se:
        of_joules = quantity.shares_error
        mostly, helps = ("the passive drain", "idle runs") if of_joules else ("the calibration", "known heights")
    common = f"; the {quantity.common_error}'s part is {drain}" if of_drain else ""
    return f"The answer's standard error, {total}, is mostly {mostly}: more {helps} narrow it{common}."


def _of_runs(comparison: Comparison) -> float | None:
    """Return the variance that runs' scatter within days gives a headline number; None where it is not known."""
    lead = comparison.decision
    sd, mean, saved = lead.run_sd.known, lead.control_mean.known, lead.headline.known
    if sd is None or mean is None or saved is None or not lead.n_control or not lead.n_treatment:
        return None
    if lead.savings is None:
        return sd**2 * (1.0 / lead.n_treatment + 1.0 / lead.n_control)
    return (100.0 * sd / mean) ** 2 * (1.0 / lead.n_treatment + (1.0 - saved / 100.0) ** 2 / lead.n_control)


def _one_day_less(results: StudyResults) -> str:
    """Say how far leaving out one day moves a group's headline, by the first unit that there is; "" without one.

    Other days may have idle runs for the drain lines of a headline, but nothing of the selection is left out there.
    """
    known = [each for each in results.headlines if each[0].decision.headline.known is not None]
    measured = {day.date for day in results.days if not results.runs.keys().isdisjoint(day.runs)}
    if not known or not measured:
        return ""
    units = [each.decision.headline.unit for each, _varied in known]
    unit = "%" if "%" in units else units[0]  # savings first
    selected = {day.date for day in results.days}
    without = [
        (as_shown(each.decision.headline).known or 0.0, as_shown(one.result.headline).known, one.day)
        for each, varied in known
        if each.decision.headline.unit == unit
        for one in varied
        if one.day in selected
    ]
    shifts = [abs(value - reported) for reported, value, _day in without if value is not None]
    if not shifts:
        one = "The one day measured cannot be left out."
        return one if len(measured) == 1 else "No day measured can be left out: nothing would be left to compare."
    unclaimed = measured - {day for _, value, day in without if value is not None}
    lost = f"; without {count_text(len(unclaimed), 'other day')} a group has no value" if unclaimed else ""
    shown = shown_unit(unit)[0]
    what = SAVINGS if unit == "%" else f"differences in {shown}"
    moved = with_unit(decimal_text(max(shifts), 1), "points" if unit == "%" else shown)
    return f"Leaving out any one day moves the {what} of a group by at most {moved}{lost}."


def sentences_on_rules(results: StudyResults) -> tuple[str, ...]:
    """Say of each headline under how many rules of onset and take-off of a single jump its verdict holds."""
    found = (_by_rules(headline_name(results, one), one.decision.headline, varied) for one, varied in results.headlines)
    return tuple(filter(None, found))


def _by_rules(headline: str, as_reported: Number, varied: list[Varied]) -> str:
    """Say it of one headline; "" where it has no verdict, or no such rules."""
    tried = [one for one in varied if one.by_rules and one.result.headline.known is not None]
    if as_reported.side is None or not tried:
        return ""
    others = [one.variant for one in tried if one.result.headline.side != as_reported.side]
    shown = [as_shown(one.result.headline) for one in tried]
    values = [one.known for one in shown if one.known is not None]
    places = common_places([as_reported])
    span = with_unit(f"{decimal_text(min(values), places)} to {decimal_text(max(values), places)}", shown[0].unit)
    rules = f"{count_text(len(tried), 'rule')} of onset and take-off ({span})"
    holds = (
        f"under all {rules}" if not others else f"under {len(tried) - len(others)} of {rules}, not {list_text(others)}"
    )
    return f"{sentence_start(headline)}: the verdict holds {holds}."
