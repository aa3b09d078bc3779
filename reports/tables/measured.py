"""What was measured and how sure it is: days, runs, packs, drain, budget, what was left out; origins of numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.rounding import decimals_for
from data_schema.vocabulary import Undefined
from reports.display import DASH, EQUALS, common_places, general_text, places_of, shown_unit, with_unit
from reports.naming import group_name, headline_name, level_value, levels_name, swept_factor, swept_words
from reports.numbers import Number, Value
from reports.results import (
    IN_ALL,
    MAH_MIN,
    OF_DRAIN,
    Assumed,
    BudgetSource,
    Comparison,
    Condition,
    Day,
    Drain,
    Factor,
    Flow,
    IdleRun,
    PackDeviation,
    Provenance,
    StudyResults,
)
from reports.tables.table import (
    PLAIN_INTERVAL,
    Cell,
    Columns,
    Table,
    TableKind,
    column,
    counts,
    ids,
    interval,
    interval_cell,
    number,
    number_cell,
    table_of,
    text,
    value_cell,
)


def _days(results: StudyResults) -> Table:
    of_run: dict[str, list[int]] = {}
    for place, condition in enumerate(results.conditions):
        for name in {run for summary in condition.summaries.values() for run, _value in summary.runs}:
            of_run.setdefault(name, []).append(place)
    checked = any(day.checks_made or day.checks_not_made for day in results.days)
    columns: Columns[Day] = (
        text("day", "day", lambda day: day.date),
        column("runs", "n_runs runs", lambda day: Cell(str(len(day.runs)), (len(day.runs), " ".join(day.runs)))),
        text("conditions", "conditions", lambda day: _conditions_cell(results, day, of_run), prose=True),
        text("packs", "packs", lambda day: _names_cell(day.packs), prose=True),
        text("checks made", "checks_made", lambda day: _names_cell(day.checks_made), prose=True, shown=checked),
        text(
            "checks not made",
            "checks_not_made",
            lambda day: _names_cell(day.checks_not_made),
            prose=True,
            shown=checked,
        ),
    )
    return table_of("days", "What was measured and when.", results.days, columns)


def _conditions_cell(results: StudyResults, day: Day, of_run: Mapping[str, Sequence[int]]) -> Cell:
    """Return a day's conditions; `of_run` has the places of the conditions to which a run contributes."""
    conditions = "; ".join(day.conditions)
    places = sorted({place for run in day.runs for place in of_run.get(run, ())})
    analysed = [results.conditions[place] for place in places]
    return Cell(_conditions_text(results, analysed) or conditions or DASH, (conditions,))


def _names_cell(names: Sequence[str]) -> Cell:
    return Cell(", ".join(names).replace("_", " ") or DASH, (", ".join(names),))


def _conditions_text(results: StudyResults, conditions: Sequence[Condition]) -> str:
    """Sum up the conditions of a day's analysed runs: "small foot, k = 1091 N/m: CE, d = 186, 352 kg/s"."""
    swept = swept_factor(results)
    groups = grouped(conditions, [group_name(results, condition) for condition in conditions])
    return "; ".join(": ".join(filter(None, (name, _levels_text(swept, found)))) for name, found in groups.items())


def _levels_text(swept: Factor | None, conditions: list[Condition]) -> str:
    if swept is None:
        return ""
    names = [swept_words(swept).control_level] if any(condition.control for condition in conditions) else []
    levels = [level for c in conditions if not c.control and (level := c.level(swept.name)) is not None]
    values = [level.label if level.value is None else level_value(level) for level in levels]
    if values:
        lead = f"{swept.symbol}{EQUALS}" if swept.symbol else ""
        names.append(with_unit(f"{lead}{', '.join(values)}", swept.unit))
    return ", ".join(names)


def _assumed(results: StudyResults) -> Table:
    columns: Columns[Assumed] = (
        text("parameter", "parameter", lambda one: one.name, prose=True),
        text("value", "value", lambda one: one.value),
        text("why", "why", lambda one: one.why, prose=True),
    )
    return table_of("assumed", "Parameters without a source.", results.assumed, columns)


def _provenance(results: StudyResults) -> Table:
    columns: Columns[Provenance] = (
        ids(lambda source: source.id, name="id"),
        text("number", "what", lambda source: source.what, prose=True),
        counts("inputs", "n_inputs", lambda source: source.inputs),
    )
    caption = "Where each number came from; `labbook why ID` follows it down to the files."
    return table_of("provenance", caption, results.provenance, columns)


DAYS = TableKind("days", _days)
ASSUMED = TableKind("assumed", _assumed)
PROVENANCE_IDS = TableKind("provenance", _provenance)


