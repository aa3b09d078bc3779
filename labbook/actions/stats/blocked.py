"""What `labbook stats blocked` finds: groups over several days, with the day as a random effect."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from data_schema.errors import InputRefused
from labbook.actions.stats.answering import Answer, Question
from labbook.analysis.comparison.by_day import add_shared_error_by_day
from labbook.presenting.stats.days import day_notes
from labbook.presenting.stats.figures import estimation_of, in_groups, number_of
from labbook.presenting.stats.plan import plan_notes
from stats.days.blocked import blocked_by_day
from stats.days.blocked_result import BlockedByDay, ExactTest
from stats.results import as_dict

COUNTS_VALUES = (
    "The mixed model's own f and p are not stated in the sentence: REML puts the days' variance at 0 and then counts "
    "values, where conditions with days of their own leave one observation a day."
)

SHARED_NOTE = (
    "The error of the passive drain is in the differences from the control; means of an average day and F leave it out."
)


def block(question: Question) -> Answer:
    """Compare every group, or all but the control together, with the control, within days where these are shared."""
    observed, with_runs = question.observed, question.source.run is not None
    observed.others()
    found = _compared(question, with_runs)
    names = {observed.name(label): label for label in observed.labels}
    notes = [*plan_notes(observed, question.pooled, question.alpha), *day_notes(observed, by_day=True)]
    if found.confounding is not None and found.leading() is not found.mixed and found.day_variance == 0.0:
        notes.append(COUNTS_VALUES)
    if question.has_shared_errors:
        notes.append(SHARED_NOTE)
    answer = Answer(
        [found.sentence(observed.unit)],
        {"blocked": as_dict(found)},
        lambda: estimation_of(
            observed,
            {
                names[one.condition]: number_of(one.difference, one.interval, question.level, observed.unit)
                for one in found.contrasts
            },
            interval="REML with Satterthwaite's df" if found.leading() is found.mixed else "the exact test",
        ),
        notes,
        quantile_level=question.level,
        by_day=True,
    )
    answer.add_fields("groups over days", found)
    answer.add_table("means of an average day", found.conditions)
    answer.add_fields("mixed model, y ~ group + (1 | day)" + (" + (1 | day:run)" if with_runs else ""), found.mixed)
    answer.add_table("its differences from the control", found.mixed.contrasts)
    if isinstance(found.exact, ExactTest):
        answer.add_fields("exact test", found.exact)
        answer.add_table("its differences from the control", found.exact.contrasts)
    answer.add_table("differences from the control, paired on day means", found.paired)
    return answer


def _compared(question: Question, with_runs: bool) -> BlockedByDay:
    observed = question.observed
    rows, control = in_groups(observed).rows, question.control
    if rows and all(row.label != observed.control for row in rows):
        raise InputRefused(
            f"the control {control!r} has no values, so that nothing can be compared with it: fill some in, or name "
            "another with --control."
        )
    values: list[Any] = [row.value for row in rows]
    conditions, days = [observed.name(row.label) for row in rows], [row.day for row in rows]
    found = blocked_by_day(
        values,
        conditions,
        days,
        [row.run for row in rows] if with_runs else None,
        control=control,
        order=list(dict.fromkeys(conditions)),
        level=question.level,
    )
    found = replace(found, missing=len(observed.rows) - len(rows))
    return add_shared_error_by_day(found, conditions, days, [row.shared for row in rows])
