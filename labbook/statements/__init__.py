"""What each kind of statement does to the tables: one file a kind, live and on rebuilding.

Readers of files and reports are loaded when they are first needed: a note must not wait for them.
"""

from __future__ import annotations

from data_schema.journal import Entry
from data_schema.vocabulary import Action
from labbook.statements.apply_context import Apply, ApplyContext
from labbook.statements.assigning import apply_assign
from labbook.statements.facts import apply_correct, apply_decide, apply_declare

__all__ = ["APPLY", "ApplyContext"]


def _ingest(context: ApplyContext, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.ingesting import apply_ingest

    return apply_ingest(context, entry, prepared)


def _read(context: ApplyContext, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.ingesting import apply_read

    return apply_read(context, entry, prepared)


def _withdraw(context: ApplyContext, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.withdrawing import apply_withdraw

    return apply_withdraw(context, entry, prepared)


def _restore(context: ApplyContext, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.withdrawing import apply_restore

    return apply_restore(context, entry, prepared)


def _dismiss(context: ApplyContext, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.withdrawing import apply_dismiss

    return apply_dismiss(context, entry, prepared)


def _refuse(context: ApplyContext, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.ingesting import apply_refuse

    return apply_refuse(context, entry, prepared)


def _report(context: ApplyContext, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.reporting import apply_report

    return apply_report(context, entry, prepared)


def _merge(_scene: ApplyContext, _entry: Entry, _prepared: object) -> list[tuple[str, str]]:
    """Change nothing: what was merged stands in the entries that follow in the same command."""
    return []


APPLY: dict[Action, Apply] = {
    Action.DECLARE: apply_declare,
    Action.CORRECT: apply_correct,
    Action.VOID: apply_correct,
    Action.ASSIGN: apply_assign,
    Action.DECIDE: apply_decide,
    Action.NOTE: apply_declare,
    Action.INGEST: _ingest,
    Action.READ: _read,
    Action.WITHDRAW: _withdraw,
    Action.RESTORE: _restore,
    Action.DISMISS: _dismiss,
    Action.REFUSE: _refuse,
    Action.REPORT: _report,
    Action.MERGE: _merge,
}
