"""What each kind of statement does to the tables: one file a kind, live and on rebuilding."""

from __future__ import annotations

from importlib import import_module

from data_schema.journal import Entry
from data_schema.vocabulary import Action
from labbook.statements.apply_context import ApplyContext

__all__ = ["ApplyContext", "apply_entry"]

_HOMES = {
    Action.DECLARE: ("facts", "apply_declare"),
    Action.CORRECT: ("facts", "apply_correct"),
    Action.VOID: ("facts", "apply_correct"),
    Action.ASSIGN: ("assigning", "apply_assign"),
    Action.DECIDE: ("facts", "apply_decide"),
    Action.NOTE: ("facts", "apply_declare"),
    Action.INGEST: ("ingesting", "apply_ingest"),
    Action.READ: ("ingesting", "apply_read"),
    Action.WITHDRAW: ("withdrawing", "apply_withdraw"),
    Action.RESTORE: ("withdrawing", "apply_restore"),
    Action.DISMISS: ("withdrawing", "apply_dismiss"),
    Action.REFUSE: ("ingesting", "apply_refuse"),
    Action.REPORT: ("reporting", "apply_report"),
}
"""The module and function of each kind, loaded when first needed: a note does not wait for readers of files."""


def apply_entry(context: ApplyContext, entry: Entry, prepared: object) -> None:
    """Apply an entry to the tables."""
    if entry.action is Action.MERGE:  # what was merged stands in the entries that follow in the same command
        return
    module, function = _HOMES[entry.action]
    getattr(import_module(f"labbook.statements.{module}"), function)(context, entry, prepared)
