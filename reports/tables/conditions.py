"""The conditions: n, mean, SD, SE and CI of one quantity; physical values with the gains beside them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import TypeVar

from data_schema.outcomes import Outcome
from reports.display import DASH, common_places, given_text, sentence_start, shown_unit, unit_slug
from reports.naming import formula_text, group_name, is_number, level_value, swept_factor, swept_words
from reports.results import Condition, ConditionSummary, Factor, StudyResults
from reports.tables.table import (
    Cell,
    Column,
    ColumnOf,
    Columns,
    Table,
    column,
    counts,
    ids,
    interval,
    number,
    table_of,
    tables_of_outcomes,
    text,
    value_cell,
)

T = TypeVar("T")


def factor_columns(results: StudyResults, of: Callable[[T], Condition]) -> ColumnOf[T]:
    """Make two columns a factor: the level and its physical value; the control's value reads "CE" or "control".

    The swept factor's are shown, since the others head the groups; all where none is swept.
    """
    columns = tuple(one for factor in results.factors for one in _columns(results, factor))
    known: dict[int, tuple[Condition, tuple[Cell, ...]]] = {}  # a table of each run has a condition as often as runs

    def make(item: T) -> tuple[Cell, ...]:
        condition = of(item)
        if id(condition) not in known:
            known[id(condition)] = condition, factor_cells(results, condition)
        return known[id(condition)][1]

    return columns, make


def _columns(results: StudyResults, factor: Factor) -> tuple[Column, Column]:
    levels = [level for condition in results.conditions if (level := condition.level(factor.name)) is not None]
    has_gain = any(level.gain is not None for level in levels)
    numeric = all(level.gain is not None or is_number(level) for level in levels)
    title = factor.symbol if factor.symbol and has_gain else sentence_start(factor.title)
    shown = factor.swept or swept_factor(results) is None
    name = f"{factor.name}_{unit_slug(factor.unit) if factor.unit else 'value'}"
    value = Column(title, (name,), factor.unit, numeric, shown)
    return value, Column("gain", (factor.name,), shown=shown and has_gain)


def block_of(results: StudyResults, condition: Condition) -> str:
    """Return the heading that a condition stands under: its group; "" where no factor is swept and columns say all."""
    return "" if swept_factor(results) is None else group_name(results, condition, gain=True)


def by_group(results: StudyResults) -> list[tuple[str, Condition]]:
    """Return the conditions with their headings, those of one group together."""
    found = [(block_of(results, condition), condition) for condition in results.conditions]
    places = {block: place for place, block in reversed(list(enumerate(block for block, _ in found)))}
    return sorted(found, key=lambda item: places[item[0]])


def factor_cells(results: StudyResults, condition: Condition) -> tuple[Cell, ...]:
    """Return the cells that belong to `factor_columns`."""
    cells: list[Cell] = []
    for factor in results.factors:
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


def _gains_note(results: StudyResults) -> str:
    """Write the formulas between gains and physical values as one sentence, "" where there are none."""
    formulas = [text for factor in results.factors if (text := formula_text(factor))]
    return f"Gains g and physical values: {'; '.join(formulas)}." if formulas else ""


_SHARED_NOTE = (
    "SD and SE hold the scatter between runs alone; the interval also holds the error of the {}, so it is wider than "
    "the SE says."
)


def _make(results: StudyResults, quantity: Outcome, name: str) -> Table:
    found = [
        (block, condition, summary)
        for block, condition in by_group(results)
        if (summary := condition.summary(quantity)) is not None
    ]
    means = [summary.mean for _, _, summary in found]
    places = common_places(means)
    unit, factor = quantity.unit, shown_unit(quantity.unit)[1]
    columns: Columns[tuple[str, Condition, ConditionSummary]] = (
        factor_columns(results, lambda row: row[1]),
        counts("n", "n_runs", lambda row: row[2].mean.n),
        counts(
            "jumps",
            "n_jumps",
            lambda row: _jumps(results, quantity, row[2]),
            shown=any(_jumps(results, quantity, row[2]) for row in found),
        ),
        text("robots", "robots", lambda row: _robots(results, row[2]), shown=len(results.robots) > 1),
        number("mean", "mean_{unit}", unit, lambda row: row[2].mean, places),
        number("SD", "sd_{unit}", unit, lambda row: row[2].sd, places),
        column("SE", "se_{unit}", lambda row: value_cell(row[2].mean.se, places, factor), unit=unit),
        column(
            "shared SE",
            "shared_se_{unit}",
            lambda row: value_cell(row[2].mean.shared_se, places, factor),
            unit=unit,
            shown=False,
        ),
        interval(means, unit, lambda row: row[2].mean, places),
        ids(lambda row: row[2].mean.provenance),
    )
    shared = any((mean.shared_se or 0.0) != 0.0 for mean in means)
    about = f"{quantity.heading} by condition; n counts runs."
    steps = " and of the charger's steps" if results.coarse_charger and quantity.shares_error else ""
    note = _SHARED_NOTE.format(f"{quantity.common_error}{steps}") if shared else ""
    caption = " ".join(filter(None, (about, note, _gains_note(results))))
    return table_of(name, caption, found, columns, block=lambda row: row[0], strong=lambda row: row[1].control)


def _jumps(results: StudyResults, quantity: Outcome, summary: ConditionSummary) -> int | None:
    """Count the jumps that a mean is of; None of another quantity than one of the jumps that count."""
    runs = summary.runs if quantity.of_jumps else ()
    return sum(len(results.runs[run].heights_m) for run, _value in runs) or None


def _robots(results: StudyResults, summary: ConditionSummary) -> str:
    runs = Counter(results.runs[run].robot for run, _value in summary.runs)
    return ", ".join(f"{robot} {several}" for robot, several in runs.items())


BY_CONDITION = tables_of_outcomes("{}_by_condition", _make)
"""A table an outcome."""
