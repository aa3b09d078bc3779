"""`labbook stats`: values are read, one function of `stats` is called for each comparison, and what it found is shown.

Where days are known the contrast by shared days answers, as in a report; `--route` asks for a test of all values.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from data_schema.errors import UsageError, unknown_name
from data_schema.rounding import error_of, interval_text, number_text, p_text, statistic_text
from data_schema.vocabulary import Rule, Undefined
from labbook.actions.stats.asked import Values
from labbook.actions.stats.data import observe
from labbook.actions.stats.figures import (
    as_shown_to_people,
    difference_number,
    draw_pictures,
    estimation_of,
)
from labbook.analysis.comparison.deciding import p_of
from labbook.analysis.observations import Observations
from labbook.config.model import Bounds
from reports.figures.estimation import Estimation
from reports.figures.kind import check_form
from stats.checks import Missing, as_values
from stats.compare.two_sample import ROUTES, Route, TwoSample, compare_two
from stats.days.decision import Bounded, Contrast, Estimate, contrast_by_day
from stats.groups.anova import one_way_anova, welch_anova
from stats.groups.multiple import HolmFamily, holm
from stats.groups.tukey import VARIANCES, compare_all_pairs
from stats.groups.variances import brown_forsythe
from stats.results import as_dict, with_unit

ALPHA = 0.05
DAYS_LEFT_OUT = "Days are left out of this test; `labbook stats compare` compares within days."
MOST_GROUPS_IN_PAIRS = 50
"""Of more groups only F is shown: their pairs are thousands."""


@dataclass(frozen=True, slots=True)
class Question:
    """The values that a test is asked about, and its level; they are `scale` times what was read."""

    observed: Observations
    missing: Missing
    alpha: float
    scale: float = 1.0

    @property
    def level(self) -> float:
        """The level of intervals, 1 - alpha."""
        return 1.0 - self.alpha

    def name(self, label: str) -> str:
        """Return a group's name."""
        return self.observed.name(label)

    @property
    def control(self) -> str:
        """The control's name."""
        return self.name(self.observed.control)


@dataclass(frozen=True, slots=True)
class Answer:
    """Sentences and notes for people, data for programs, and the function that makes the estimation plot."""

    sentences: list[str]
    data: dict[str, Any]
    drawn: Callable[[], Estimation]
    notes: Sequence[str] = ()


def answer(
    values: Values, ask: Callable[[Question], Answer], pooled: bool, step: Callable[[str], None]
) -> tuple[dict[str, Any], list[str]]:
    """Observe the values, ask, and draw what is wanted; returns data for programs, and lines for people.

    Data have the values' unit and the groups' own names, as programs ask for them; what people read has lengths below
    1 m in mm, and groups of a book named as in its report.
    """
    pictures = values.pictures
    for name, path in pictures.items():
        check_form(f"--{name}", path)
    observed = observe(values, step)
    if pooled:
        observed = observed.pooled()
    question = Question(observed, cast(Missing, values.missing), _alpha_of(values.alpha, observed))
    observed.others()
    found = ask(question)
    step("figures" if pictures else "tables")
    draw_pictures(pictures, observed, found.drawn, question.level)
    shown = as_shown_to_people(observed.in_small_units())
    scale = 1.0 if shown.unit == observed.unit else 1000.0
    as_shown = found if shown is observed else ask(replace(question, observed=shown, scale=scale))
    known = observed.known()
    data = {
        "source": observed.source,
        "quantity": observed.quantity,
        "unit": observed.unit,
        "by": observed.by,
        "control": question.control,
        "groups": {observed.name(label): len(known.values(label)) for label in observed.labels},
        "notes": [*observed.notes, *found.notes],
        **found.data,
        "files": {name: str(path) for name, path in pictures.items()},
    }
    notes = [*shown.notes, *as_shown.notes]
    lines = [*as_shown.sentences, *([""] if notes else []), *(f"note: {note}" for note in notes)]
    return data, lines


def _alpha_of(given: float | None, observed: Observations) -> float:
    """Return the level of tests: the one given, the book's, or 0.05."""
    if given is not None and not 0.0 < given < 1.0:
        raise UsageError(f"--alpha is {given!r}: give a number between 0 and 1, for example 0.05 for 5 %.")
    return given or (ALPHA if observed.settings is None else observed.settings.alpha)


