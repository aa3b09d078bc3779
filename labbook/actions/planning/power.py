"""`labbook power`: how many runs of each condition the study needs; nothing is drawn, stated or stored.

`labbook power --test`: how likely a test finds what is there, or how many values that needs.
"""

from __future__ import annotations

import functools
import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from data_schema.errors import UsageError, unknown_name
from data_schema.outcomes import Outcome
from data_schema.queries.study import planned_runs
from data_schema.reasons import Reason
from data_schema.rounding import interval_text, number_text
from data_schema.vocabulary import Undefined
from labbook.actions.planning.asked import PowerRequest
from labbook.actions.planning.plan import draw_study_plan
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
from labbook.analysis.comparison.pairing import swept_factor
from labbook.analysis.outcomes.conditions import SPREAD_LEVEL, Spread, run_spread
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.preregistration.planned import FAMILY_OF, Planned, planned_analysis
from labbook.analysis.results import Results
from labbook.analysis.study_data import gather
from labbook.book.opening import Book
from labbook.config.parsing import Configuration
from labbook.plan.drawing import LARGEST_PLAN, Plan
from reports.display import shown_unit
from stats.planning.power import Power, SampleSize, power_anova, power_equivalence, power_t, power_welch, sample_size
from stats.results import as_dict

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
        of_condition = Counter(row.condition_key for row in planned_runs(connection) if row.condition_key is not None)
    n_of_plan = min(of_condition.values(), default=None)
    if isinstance(primary, Undefined):
        raise UsageError(f"{primary.reason}: give the expected standard deviation with --sd.")
    difference = _difference(request, quantity, primary)
    design = _design(configuration, planned)

    @functools.cache
    def draw(n: int) -> Plan | Undefined:
        """Return a plan with this n, as `labbook plan` would draw it."""
        if n * math.prod(len(factor.levels) for factor in configuration.factors.values()) > LARGEST_PLAN // 2:
            return Undefined(Reason.PLAN_TOO_LARGE)
        return draw_study_plan(configuration, n, request.per_day, request.method, seed=1, idle=request.idle)

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


def _needed(test: PlannedTest, ns: list[int], target: float, draw: DrawPlan, within: int) -> Needed:
    if isinstance(test.assumed, Undefined):
        none, remedy = test.assumed, ""
        if none.code is Reason.NO_TWO_OF_A_CONDITION:  # without the primary outcome's there is no answer
            remedy = ": give --apex-sd and --apex-mean"
        why = f"No power: {none.reason}{remedy}."
        return Needed(test.name, test.note, test.alpha, none, why, None, dict.fromkeys(ns, none), none, none)
    sd, spread = test.assumed.sd, test.assumed.spread
    found, over = _smallest(test, sd, target, within), None
    if spread is not None:
        low, high = (_smallest(test, end, target, within).n for end in (spread.sd_low, spread.sd_high))
        over = low, high
    drawn = found.n if isinstance(found.n, Undefined) else draw(found.n)
    runs, days = (drawn, drawn) if isinstance(drawn, Undefined) else (len(drawn.runs), len(drawn.days))
    powers = {n: test.plan(sd, n).power for n in ns}
    return Needed(test.name, test.note, test.alpha, found.n, found.sentence(), over, powers, runs, days)


def _smallest(test: PlannedTest, sd: float, target: float, within: int) -> SampleSize:
    """Return the smallest plan that reaches the target: up to `within` first, beyond which the power may fall once."""
    if within >= 2:
        found = sample_size(lambda n: test.plan(sd, n), target, within)
        if not isinstance(found.plan, Undefined):
            return found
    return sample_size(lambda n: test.plan(sd, n), target)


ALPHA, USUAL_POWER = 0.05, 0.8
Given = Mapping[str, Any]
"""The options that were given, by name; those that may be repeated are lists."""


@dataclass(frozen=True, slots=True)
class _Test:
    """What a test needs and may have, and its power with so many values in the first and in the second group.

    `most` says how often an option may be given, once where it is not there; None: any number of times.
    """

    needs: tuple[str, ...]
    may_have: tuple[str, ...]
    plan: Callable[[Given, float, int, int], Power]
    most: Mapping[str, int | None]


def plan_test(name: str, given: Given) -> tuple[dict[str, Any], list[str]]:
    """Return the plan with the n given, or the smallest n that reaches the power: as data and in words."""
    if name not in _TESTS:
        raise unknown_name("test", name, _TESTS)
    test = _TESTS[name]
    if "--n" in given and "--power" in given:
        raise UsageError("--n asks for the power and --power for the n: give one of the two.")
    reads = (*test.needs, *test.may_have)
    idle = [option for option in given if option not in (*reads, "--n", "--power", "--alpha")]
    if idle:
        raise UsageError(
            f"--test {name} has no use for {' and '.join(idle)}: leave that out; it reads {', '.join(reads)}."
        )
    for option in test.needs:
        if option not in given:
            raise UsageError(f"this test needs {option}: add it, in the unit of the values.")
    for option, values in given.items():
        most = test.most.get(option, 1)
        if isinstance(values, list | tuple) and most is not None and len(values) > most:
            raise UsageError(f"{option} is given {len(values)} times: this test takes {most} at most.")
    alpha = given.get("--alpha", ALPHA)
    if "--n" in given:
        found = test.plan(given, alpha, given["--n"][0], given["--n"][-1])
        return {"plan": as_dict(found)}, [found.sentence()]
    smallest = sample_size(lambda n: test.plan(given, alpha, n, n), given.get("--power", USUAL_POWER))
    return smallest.to_dict(), [smallest.sentence()]


