"""The statement that a report was made: the numbers it showed, and the results that were computed for it.

The journal keeps every number that was shown, with its id and its value, and the versions of the algorithms. A newer
version gives its numbers other ids, while an id on a printed page can still be looked up.
"""

from __future__ import annotations

from typing import Any

from data_schema.journal import Entry, canonical
from data_schema.queries.facts import insert_fact
from data_schema.queries.results import add_report_items
from data_schema.queries.study import config_in_force
from labbook.analysis.outcomes.detection import store_detections
from labbook.analysis.results.result_cache import keep
from labbook.config.parsing import parse_configuration
from labbook.presenting.report.content import MadeReport, make_report
from labbook.statements.apply_context import ApplyContext, ReplayedReports
from stats.apexes.detectors import DETECTORS


def shown_by(made: MadeReport) -> dict[str, Any]:
    """Return what the journal keeps of a report's numbers: each one's value by its id, and the versions in force."""
    from labbook.analysis.algorithms import versions_now  # what computes, and takes long to import

    results = [*made.cache.computed.values(), *made.cache.reused.values()]
    values = {number.uid: number.value for row in results for number in row.numbers}
    used = {row.algorithm for row in results}
    return {
        "shown": {uid: values[uid] for uid in sorted(made.shown)},
        "versions": {name: number for name, number in versions_now().items() if name in used or name in DETECTORS},
    }


def apply_report(context: ApplyContext, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    """Add the report and its results; on rebuilding, compute it again unless that can give nothing new."""
    new = entry.new or {}
    row = config_in_force(context.connection)
    assert row is not None, "a configuration is declared before any report is made"  # noqa: S101
    replayed = prepared if isinstance(prepared, ReplayedReports) else ReplayedReports()
    made = prepared if isinstance(prepared, MadeReport) else None
    if made is None and new["where"] not in replayed.settled:
        configuration = parse_configuration(row.text, "the book's configuration")
        made = make_report(context.connection, context.store, configuration, where=new["where"], made_at=new["made_at"])
        replayed.note_report(new["where"], made)
    values = {
        "options_json": canonical({"where": new["where"]}),
        "as_of_utc": new["made_at"],
        "config": row.uid,
        "versions_json": canonical(new["versions"]),
        "made_utc": new["made_at"],
    }
    insert_fact(context.connection, "report", entry.entity_uid, values)
    if made is not None:
        store_detections(context.connection, made.detections)
        keep(context.connection, made.cache)
    add_report_items(context.connection, entry.entity_uid, new["shown"])
    return []
