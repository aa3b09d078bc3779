"""What `labbook plan` does: draw, state, write the sheet."""

from __future__ import annotations

import contextlib
import datetime
import functools
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import sqlalchemy as sa

from data_schema.disk import replace_together
from data_schema.errors import BookBusy, UsageError
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
from data_schema.vocabulary import Action, PlanMethod, RunKind, Undefined
from labbook.actions.planning.asked import PlanRequest
from labbook.actions.planning.power_tests import Crossing, DrawPlan, crossing_of, drawn_layouts, least_of, shared_days
from labbook.actions.runs.runs_importing import plan_factors
from labbook.analysis.comparison.pairing import swept_factor
from labbook.analysis.preregistration.looks import look_at
from labbook.analysis.preregistration.planned import planned_analysis
from labbook.book.naming import condition_key, ensure_condition, refuse_empty, study_of
from labbook.book.opening import Book
from labbook.book.write_session import Statement, WriteSession, now_utc
from labbook.config.local_time import day_named
from labbook.config.model import AnalysisSettings
from labbook.config.parsing import Configuration
from labbook.config.run_names import RunNames
from labbook.plan.drawing import Plan, PlannedRun, draw_plan
from labbook.plan.sheet import format_run_sheet_for_print, write_run_sheet
from reports.display import list_text
from stats.planning.power import Power, power_by_day


def draw_study_plan(
    configuration: Configuration, n: int, per_day: int, method: PlanMethod, seed: int, *, idle: bool
) -> Plan:
    """Draw a plan of the study with n runs of each condition, and the protocol's idle runs if wanted."""
    protocol = configuration.protocol
    minutes = protocol.idle_minutes if idle else ()
    factors, duration_s = plan_factors(configuration), protocol.run_duration_s
    return draw_plan(factors, n, per_day, method, seed, idle_minutes=minutes, run_duration_s=duration_s)


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
