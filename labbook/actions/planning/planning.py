"""`labbook plan`: draw, state, write the sheet. `labbook power`: how many runs of each condition the study needs.

The tests that a study is planned for: what they compare, at which level, with how many values. Those by shared days are
planned with the days that a drawn plan gives each group.

`labbook power --test`: how likely a test finds what is there, or how many values that needs.
"""

from __future__ import annotations

import contextlib
import datetime
import functools
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import sqlalchemy as sa

from data_schema.disk import replace_together
from data_schema.errors import BookBusy, UsageError, unknown_name
from data_schema.outcomes import Outcome
from data_schema.queries.history import EntryRow, first_measurement
from data_schema.queries.runs import run_names
from data_schema.queries.study import (
    OpenPlan,
    PlannedEntry,
    open_plans,
    planned_runs,
    seeds_of_plans,
    stated_plan,
    withdrawn_names,
)
from data_schema.reasons import Reason
from data_schema.rounding import interval_text, number_text
from data_schema.vocabulary import Action, PlanMethod, RunKind, Undefined
from labbook.actions.planning.asked import PlanRequest, PowerRequest
from labbook.actions.runs.runs_importing import plan_factors
from labbook.analysis.comparison.pairing import swept_factor
from labbook.analysis.outcomes.conditions import SPREAD_LEVEL, Spread, run_spread
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.preregistration.looks import look_at
from labbook.analysis.preregistration.planned import FAMILY_OF, Planned, planned_analysis
from labbook.analysis.results import Results
from labbook.analysis.study_data import gather
from labbook.book.naming import condition_key, ensure_condition, refuse_empty, study_of
from labbook.book.opening import Book
from labbook.book.write_session import Statement, WriteSession, now_utc
from labbook.config.local_time import day_named
from labbook.config.model import AnalysisSettings, Family
from labbook.config.parsing import Configuration
from labbook.config.run_names import RunNames
from labbook.plan.drawing import LARGEST_PLAN, Plan, PlannedRun, draw_plan
from labbook.plan.sheet import format_run_sheet_for_print, write_run_sheet
from reports.display import list_text, shown_unit
from stats.days.decision import LEAST_DAYS
from stats.planning.power import (
    Power,
    SampleSize,
    power_anova,
    power_by_day,
    power_equivalence,
    power_equivalence_by_day,
    power_t,
    power_welch,
    sample_size,
)
from stats.results import as_dict

USUAL_N = 10
_Given = TypeVar("_Given", int, float)


@dataclass(frozen=True, slots=True)
class Assumed:
    """A standard deviation and a control mean, in J or m; `spread` is what the former was estimated from, if it was.

    The reason of an undefined mean tells how to get one.
    """

    sd: float
    mean: float | Undefined
    spread: Spread | None = None


@dataclass(frozen=True, slots=True)
class Design:
    """What is compared: in each of so many groups, so many treated levels of the swept factor with one control."""

    settings: AnalysisSettings
    swept: str
    treated: int
    groups: int

    @property
    def comparisons(self) -> int:
        """How many comparisons the family has."""
        return self.groups * (1 if self.settings.family is Family.POOLED else self.treated)

    def sizes(self, n: int) -> tuple[int, int]:
        """Return how many runs of the control and of the treatment a comparison has, with n of each condition."""
        return n, n * self.treated if self.settings.family is Family.POOLED else n


@dataclass(frozen=True, slots=True)
class PlannedTest:
    """A test at a level; `plan` goes from a standard deviation and the n of each condition to the power.

    `note` adds what the name leaves open.
    """

    name: str
    alpha: float
    assumed: Assumed | Undefined
    plan: Callable[[float, int], Power]
    note: str = ""


Layout: TypeAlias = list[tuple[int, int]]
"""Runs of the control and of the treatment on each day."""

DrawPlan: TypeAlias = Callable[[int], Plan | Undefined]
"""Draws a plan with so many runs of each condition; undefined where it is too large."""

LayoutsOf: TypeAlias = Callable[[int], "list[Layout] | Undefined"]
"""The layouts of a plan with so many runs of each condition."""

OfSize: TypeAlias = Callable[[float, int], Power]
"""The power at a standard deviation with so many values of each condition."""


