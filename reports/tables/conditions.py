"""The conditions: n, mean, SD, SE and CI of one quantity; physical values with the gains beside them."""

from __future__ import annotations

from data_schema.outcomes import Outcome
from reports.content import Condition, Factor, ReportContent, Summary
from reports.display import DASH, common_places, general_text, level_text, sentence_start, shown_unit, stated_text
from reports.naming import formula_text, group_name, is_number, level_value, swept_factor, swept_words
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
    tables_of_outcomes,
    unit_slug,
    value_cell,
    words,
)


def factor_columns(content: ReportContent) -> tuple[Column, ...]:
    """Return two columns a factor: the level and its physical value.

    The swept factor's are shown, since the others head the groups; all where none is swept.
    """
    return tuple(column for factor in content.factors for column in _columns(content, factor))


def _columns(content: ReportContent, factor: Factor) -> tuple[Column, Column]:
    physical = (f"{factor.name}_{unit_slug(factor.unit)}" if factor.unit else f"{factor.name}_value",)
    title = factor.symbol if factor.symbol and _has_gain(content, factor) else factor.title
    shown = factor.swept or swept_factor(content) is None
    value = Column(
        sentence_start(title) if title == factor.title else title,
        physical,
        factor.unit,
        numeric=_is_numeric(content, factor),
        shown=shown,
    )
    return value, Column("gain", (factor.name,), shown=shown and _has_gain(content, factor))


def block_of(content: ReportContent, condition: Condition) -> str:
    """Return the heading that a condition stands under: its group; "" where no factor is swept and columns say all."""
    return "" if swept_factor(content) is None else group_name(content, condition, gain=True)


def by_group(content: ReportContent) -> list[tuple[str, Condition]]:
    """Return the conditions with their headings, those of one group together."""
    found = [(block_of(content, condition), condition) for condition in content.conditions]
    places = {block: place for place, block in reversed(list(enumerate(block for block, _ in found)))}
    return sorted(found, key=lambda item: places[item[0]])


def _is_numeric(content: ReportContent, factor: Factor) -> bool:
    """Whether a factor's levels are read as numbers: gains, or numbers themselves."""
    levels = (condition.level(factor.name) for condition in content.conditions)
    return all(level.gain is not None or is_number(level) for level in levels if level is not None)


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
        numeric = level.gain is not None or is_number(level)
        shown = level_value(level) if numeric and level.value is not None else level.label
        gain = DASH if level.gain is None else stated_text(level.gain)
        text = swept_words(factor).control_level if factor.swept and condition.control else shown
        cells += [Cell(text, (level.value,)), Cell(gain, (level.label,))]
    return tuple(cells)


def _gains_note(content: ReportContent) -> str:
    """Write the formulas between gains and physical values as one sentence, "" where there are none."""
    formulas = [text for factor in content.factors if (text := formula_text(factor))]
    return f"Gains g and physical values: {'; '.join(formulas)}." if formulas else ""


_SHARED_NOTE = (
    "SD and SE hold the scatter between runs alone; the interval also holds the error of the drain fit, so it is wider "
    "than the SE says."
)


def _make(content: ReportContent, quantity: Outcome, name: str) -> Table:
    found = [(block, condition, condition.summary(quantity)) for block, condition in by_group(content)]
    summaries = [(block, condition, summary) for block, condition, summary in found if summary is not None]
    places = common_places([summary.mean for _, _, summary in summaries])
    unit, factor = shown_unit(quantity.unit)
    slug = unit_slug(quantity.unit)
    level = level_text(summaries[0][2].mean) if summaries else "CI"
    columns = (
        *factor_columns(content),
        Column("n", ("n_runs",)),
        Column("jumps", ("n_jumps",), shown=any(summary.jumps is not None for _, _, summary in summaries)),
        Column("robots", ("robots",), numeric=False, shown=len(content.robots) > 1),
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
            block=block,
            strong=condition.control,
        )
        for block, condition, summary in summaries
    )
    shared = any((summary.mean.shared_se or 0.0) != 0.0 for _, _, summary in summaries)
    about = f"{quantity.heading} by condition; n counts runs."
    notes = (about, _SHARED_NOTE if shared else "", _gains_note(content))
    caption = " ".join(filter(None, notes))
    return Table(name, caption, columns, rows)


def _numbers(summary: Summary, places: int, factor: float) -> tuple[Cell, ...]:
    mean = summary.mean
    return (
        count(mean.n),
        count(summary.jumps),
        words(", ".join(f"{robot} {runs}" for robot, runs in summary.robots.items())),
        number_cell(mean, places),
        value_cell(summary.sd, places, factor),
        value_cell(mean.se, places, factor),
        value_cell(mean.shared_se, places, factor),
        interval_cell(mean, places),
        provenance_cell(mean.provenance),
    )


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
                *levels,
                words(quantity),
                words(run.run),
                Cell(f"{general_text(run.value * shown_unit(unit)[1], 5)} {shown_unit(unit)[0]}", (run.value, unit)),
            ),
            block=block,
        )
        for block, condition in by_group(content)
        for levels in [factor_cells(content, condition)]
        for quantity, summary in condition.summaries.items()
        for unit in [quantity.unit]
        for run in summary.runs
    )
    return Table("run_values", "What each run contributed to its condition.", columns, rows)


BY_CONDITION = tables_of_outcomes("{}_by_condition", _make)
"""A table an outcome."""
RUN_VALUES = TableKind("run_values", run_values, by_run=True)
