"""What was measured and how sure it is: days, runs, packs, drain, budget, what was left out; origins of numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from data_schema.outcomes import Outcome
from data_schema.rounding import decimals_for
from data_schema.vocabulary import Undefined
from reports import fields
from reports.content import (
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
    ReportContent,
)
from reports.display import DASH, EQUALS, common_places, general_text, places_of, shown_unit, with_unit
from reports.naming import group_name, headline_name, level_value, levels_name, swept_factor, swept_words
from reports.numbers import Number, Value
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Columns,
    Row,
    Table,
    TableKind,
    count,
    in_unit,
    interval_cell,
    interval_column,
    number_cell,
    provenance_cell,
    table_of,
    text_column,
    value_cell,
    words,
)


def _days(content: ReportContent) -> Table:
    of_run: dict[str, list[int]] = {}
    for place, condition in enumerate(content.conditions):
        for name in {run for summary in condition.summaries.values() for run, _value in summary.runs}:
            of_run.setdefault(name, []).append(place)
    checked = any(day.checks_made or day.checks_not_made for day in content.days)
    made = text_column("checks made", fields.CHECKS_MADE, prose=True, shown=checked)
    not_made = text_column("checks not made", fields.CHECKS_NOT_MADE, prose=True, shown=checked)
    columns: Columns[Day] = (
        (text_column("day", fields.DAY), lambda day: words(day.date)),
        (Column("runs", fields.RUNS_OF_DAY), lambda day: Cell(str(len(day.runs)), (len(day.runs), " ".join(day.runs)))),
        (text_column("conditions", fields.CONDITIONS, prose=True), lambda day: _conditions_cell(content, day, of_run)),
        (text_column("packs", fields.PACKS, prose=True), lambda day: _names_cell(day.packs)),
        (made, lambda day: _names_cell(day.checks_made)),
        (not_made, lambda day: _names_cell(day.checks_not_made)),
    )
    return table_of("days", "What was measured and when.", content.days, columns)


def _conditions_cell(content: ReportContent, day: Day, of_run: Mapping[str, Sequence[int]]) -> Cell:
    """Return a day's conditions; `of_run` has the places of the conditions to which a run contributes."""
    conditions = "; ".join(day.conditions)
    places = sorted({place for run in day.runs for place in of_run.get(run, ())})
    analysed = [content.conditions[place] for place in places]
    return Cell(_conditions_text(content, analysed) or conditions or DASH, (conditions,))


def _names_cell(names: Sequence[str]) -> Cell:
    return Cell(", ".join(names).replace("_", " ") or DASH, (", ".join(names),))


def _conditions_text(content: ReportContent, conditions: Sequence[Condition]) -> str:
    """Sum up the conditions of a day's analysed runs: "small foot, k = 1091 N/m: CE, d = 186, 352 kg/s"."""
    swept = swept_factor(content)
    groups: dict[str, list[Condition]] = {}
    for condition in conditions:
        groups.setdefault(group_name(content, condition), []).append(condition)
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


def _assumed(content: ReportContent) -> Table:
    columns: Columns[Assumed] = (
        (text_column("parameter", fields.PARAMETER, prose=True), lambda one: words(one.name)),
        (text_column("value", fields.VALUE), lambda one: words(one.value)),
        (text_column("why", fields.WHY, prose=True), lambda one: words(one.why)),
    )
    return table_of("assumed", "Parameters without a source.", content.assumed, columns)


def _provenance(content: ReportContent) -> Table:
    columns: Columns[Provenance] = (
        (text_column("id", fields.ID), lambda source: provenance_cell(source.id)),
        (text_column("number", fields.WHAT, prose=True), lambda source: words(source.what)),
        (Column("inputs", fields.N_INPUTS), lambda source: count(source.inputs)),
    )
    caption = "Where each number came from; `labbook why ID` follows it down to the files."
    return table_of("provenance", caption, content.provenance, columns)


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


def _budget(content: ReportContent) -> Table:
    budget, several = content.budget, len(content.robots) > 1
    one_run, mean = ({}, {}) if budget is None else (budget.one_run, budget.mean)
    sources = {} if budget is None else {source.name: source for source in budget.terms}
    columns: Columns[str] = (
        (text_column("component", fields.COMPONENT, prose=True), words),
        (Column("one run", fields.UNCERTAINTY, "J a jump"), lambda name: _budget_cell(one_run[name].value)),
        (
            Column("mean of the runs", fields.UNCERTAINTY_OF_MEAN, "J a jump"),
            lambda name: _budget_cell(mean[name].value),
        ),
        (
            text_column("shared by" if several else "shared by all runs", fields.SHARED),
            lambda name: (
                words(_shared_text(sources[name], several_robots=several)) if name in sources else Cell("", (None,))
            ),
        ),
        (
            text_column("note", fields.NOTE, prose=True),
            lambda name: words(_source_note(sources[name]) if name in sources else ""),
        ),
        (
            replace(PROVENANCE, shown=any(each.provenance for each in one_run.values())),
            lambda name: provenance_cell(one_run[name].provenance),
        ),
    )
    caption = (
        "Uncertainty of the joules a jump of a single run, and in the mean over a condition's runs, by source, one "
        "standard uncertainty each. In a mean the scatter averages out, what runs share does not."
    )
    if budget is not None:
        n = budget.one_mah.n
        caption += (
            f" Shown for {levels_name(content, budget.levels)} ({n} run{'' if n == 1 else 's'}), where 1 mAh is "
            f"{budget.one_mah.value:.2g} J a jump."
        )
    return table_of("uncertainty_budget", caption, one_run, columns, strong=lambda name: name == IN_ALL)


