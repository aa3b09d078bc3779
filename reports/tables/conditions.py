"""The conditions: n, mean, SD, SE and CI of one quantity; physical values with the gains beside them."""

from __future__ import annotations

from reports.content import Condition, Factor, ReportContent, Summary
from reports.display import DASH, common_places, general_text, level_text, shown_unit
from reports.numbers import Quantity
from reports.sentences import formula_text, group_name, physical_text, swept_words
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
    unit_slug,
    value_cell,
    words,
)


def factor_columns(content: ReportContent) -> tuple[Column, ...]:
    """Return two columns a factor: the level and its physical value; only the swept factor's are shown."""
    return tuple(column for factor in content.factors for column in _columns(content, factor))


def _columns(content: ReportContent, factor: Factor) -> tuple[Column, Column]:
    physical = (f"{factor.name}_{unit_slug(factor.unit)}" if factor.unit else f"{factor.name}_value",)
    title = factor.symbol if factor.symbol and _has_gain(content, factor) else factor.title
    value = Column(title, physical, factor.unit, shown=factor.swept)
    return value, Column("gain", (factor.name,), shown=factor.swept and _has_gain(content, factor))


def _has_gain(content: ReportContent, factor: Factor) -> bool:
    levels = (condition.level(factor.name) for condition in content.conditions)
    return any(level is not None and level.gain is not None for level in levels)


def factor_cells(content: ReportContent, condition: Condition) -> tuple[Cell, ...]:
    """Return the cells that belong to `factor_columns`; the control's value reads "CE" or "control"."""
    cells: list[Cell] = []
    for factor in content.factors:
        level = condition.level(factor.name)
        if level is None:
            cells += [Cell(DASH, (None,)), Cell(DASH, (None,))]
            continue
        shown = general_text(level.value) if level.value is not None else physical_text(level)
        gain = DASH if level.gain is None else general_text(level.gain)
        text = swept_words(factor).control if factor.swept and condition.control else shown
        cells += [Cell(text, (level.value,)), Cell(gain, (level.label,))]
    return tuple(cells)


def gains_note(content: ReportContent) -> str:
    """Write the formulas between gains and physical values as one sentence, "" where there are none."""
    formulas = [text for factor in content.factors if (text := formula_text(factor))]
    return f"Gains g and physical values: {'; '.join(formulas)}." if formulas else ""


def _make(content: ReportContent, quantity: Quantity, name: str, stored: str, title: str) -> Table:
    found = [(condition, condition.summary(quantity)) for condition in content.conditions]
    summaries = [(condition, summary) for condition, summary in found if summary is not None]
    places = common_places([summary.mean for _, summary in summaries])
    unit, factor = shown_unit(stored)
    slug = unit_slug(stored)
    level = level_text(summaries[0][1].mean) if summaries else "CI"
    columns = (
        *factor_columns(content),
        Column("n", ("n_runs",)),
        Column("jumps", ("n_jumps",), shown=any(summary.jumps is not None for _, summary in summaries)),
        Column("mean", (f"mean_{slug}",), unit),
        Column("SD", (f"sd_{slug}",), unit),
        Column("SE", (f"se_{slug}",), unit),
        Column("shared SE", (f"shared_se_{slug}",), unit, shown=False),
        Column(level, (f"ci_low_{slug}", f"ci_high_{slug}", "ci_level"), unit),
        PROVENANCE,
    )
    rows = tuple(
        Row(
            (*factor_cells(content, condition), *_numbers(summary, places, factor)),
            block=group_name(content, condition, gain=True),
            strong=condition.control,
        )
        for condition, summary in summaries
    )
    caption = f"{title} by condition; n counts runs. {gains_note(content)}".strip()
    return Table(name, caption, columns, rows)


def _numbers(summary: Summary, places: int, factor: float) -> tuple[Cell, ...]:
    mean = summary.mean
    return (
        count(mean.n),
        count(summary.jumps),
        number_cell(mean, places),
        value_cell(summary.sd, places, factor),
        value_cell(mean.se, places, factor),
        value_cell(mean.shared_se, places, factor),
        interval_cell(mean, places),
        provenance_cell(mean.provenance),
    )


def joules(content: ReportContent) -> Table:
    """Make the table of joules a jump by condition."""
    return _make(content, Quantity.JOULES, "joules_by_condition", "J", "Energy of a jump")


def apex(content: ReportContent) -> Table:
    """Make the table of apex heights by condition."""
    return _make(content, Quantity.APEX, "apex_by_condition", "m", "Apex height")


def run_values(content: ReportContent) -> Table:
    """Make the table of what every run contributed to its condition."""
    columns = (
        *factor_columns(content),
        Column("quantity", ("quantity",), numeric=False),
        Column("run", ("run",), numeric=False),
        Column("value", ("value", "unit")),
    )
    rows = tuple(
        Row(
            (
                *factor_cells(content, condition),
                words(quantity),
                words(run.run),
                Cell(f"{general_text(run.value * shown_unit(unit)[1], 5)} {shown_unit(unit)[0]}", (run.value, unit)),
            ),
            block=group_name(content, condition, gain=True),
        )
        for condition in content.conditions
        for quantity, unit in ((Quantity.JOULES, "J"), (Quantity.APEX, "m"))
        if (summary := condition.summary(quantity)) is not None
        for run in summary.runs
    )
    return Table("run_values", "What each run contributed to its condition.", columns, rows)


JOULES_BY_CONDITION = TableKind("joules_by_condition", joules)
APEX_BY_CONDITION = TableKind("apex_by_condition", apex)
RUN_VALUES = TableKind("run_values", run_values)