def tests_of(
    design: Design, difference: float, primary: Assumed, apex: Assumed | Undefined, layouts: LayoutsOf
) -> list[PlannedTest]:
    """Return the tests for a difference of the primary outcome in the order in which they are shown.

    The first is the comparison with the control, by the shared days of the layouts.
    """
    alpha, comparisons = design.settings.alpha, design.comparisons
    one_sided = design.settings.one_sided and design.settings.primary_outcome.has_savings
    sides = 2.0 if one_sided else 1.0  # a one-sided test at alpha rejects where the two-sided one at 2 alpha does

    def with_control(level: float) -> OfSize:
        both = sides * level
        return _by_layout(design, both, layouts, lambda sd, layout: power_by_day(difference, sd, layout, both))

    name = f"by shared days{', one-sided' if one_sided else ''}"
    found = [PlannedTest(name, alpha, primary, with_control(alpha))]
    if comparisons > 1:
        level, note = alpha / comparisons, "rejects at this alpha whatever the other comparisons of the family give"
        found.append(PlannedTest(f"{name}, Holm over {comparisons}", level, primary, with_control(level), note))
    further = _anova_test(design, difference, primary), _equivalence_test(design, apex, layouts)
    return [*found, *(test for test in further if test is not None)]


def _anova_test(design: Design, difference: float, primary: Assumed) -> PlannedTest | None:
    """Two levels apart by the difference and the others half way: of all such means those hardest to find.

    Over two levels with as many values as the comparison with the control has, F is Student's t squared: no other test.
    """
    if design.treated < 2 or (design.treated == 2 and design.sizes(1) == (1, 1)):
        return None
    means = (-difference / 2.0, difference / 2.0, *[0.0] * (design.treated - 2))
    alpha = design.settings.alpha
    return PlannedTest(
        f"ANOVA over {design.treated} levels",
        alpha,
        primary,
        lambda sd, n: power_anova(means, sd, n, alpha),
        "two treated levels are that far apart and the others half way, the hardest case to find",
    )


def _equivalence_test(design: Design, apex: Assumed | Undefined, layouts: LayoutsOf) -> PlannedTest | None:
    """Apex heights that do not differ at all, against the bounds; None without bounds."""
    bounds, alpha = design.settings.apex_bounds, design.settings.alpha
    if bounds is None:
        return None
    low, high = bounds.low, bounds.high
    mean = apex.mean if bounds.percent and isinstance(apex, Assumed) else None
    if isinstance(mean, Undefined):
        apex, mean = Undefined(Reason.BOUNDS_IN_PERCENT, reason=mean.reason), None
    note = "by the shared days; apexes do not differ at all"
    if bounds.percent:
        note += "; the mean that the percent are of is estimated in the study, as in the test"
    plan = _by_layout(
        design,
        alpha,
        layouts,
        lambda sd, layout: power_equivalence_by_day(sd, low, high, layout, alpha, control_mean=mean),
    )
    return PlannedTest("no loss of apex height (TOST)", alpha, apex, plan, note)


def _by_layout(design: Design, alpha: float, layouts: LayoutsOf, power: Callable[[float, Layout], Power]) -> OfSize:
    def plan(sd: float, n: int) -> Power:
        """Return the power in the group whose days find least."""
        found = layouts(n)
        if isinstance(found, Undefined):
            return Power("the test by shared days", design.sizes(n), alpha, found)
        return least_of([power(sd, layout) for layout in found])

    return plan


def drawn_layouts(swept: str, family: Family, draw: DrawPlan) -> LayoutsOf:
    """Return what gives the layout of each comparison of a drawn plan."""

    @functools.cache
    def layouts(n: int) -> list[Layout] | Undefined:
        plan = draw(n)
        return plan if isinstance(plan, Undefined) else _layouts_of(plan, swept, family)

    return layouts