def compare(question: Question, route: str | None) -> Answer:
    """Compare every group with the control, by shared days where these are known, else by the t-test of the route."""
    if route is not None and route not in ROUTES:
        raise unknown_name("route", route, ROUTES)
    if route is None and days_decide(question.observed):
        return _by_days(question)
    found = {label: _compared(question, label, route or "welch") for label in question.observed.others()}
    answer = Answer(
        [result.sentence(unit=question.observed.unit) for result in found.values()],
        {
            "comparisons": [
                {"a": question.name(label), "b": question.control, **as_dict(result)} for label, result in found.items()
            ]
        },
        lambda: estimation_of(
            question.observed,
            {
                label: difference_number(
                    result.difference, result.difference_ci, question.level, question.observed.unit
                )
                for label, result in found.items()
            },
            interval=" or ".join(f"{test}'s t" for test in sorted({result.test for result in found.values()})),
        ),
        _days_left_out(question.observed),
    )
    if len(found) > 1:
        family = _adjusted(question, {label: result.p for label, result in found.items()})
        answer.sentences.append(family.sentence())
        answer.data["holm"] = as_dict(family)
    return answer


def _compared(question: Question, label: str, route: Route) -> TwoSample:
    """Compare a group with the control by a t-test of all values, as the thesis did, without errors in common."""
    observed = question.observed
    return compare_two(
        observed.values(label),
        observed.values(observed.control),
        route=route,
        alpha=question.alpha,
        missing=question.missing,
        names=(question.name(label), question.control),
    )


def _adjusted(question: Question, p_values: Mapping[str, float | Undefined]) -> HolmFamily:
    named = {question.name(label): p for label, p in p_values.items()}
    return holm(named, f"against {question.control}", alpha=question.alpha)


def _by_days(question: Question, *, savings: bool = False) -> Answer:
    """Compare every group with the control by the days that both share; several are a family, adjusted by Holm.

    At the alpha decided on, a saving of the book's outcome is tested against the side that was decided on.
    """
    observed, alpha = question.observed, question.alpha
    settings, of_plan = observed.settings, observed.plan is not None and observed.measured.has_savings
    one_sided = of_plan and settings is not None and settings.one_sided and math.isclose(alpha, settings.alpha)
    level = 1.0 - (2.0 * alpha if one_sided else alpha)
    contrasts = _contrasts(question)
    tested = {
        label: one.savings(level) if savings or of_plan else one.difference(level) for label, one in contrasts.items()
    }
    shown = tested if savings else {label: one.difference(level) for label, one in contrasts.items()}
    p_values = {label: p_of(one, one_sided) for label, one in tested.items()}
    family = _adjusted(question, p_values) if len(contrasts) > 1 else None
    answers, sentences = [], []
    for at, (label, contrast) in enumerate(contrasts.items()):
        p = p_values[label]
        data: dict[str, Any] = {
            **_described(question, label, contrast),
            **_estimate("difference", contrast.difference(level)),
            **(_estimate("savings_percent", tested[label]) if savings or of_plan else {}),
            "t": tested[label].t,
            "df": tested[label].df,
            "p": p,
            "one_sided": one_sided,
            "rejected": None if isinstance(p, Undefined) else p <= alpha,
        }
        adjusted = None
        if family is not None:
            data["adjusted_p"] = adjusted = family.adjusted_p[at]
        answers.append(data)
        what = "saves" if savings else "minus"
        sentences.append(_sentence(question, label, contrast, what, replace(shown[label], p=p), adjusted, one_sided))
    unit = "%" if savings else observed.unit
    return Answer(
        sentences,
        {"decisions": answers},
        lambda: estimation_of(
            observed,
            {label: difference_number(one.value, one.ci, level, unit) for label, one in shown.items()},
            difference="Savings against" if savings else "",
            interval=f"{'Fieller' if savings else 't'}, by shared days",
        ),
    )


def _described(question: Question, label: str, contrast: Contrast) -> dict[str, Any]:
    counts = contrast.counts
    every = counts.control + counts.treated + counts.other_control + counts.other_treated
    return {
        "a": question.name(label),
        "b": question.control,
        "alpha": question.alpha,
        "rule": str(contrast.rule),
        "days": [day for day in contrast.days if day],
        "n_a": contrast.n[1],
        "n_b": contrast.n[0],
        "other_days": every - sum(contrast.n),
    }


def _estimate(name: str, found: Estimate | Bounded) -> dict[str, Any]:
    return {name: found.value, f"{name}_ci": found.ci}


