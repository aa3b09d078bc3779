"""What `labbook stats equivalence` does: whether groups differ from the control by less than what matters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import cast

from data_schema.errors import UsageError
from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.actions.stats.anova import SHARED_NOTE
from labbook.actions.stats.data import DataSource, observe
from labbook.actions.stats.output import CommandOutput, alpha_of, output_of
from labbook.actions.stats.pictures import Pictures
from labbook.analysis.observations import Observations
from labbook.config.model import Bounds
from labbook.presenting.report.one_day_each import FROM_DAYS
from labbook.presenting.stats.days import day_notes, days_untold, with_days_said
from labbook.presenting.stats.figures import estimation_of, number_of
from labbook.presenting.stats.plan import Bounded, bounds_notes
from stats.checks import Missing
from stats.compare.equivalence import Equivalence, EquivalenceRoute, equivalence
from stats.results import as_dict


@dataclass(frozen=True, slots=True)
class EquivalenceRequest:
    """The bounds, one or both, in the values' unit or in percent of the control's mean, and how to test."""

    low: float | None = None
    high: float | None = None
    percent: bool = False
    route: str = "welch"
    alpha: float | None = None
    pooled: bool = False


def equal(
    given: DataSource, request: EquivalenceRequest, pictures: Pictures, step: Callable[[str], None]
) -> CommandOutput:
    """Test every group, or all but the control together, against the bounds."""
    pictures.check()
    observed = observe(given, step)
    if request.pooled:
        observed = observed.pooled()
    bounds = _bounds(request, observed)
    return output_of(
        observed,
        pictures,
        lambda own, drawn: _answer(own, given, request, bounds, drawn, 1000.0 if own.unit != observed.unit else 1.0),
    )


def _answer(
    observed: Observations,
    given: DataSource,
    request: EquivalenceRequest,
    bounds: Bounded,
    pictures: Pictures,
    factor: float,
) -> CommandOutput:
    """Test against bounds, which are `factor` times as large in the unit of these values."""
    low, high, percent = bounds
    if not percent:
        low, high = (None if end is None else factor * end for end in (low, high))
    alpha = alpha_of(request.alpha, None, observed)
    found = {
        label: equivalence(
            observed.values(label),
            observed.values(observed.control),
            low=low,
            high=high,
            bounds="percent" if percent else "raw",
            route=cast(EquivalenceRoute, request.route),
            alpha=alpha,
            missing=cast(Missing, given.missing),
            names=(observed.name(label), observed.name(observed.control)),
        )
        for label in observed.others()
    }
    control, told = observed.name(observed.control), CommandOutput()
    for label, result in found.items():
        untold = days_untold(observed, (label, observed.control))
        said = result.sentence(observed.name(label), control, observed.unit, untold and FROM_DAYS)
        told.lines.append(with_days_said(said, untold))
        found[label] = _left_open(result, untold)
    told.say_each(
        (title, part)
        for label, result in found.items()
        for title, part in (
            (f"{observed.name(label)} (a) minus {control} (b)", result),
            *((f"both one-sided tests, {test.test}", test) for test in (result.welch, result.student)),
        )
    )
    told.data["equivalence"] = [
        {"a": observed.name(label), "b": control, **as_dict(result)} for label, result in found.items()
    ]
    unit, level = "%" if percent else observed.unit, 1.0 - 2.0 * alpha
    pictures.write(
        observed,
        lambda: estimation_of(
            observed,
            {label: number_of(result.estimate, result.estimate_ci, level, unit) for label, result in found.items()},
            [bound for bound in (low, high) if bound is not None],
            interval=f"both one-sided tests ({request.route.capitalize()})",
        ),
        1.0 - alpha,
    )
    notes = [*bounds_notes(observed, request.pooled, alpha, bounds), *day_notes(observed)]
    if any(row.shared.se > 0.0 for row in observed.rows):
        notes.append(SHARED_NOTE)
    return told.about(observed, pictures, notes)


def _left_open(result: Equivalence, untold: str) -> Equivalence:
    """Return the result without its verdicts where there is something that its p cannot tell."""
    if not untold or isinstance(result.p, Undefined):
        return result
    why = Undefined(untold)
    welch, student = (replace(test, equivalent=why) for test in (result.welch, result.student))
    return replace(result, equivalent=why, welch=welch, student=student)


def _bounds(request: EquivalenceRequest, observed: Observations) -> tuple[float | None, float | None, bool]:
    """Return the bounds given or, for the book's apex heights, those of its [analysis]."""
    if request.low is not None or request.high is not None:
        _refuse_millimetres(request, observed)
        return request.low, request.high, request.percent
    planned: Bounds | None = None
    if observed.settings is not None and observed.unit == Outcome.APEX.unit:
        planned = observed.settings.apex_bounds
    if planned is None:
        raise UsageError(
            "there are no bounds: add --low and --high, or one of them for non-inferiority, in the values' unit or, "
            "with --percent, in percent of the control's mean."
        )
    return planned.low, planned.high, planned.percent


def _refuse_millimetres(request: EquivalenceRequest, observed: Observations) -> None:
    """Raise `UsageError` for bounds of heights that no height lies beyond: they are metres, whatever is printed."""
    of_heights = observed.plan is not None and observed.measured is Outcome.APEX and not request.percent
    heights = [abs(float(row.value)) for row in observed.rows if row.value is not None]
    for option, bound in (("--low", request.low), ("--high", request.high)):
        if of_heights and bound is not None and heights and abs(bound) > max(heights):
            raise UsageError(
                f"{option} {bound:g} is in metres, and no apex height is above {max(heights):.3g} m: for {bound:g} mm "
                f"write {option} {bound / 1000:g}."
            )