def _layouts_of(plan: Plan, swept: str, family: Family) -> list[Layout]:
    """Return the layout of each comparison of the family."""
    control = next(factor.control for factor in plan.factors if factor.name == swept)
    runs: dict[tuple[tuple[str, str], ...], Counter[tuple[int, str]]] = {}
    for run in plan.runs:
        if run.condition is not None:
            levels = dict(run.condition)
            level = levels.pop(swept)
            runs.setdefault(tuple(levels.items()), Counter())[run.day, level] += 1
    found = []
    for counts in runs.values():
        treated = dict.fromkeys(level for _day, level in counts if level != control)
        compared = [tuple(treated)] if family is Family.POOLED else [(level,) for level in treated]
        days = dict.fromkeys(day for day, _level in counts)
        found += [
            [(counts[day, str(control)], sum(counts[day, level] for level in levels)) for day in days]
            for levels in compared
        ]
    return found


def least_of(powers: Sequence[Power]) -> Power:
    """Return the plan that finds least; one that claims nothing finds least of all."""
    return min(powers, key=lambda one: -1.0 if isinstance(one.power, Undefined) else one.power)


def shared_days(layouts: Sequence[Layout]) -> int:
    """Return the fewest days that hold both sides of a comparison."""
    return min(map(_shared, layouts), default=0)


def _shared(layout: Layout) -> int:
    return sum(1 for of_day in layout if all(of_day))


@dataclass(frozen=True, slots=True)
class Crossing:
    """Where more runs find less: the last n with all comparisons within days, the first with one paired on day means.

    Pairing on day means needs more to find as much, and what it finds holds for days like these.
    """

    n_within: int
    power_within: float
    n_paired: int
    power_paired: float

    @property
    def sentence(self) -> str:
        """Say both powers."""
        within, paired = (f"{100.0 * power:.1f} %" for power in (self.power_within, self.power_paired))
        return (
            f"From n = {self.n_paired} on, where {LEAST_DAYS} days are shared, the test is paired on day means: power "
            f"{paired}, and {within} at n = {self.n_within}, within days, valid for the days measured only."
        )


def largest_n_within_days(layouts: LayoutsOf) -> int:
    """Return the largest n with all comparisons within days; the days that are shared grow with n."""

    def paired(n: int) -> bool:
        found = layouts(n)
        return isinstance(found, Undefined) or max(map(_shared, found), default=LEAST_DAYS) >= LEAST_DAYS

    low, high = 1, 2
    while not paired(high):
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if paired(middle) else (middle, high)
    return low


def crossing_of(plan: Callable[[int], Power], layouts: LayoutsOf, largest: int) -> Crossing | None:
    """Return where the rule changes up to an n, if the power falls there."""
    within = largest_n_within_days(layouts)
    if within < 2 or within >= largest:
        return None
    before, after = plan(within).power, plan(within + 1).power
    if isinstance(before, float) and isinstance(after, float) and after < before:
        return Crossing(within, before, within + 1, after)
    return None


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


def draw_study_plan(
    configuration: Configuration, n: int, per_day: int, method: PlanMethod, seed: int, *, idle: bool
) -> Plan:
    """Draw a plan of the study with n runs of each condition, and the protocol's idle runs if wanted."""
    protocol = configuration.protocol
    minutes = protocol.idle_minutes if idle else ()
    factors, duration_s = plan_factors(configuration), protocol.run_duration_s
    return draw_plan(factors, n, per_day, method, seed, idle_minutes=minutes, run_duration_s=duration_s)


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


@dataclass(frozen=True, slots=True)
class PlanMade:
    """What was drawn and written.

    `shared_days` is the least number of days that hold both sides of a comparison, None where they decide no test;
    `power` is the least with which a comparison then finds a difference of one standard deviation of runs, and
    `crossing` where fewer runs would find more of it; `too_few` says that the power is below alpha,
    or that nothing can be tested.
    """

    runs: int
    days: int
    controls: int
    idle: int
    shared_days: int | None
    power: float | Undefined | None
    crossing: Crossing | None
    too_few: bool
    sheet: str
    printed: str
    remarks: tuple[str, ...]
    looks: tuple[PlannedLook, ...]


@dataclass(frozen=True, slots=True)
class PlannedLook:
    """After how many runs of jumps a look is planned, and the level that p is then compared with."""

    runs: int
    level: float


