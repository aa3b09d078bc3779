"""Making a report: analyse the selected runs and collect the content of the page."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.queries.plans import planned_runs
from data_schema.queries.study import checks_by_day, people
from ingest.store import Store
from labbook.analysis.outcomes.detections import Detections
from labbook.analysis.results.result_cache import ResultCache
from labbook.analysis.study import StudyAnalysis, analyse
from labbook.analysis.study_data import gather
from labbook.config.parsing import Configuration
from labbook.presenting.numbers import Shown
from labbook.presenting.report.content import build_content
from reports.content import ReportContent


@dataclass(frozen=True, slots=True)
class MadeReport:
    """A report's content, and what had to be computed for it."""

    content: ReportContent
    analysis: StudyAnalysis
    cache: ResultCache
    detections: Detections
    shown: tuple[str, ...]


def make_report(
    connection: sa.Connection,
    store: Store,
    configuration: Configuration,
    *,
    where: str | None,
    made_at: str,
    progress: Callable[[str], None] = lambda _what: None,
) -> MadeReport:
    """Analyse the selected runs; needs no lock and stores nothing."""
    evidence = gather(connection, configuration, where)
    cache = ResultCache(connection)
    detections = Detections(connection, store, progress)
    analysis = analyse(cache, detections, evidence, progress)
    shown = Shown()
    content = build_content(
        analysis,
        shown,
        made_at=made_at,
        people=list(people(connection)),
        planned=planned_runs(connection),
        checks=checks_by_day(connection),
        results=[*cache.computed.values(), *cache.reused.values()],
    )
    return MadeReport(content, analysis, cache, detections, tuple(shown.ids))
