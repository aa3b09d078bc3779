"""What each kind of statement does to the tables: one file a kind, live and on rebuilding."""

from __future__ import annotations

from data_schema.vocabulary import Action
from labbook.statements.assigning import apply_assign
from labbook.statements.correcting import apply_correct
from labbook.statements.deciding import apply_decide
from labbook.statements.declaring import apply_declare
from labbook.statements.ingesting import apply_ingest, apply_refuse
from labbook.statements.reporting import apply_report
from labbook.statements.scene import Apply, Scene

__all__ = ["APPLY", "Scene"]

APPLY: dict[Action, Apply] = {
    Action.DECLARE: apply_declare,
    Action.CORRECT: apply_correct,
    Action.VOID: apply_correct,
    Action.ASSIGN: apply_assign,
    Action.DECIDE: apply_decide,
    Action.NOTE: apply_declare,
    Action.INGEST: apply_ingest,
    Action.REFUSE: apply_refuse,
    Action.REPORT: apply_report,
}
