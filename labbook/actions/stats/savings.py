"""What `labbook stats savings` does: the share of the control's mean that each other group saves."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from data_schema.outcomes import Outcome
from labbook.actions.stats.data import DataSource, observe
from labbook.actions.stats.output import CommandOutput, alpha_of, output_of
from labbook.actions.stats.pictures import Pictures
from labbook.analysis.observations import Observations
from labbook.presenting.report.one_day_each import FROM_DAYS
from labbook.presenting.stats.days import day_notes, days_untold, with_days_said
from labbook.presenting.stats.figures import estimation_of, number_of
from labbook.presenting.stats.plan import plan_notes
from stats.checks import Missing
from stats.compare.savings import percent_savings
from stats.results import as_dict

NOT_CONSUMED = (
    "Savings are of what is consumed, and an apex height is not: these are percent of the control's height that are "
    "lost. Whether height is kept is what `labbook stats equivalence --quantity apex` tells."
)

NOT_CORRECTED = (
    "Every interval stands for itself: that several are looked at is counted by `labbook stats compare`, which adjusts "
    "p by Holm."
)


def save(
    given: DataSource,
    alpha: float | None,
    level: float | None,
    pooled: bool,
    pictures: Pictures,
    step: Callable[[str], None],
) -> CommandOutput:
    """Return the savings of every group, or of all but the control together."""
    pictures.check()
    observed = observe(given, step)
    if pooled:
        observed = observed.pooled()
    alpha = alpha_of(alpha, level, observed)
    return output_of(observed, pictures, lambda own, drawn: _answer(own, given, alpha, pooled, drawn))


def _answer(observed: Observations, given: DataSource, alpha: float, pooled: bool, pictures: Pictures) -> CommandOutput:
    level = 1.0 - alpha
    found = {
        label: percent_savings(
            observed.values(observed.control),
            observed.values(label),
            shared_in_control=observed.shared(observed.control),
            shared_in_treated=observed.shared(label),
            level=level,
            missing=cast(Missing, given.missing),
            names=(observed.name(observed.control), observed.name(label)),
        )
        for label in observed.others()
    }
    control, told = observed.name(observed.control), CommandOutput()
    for label, result in found.items():
        untold = days_untold(observed, (label, observed.control))
        said = result.sentence(control, observed.name(label), untold and FROM_DAYS)
        told.lines.append(with_days_said(said, untold))
    told.say_each((f"savings of {observed.name(label)} against {control}", result) for label, result in found.items())
    told.data["savings"] = [
        {"treated": observed.name(label), "control": control, **as_dict(result)} for label, result in found.items()
    ]
    pictures.write(
        observed,
        lambda: estimation_of(
            observed,
            {label: number_of(result.percent, result.percent_ci, level, "%") for label, result in found.items()},
            difference="Savings against",
            interval="Fieller's",
        ),
        level,
    )
    notes = [*plan_notes(observed, pooled, alpha), *day_notes(observed)]
    if observed.plan is not None and observed.measured is Outcome.APEX:
        notes.insert(0, NOT_CONSUMED)
    if len(found) > 1:
        notes.append(NOT_CORRECTED)
    return told.about(observed, pictures, notes)