def make_plan(book: Book, seed: int, request: PlanRequest, person: str | None, *, dry_run: bool = False) -> PlanMade:
    """Draw a plan, write its sheet and print-out, and state it unless it is a dry run."""
    configuration = book.configuration
    if not configuration.factors:
        raise UsageError("the study has no factors: declare them under [factors] in labbook.toml.")

    @functools.cache
    def draw(n: int) -> Plan:
        return draw_study_plan(configuration, n, request.per_day, request.method, seed, idle=request.idle)

    drawn = draw(request.n)
    if not dry_run:
        book.catch_up()
    with book.reading() as connection:
        _refuse_seed_in_use(open_plans(connection), seed)
        taken = _names_taken(connection)
        settings = planned_analysis(connection, configuration).settings
        measured = first_measurement(connection)
    jumps = sum(run.condition is not None for run in drawn.runs)
    looks = _looks(request.looks, jumps, settings, measured)
    if looks:
        settings = replace(settings, alpha=looks[-1].level)
    days, power, crossing = _tested(configuration, draw, request.n, settings)
    scheme = RunNames(configuration.study.run_names)
    free = 1 + max((number for name in taken if (number := scheme.number(name)) is not None), default=0)
    names = [scheme.name(number) for number in range(free, free + len(drawn.runs))]
    # A plan that cannot be written to its file is not stated, and one that is not stated leaves no file.
    with _sheet_written(configuration, drawn, names, request.start, request.out) as page:
        if not dry_run:
            with book.session(person) as session:  # which has caught up with what others stated meanwhile
                _refuse_seed_in_use(open_plans(session.connection), seed)
                _looks(request.looks, jumps, settings, first_measurement(session.connection))
                if not _names_taken(session.connection).isdisjoint(names):
                    raise BookBusy("somebody planned or made runs meanwhile: give the command again.")
                entries = [
                    PlannedEntry(name, run.day, run.block, None if run.condition is None else dict(run.condition))
                    for name, run in zip(names, drawn.runs, strict=True)
                ]
                state_plan(session, configuration, drawn.seed, drawn.method, entries, request.looks)
    idle = sum(run.kind is RunKind.IDLE for run in drawn.runs)
    controls = {(factor.name, factor.control) for factor in drawn.factors if factor.control is not None}
    return PlanMade(
        runs=len(drawn.runs),
        days=len(drawn.days),
        controls=sum(not controls.isdisjoint(run.condition or ()) for run in drawn.runs),
        idle=idle,
        shared_days=days,
        power=power,
        crossing=crossing,
        too_few=isinstance(power, Undefined) or (power is not None and power < settings.alpha),
        sheet=str(request.out),
        printed=str(page),
        remarks=tuple(_remarks(configuration, idle)),
        looks=looks,
    )


@contextlib.contextmanager
def _sheet_written(
    configuration: Configuration, drawn: Plan, names: Sequence[str], start: str | None, out: Path
) -> Iterator[Path]:
    """Write the sheet of a plan and the page to print, whose path is given; both go again where the block raises."""
    if out.suffix.lower() == ".html":
        raise UsageError(f"{out} is named as the page to print would be: name the sheet with --out, as {out.stem}.csv.")
    first_day = datetime.date.fromisoformat(day_named("--start", start, configuration.study.time_zone))
    dates = [first_day + datetime.timedelta(days=day) for day in range(len(drawn.days))]
    declared = {"battery": list(configuration.batteries), "robot": list(configuration.robots)}
    only = {kind: names[0] if len(names) == 1 else "" for kind, names in declared.items()}
    sheet = write_run_sheet(drawn, names, dates, **only)
    printed = format_run_sheet_for_print(
        drawn,
        names,
        dates,
        study=configuration.study.name,
        jumps_nominal=configuration.study.jumps_nominal,
        checks=configuration.protocol.checks,
        **only,
    )
    _refuse_other(out, sheet)
    page = out.with_suffix(".html")
    _refuse_other(page, printed)
    with contextlib.ExitStack() as written:
        try:
            written.enter_context(replace_together({out: sheet.encode(), page: printed.encode()}))
        except OSError as error:
            reason = error.strerror or error
            raise UsageError(f"{error.filename} cannot be written ({reason}): name another file with --out.") from error
        yield page


def _refuse_other(path: Path, text: str) -> None:
    """Raise `UsageError` where a file is there that holds anything else, as it does not after a dry run."""
    if path.exists() and not (path.is_file() and path.read_bytes() == text.encode()):
        raise UsageError(f"{path} exists: name another file with --out, or move it away.")


