"""What was measured and how sure it is: days, runs, packs, drain, budget; where numbers and assumptions came from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from data_schema.rounding import decimals_for
from data_schema.vocabulary import Undefined
from reports.content import BudgetItem, Condition, Day, DrainFit, Factor, ReportContent
from reports.display import DASH, EQUALS, common_places, level_text, places_of, shown_unit, with_unit
from reports.flow_steps import flow_lines
from reports.naming import group_name, level_value, swept_factor, swept_words
from reports.numbers import Number, Value
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Row,
    Table,
    TableKind,
    count,
    interval_cell,
    number_cell,
    provenance_cell,
    value_cell,
    words,
)


def _days(content: ReportContent) -> Table:
    columns = (
        Column("day", ("day",), numeric=False),
        Column("runs", ("n_runs", "runs")),
        Column("conditions", ("conditions",), numeric=False, prose=True),
        Column("packs", ("packs",), numeric=False, prose=True),
        Column("checks made", ("checks_made",), numeric=False, prose=True),
        Column("checks not made", ("checks_not_made",), numeric=False, prose=True),
        Column("note", ("note",), numeric=False, prose=True, shown=any(day.note for day in content.days)),
    )
    of_run: dict[str, list[int]] = {}
    for place, condition in enumerate(content.conditions):
        for name in {run.run for summary in condition.summaries.values() for run in summary.runs}:
            of_run.setdefault(name, []).append(place)
    rows = tuple(Row(_day_cells(content, day, of_run)) for day in content.days)
    return Table("days", "What was measured and when.", columns, rows)


def _day_cells(content: ReportContent, day: Day, of_run: Mapping[str, Sequence[int]]) -> tuple[Cell, ...]:
    """Return a day's cells; `of_run` has the places of the conditions to which a run contributes."""
    conditions = "; ".join(day.conditions)
    places = sorted({place for run in day.runs for place in of_run.get(run, ())})
    analysed = [content.conditions[place] for place in places]
    lists = (day.packs, day.checks_made, day.checks_not_made)
    return (
        words(day.date),
        Cell(str(len(day.runs)), (len(day.runs), " ".join(day.runs))),
        Cell(_conditions_text(content, analysed) or conditions or DASH, (conditions,)),
        *(Cell(", ".join(names).replace("_", " ") or DASH, (", ".join(names),)) for names in lists),
        words(day.note),
    )


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


def _flow(content: ReportContent) -> Table:
    columns = (
        Column("analysis", ("analysis",), numeric=False),
        Column("step", ("step",), numeric=False),
        Column("count", ("count",)),
        Column("left out before it", ("left_out",), numeric=False, prose=True),
    )
    rows = tuple(
        Row((words(str(quantity)), words(step.name), count(step.count), words("; ".join(step.leaving))))
        for quantity, steps in flow_lines(content.flow).items()
        for step in steps
    )
    return Table("flow", "Runs and jumps, from what was planned to what was analysed.", columns, rows)


def _assumed(content: ReportContent) -> Table:
    columns = (
        Column("parameter", ("parameter",), numeric=False, prose=True),
        Column("value", ("value",), numeric=False),
        Column("why", ("why",), numeric=False, prose=True),
        Column("varied", ("varied",), numeric=False, prose=True),
    )
    rows = tuple(
        Row((words(one.name), words(one.value), words(one.why), words(one.varied or DASH))) for one in content.assumed
    )
    return Table("assumed", "Parameters without a source.", columns, rows)


def _provenance(content: ReportContent) -> Table:
    columns = (
        Column("id", ("id",), numeric=False),
        Column("number", ("what",), numeric=False, prose=True),
        Column("inputs", ("n_inputs",)),
    )
    rows = tuple(
        Row((provenance_cell(source.id), words(source.what), count(source.inputs))) for source in content.provenance
    )
    caption = "Where each number came from; `labbook why ID` follows it down to the files."
    return Table("provenance", caption, columns, rows)


DAYS = TableKind("days", _days)
FLOW = TableKind("flow", _flow)
ASSUMED = TableKind("assumed", _assumed)
PROVENANCE_IDS = TableKind("provenance", _provenance)


def _shared_text(item: BudgetItem, *, several_robots: bool) -> str:
    """Say which runs share an error; with one robot, whether they all do."""
    if not several_robots:
        return "yes" if item.shared else "no"
    if not item.shared:
        return "no runs"
    return "a robot's runs" if item.within_robot else "all runs"


def _budget(content: ReportContent) -> Table:
    several = len(content.robots) > 1
    columns = (
        Column("component", ("component",), numeric=False, prose=True),
        Column("one run", ("uncertainty_j",), "J a jump"),
        Column("mean of the runs", ("uncertainty_of_mean_j",), "J a jump"),
        Column("shared by" if several else "shared by all runs", ("shared",), numeric=False),
        Column("note", ("note",), numeric=False, prose=True),
        replace(PROVENANCE, shown=any(item.provenance for item in content.budget)),
    )
    rows = tuple(
        Row(
            (
                words(item.component),
                value_cell(item.joules, _budget_places(item.joules)),
                value_cell(item.of_mean, _budget_places(item.of_mean)),
                Cell("", (None,)) if item.total else words(_shared_text(item, several_robots=several)),
                words(item.note),
                provenance_cell(item.provenance),
            ),
            strong=item.total,
        )
        for item in content.budget
    )
    caption = (
        "Uncertainty of the joules a jump of a single run, and in the mean over a condition's runs, by source, one "
        f"standard uncertainty each. In a mean the scatter averages out, what runs share does not. "
        f"{content.budget_note}"
    ).rstrip()
    return Table("uncertainty_budget", caption, columns, rows)


