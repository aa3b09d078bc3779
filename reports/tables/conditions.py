"""The conditions: n, mean, SD, SE and CI of one quantity; physical values with the gains beside them."""

from __future__ import annotations

from collections import Counter

from data_schema.outcomes import Outcome
from reports import fields
from reports.content import Condition, ConditionSummary, Factor, ReportContent
from reports.display import DASH, common_places, given_text, sentence_start, shown_unit
from reports.naming import formula_text, group_name, is_number, level_value, swept_factor, swept_words
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Columns,
    Table,
    count,
    in_unit,
    interval_cell,
    interval_column,
    number_cell,
    provenance_cell,
    table_of,
    tables_of_outcomes,
    text_column,
    value_cell,
    words,
)


def factor_columns(content: ReportContent) -> tuple[Column, ...]:
    """Return two columns a factor: the level and its physical value.

    The swept factor's are shown, since the others head the groups; all where none is swept.
    """
    return tuple(column for factor in content.factors for column in _columns(content, factor))


def _columns(content: ReportContent, factor: Factor) -> tuple[Column, Column]:
    physical = fields.PHYSICAL if factor.unit else fields.PHYSICAL_WITHOUT_UNIT
    title = factor.symbol if factor.symbol and _has_gain(content, factor) else factor.title
    shown = factor.swept or swept_factor(content) is None
    value = Column(
        sentence_start(title) if title == factor.title else title,
        fields.named(physical, of=factor.name, unit=factor.unit),
        factor.unit,
        numeric=_is_numeric(content, factor),
        shown=shown,
    )
    gain = Column("gain", fields.named(fields.LEVEL, of=factor.name), shown=shown and _has_gain(content, factor))
    return value, gain


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
        gain = DASH if level.gain is None else given_text(level.gain)
        text = swept_words(factor).control_level if factor.swept and condition.control else shown
        cells += [Cell(text, (level.value,)), Cell(gain, (level.label,))]
    return tuple(cells)


def _gains_note(content: ReportContent) -> str:
    """Write the formulas between gains and physical values as one sentence, "" where there are none."""
    formulas = [text for factor in content.factors if (text := formula_text(factor))]
    return f"Gains g and physical values: {'; '.join(formulas)}." if formulas else ""


_SHARED_NOTE = (
    "SD and SE hold the scatter between runs alone; the interval also holds the error of the {}, so it is wider than "
    "the SE says."
)


def _make(content: ReportContent, quantity: Outcome, name: str) -> Table:
    found = [
        (block, condition, summary)
        for block, condition in by_group(content)
        if (summary := condition.summary(quantity)) is not None
    ]
    means = [summary.mean for _, _, summary in found]
    places = common_places(means)
    unit, factor = quantity.unit, shown_unit(quantity.unit)[1]
    several = len(content.robots) > 1
    columns: Columns[tuple[str, Condition, ConditionSummary]] = (
        (factor_columns(content), lambda row: factor_cells(content, row[1])),
        (Column("n", fields.N_RUNS), lambda row: count(row[2].mean.n)),
        (
            Column("jumps", fields.N_JUMPS, shown=any(_jumps(content, quantity, row[2]) for row in found)),
            lambda row: count(_jumps(content, quantity, row[2])),
        ),
        (
            text_column("robots", fields.ROBOTS, shown=several),
            lambda row: words(_robots(content, row[2])),
        ),
        (in_unit("mean", fields.MEAN, unit), lambda row: number_cell(row[2].mean, places)),
        (in_unit("SD", fields.SD, unit), lambda row: number_cell(row[2].sd, places)),
        (in_unit("SE", fields.SE, unit), lambda row: value_cell(row[2].mean.se, places, factor)),
        (
            in_unit("shared SE", fields.SHARED_SE, unit, shown=False),
            lambda row: value_cell(row[2].mean.shared_se, places, factor),
        ),
        (interval_column(means, unit), lambda row: interval_cell(row[2].mean, places)),
        (PROVENANCE, lambda row: provenance_cell(row[2].mean.provenance)),
    )
    shared = any((mean.shared_se or 0.0) != 0.0 for mean in means)
    about = f"{quantity.heading} by condition; n counts runs."
    steps = " and of the charger's steps" if content.coarse_charger and quantity.shares_error else ""
    note = _SHARED_NOTE.format(f"{quantity.common_error}{steps}") if shared else ""
    caption = " ".join(filter(None, (about, note, _gains_note(content))))
    return table_of(name, caption, found, columns, block=lambda row: row[0], strong=lambda row: row[1].control)


def _jumps(content: ReportContent, quantity: Outcome, summary: ConditionSummary) -> int | None:
    """Count the jumps that a mean is of; None of another quantity than one of the jumps that count."""
    runs = summary.runs if quantity.of_jumps else ()
    return sum(len(content.runs[run].heights_m) for run, _value in runs) or None


def _robots(content: ReportContent, summary: ConditionSummary) -> str:
    runs = Counter(content.runs[run].robot for run, _value in summary.runs)
    return ", ".join(f"{robot} {several}" for robot, several in runs.items())


BY_CONDITION = tables_of_outcomes("{}_by_condition", _make)
"""A table an outcome."""