def _shared_text(source: BudgetSource, *, several_robots: bool) -> str:
    """Say which runs share an error; with one robot, whether they all do."""
    if not several_robots:
        return "yes" if source.shared else "no"
    if not source.shared:
        return "no runs"
    return "a robot's runs" if source.name == OF_DRAIN else "all runs"


def _budget(results: StudyResults) -> Table:
    budget, several = results.budget, len(results.robots) > 1
    one_run, mean = ({}, {}) if budget is None else (budget.one_run, budget.mean)
    sources = {} if budget is None else {source.name: source for source in budget.terms}
    columns: Columns[str] = (
        text("component", "component", str, prose=True),
        column("one run", "uncertainty_j", lambda name: _budget_cell(one_run[name].value), unit="J a jump"),
        column(
            "mean of the runs", "uncertainty_of_mean_j", lambda name: _budget_cell(mean[name].value), unit="J a jump"
        ),
        text(
            "shared by" if several else "shared by all runs",
            "shared",
            lambda name: _shared_text(sources[name], several_robots=several) if name in sources else Cell("", (None,)),
        ),
        text("note", "note", lambda name: _source_note(sources[name]) if name in sources else "", prose=True),
        ids(lambda name: one_run[name].provenance, shown=any(each.provenance for each in one_run.values())),
    )
    caption = (
        "Uncertainty of the joules a jump of a single run, and in the mean over a condition's runs, by source, one "
        "standard uncertainty each. In a mean the scatter averages out, what runs share does not."
    )
    if budget is not None:
        n = budget.one_mah.n
        caption += (
            f" Shown for {levels_name(results, budget.levels)} ({n} run{'' if n == 1 else 's'}), where 1 mAh is "
            f"{budget.one_mah.value:.2g} J a jump."
        )
    return table_of("uncertainty_budget", caption, one_run, columns, strong=lambda name: name == IN_ALL)


def _source_note(source: BudgetSource) -> str:
    notes = [("contained in the scatter", source.in_scatter), ("assumed", source.assumed)]
    return " and ".join(note for note, holds in notes if holds)


def _budget_cell(value: Value | None) -> Cell:
    return value_cell(value, 2 if value is None or isinstance(value, Undefined) else decimals_for(value))


def _drain(results: StudyResults) -> Table:
    fits = [drain.result for drain in results.drains]
    with_se = any(fit.slope.se is not None for fit in fits)
    columns: Columns[tuple[str, str, Number]] = (
        text("quantity", "quantity", lambda row: row[1]),
        column("value", "value", lambda row: number_cell(row[2], _drain_places(row[2]))),
        column(
            "SE",
            "se",
            lambda row: value_cell(row[2].se, places_of(row[2])),
            shown=with_se,
        ),
        interval((fit.at_run for fit in fits), "", _with_interval, None, names=PLAIN_INTERVAL),
        text("unit", "unit", lambda row: row[2].unit.removeprefix("1")),
        ids(lambda row: row[2].provenance),
    )
    rows = [
        (drain.robot if len(fits) > 1 else "", name, number)
        for drain in results.drains
        for name, number in {
            "slope": drain.result.slope,
            "intercept": drain.result.intercept,
            f"at {general_text(drain.run_duration_min)} min": drain.result.at_run,
            "R²": drain.result.r_squared,
        }.items()
    ]
    caption = "Passive drain: straight line through the idle runs." if fits else "Passive drain: not fitted."
    return table_of("passive_drain", caption, rows, columns, block=lambda row: row[0])


def _with_interval(row: tuple[str, str, Number]) -> Number | None:
    return None if row[2].ci_low is None else row[2]


def _drain_places(number: Number) -> int | None:
    """Return the decimals of a number of a line, of R² those that tell it from 1."""
    if number.unit != "1":
        return places_of(number)
    return 2 if isinstance(number.value, Undefined) else decimals_for(1.0 - number.value)


def _idle_runs(results: StudyResults) -> Table:
    fits = results.drains
    columns: Columns[tuple[Drain, IdleRun]] = (
        text("run", "run", lambda row: row[1].run),
        column("duration", "duration_min", lambda row: value_cell(row[1].duration_s / MAH_MIN), unit="min"),
        column("charge", "charge_mah", lambda row: value_cell(row[1].charge_mah), unit="mAh"),
    )
    points = [(fit, run) for fit in fits for run in fit.idle]
    caption = "Idle runs that the passive drain is fitted to."
    return table_of("idle_runs", caption, points, columns, block=lambda row: row[0].robot if len(fits) > 1 else "")


