"""A report's page without the time that drawing takes."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from data_schema.outcomes import Outcome
from labbook.analysis.study import analyse
from labbook.book.opening import opened
from reports.figures.registry import FIGURES
from reports.page.writing import render_page
from reports.results import Condition, ConditionSummary, StudyResults
from reports.tables.registry import TABLES, tables_of

FIGURE_NAMES = [kind.name for kind in FIGURES.values() if kind.outcome is None or kind.outcome.of_every_run]
TABLE_NAMES = [kind.name for kind in TABLES.values() if kind.outcome is None or kind.outcome.of_every_run]
"""Of a study without further instruments."""


DRAWN = [f"{name}{width}" for name in FIGURES for width in ("", "_one_column")]
"""What a page places: figures for two columns of a paper, and for one."""


def quick_page(content: StudyResults, templates: Path | None = None) -> str:
    """Render with one small drawing in every figure's place: the words are what is looked at."""
    drawing = b'<svg viewBox="0 0 72 72"><g id="a"/></svg>'
    tables = {kind.name: kind.make(content) for kind in tables_of(content)}
    return render_page(content, dict.fromkeys(DRAWN, drawing), tables, templates=templates)


def with_summary(condition: Condition, outcome: Outcome, summary: ConditionSummary | None) -> Condition:
    """Return the condition with another summary of an outcome, or without one."""
    found = {**condition.summaries, outcome: summary}
    return dataclasses.replace(condition, summaries={which: item for which, item in found.items() if item is not None})


def content_of(book: Path, where: str | None = None) -> StudyResults:
    """What a report on a book's runs would hold; nothing is stored."""
    with opened(book) as found, found.reading() as connection:
        made = analyse(connection, found.store, found.configuration, where=where, made_at="2021-07-01T12:00:00Z")
    return made.results
