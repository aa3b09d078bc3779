"""What `labbook stats equivalence` finds: whether groups differ from the control by less than what matters."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

from data_schema.errors import UsageError
from data_schema.reasons import Reason
from data_schema.rounding import number_text
from data_schema.vocabulary import Undefined
from labbook.actions.stats.answering import SHARED_NOTE, Answer, Question
from labbook.actions.stats.comparing import sentences_with_days
from labbook.config.model import Bounds
from labbook.presenting.report.day_layout import FROM_DAYS
from labbook.presenting.stats.days import HERE, LEFT_OUT, day_notes, one_day_groups, with_confounding
from labbook.presenting.stats.decided import IGNORING, decide_group_equivalence, shared_days_decide
from labbook.presenting.stats.figures import estimation_of, number_of
from labbook.presenting.stats.plan import Bounded, plan_notes
from stats.checks import Missing
from stats.compare.equivalence import Equivalence, EquivalenceRoute, equivalence
from stats.results import as_dict


def equal(question: Question, given: Bounded, route: str = "welch") -> Answer:
    """Test every group, or all but the control together, against the bounds, in the values' unit if not in percent."""
    observed, control = question.observed, question.control
    bounds = _bounds(given, question)
    low, high, percent = bounds
    if not percent:
        low, high = (None if end is None else question.scale * end for end in (low, high))
    confounded = {label: one_day_groups(observed, (label, observed.control)) for label in observed.others()}
    tested = {
        label: equivalence(
            observed.values(label),
            observed.values(observed.control),
            low=low,
            high=high,
            bounds="percent" if percent else "raw",
            route=cast(EquivalenceRoute, route),
            alpha=question.alpha,
            missing=cast(Missing, question.source.missing),
            names=(observed.name(label), control),
        )
        for label in confounded
    }
    # A single bound is a test that no report makes: only the sentence that ignores days is given
    by_days = (
        None
        if low is None or high is None
        else decide_group_equivalence(observed, Bounds(low, high, percent), question.alpha)
    )
    alone, sentences = by_days is None and shared_days_decide(observed), []
    for label, result in tested.items():
        own = result.sentence(observed.name(label), control, observed.unit, confounded[label] and FROM_DAYS)
        own = with_confounding(own, confounded[label])
        sentences += [f"{IGNORING}: {own}"] if alone else sentences_with_days(by_days, label, own)
    found = {
        label: _left_open(result, observed.name(label), control) if confounded[label] else result
        for label, result in tested.items()
    }
    unit, level = "%" if percent else observed.unit, 1.0 - 2.0 * question.alpha
    notes = [
        *plan_notes(observed, question.pooled, question.alpha, bounds=bounds),
        *day_notes(observed, where=LEFT_OUT if by_days else HERE),
    ]
    if alone:
        notes.append("One bound is tested without days: give both, --low and --high, for the test by shared days.")
    if question.has_shared_errors:
        notes.append(SHARED_NOTE)
    answer = Answer(
        sentences,
        {
            **({} if by_days is None else {"decisions": by_days.data()}),
            "equivalence": [
                {"a": observed.name(label), "b": control, **as_dict(result)} for label, result in found.items()
            ],
        },
        lambda: estimation_of(
            observed,
            {label: number_of(result.estimate, result.estimate_ci, level, unit) for label, result in found.items()}
            if by_days is None
            else by_days.differences(),
            [bound for bound in (low, high) if bound is not None],
            interval=f"both one-sided tests ({route.capitalize() if by_days is None else 'by shared days'})",
        ),
        notes,
        quantile_level=question.level,
    )
    answer.add_fields_of_each(
        (title, part)
        for label, result in found.items()
        for title, part in (
            (f"{observed.name(label)} (a) minus {control} (b)", result),
            *((f"both one-sided tests, {test.test}", test) for test in (result.welch, result.student)),
        )
    )
    return answer


def _left_open(result: Equivalence, name: str, control: str) -> Equivalence:
    """Return the result without its verdicts, for groups that its p cannot separate from their days."""
    if isinstance(result.p, Undefined):
        return result
    why = Undefined(Reason.ONE_DAY_EACH, a=name, b=control)
    welch, student = (replace(test, equivalent=why) for test in (result.welch, result.student))
    return replace(result, equivalent=why, welch=welch, student=student)


def _bounds(given: Bounded, question: Question) -> Bounded:
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


def _refuse_millimetres(given: Bounded, question: Question) -> None:
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