def _packs(results: StudyResults) -> Table:
    means = [found.deviation for found in results.packs.values()]
    places = common_places(means)
    unit = means[0].unit if means else ""
    columns: Columns[tuple[str, PackDeviation]] = (
        text("pack", "pack", lambda row: row[0]),
        counts("n", "n_runs", lambda row: row[1].deviation.n),
        number("mean", "mean", unit, lambda row: row[1].deviation, places),
        interval(means, unit, lambda row: row[1].deviation, places, names=PLAIN_INTERVAL),
        ids(lambda row: row[1].deviation.provenance, shown=any(mean.provenance for mean in means)),
    )
    return table_of(
        "packs",
        "Joules a jump by battery pack, less the mean of each run's condition where all have one.",
        list(results.packs.items()),
        columns,
    )


def _sensitivity(results: StudyResults) -> Table:
    def places(row: tuple[Comparison, str, Number]) -> int:
        return common_places([row[0].decision.headline])

    columns: Columns[tuple[Comparison, str, Number]] = (
        text("computed", "variant", lambda row: row[1]),
        counts("n", "n", lambda row: row[2].n),
        column("value", "value", lambda row: number_cell(row[2], places(row))),
        column("CI", PLAIN_INTERVAL, lambda row: interval_cell(row[2], places(row))),
        text("unit", "unit", lambda row: Cell(shown_unit(row[2].unit)[0], (row[2].unit,))),
        ids(lambda row: row[2].provenance),
    )
    rows = [
        (one, label, number)
        for one, varied in results.headlines
        for label, number in (
            ("as reported", one.decision.headline),
            *((each.variant, each.result.headline) for each in varied),
        )
    ]
    return table_of(
        "sensitivity",
        "Each headline as reported and recomputed another way.",
        rows,
        columns,
        block=lambda row: headline_name(results, row[0]),
        strong=lambda row: row[2] is row[0].decision.headline,
    )


UNCERTAINTY_BUDGET = TableKind("uncertainty_budget", _budget)
PASSIVE_DRAIN = TableKind("passive_drain", _drain)
IDLE_RUNS = TableKind("idle_runs", _idle_runs)
PACKS = TableKind("packs", _packs)
SENSITIVITY = TableKind("sensitivity", _sensitivity)


@dataclass(frozen=True, slots=True)
class Step:
    """A step, and what is left out on the way to it."""

    name: str
    count: int
    leaving: tuple[str, ...] = ()


def flow_lines(flow: Flow) -> dict[Outcome, tuple[Step, ...]]:
    """Return the steps of each outcome: the first begins with the plan, that of apex heights ends with jumps."""
    lines = {outcome: _run_steps(flow, outcome) for outcome in flow.runs_with}
    if flow.runs_planned is not None:
        lines[Outcome.JOULES] = (Step("runs planned", flow.runs_planned), *lines[Outcome.JOULES])
    if flow.runs_with[Outcome.APEX]:
        lines[Outcome.APEX] += _jump_steps(flow)
    return lines


def _run_steps(flow: Flow, quantity: Outcome) -> tuple[Step, ...]:
    leaving = []
    if flow.runs_void:
        leaving.append(f"{flow.runs_void} void")
    if flow.runs_idle:
        leaving.append(f"{flow.runs_idle} idle, for the passive drain")
    leaving += _reasons(flow.runs_other)
    leaving += _reasons(flow.runs_without[quantity])
    return (
        Step("runs done", flow.runs_done),
        Step(f"runs with {quantity.plural}", flow.runs_with[quantity], tuple(leaving)),
    )


def _jump_steps(flow: Flow) -> tuple[Step, ...]:
    return (
        Step("jumps made", flow.jumps_made),
        Step("stances detected", flow.jumps_detected),
        Step("jumps analysed", flow.jumps_analysed, tuple(_reasons(flow.jumps_excluded))),
    )


def _reasons(excluded: Mapping[str, int]) -> list[str]:
    return [f"{count} excluded: {reason}" for reason, count in excluded.items()]


def _flow(results: StudyResults) -> Table:
    columns: Columns[tuple[Outcome, Step]] = (
        text("analysis", "analysis", lambda row: str(row[0])),
        text("step", "step", lambda row: row[1].name),
        counts("count", "count", lambda row: row[1].count),
        text("left out before it", "left_out", lambda row: "; ".join(row[1].leaving), prose=True),
    )
    steps = [(quantity, step) for quantity, steps in flow_lines(results.flow).items() for step in steps]
    return table_of("flow", "Runs and jumps, from what was planned to what was analysed.", steps, columns)


FLOW = TableKind("flow", _flow)
