"""Effects of treatments against their control: differences and savings, and the same with days as a random effect.

A comparison stands in the block of its family, under its label, with a word for what was not planned.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from data_schema.outcomes import Outcome
from reports.content import Comparison, ReportContent
from reports.display import DASH, common_places, shown_unit
from reports.evidence import ByDay, Decision
from reports.naming import level_of, levels_name
from reports.numbers import Number, SignificanceTest
from reports.remarks import FOOTNOTE
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Row,
    Table,
    count,
    interval_cell,
    interval_title,
    number_cell,
    p_cell,
    provenance_cell,
    statistic_cells,
    statistic_columns,
    tables_of_outcomes,
    unit_slug,
    words,
)

COMPARISON = Column("comparison", ("family", "group", "level"), numeric=False)
EXPLORATORY = Column("exploratory", ("exploratory",), numeric=False, shown=False)
"""Why a comparison is exploratory; the page says so in the heading of its block and in the caption."""
ONE_DAY_EACH = Column("one day each", ("one_day_each",), numeric=False, shown=False)
"""What the row's p and intervals cannot tell; the page marks them in a footnote."""

Why = Callable[[Comparison], str]


def why_exploratory(comparison: Comparison) -> str:
    """Return why a comparison is exploratory, "" where it is planned."""
    return comparison.exploratory


def placed(
    content: ReportContent, comparisons: Sequence[Comparison], why: Why = why_exploratory
) -> list[tuple[Comparison, Cell, str]]:
    """Return each comparison with its first cell and its block.

    A family with several levels a group has a block a group; one with a single row a group is one block. `why` tells
    which are exploratory.
    """
    names = [levels_name(content, comparison.group) or "all runs" for comparison in comparisons]
    counts = Counter((comparison.family, name) for comparison, name in zip(comparisons, names, strict=True))
    several = {family for (family, _), number in counts.items() if number > 1}
    found = []
    for comparison, name in zip(comparisons, names, strict=True):
        family, level = comparison.family, level_of(content, comparison)
        if family in several:
            text, block = level, ": ".join(filter(None, (family, name)))
        else:
            text = name if level.lower() in family.lower() else f"{name}, {level}"
            block = family
        block = f"{block} (exploratory)" if why(comparison) else block
        found.append((comparison, Cell(text, (family, name, comparison.level)), block))
    return found


def exploratory_note(comparisons: Iterable[Comparison], why: Why = why_exploratory) -> str:
    """Return the end of a caption that says why comparisons are exploratory, "" where all are planned."""
    return reasons_note(why(comparison) for comparison in comparisons)


def on_one_day_each(cell: Cell, why: str) -> Cell:
    """Mark a p or an interval that cannot tell groups of one day each (`why`) from days; a dash tells nothing."""
    return replace(cell, note=FOOTNOTE) if why and cell.text != DASH else cell


def over_runs(test: SignificanceTest, one_day_each: str, degrees: int = 1) -> tuple[Cell, Cell]:
    """Make the cells of a test that knows no days: its p is marked where each group had one day."""
    statistic, p = statistic_cells(test, degrees)
    return statistic, on_one_day_each(p, one_day_each)


def dash_of_one_day_each(cell: Cell, why: str) -> Cell:
    """Give a dash where groups had one day each (`why`) the same footnote; the file has its own reason."""
    return replace(cell, note=FOOTNOTE) if why and cell.text == DASH else cell


def reasons_note(given: Iterable[str]) -> str:
    """Return the end of a caption that gives the reasons, each once; "" is none."""
    reasons = list(dict.fromkeys(filter(None, given)))
    if len(reasons) > 1:
        numbered = "; ".join(f"({place}) {reason}" for place, reason in enumerate(reasons, 1))
        return f" Rows called exploratory are so for one of these reasons: {numbered}."
    return f" Rows called exploratory are so because {reasons[0]}." if reasons else ""


_WELCH = (
    "Difference: treatment less control{rows}, with interval and p by Welch's t-test (the F-test's choice stands under "
    "Tests in full); n: {counted}s of the control, of the treatment."
)
_DECIDED = (
    "Difference: treatment less control{rows}, with interval and p by the days that hold both: paired on day means "
    "from four days on, within days where there are fewer. n: runs of the control and of the treatment on these days."
)


def legend(content: ReportContent, comparisons: Sequence[Comparison], rows: str = "") -> str:
    """Say which test the intervals and p of comparisons are of, and what n counts."""
    decided = any(comparison.decision is not None for comparison in comparisons)
    return (_DECIDED if decided else _WELCH).format(rows=rows, counted=content.counted)