@dataclass(frozen=True, slots=True)
class SheetAgain:
    """The sheet of a plan that was stated before, and the page to print."""

    runs: int
    sheet: str
    printed: str
    remarks: tuple[str, ...]


def sheet_again(book: Book, seed: int, start: str | None, out: Path) -> SheetAgain:
    """Write the sheet of a plan that the book has once more, with other dates where it starts on another day.

    Raises `UsageError` where no plan with that seed was stated, or it was withdrawn.
    """
    with book.reading() as connection:
        stated = stated_plan(connection, seed)
        if stated is None:
            standing, withdrawn = seeds_of_plans(connection)
            what = f"the plan with seed {seed} was withdrawn" if seed in withdrawn else f"no plan has seed {seed}"
            seeds = list_text(list(map(str, standing))) if standing else "none"
            raise UsageError(f"{what}: give the seed of one that stands ({seeds}), or draw another plan.")
    method, entries = stated
    drawn = _drawn_again(book.configuration, seed, method, entries)
    unknown = "labbook.toml draws another plan with this seed now: how long idle runs take is left blank."
    known = all(run.duration_s is not None for run in drawn.runs if run.kind is RunKind.IDLE)
    remarks = () if known else (unknown,)
    with _sheet_written(book.configuration, drawn, [entry.name for entry in entries], start, out) as page:
        pass
    return SheetAgain(len(entries), str(out), str(page), remarks)


def _drawn_again(configuration: Configuration, seed: int, method: PlanMethod, entries: Sequence[PlannedEntry]) -> Plan:
    """Return a plan as it was stated; how long idle runs take was not, and is what drawing it again gives."""
    places: Counter[int] = Counter()
    rows: list[PlannedRun] = []
    for position, entry in enumerate(entries, start=1):
        places[entry.day] += 1
        condition = None if entry.levels is None else tuple(entry.levels.items())
        kind = RunKind.IDLE if condition is None else RunKind.JUMPS
        rows.append(PlannedRun(position, entry.day, places[entry.day], entry.block, condition, kind, None))
    stated = Plan(tuple(plan_factors(configuration)), method, seed, tuple(rows))
    counts = Counter(row.condition for row in rows if row.condition is not None)
    most = max(places.values())
    for per_day in range(most, most + 3):  # a day with places left over has one at most that a control needs
        with contextlib.suppress(UsageError):
            n = min(counts.values(), default=1)
            drawn = draw_study_plan(configuration, n, per_day, method, seed, idle=len(rows) > counts.total())
            if [replace(run, duration_s=None) for run in drawn.runs] == rows:
                return drawn
    return stated


def _names_taken(connection: sa.Connection) -> set[str]:
    """Return the names that no run of a new plan may have: of runs made, planned or withdrawn."""
    planned = {row.name for row in planned_runs(connection)}
    return {*run_names(connection), *planned, *withdrawn_names(connection)}


def _looks(number: int, runs: int, settings: AnalysisSettings, measured: EntryRow | None) -> tuple[PlannedLook, ...]:
    """Return the looks of a plan at equal parts of its runs; none where one was asked for."""
    if not 1 <= number <= runs:
        raise UsageError(f"--looks {number} is not possible: give a number from 1 to {runs}, the runs of jumps.")
    if number == 1:
        return ()
    if measured is not None:
        raise UsageError(
            f"looks are planned before the first measurement, which came into the book on {measured.at_utc[:10]}: "
            "leave --looks out; the report says how many looks there were."
        )
    at = [round(runs * look / number) for look in range(1, number + 1)]
    one_sided = settings.one_sided and settings.primary_outcome.has_savings
    levels = [
        look_at(at[:n], settings.alpha, planned=number, runs_planned=runs, one_sided=one_sided).level
        for n in range(1, number + 1)
    ]
    return tuple(map(PlannedLook, at, levels))


