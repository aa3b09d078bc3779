"""What `labbook stats blocked` does: groups over several days, with the day as a random effect."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from data_schema.errors import InputRefused, UsageError
from labbook.actions.stats.data import DataSource, observe
from labbook.actions.stats.output import CommandOutput, alpha_of, output_of
from labbook.actions.stats.pictures import Pictures
from labbook.analysis.comparison.shared_error_tests import add_shared_error_by_day
from labbook.analysis.observations import Observations
from labbook.presenting.stats.days import day_notes
from labbook.presenting.stats.fields import field_lines
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


def block(
    given: DataSource,
    alpha: float | None,
    level: float | None,
    pooled: bool,
    pictures: Pictures,
    step: Callable[[str], None],
) -> CommandOutput:
    """Compare every group, or all but the control together, with the control, within days where these are shared."""
    pictures.check()
    if given.file is not None and given.day is None:
        raise UsageError("comparing over days needs the table's column of days: add --day COLUMN.")
    observed = observe(given, step)
    if pooled:
        observed = observed.pooled()
    observed.others()
    alpha = alpha_of(alpha, level, observed)
    return output_of(observed, pictures, lambda own, drawn: _answer(own, given, alpha, pooled, drawn))


def _answer(observed: Observations, given: DataSource, alpha: float, pooled: bool, pictures: Pictures) -> CommandOutput:
    level = 1.0 - alpha
    found = _compared(observed, level, with_runs=given.run is not None)
    told = CommandOutput()
    told.lines.append(found.sentence(observed.unit))
    told.say("groups over days", field_lines(found))
    told.show("means of an average day", found.conditions)
    told.say("mixed model, y ~ group + (1 | day)" + (" + (1 | day:run)" if given.run else ""), field_lines(found.mixed))
    told.show("its differences from the control", found.mixed.contrasts)
    if isinstance(found.exact, ExactTest):
        told.say("exact test", field_lines(found.exact))
        told.show("its differences from the control", found.exact.contrasts)
    told.show("differences from the control, paired on day means", found.paired)
    told.data["blocked"] = as_dict(found)
    names = {observed.name(label): label for label in observed.labels}
    pictures.write(
        observed,
        lambda: estimation_of(
            observed,
            {
                names[one.condition]: number_of(one.difference, one.interval, level, observed.unit)
                for one in found.contrasts
            },
            interval="REML with Satterthwaite's df" if found.stated() is found.mixed else "the exact test",
        ),
        level,
        by_day=True,
    )
    notes = [*plan_notes(observed, pooled, alpha), *day_notes(observed, by_day=True)]
    if found.confounding and found.stated() is not found.mixed and found.day_variance == 0.0:
        notes.append(COUNTS_VALUES)
    if any(row.shared.se > 0.0 for row in observed.rows):
        notes.append(SHARED_NOTE)
    return told.about(observed, pictures, notes)


def _compared(observed: Observations, level: float, *, with_runs: bool) -> BlockedByDay:
    rows, control = in_groups(observed).rows, observed.name(observed.control)
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
        level=level,
    )
    found = replace(found, missing=len(observed.rows) - len(rows))
    return add_shared_error_by_day(found, conditions, days, [row.shared for row in rows])