def _effects(content: ReportContent, comparisons: list[Comparison], name: str, caption: str, unit: str) -> Table:
    leads = [comparison.lead for comparison in comparisons]
    differences: list[Number | None] = [lead.difference for lead in leads]
    savings: list[Number | None] = [lead.savings for lead in leads]
    decided = any(comparison.decision is not None for comparison in comparisons)
    with_savings = any(saved is not None for saved in savings)
    adjusted = next((lead.adjusted for lead in leads if lead.adjusted is not None), None)
    if adjusted is not None:
        caption += f" Holm: p adjusted over the {adjusted.n} tests of the family."
    places, savings_places = common_places(differences), common_places(savings, 1)
    slug, shown = unit_slug(unit), shown_unit(unit)[0]
    columns = (
        COMPARISON,
        Column("days", ("days",), shown=decided),
        Column("n", ("n_control", "n_treatment")),
        Column("difference", (f"difference_{slug}",), shown),
        Column(interval_title(differences), (f"ci_low_{slug}", f"ci_high_{slug}", "ci_level"), shown),
        *statistic_columns("t", "t"),
        Column("Holm", ("holm_p", "holm_tests", "holm_provenance"), shown=adjusted is not None),
        Column("savings", ("savings_percent",), "%", shown=with_savings),
        Column(
            interval_title(savings),
            ("savings_ci_low_percent", "savings_ci_high_percent", "savings_ci_level"),
            "%",
            shown=with_savings,
        ),
        Column("unit", ("unit",), numeric=False, shown=False),
        PROVENANCE,
        EXPLORATORY,
        ONE_DAY_EACH,
    )
    rows = []
    for comparison, first, block in placed(content, comparisons):
        lead, why = comparison.lead, "" if comparison.decision is not None else comparison.one_day_each
        cells = (
            first,
            words("") if comparison.decision is None else count(len(lead.days)),
            Cell(f"{lead.n_control}, {lead.n_treatment}", (lead.n_control, lead.n_treatment)),
            number_cell(lead.difference, places),
            on_one_day_each(interval_cell(lead.difference, places), why),
            *over_runs(_of_difference(lead), why),
            on_one_day_each(_adjusted_cell(lead.adjusted), why),
            number_cell(lead.savings, savings_places),
            on_one_day_each(interval_cell(lead.savings, savings_places), why),
            words(lead.unit),
            provenance_cell((lead.savings or lead.difference).provenance),
            words(comparison.exploratory),
            words(comparison.one_day_each),
        )
        rows.append(Row(cells, block=block))
    return Table(name, caption + exploratory_note(comparisons), columns, tuple(rows))


def _of_difference(lead: Decision) -> SignificanceTest:
    """Return the test with the sign of the difference beside it; t of savings is stored as positive for a saving."""
    t, difference = lead.test.statistic, lead.difference.value
    if not isinstance(t, float) or not isinstance(difference, float):
        return lead.test
    return replace(lead.test, statistic=math.copysign(t, difference))


def _adjusted_cell(adjusted: Number | None) -> Cell:
    if adjusted is None:
        return Cell(DASH, (None, None, None))
    return replace(p_cell(adjusted.value), values=(adjusted.value, adjusted.n, adjusted.provenance))


def _of_outcome(content: ReportContent, quantity: Outcome, name: str) -> Table:
    chosen = [comparison for comparison in content.comparisons if comparison.quantity is quantity]
    others = any(comparison.savings is None for comparison in chosen) and quantity.has_savings
    rows = ", or what the row says" if others else ""
    caption = f"Every comparison of {quantity}. {legend(content, chosen, rows)}"
    return _effects(content, chosen, name, caption, quantity.unit)


COMPARISONS = tables_of_outcomes("comparisons_{}", _of_outcome)
"""A table an outcome."""


def blocked(content: ReportContent, quantity: Outcome) -> list[tuple[Comparison, ByDay]]:
    """Return the comparisons of a quantity that were made by day."""
    return [
        (comparison, comparison.by_day)
        for comparison in content.comparisons
        if comparison.quantity is quantity and comparison.by_day is not None
    ]


def _by_day(content: ReportContent, quantity: Outcome, name: str) -> Table:
    found = blocked(content, quantity)
    of = {id(comparison): by_day for comparison, by_day in found}
    unit = quantity.unit
    slug, shown = unit_slug(unit), shown_unit(unit)[0]
    differences = [by_day.difference for _, by_day in found]
    places = common_places(differences)
    columns = (
        COMPARISON,
        Column("days", ("days",)),
        Column("difference", (f"difference_{slug}",), shown),
        Column(interval_title(differences), (f"ci_low_{slug}", f"ci_high_{slug}", "ci_level"), shown),
        *statistic_columns("t", "t"),
        Column("day SD", (f"day_sd_{slug}",), shown),
        Column("run SD", (f"run_sd_{slug}",), shown, shown=False),
        Column("test", ("method",), numeric=False),
        PROVENANCE,
        EXPLORATORY,
        Column("confounding", ("confounding",), numeric=False, shown=False),
    )
    rows = tuple(
        Row(
            (
                first,
                count(by_day.days),
                number_cell(by_day.difference, places),
                dash_of_one_day_each(interval_cell(by_day.difference, places), comparison.one_day_each),
                *(dash_of_one_day_each(cell, comparison.one_day_each) for cell in statistic_cells(by_day.test)),
                dash_of_one_day_each(number_cell(by_day.day_sd, places), comparison.one_day_each),
                number_cell(by_day.run_sd, places),
                Cell(by_day.kind, (by_day.method,)),
                provenance_cell(by_day.difference.provenance),
                words(comparison.exploratory),
                words(by_day.confounding),
            ),
            block=block,
        )
        for comparison, first, block in placed(content, [comparison for comparison, _ in found])
        for by_day in [of[id(comparison)]]
    )
    caption = (
        f"The comparisons of {quantity} with the control by day: runs of one day have the day in common (day as a "
        "random effect; the exact test where the design is balanced, else a mixed model, REML, degrees of freedom "
        "after Satterthwaite; either takes both sides to scatter alike). Day SD: how days differ, as a standard "
        "deviation by the mixed model."
        f"{exploratory_note(comparison for comparison, _ in found)}"
    )
    return Table(name, caption, columns, rows)


BY_DAY = tables_of_outcomes("by_day_{}", _by_day)
"""A table an outcome."""