def _source_note(source: BudgetSource) -> str:
    notes = [("contained in the scatter", source.in_scatter), ("assumed", source.assumed)]
    return " and ".join(note for note, holds in notes if holds)


def _budget_cell(value: Value | None) -> Cell:
    return value_cell(value, 2 if value is None or isinstance(value, Undefined) else decimals_for(value))


def _drain(content: ReportContent) -> Table:
    fits = [drain.result for drain in content.drains]
    columns = (
        text_column("quantity", fields.QUANTITY),
        Column("value", fields.VALUE),
        Column(
            "SE",
            fields.PLAIN_SE,
            shown=any(fit.at_run.se is not None or fit.slope.se is not None for fit in fits),
        ),
        interval_column(fit.at_run for fit in fits),
        text_column("unit", fields.UNIT),
        PROVENANCE,
    )
    rows = tuple(row for drain in content.drains for row in _drain_rows(drain, drain.robot if len(fits) > 1 else ""))
    caption = "Passive drain: straight line through the idle runs." if fits else "Passive drain: not fitted."
    return Table("passive_drain", caption, columns, rows)


def _drain_rows(drain: Drain, block: str) -> list[Row]:
    fit, at = drain.result, f"at {general_text(drain.run_duration_min)} min"
    named = {"slope": fit.slope, "intercept": fit.intercept, at: fit.at_run}
    rows = [Row(_named_cells(name, number), block=block) for name, number in named.items()]
    cells = (
        words("R²"),
        value_cell(fit.r_squared.value, _r_squared_places(fit.r_squared.value)),
        Cell("", (None,)),
        Cell("", (None, None, None)),
        words(""),
        provenance_cell(fit.r_squared.provenance),
    )
    return [*rows, Row(cells, block=block)]


def _r_squared_places(r_squared: Value) -> int:
    """Return the decimals that tell R² from 1."""
    return 2 if isinstance(r_squared, Undefined) else decimals_for(1.0 - r_squared)


def _named_cells(name: str, number: Number) -> tuple[Cell, ...]:
    places = places_of(number)
    return (
        words(name),
        number_cell(number, places),
        value_cell(number.se, places),
        interval_cell(number, places),
        words(number.unit),
        provenance_cell(number.provenance),
    )


def _idle_runs(content: ReportContent) -> Table:
    fits = content.drains
    columns: Columns[tuple[Drain, IdleRun]] = (
        (text_column("run", fields.RUN), lambda row: words(row[1].run)),
        (Column("duration", fields.DURATION, "min"), lambda row: value_cell(row[1].duration_s / MAH_MIN)),
        (Column("charge", fields.CHARGE, "mAh"), lambda row: value_cell(row[1].charge_mah)),
    )
    points = [(fit, run) for fit in fits for run in fit.idle]
    caption = "Idle runs that the passive drain is fitted to."
    return table_of("idle_runs", caption, points, columns, block=lambda row: row[0].robot if len(fits) > 1 else "")


def _packs(content: ReportContent) -> Table:
    means = [found.deviation for found in content.packs.values()]
    places = common_places(means)
    unit = means[0].unit if means else ""
    traced = any(mean.provenance for mean in means)
    columns: Columns[tuple[str, PackDeviation]] = (
        (text_column("pack", fields.PACK), lambda row: words(row[0])),
        (Column("n", fields.N_RUNS), lambda row: count(row[1].deviation.n)),
        (in_unit("mean", fields.PLAIN_MEAN, unit), lambda row: number_cell(row[1].deviation, places)),
        (interval_column(means, unit, named_unit=False), lambda row: interval_cell(row[1].deviation, places)),
        (replace(PROVENANCE, shown=traced), lambda row: provenance_cell(row[1].deviation.provenance)),
    )
    return table_of(
        "packs",
        "Joules a jump by battery pack, less the mean of each run's condition where all have one.",
        list(content.packs.items()),
        columns,
    )


def _sensitivity(content: ReportContent) -> Table:
    # CSV has the stored unit beside the stored value, the page the unit shown.
    columns: Columns[tuple[Comparison, str, Number]] = (
        (text_column("computed", fields.VARIANT), lambda row: words(row[1])),
        (Column("n", fields.N), lambda row: count(row[2].n)),
        (Column("value", fields.VALUE), lambda row: number_cell(row[2], common_places([row[0].decision.headline]))),
        (interval_column(()), lambda row: interval_cell(row[2], common_places([row[0].decision.headline]))),
        (text_column("unit", fields.UNIT), lambda row: Cell(shown_unit(row[2].unit)[0], (row[2].unit,))),
        (PROVENANCE, lambda row: provenance_cell(row[2].provenance)),
    )
    rows = [
        (one, label, number)
        for one, varied in content.headlines
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
        block=lambda row: headline_name(content, row[0]),
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


def _flow(content: ReportContent) -> Table:
    columns: Columns[tuple[Outcome, Step]] = (
        (text_column("analysis", fields.ANALYSIS), lambda row: words(str(row[0]))),
        (text_column("step", fields.STEP), lambda row: words(row[1].name)),
        (Column("count", fields.COUNT), lambda row: count(row[1].count)),
        (text_column("left out before it", fields.LEFT_OUT, prose=True), lambda row: words("; ".join(row[1].leaving))),
    )
    steps = [(quantity, step) for quantity, steps in flow_lines(content.flow).items() for step in steps]
    return table_of("flow", "Runs and jumps, from what was planned to what was analysed.", steps, columns)


FLOW = TableKind("flow", _flow)
