"""What each kind of statement does to the tables: one file a kind, live and on rebuilding."""

from __future__ import annotations

from importlib import import_module

from data_schema.journal import Entry
from data_schema.vocabulary import Action
from labbook.statements.apply_context import ApplyContext

__all__ = ["ApplyContext", "apply_entry"]

_FACTS = ("facts", "apply_set")
_HOMES = {
    (Action.INGEST, "ingest"): ("ingesting", "apply_ingest"),
    (Action.SET, "file"): ("assigning", "apply_assign"),
    (Action.SET, "run_file"): ("assigning", "apply_link"),
    (Action.EXCLUDE, "file"): ("withdrawing", "apply_use"),
    (Action.INCLUDE, "file"): ("withdrawing", "apply_use"),
    (Action.EXCLUDE, "charge"): ("counted_charges", "apply_to_charge"),
    (Action.INCLUDE, "charge"): ("counted_charges", "apply_to_charge"),
    (Action.REPORT, "report"): ("reporting", "apply_report"),
}
"""The module and function of each kind that is not a row alone, loaded when first needed: a note does not wait for
readers of files.
"""


def apply_entry(context: ApplyContext, entry: Entry, prepared: object) -> None:
    """Apply an entry to the tables."""
    if entry.action is Action.MERGE:  # what was merged stands in the entries that follow in the same command
        return
    module, function = _HOMES.get((entry.action, entry.entity_kind), _FACTS)
    getattr(import_module(f"labbook.statements.{module}"), function)(context, entry, prepared)