def _tost(given: Given, alpha: float, a: int, b: int) -> Power:
    mean = given["--mean"][0] if "--mean" in given else None
    if "--percent" in given and mean is None:
        raise UsageError("this test needs --mean: add it, for bounds in percent of the control's.")
    if mean is not None and "--percent" not in given:
        raise UsageError("--mean is the control's, for bounds in percent of it: add --percent, or leave it out.")
    low, high, difference = given["--low"], given["--high"], given.get("--difference", 0.0)
    return power_equivalence(given["--sd"][0], low, high, a, b, alpha, difference=difference, control_mean=mean)


def _sides(given: Given) -> int:
    return 1 if "--one-sided" in given else 2


_OF_T = ("--difference", "--sd")
_TESTS: Mapping[str, _Test] = {
    "t": _Test(
        _OF_T,
        ("--one-sided",),
        lambda given, alpha, a, b: power_t(given["--difference"], given["--sd"][0], a, b, alpha, _sides(given)),
        {"--n": 2},
    ),
    "welch": _Test(
        _OF_T,
        ("--one-sided",),
        lambda given, alpha, a, b: power_welch(
            given["--difference"], given["--sd"][0], given["--sd"][-1], a, b, alpha, _sides(given)
        ),
        {"--sd": 2, "--n": 2},
    ),
    "anova": _Test(
        ("--mean", "--sd"),
        (),
        lambda given, alpha, n, _same: power_anova(given["--mean"], given["--sd"][0], n, alpha),
        {"--mean": None},
    ),
    "tost": _Test(("--low", "--high", "--sd"), ("--difference", "--percent", "--mean"), _tost, {"--n": 2}),
}


_NOT_KNOWN = (
    "Assumed: independent normal values with one standard deviation everywhere, complete runs, and nothing of the "
    "drain's own error, which cancels where durations are equal; what differs between days cancels where a drawn plan "
    "gives both sides to a day, and days act on both alike. An effect that is smaller is found less often."
)


def power_head(found: StudyPower) -> list[str]:
    """Say what is assumed and by whose decision."""
    settings, unit = found.planned.settings, found.unit
    decided = (
        "as [analysis] decides"
        if found.planned.stated
        else "by default, for [analysis] decided nothing"
        if found.planned.first_measured_utc is None
        else "though [analysis] decided nothing before the first measurement"
    )
    saving, of_mean = found.saving_percent, ""
    if saving is not None and not isinstance(found.primary.mean, Undefined):
        of_mean = f", {saving:g} % of the control's {_value(found.primary.mean, unit)}"
    mean = found.primary.spread
    so_far = f" (mean of {mean.control_n} so far)" if mean is not None and saving is not None else ""
    lines = [
        f"To be found: a difference of {_value(abs(found.difference), unit)} in {found.outcome}{of_mean}{so_far}.",
        f"Scatter of {found.outcome}: {_scatter(found.primary, unit)}.",
    ]
    if settings.apex_bounds is not None and isinstance(found.apex, Assumed) and found.apex is not found.primary:
        lines.append(f"Scatter of apex height: {_scatter(found.apex, 'm')}.")
    return [
        *lines,
        f"Compared: {FAMILY_OF[settings.family]} of {found.design.swept}, alpha {settings.alpha:g}"
        f"{' one-sided' if settings.one_sided else ''}, {decided}.",
    ]


def power_table(found: StudyPower) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return head and rows: for each test the n of each condition, the size of that plan, and the chance at other n."""
    at = [f"at n = {n}" for n in found.needed[0].powers]
    head = ("test", "alpha", f"n for {100 * found.target:g} %", "at the CI limits of the SD", "runs", "days", *at)
    rows = [
        (
            item.test,
            number_text(item.alpha),
            _count(item.n),
            "" if item.n_over_sd is None else " to ".join(map(_count, item.n_over_sd)),
            _count(item.runs),
            _count(item.days),
            *("-" if isinstance(power, Undefined) else f"{100 * power:.1f} %" for power in item.powers.values()),
        )
        for item in found.needed
    ]
    return head, rows


def power_foot(found: StudyPower) -> list[str]:
    """Say what the columns mean, and why a row has no numbers."""
    of_plan = ""
    if found.n_of_plan is not None:
        of_plan = f" The plans that stand have n = {found.n_of_plan} or more."
    unknown = [f"{item.test}: {item.sentence}" for item in found.needed if isinstance(item.n, Undefined)]
    notes = [f"{item.test}: {item.note}." for item in found.needed if item.note and not isinstance(item.n, Undefined)]
    pooled = found.design.sizes(1)[1]
    treated = f"; a comparison has n controls or more and {pooled} n treated" if pooled > 1 else ""
    return [
        f"n counts runs of each condition{treated}; runs and days are the study's.{of_plan}",
        *unknown,
        *notes,
        *([] if found.crossing is None else [found.crossing.sentence]),
        *(item.sentence for item in found.needed if not isinstance(item.n, Undefined)),
        _NOT_KNOWN,
    ]


def _count(n: int | Undefined) -> str:
    return "-" if isinstance(n, Undefined) else str(n)


def _scatter(assumed: Assumed, unit: str) -> str:
    sd, (shown, factor) = f"standard deviation {_value(assumed.sd, unit)}", shown_unit(unit)
    spread = assumed.spread
    if spread is None:
        return f"{sd}, as stated"
    return (
        f"{sd} between runs of a condition "
        f"({interval_text((factor * spread.sd_low, factor * spread.sd_high), SPREAD_LEVEL, shown)}, "
        f"{spread.df} degrees of freedom, from {spread.n} so far)"
    )


def _value(value: float, unit: str) -> str:
    shown, factor = shown_unit(unit)
    return f"{number_text(factor * value)} {shown}"