def _budget_places(value: Value | None) -> int:
    return 2 if value is None or isinstance(value, Undefined) else decimals_for(value)


def _drain(content: ReportContent) -> Table:
    fits = content.drains
    columns = (
        Column("quantity", ("quantity",), numeric=False),
        Column("value", ("value",)),
        Column("SE", ("se",), shown=any(fit.at_run.se is not None or fit.slope.se is not None for fit in fits)),
        Column(level_text(fits[0].at_run) if fits else "CI", ("ci_low", "ci_high", "ci_level")),
        Column("unit", ("unit",), numeric=False),
        PROVENANCE,
    )
    rows = tuple(row for fit in fits for row in _drain_rows(fit, fit.robot if len(fits) > 1 else ""))
    caption = "Passive drain: straight line through the idle runs." if fits else "Passive drain: not fitted."
    return Table("passive_drain", caption, columns, rows)


def _drain_rows(fit: DrainFit, block: str) -> list[Row]:
    named = (
        ("slope", fit.slope),
        ("intercept", fit.intercept),
        (f"at {fit.run_duration_min:g} min", fit.at_run),
    )
    rows = [Row(_named_cells(name, number), block=block) for name, number in named]
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
    columns = (
        Column("run", ("run",), numeric=False),
        Column("duration", ("duration_min",), "min"),
        Column("charge", ("charge_mah",), "mAh"),
    )
    fits = content.drains
    rows = tuple(
        Row(
            (words(point.run), value_cell(point.duration_min), value_cell(point.charge_mah)),
            block=fit.robot if len(fits) > 1 else "",
        )
        for fit in fits
        for point in fit.points
    )
    return Table("idle_runs", "Idle runs that the passive drain is fitted to.", columns, rows)


def _runs(content: ReportContent) -> Table:
    columns = (
        Column("run", ("run",), numeric=False),
        Column("day", ("day",), numeric=False),
        Column("position", ("position",)),
        Column("pack", ("pack",), numeric=False),
        Column("energy", ("joules_a_jump",), "J a jump"),
        Column("difference from condition", ("deviation_j",), "J a jump"),
        Column("control", ("control",), numeric=False),
    )
    rows = tuple(
        Row(
            (
                words(point.run),
                words(point.day),
                count(point.position),
                words(point.pack),
                value_cell(point.joules, 2),
                value_cell(point.deviation_j, 2),
                words("yes" if point.control else "no"),
            )
        )
        for point in content.order.points
    )
    return Table("runs", "Every analysed run by day and position in the day.", columns, rows)


def _packs(content: ReportContent) -> Table:
    means = [summary.mean for summary in content.order.packs]
    places = common_places(means)
    unit = shown_unit(means[0].unit)[0] if means else ""
    columns = (
        Column("pack", ("pack",), numeric=False),
        Column("n", ("n_runs",)),
        Column("mean", ("mean",), unit),
        Column(level_text(means[0]) if means else "CI", ("ci_low", "ci_high", "ci_level"), unit),
        replace(PROVENANCE, shown=any(mean.provenance for mean in means)),
    )
    rows = tuple(
        Row(
            (
                words(summary.pack),
                count(summary.mean.n),
                number_cell(summary.mean, places),
                interval_cell(summary.mean, places),
                provenance_cell(summary.mean.provenance),
            )
        )
        for summary in content.order.packs
    )
    return Table("packs", "Joules a jump by battery pack, as in the figure.", columns, rows)


def _sensitivity(content: ReportContent) -> Table:
    columns = (
        Column("computed", ("variant",), numeric=False),
        Column("n", ("n",)),
        Column("value", ("value",)),
        Column("CI", ("ci_low", "ci_high", "ci_level")),
        Column("unit", ("unit",), numeric=False),
        PROVENANCE,
    )
    rows = []
    for one in content.sensitivity:
        places = common_places([one.as_reported])
        for label, number in (("as reported", one.as_reported), *((v.label, v.number) for v in one.variants)):
            # CSV has the stored unit beside the stored value, the page the unit shown.
            cells = (
                words(label),
                count(number.n),
                number_cell(number, places),
                interval_cell(number, places),
                Cell(shown_unit(number.unit)[0], (number.unit,)),
                provenance_cell(number.provenance),
            )
            rows.append(Row(cells, block=one.headline, strong=number is one.as_reported))
    caption = "Each headline as reported and recomputed another way."
    return Table("sensitivity", caption, columns, tuple(rows))


UNCERTAINTY_BUDGET = TableKind("uncertainty_budget", _budget)
PASSIVE_DRAIN = TableKind("passive_drain", _drain)
IDLE_RUNS = TableKind("idle_runs", _idle_runs)
RUNS = TableKind("runs", _runs, by_run=True)
PACKS = TableKind("packs", _packs)
SENSITIVITY = TableKind("sensitivity", _sensitivity)
