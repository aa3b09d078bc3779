"""Where a comparison stands in a table: its block, its first cell, and the word for what was not planned."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from reports.content import Comparison, ReportContent
from reports.display import DASH
from reports.naming import level_of, levels_name
from reports.remarks import FOOTNOTE
from reports.tables.table import Cell, Column

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