def _sentence(
    question: Question,
    label: str,
    contrast: Contrast,
    what: str,
    shown: Estimate,
    adjusted: float | Undefined | None,
    one_sided: bool,
) -> str:
    """Say by which rule a group is compared with the control: estimate, interval, t, p, n and what is left out."""
    unit = "%" if what == "saves" else question.observed.unit
    sides = f"{question.name(label)} minus {question.control}"
    verb = "are" if what == "saves" else "is"
    if what == "saves":
        sides = f"the savings of {question.name(label)} against {question.control}"
    head = f"{_rule_text(contrast)}: {sides}"
    if isinstance(shown.value, Undefined):
        return f"{head} cannot be told: {shown.value.reason}."
    value = f"{number_text(shown.value, error=error_of(shown.ci))}{with_unit(unit)}"
    if isinstance(shown.p, Undefined) or isinstance(shown.df, Undefined):
        why = shown.p.reason if isinstance(shown.p, Undefined) else "there are no degrees of freedom"
        return f"{head} {verb} {value}; no test, because {why}."
    evidence = [
        interval_text(shown.ci, shown.level, unit),
        f"{statistic_text('t', shown.t, (shown.df,))}, {p_text(shown.p, question.alpha)}",
    ]
    if one_sided:
        evidence[-1] += " one-sided"
    if adjusted is not None:
        evidence.append(f"after Holm {p_text(adjusted, question.alpha)}")
    return f"{head} {verb} {value} ({'; '.join([*evidence, _counted(contrast)])})."


def _rule_text(contrast: Contrast) -> str:
    if not any(contrast.days):
        return "All values" if contrast.days else f"By shared days ({contrast.rule})"
    days = len(contrast.days)
    count = f", {days} day{'' if days == 1 else 's'}" if days else ""
    only = "; holds for the days measured" if contrast.rule is Rule.WITHIN else ""
    return f"By shared days ({contrast.rule}{count}{only})"


def _counted(contrast: Contrast) -> str:
    other = contrast.counts.other_control + contrast.counts.other_treated
    left_out = f", {other} on other days left out" if other else ""
    return f"n = {contrast.n[1]} against {contrast.n[0]}{left_out}"


def days_decide(observed: Observations) -> bool:
    """Tell whether every value has a day, and days are not the groups."""
    rows = observed.known().rows
    return observed.by != "day" and all(row.day for row in rows) and any(row.day != row.label for row in rows)


def _days_left_out(observed: Observations) -> list[str]:
    return [DAYS_LEFT_OUT] if days_decide(observed) else []


def _contrasts(question: Question) -> dict[str, Contrast]:
    """Return the contrast of every group with the control by label, by the days that both share where these are known.

    Without days all values are as of one day.
    """
    observed, known = question.observed, question.observed.known()
    by_days = days_decide(observed)
    if not by_days and question.missing == "refuse":
        for label in observed.labels:
            as_values(observed.name(label), observed.values(label))
    control = [row for row in known.rows if row.label == known.control]
    found = {}
    for label in observed.others():
        treated = [row for row in known.rows if row.label == label]
        found[label] = contrast_by_day(
            [float(value) for value in known.values(label)],
            [float(value) for value in known.values(known.control)],
            days_treated=[row.day for row in treated] if by_days else None,
            days_control=[row.day for row in control] if by_days else None,
            shared_treated=[row.shared for row in treated],
            shared_control=[row.shared for row in control],
            strata_treated=[", ".join(row.pooled) or "all" for row in treated],
            strata_control=[", ".join(row.pooled) or "all" for row in control],
        )
    return found


def save(question: Question) -> Answer:
    """Return the savings of every group, by shared days where these are known."""
    observed, notes = question.observed, []
    if observed.plan is not None and not observed.measured.has_savings:
        notes.append(
            f"Savings are of what is consumed, and {observed.measured} is not: these are percent of the control's that "
            "are lost."
        )
    return replace(_by_days(question, savings=True), notes=notes)


Limits = tuple[float | None, float | None, bool]
"""Both bounds, None for one that is not there, and whether they are in percent."""


def equal(question: Question, given: Limits) -> Answer:
    """Test every group against the bounds, by shared days where these are known; in the values' unit or in percent."""
    observed = question.observed
    low, high, percent = _bounds(given, question)
    if not percent:
        low, high = (None if end is None else question.scale * end for end in (low, high))
    unit, level = "%" if percent else observed.unit, 1.0 - 2.0 * question.alpha
    contrasts = _contrasts(question)
    bounded = {label: one.equivalence(low, high, question.alpha, percent=percent) for label, one in contrasts.items()}
    return Answer(
        [_bounded_sentence(question, label, contrasts[label], one, unit) for label, one in bounded.items()],
        {
            "decisions": [
                {
                    **_described(question, label, contrasts[label]),
                    "low": low,
                    "high": high,
                    **_estimate("estimate", one),
                    "t_low": one.t_low,
                    "t_high": one.t_high,
                    "df": one.df,
                    "p": one.p,
                    "equivalent": one.equivalent,
                }
                for label, one in bounded.items()
            ]
        },
        lambda: estimation_of(
            observed,
            {label: difference_number(one.value, one.ci, level, unit) for label, one in bounded.items()},
            [bound for bound in (low, high) if bound is not None],
            interval="one-sided tests by shared days" if days_decide(observed) else "one-sided tests",
        ),
    )