def _tested(
    configuration: Configuration, draw: DrawPlan, n: int, settings: AnalysisSettings
) -> tuple[int | None, float | Undefined | None, Crossing | None]:
    """Return the fewest days that comparisons share, and what they find; None where they do not decide the test."""
    swept = swept_factor(configuration)
    if swept is None:
        return None, None, None
    layouts = drawn_layouts(swept, settings.family, draw)
    level = settings.outside if settings.primary_outcome.has_savings else settings.alpha
    found = layouts(n)
    if isinstance(found, Undefined) or not found:
        return None, None, None

    def plan(n: int) -> Power:
        of_n = layouts(n)
        assert not isinstance(of_n, Undefined)  # noqa: S101 - a plan with so few runs is drawn as well
        return least_of([power_by_day(1.0, 1.0, layout, level) for layout in of_n])

    power = plan(n).power
    crossing = crossing_of(plan, layouts, n) if n > 1 and isinstance(power, float) else None
    still = crossing is not None and isinstance(power, float) and power < crossing.power_within
    return shared_days(found), power, crossing if still else None


def _refuse_seed_in_use(plans: Sequence[OpenPlan], seed: int) -> None:
    """Raise `UsageError` where runs of a plan with this seed are still to be made: the seed is how a plan is called."""
    left = sum(len(plan.to_be_made) for plan in plans if plan.seed == seed)
    if left:
        raise UsageError(
            f"a plan with seed {seed} has {left} run{'' if left == 1 else 's'} still to be made: its sheet is written "
            f"again by `labbook plan --sheet --seed {seed}`; for other runs give another seed, or withdraw that plan "
            f'first with `labbook plan --withdraw --seed {seed} --why "..."`.'
        )


def _remarks(configuration: Configuration, idle: int) -> Iterator[str]:
    """Say what the plan leaves open and a person would miss only when the runs are made."""
    if all(factor.control is None for factor in configuration.factors.values()):
        yield (
            "no factor has a control, so nothing can be compared: before the runs are made, name the control level of "
            "what is varied, as control = ... under its [factors.NAME] in labbook.toml."
        )
    robots = len(configuration.robots)
    if robots > 1:
        yield (
            f"the book has {robots} robots and the plan leaves open which one makes a run: write it in every row. Each "
            f"robot's passive drain is fitted to its own idle runs, three or more, and the plan has {idle} in all."
        )


def state_plan(
    session: WriteSession,
    configuration: Configuration,
    seed: int,
    method: PlanMethod,
    entries: Sequence[PlannedEntry],
    looks: int = 1,
) -> None:
    """State a plan and its runs in order, making the conditions that it needs, and its looks where it has several."""
    study_uid = study_of(session.connection).uid
    conditions: dict[str, str] = {}
    runs = []
    for entry in entries:
        key = None if entry.levels is None else condition_key(entry.levels)
        if entry.levels is not None and key not in conditions:
            conditions[str(key)] = ensure_condition(session, configuration, study_uid, entry.levels)
        condition = None if key is None else conditions[key]
        runs.append({"name": entry.name, "day_number": entry.day, "block": entry.block, "condition": condition})
    further = {"looks": looks} if looks > 1 else {}
    session.declare("plan", study=study_uid, seed=seed, method=str(method), created_utc=now_utc(), runs=runs, **further)


@dataclass(frozen=True, slots=True)
class PlansWithdrawn:
    """Names of the runs that are no longer planned, and of those of the same plans that were made and stay."""

    withdrawn: tuple[str, ...]
    made: tuple[str, ...]


def withdraw_plans(session: WriteSession, seed: int | None, why: str) -> PlansWithdrawn:
    """State that what is left of the plans drawn with `seed` (None: of all plans) will not be made."""
    refuse_empty("--why", why)
    plans = open_plans(session.connection)
    meant = [plan for plan in plans if seed in (None, plan.seed)]
    if not meant:
        seeds = ", ".join(dict.fromkeys(str(plan.seed) for plan in plans))
        rest = f" with seed {seed}: runs are left of the plans with seed {seeds}." if plans else ": draw a plan first."
        raise UsageError(f"no planned run is left to withdraw{rest}")
    for plan in meant:
        session.state(
            Statement(Action.EXCLUDE, "plan", plan.uid, old={"to_be_made": list(plan.to_be_made)}, reason=why)
        )
    return PlansWithdrawn(
        tuple(name for plan in meant for name in plan.to_be_made), tuple(name for plan in meant for name in plan.made)
    )
