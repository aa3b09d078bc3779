"""What `labbook stats compare` and `labbook stats savings` find: groups against a control, as a difference by t-tests
and as the share of the control's mean that is saved.
"""

from __future__ import annotations

from dataclasses import replace
from typing import cast

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.actions.stats.answering import Answer, Question
from labbook.analysis.comparison.by_day import add_shared_error
from labbook.analysis.observations import Observations
from labbook.presenting.report.day_layout import FROM_DAYS
from labbook.presenting.stats.days import HERE, LEFT_OUT, day_left_out, day_notes, one_day_groups, with_confounding
from labbook.presenting.stats.decided import IGNORING, DecidedEquivalence, DecidedGroups, decide_groups
from labbook.presenting.stats.figures import estimation_of, number_of
from labbook.presenting.stats.plan import plan_notes
from stats.checks import Missing
from stats.compare.savings import percent_savings
from stats.compare.two_sample import Route, TwoSample, compare_two
from stats.groups.multiple import HolmFamily, holm
from stats.results import as_dict

NOT_CORRECTED = (
    "Every interval stands for itself: that several are looked at is counted by `labbook stats compare`, which adjusts "
    "p by Holm."
)


def compare(question: Question, route: str) -> Answer:
    """Compare every group with the control; several comparisons are a family, adjusted by Holm's method.

    Where days are known, and the plan leaves the unit of analysis to them, the test by shared days leads.
    """
    observed, control = question.observed, question.control
    found, by_days = compared(question, route), decide_groups(observed, question.alpha)
    names = {label: observed.name(label) for label in found}
    sentences = []
    for label, result in found.items():
        own = result.sentence(names[label], control, observed.unit)
        own = with_confounding(own, one_day_groups(observed, (label, observed.control)))
        sentences += sentences_with_days(by_days, label, own)
    answer = Answer(
        sentences,
        {
            **({} if by_days is None else {"decisions": by_days.data()}),
            "comparisons": [{"a": names[label], "b": control, **as_dict(result)} for label, result in found.items()],
        },
        lambda: estimation_of(
            observed,
            {
                label: number_of(result.difference, result.difference_ci, question.level, observed.unit)
                for label, result in found.items()
            }
            if by_days is None
            else by_days.differences(),
            interval=_tests_of(found) if by_days is None else "t, by shared days",
        ),
        [
            *plan_notes(observed, question.pooled, question.alpha),
            *day_notes(observed, where=LEFT_OUT if by_days else HERE),
            *day_left_out(observed, question.source.day),
        ],
        quantile_level=question.level,
    )
    if len(found) > 1:
        family = holm_of(found, observed, question.alpha)
        answer.sentences.append(family.sentence() if by_days is None else f"{IGNORING}: {family.sentence()}")
        answer.data["holm"] = as_dict(family)
    answer.add_fields_of_each((f"{names[label]} (a) minus {control} (b)", result) for label, result in found.items())
    return answer


def compared(question: Question, route: str) -> dict[str, TwoSample]:
    """Compare each group, by label, with the control, with what is left of an error that they share."""
    observed = question.observed
    found = {}
    for label in observed.others():
        test = compare_two(
            observed.values(label),
            observed.values(observed.control),
            route=cast(Route, route),
            alpha=question.alpha,
            missing=cast(Missing, question.source.missing),
            names=(observed.name(label), question.control),
        )
        found[label] = add_shared_error(test, observed.shared(label).minus(observed.shared(observed.control)))
    return found


def sentences_with_days(by_days: DecidedGroups | DecidedEquivalence | None, label: str, ignoring: str) -> list[str]:
    """Return the sentences on a group: the one that ignores days, after the test by shared days where that decides."""
    return [ignoring] if by_days is None else [by_days.sentence(label), f"{IGNORING}: {ignoring}"]


def holm_of(found: dict[str, TwoSample], observed: Observations, alpha: float) -> HolmFamily:
    """Adjust the p-values of Welch's tests against the control, by label, which hold their level.

    Where a p cannot tell a group from its day, whether it is rejected is left open.
    """
    control = observed.name(observed.control)
    family = holm(
        {observed.name(label): result.welch_p for label, result in found.items()},
        f"Welch against {control}",
        log10_p={observed.name(label): result.welch_log10_p for label, result in found.items()},
        alpha=alpha,
    )
    rejected = (
        Undefined(Reason.ONE_DAY_EACH, a=observed.name(label), b=control)
        if one_day_groups(observed, (label, observed.control)) and not isinstance(each, Undefined)
        else each
        for label, each in zip(found, family.rejected, strict=True)
    )
    return replace(family, rejected=tuple(rejected))


def _tests_of(found: dict[str, TwoSample]) -> str:
    """Name the tests that the intervals are of."""
    shown = [result for result in found.values() if not isinstance(result.difference_ci, Undefined)] or found.values()
    return " or ".join(f"{test}'s t" for test in sorted({result.test for result in shown}))


def save(question: Question) -> Answer:
    """Return the savings of every group, or of all but the control together.

    As in `compare` the test by shared days leads, with the savings that the report states.
    """
    observed, control = question.observed, question.control
    by_days = decide_groups(observed, question.alpha, savings=True)
    found = {
        label: percent_savings(
            observed.values(observed.control),
            observed.values(label),
            shared_in_control=observed.shared(observed.control),
            shared_in_treated=observed.shared(label),
            level=question.level,
            missing=cast(Missing, question.source.missing),
            names=(control, observed.name(label)),
        )
        for label in observed.others()
    }
    confounded = {label: one_day_groups(observed, (label, observed.control)) for label in found}
    notes = [
        *plan_notes(observed, question.pooled, question.alpha),
        *day_notes(observed, where=LEFT_OUT if by_days else HERE),
    ]
    if observed.plan is not None and not observed.measured.has_savings:
        notes.insert(0, _not_consumed(observed.measured))
    if len(found) > 1 and by_days is None:
        notes.append(NOT_CORRECTED)
    sentences = []
    for label, result in found.items():
        own = result.sentence(control, observed.name(label), confounded[label] and FROM_DAYS)
        sentences += sentences_with_days(by_days, label, with_confounding(own, confounded[label]))
    shown = (
        {label: number_of(result.percent, result.percent_ci, question.level, "%") for label, result in found.items()}
        if by_days is None
        else by_days.savings()
    )
    answer = Answer(
        sentences,
        {
            **({} if by_days is None else {"decisions": by_days.data()}),
            "savings": [
                {"treated": observed.name(label), "control": control, **as_dict(result)}
                for label, result in found.items()
            ],
        },
        lambda: estimation_of(
            observed,
            shown,
            difference="Savings against",
            interval="Fieller's" if by_days is None else "Fieller's, by shared days",
        ),
        notes,
        quantile_level=question.level,
    )
    answer.add_fields_of_each(
        (f"savings of {observed.name(label)} against {control}", result) for label, result in found.items()
    )
    return answer


def _not_consumed(outcome: Outcome) -> str:
    """Say what savings are of an outcome that nobody saves."""
    equivalence_text = f" Whether it is kept is what `labbook stats equivalence --quantity {outcome.key}` tells."
    return (
        f"Savings are of what is consumed, and {outcome} is not: these are percent of the control's that are lost."
        f"{equivalence_text if outcome.has_equivalence else ''}"
    )