def _bounded_sentence(question: Question, label: str, contrast: Contrast, found: Bounded, unit: str) -> str:
    head = f"{_rule_text(contrast)}: {question.name(label)} minus {question.control}"
    ends = [f"{number_text(end)}{with_unit(unit)}" for end in (found.low, found.high) if math.isfinite(end)]
    bounds = f"{number_text(found.low)} to {ends[-1]}"
    if len(ends) == 1:
        bounds = f"{'above' if math.isfinite(found.low) else 'below'} {ends[0]}"
    within = "within " if len(ends) == 2 else ""
    if isinstance(found.p, Undefined) or isinstance(found.value, Undefined) or isinstance(found.df, Undefined):
        why = next(each for each in (found.value, found.p, found.df) if isinstance(each, Undefined))
        return f"{head}: whether it lies {within}{bounds} cannot be told: {why.reason}."
    value = f"{number_text(found.value, error=error_of(found.ci))}{with_unit(unit)}"
    verdict = f"is {'shown' if found.equivalent is True else 'not shown'} to lie {within}{bounds}"
    known = [t for t in (found.t_low, found.t_high) if isinstance(t, float)]
    tests = " and ".join(statistic_text("t", t, (found.df,)) for t in known)
    interval = interval_text(found.ci, 1.0 - 2.0 * found.alpha, unit)
    return f"{head}: {value} {verdict} ({interval}; {tests}, {p_text(found.p, question.alpha)}; {_counted(contrast)})."


def _bounds(given: Limits, question: Question) -> Limits:
    """Return the bounds given or, for the outcome that the book's [analysis] has bounds of, those."""
    observed = question.observed
    if given[:2] != (None, None):
        _refuse_millimetres(given, question)
        return given
    planned: Bounds | None = None
    if observed.settings is not None and observed.measured.has_equivalence:
        planned = observed.settings.apex_bounds
    if planned is None:
        raise UsageError(
            "there are no bounds: add --low and --high, or one of them for non-inferiority, in the values' unit or, "
            "with --percent, in percent of the control's mean."
        )
    return planned.low, planned.high, planned.percent


def _refuse_millimetres(given: Limits, question: Question) -> None:
    """Raise `UsageError` for bounds of heights that no height lies beyond: they are metres, whatever is printed."""
    observed, (low, high, percent) = question.observed, given
    if observed.plan is None or observed.measured.unit != "m" or percent:
        return
    heights = [abs(float(row.value)) / question.scale for row in observed.rows if row.value is not None]
    for option, bound in (("--low", low), ("--high", high)):
        if bound is not None and heights and abs(bound) > max(heights):
            raise UsageError(
                f"{option} {bound:g} is in metres, and no {observed.measured} is above {number_text(max(heights))} m: "
                f"for {bound:g} mm write {option} {bound / 1000:g}."
            )


def analyse(question: Question, variances: str) -> Answer:
    """Analyse the variance of all groups and compare all pairs, with one variance for all or each group's own."""
    if variances not in VARIANCES:
        raise unknown_name("assumption on variances", variances, VARIANCES)
    observed, level, missing = question.observed, question.level, question.missing
    groups, equal_variances = observed.groups(), variances == "equal"
    analysed = (one_way_anova if equal_variances else welch_anova)(groups, level=level, missing=missing)
    scatter = brown_forsythe(groups, missing=missing)
    sentences, notes = [analysed.sentence(observed.shown_by or observed.by), scatter.sentence()], []
    data = {"one_way" if equal_variances else "welch": as_dict(analysed), "variances": as_dict(scatter)}
    differences = {}
    if len(groups) <= MOST_GROUPS_IN_PAIRS:
        pairs = compare_all_pairs(groups, variances=variances, level=level, missing=missing)
        sentences.append(pairs.sentence(observed.unit))
        data["pairs"] = as_dict(pairs)
        of_control = {pair.b: pair for pair in pairs.pairs if pair.a == question.control}
        for label in observed.others():
            pair = of_control.get(question.name(label))
            if pair is not None and not isinstance(pair.difference, Undefined):
                ci = pair.difference_ci
                reversed_ci = ci if isinstance(ci, Undefined) else (-ci[1], -ci[0])
                differences[label] = difference_number(-pair.difference, reversed_ci, level, observed.unit)
    else:
        notes.append(
            f"Pairs are compared of up to {MOST_GROUPS_IN_PAIRS} groups, and there are {len(groups)}: choose with "
            "--where."
        )
    method = "Tukey" if equal_variances else "Games and Howell"
    return Answer(
        sentences,
        data,
        lambda: estimation_of(observed, differences, interval=method),
        [*notes, *_days_left_out(observed)],
    )
