"""What is stored. Importing this package declares every table on `METADATA`."""

from __future__ import annotations

import sqlalchemy as sa

from data_schema.tables import design, equipment, files, journal, reports, runs, signals
from data_schema.tables.base import METADATA

__all__ = ["FACTS", "METADATA", "design", "equipment", "files", "journal", "reports", "runs", "signals"]

FACTS: dict[str, sa.Table] = {
    fact.name: fact
    for fact in (
        journal.person,
        journal.config,
        design.study,
        design.day,
        design.day_check,
        design.factor,
        design.level,
        design.condition,
        design.plan,
        design.planned_run,
        equipment.robot,
        equipment.battery,
        equipment.instrument,
        files.file,
        files.run_file,
        runs.run,
        runs.charge,
        runs.note,
        runs.decision,
        reports.report,
    )
}
"""The tables a person's statement can write to, by the kind of thing they hold."""
