"""What `labbook stats compare` does: each group, or all together, against the control by t-tests."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import cast

from data_schema.vocabulary import Undefined
from labbook.actions.stats.data import DataSource, observe
from labbook.actions.stats.output import CommandOutput, alpha_of, output_of
from labbook.actions.stats.pictures import Pictures
from labbook.analysis.comparison.shared_error_tests import add_shared_error
from labbook.analysis.observations import Observations
from labbook.presenting.stats.days import day_left_out, day_notes, days_untold, with_days_said
from labbook.presenting.stats.figures import estimation_of, number_of
from labbook.presenting.stats.plan import plan_notes
from stats.checks import Missing
from stats.compare.two_sample import Route, TwoSample, compare_two
from stats.groups.multiple import HolmFamily, holm
from stats.results import as_dict


@dataclass(frozen=True, slots=True)
class CompareRequest:
    """How to compare: the t-test's route, alpha or the intervals' level, and whether all other groups are one."""

    route: str = "welch"
    alpha: float | None = None
    level: float | None = None
    pooled: bool = False


def compare(
    given: DataSource, request: CompareRequest, pictures: Pictures, step: Callable[[str], None]
) -> CommandOutput:
    """Compare every group with the control; several comparisons are a family, adjusted by Holm's method."""
    pictures.check()
    observed = observe(given, step)
    if request.pooled:
        observed = observed.pooled()
    return output_of(observed, pictures, lambda own, drawn: _answer(own, given, request, drawn))


def _answer(observed: Observations, given: DataSource, request: CompareRequest, pictures: Pictures) -> CommandOutput:
    alpha = alpha_of(request.alpha, request.level, observed)
    found = {label: compared(observed, label, request.route, alpha, given.missing) for label in observed.others()}
    told = CommandOutput()
    names = {label: (observed.name(label), observed.name(observed.control)) for label in found}
    told.lines += [
        with_days_said(result.sentence(*names[label], observed.unit), days_untold(observed, (label, observed.control)))
        for label, result in found.items()
    ]
    told.data["comparisons"] = [
        {"a": names[label][0], "b": names[label][1], **as_dict(result)} for label, result in found.items()
    ]
    if len(found) > 1:
        family = holm_of(found, observed, alpha)
        told.lines.append(family.sentence())
        told.data["holm"] = as_dict(family)
    told.say_each((f"{names[label][0]} (a) minus {names[label][1]} (b)", result) for label, result in found.items())
    level = 1.0 - alpha
    differences = {
        label: number_of(result.difference, result.difference_ci, level, observed.unit)
        for label, result in found.items()
    }
    shown = [result for result in found.values() if not isinstance(result.difference_ci, Undefined)] or found.values()
    tests = " or ".join(f"{test}'s t" for test in sorted({result.test for result in shown}))
    pictures.write(observed, lambda: estimation_of(observed, differences, interval=tests), level)
    notes = [
        *plan_notes(observed, request.pooled, alpha),
        *day_notes(observed),
        *day_left_out(observed, given.day),
    ]
    return told.about(observed, pictures, notes)


def compared(observed: Observations, label: str, route: str, alpha: float, missing: str) -> TwoSample:
    """Compare one group with the control, with what is left of an error that they share."""
    test = compare_two(
        observed.values(label),
        observed.values(observed.control),
        route=cast(Route, route),
        alpha=alpha,
        missing=cast(Missing, missing),
        names=(observed.name(label), observed.name(observed.control)),
    )
    return add_shared_error(test, observed.shared(label).minus(observed.shared(observed.control)))


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
    untold = [days_untold(observed, (label, observed.control)) for label in found]
    rejected = (
        Undefined(why) if why and not isinstance(each, Undefined) else each
        for why, each in zip(untold, family.rejected, strict=True)
    )
    return replace(family, rejected=tuple(rejected))
