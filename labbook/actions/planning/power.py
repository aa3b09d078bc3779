"""`labbook power`: how many runs of each condition the study needs; nothing is drawn, stated or stored."""

from __future__ import annotations

import functools
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import sqlalchemy as sa

from data_schema.errors import UsageError
from data_schema.outcomes import Outcome
from data_schema.queries.study import planned_runs
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.actions.planning.asked import PowerRequest
from labbook.actions.planning.power_tests import (
    Assumed,
    Crossing,
    Design,
    DrawPlan,
    PlannedTest,
    crossing_of,
    drawn_layouts,
    largest_n_within_days,
    tests_of,
)
from labbook.actions.planning.runs import draw_study_plan
from labbook.analysis.comparison.pairing import swept_factor
from labbook.analysis.outcomes.conditions import Spread, run_spread
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.preregistration.planned import Planned, planned_analysis
from labbook.analysis.results import Results
from labbook.analysis.study_data import gather
from labbook.book.opening import Book
from labbook.config.parsing import Configuration
from labbook.plan.drawing import LARGEST_PLAN, Plan
from stats.planning.power import SampleSize, sample_size

USUAL_N = 10
_Given = TypeVar("_Given", int, float)


@dataclass(frozen=True, slots=True)
class Needed:
    """How many runs one test needs; `note` adds what its name leaves open, `sentence` what is found with that n.

    `n` counts runs of each condition; `n_over_sd` is the same at both ends of the standard deviation's interval, where
    that was estimated. `powers` goes from an n to the chance at it. `runs` and `days` are those of a plan with that n.
    """

    test: str
    note: str
    alpha: float
    n: int | Undefined
    sentence: str
    n_over_sd: tuple[int | Undefined, int | Undefined] | None
    powers: dict[int, float | Undefined]
    runs: int | Undefined
    days: int | Undefined


@dataclass(frozen=True, slots=True)
class StudyPower:
    """What was assumed, and what each test needs; `n_of_plan` is the least n of a condition in the plans that stand.

    `difference` is in `unit`, as are the numbers of `primary`; those of `apex` are in m. `crossing` is where more runs
    find less by shared days, None where nothing that is shown goes that far.
    """

    outcome: Outcome
    unit: str
    target: float
    difference: float
    saving_percent: float | None
    primary: Assumed
    apex: Assumed | Undefined
    planned: Planned
    design: Design
    n: int
    n_of_plan: int | None
    needed: tuple[Needed, ...]
    crossing: Crossing | None


def study_power(book: Book, request: PowerRequest) -> StudyPower:
    """Work out what the study needs; raises `UsageError` where too little is known to do so."""
    asked_n = USUAL_N if (n := _one("--n", request.n)) is None else n
    sd, mean = _one("--sd", request.sd), _one("--mean", request.mean)
    _refuse_impossible(request, sd, mean, asked_n)
    configuration = book.configuration
    with book.reading() as connection:
        planned = planned_analysis(connection, configuration)
        settings = planned.settings
        quantity = settings.primary_outcome
        computed, detections = Results(), Detections(connection, book.store)
        evidence = gather(connection, configuration, None)

        def spread(of: Outcome) -> Spread | Undefined:
            return run_spread(computed, detections, evidence, of)

        primary = _assumed(sd, mean, spread, quantity, "--mean")
        if quantity.has_equivalence and request.apex_sd is None and request.apex_mean is None:
            apex = primary
        elif settings.apex_bounds is None:
            apex = Undefined(Reason.NO_APEX_BOUNDS)
        else:
            given = request.apex_sd, request.apex_mean
            apex = _assumed(*given, spread, Outcome.APEX, "--apex-mean")
        n_of_plan = _n_of_plan(connection)
    if isinstance(primary, Undefined):
        raise UsageError(f"{primary.reason}: give the expected standard deviation with --sd.")
    difference = _difference(request, quantity, primary)
    design = _design(configuration, planned)
    draw = functools.cache(lambda n: _drawn(configuration, request, n))
    ns = sorted({asked_n, *([] if n_of_plan is None else [n_of_plan])})
    layouts = drawn_layouts(design.swept, settings.family, draw)
    tests = tests_of(design, difference, primary, apex, layouts)
    within = largest_n_within_days(layouts)
    needed = tuple(_needed(test, ns, request.power, draw, within) for test in tests)
    largest = max(*ns, needed[0].n if isinstance(needed[0].n, int) else 2)
    crossing = crossing_of(lambda n: tests[0].plan(primary.sd, n), layouts, largest)
    return StudyPower(
        outcome=quantity,
        unit=quantity.unit,
        target=request.power,
        difference=difference,
        saving_percent=request.saving,
        primary=primary,
        apex=apex,
        planned=planned,
        design=design,
        n=asked_n,
        n_of_plan=n_of_plan,
        needed=needed,
        crossing=crossing,
    )


def _one(option: str, values: list[_Given] | None) -> _Given | None:
    """Return the value of an option that may be given several times; raises `UsageError` where it is."""
    if values and len(values) > 1:
        raise UsageError(f"{option} is given {len(values)} times: a study takes one, or name one test with --test.")
    return values[0] if values else None


def _refuse_impossible(request: PowerRequest, sd: float | None, mean: float | None, n: int) -> None:
    """Raise `UsageError` for numbers that no study has."""
    if (request.saving is None) == (request.difference is None):
        raise UsageError(
            "the power needs one effect to be found: add --saving 10 (percent of the control) or --difference 4."
        )
    if request.saving is not None and not 0 < request.saving < 100:
        raise UsageError(f"--saving {request.saving:g} is no saving: give percent between 0 and 100.")
    if request.difference is not None and not (math.isfinite(request.difference) and request.difference != 0):
        raise UsageError(f"--difference {request.difference:g} is none: give the smallest one that matters.")
    for option, value in (
        ("--sd", sd),
        ("--mean", mean),
        ("--apex-sd", request.apex_sd),
        ("--apex-mean", request.apex_mean),
    ):
        if value is not None and not (math.isfinite(value) and value > 0):
            raise UsageError(f"{option} {value:g} is not possible: give a number above 0.")
    if not 0 < request.power < 1:
        raise UsageError(f"--power {request.power:g} is no chance: give one between 0 and 1, such as 0.8.")
    if n < 2:
        raise UsageError(f"--n {n} has no scatter to test against: give 2 or more.")


def _assumed(
    sd: float | None,
    mean: float | None,
    spread: Callable[[Outcome], Spread | Undefined],
    quantity: Outcome,
    option: str,
) -> Assumed | Undefined:
    """Take what was given, and the rest from the book's own runs; `option` gives the mean."""
    if sd is not None and mean is not None:
        return Assumed(sd, mean)
    found = spread(quantity)
    if mean is None and not isinstance(found, Undefined):
        mean = found.control_mean
    known = Undefined(Reason.NO_CONTROL_YET, quantity=str(quantity), option=option) if mean is None else mean
    if sd is not None:
        return Assumed(sd, known)
    return found if isinstance(found, Undefined) else Assumed(found.sd, known, found)


def _difference(request: PowerRequest, outcome: Outcome, primary: Assumed) -> float:
    if request.difference is not None:
        return request.difference
    assert request.saving is not None  # noqa: S101 - `_refuse_impossible` has asked
    if not outcome.has_savings:
        raise UsageError(
            f"--saving is of joules, and the primary outcome is {outcome}: give --difference in {outcome.unit}."
        )
    if isinstance(primary.mean, Undefined):
        raise UsageError(f"{primary.mean.reason}, or the effect in joules with --difference.")
    return request.saving / 100.0 * primary.mean


def _design(configuration: Configuration, planned: Planned) -> Design:
    swept = swept_factor(configuration)
    if swept is None:
        raise UsageError(
            "no factor has a control, so nothing is compared: name the control level of what is varied, as control = "
            "... under its [factors.NAME] in labbook.toml."
        )
    groups = math.prod(len(factor.levels) for name, factor in configuration.factors.items() if name != swept)
    treated = len(configuration.factors[swept].levels) - 1
    if treated < 1:
        raise UsageError(f"factor {swept} has its control only: give it a level to compare with that.")
    return Design(planned.settings, swept, treated, groups)


def _n_of_plan(connection: sa.Connection) -> int | None:
    """Return the least number of runs of a condition in the plans that stand."""
    counts = Counter(row.condition_key for row in planned_runs(connection) if row.condition_key is not None)
    return min(counts.values(), default=None)


def _needed(test: PlannedTest, ns: list[int], target: float, draw: DrawPlan, within: int) -> Needed:
    if isinstance(test.assumed, Undefined):
        none, remedy = test.assumed, ""
        if none.code is Reason.NO_TWO_OF_A_CONDITION:  # without the primary outcome's there is no answer
            remedy = ": give --apex-sd and --apex-mean"
        why = f"No power: {none.reason}{remedy}."
        return Needed(test.name, test.note, test.alpha, none, why, None, dict.fromkeys(ns, none), none, none)
    sd, spread = test.assumed.sd, test.assumed.spread
    found = _smallest(test, sd, target, within)
    over = None
    if spread is not None:
        low, high = (_smallest(test, end, target, within).n for end in (spread.sd_low, spread.sd_high))
        over = low, high
    runs, days = _size(draw, found.n)
    powers = {n: test.plan(sd, n).power for n in ns}
    return Needed(test.name, test.note, test.alpha, found.n, found.sentence(), over, powers, runs, days)


def _smallest(test: PlannedTest, sd: float, target: float, within: int) -> SampleSize:
    """Return the smallest plan that reaches the target: up to `within` first, beyond which the power may fall once."""
    if within >= 2:
        found = sample_size(lambda n: test.plan(sd, n), target, within)
        if not isinstance(found.plan, Undefined):
            return found
    return sample_size(lambda n: test.plan(sd, n), target)


def _size(draw: DrawPlan, n: int | Undefined) -> tuple[int | Undefined, int | Undefined]:
    """Return runs and days of a plan with this n."""
    drawn = n if isinstance(n, Undefined) else draw(n)
    return (drawn, drawn) if isinstance(drawn, Undefined) else (len(drawn.runs), len(drawn.days))


def _drawn(configuration: Configuration, request: PowerRequest, n: int) -> Plan | Undefined:
    """Return a plan with this n, as `labbook plan` would draw it."""
    if n * math.prod(len(factor.levels) for factor in configuration.factors.values()) > LARGEST_PLAN // 2:
        return Undefined(Reason.PLAN_TOO_LARGE)
    return draw_study_plan(configuration, n, request.per_day, request.method, seed=1, idle=request.idle)
