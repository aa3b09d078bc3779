"""What each kind of statement does to the tables: one file a kind, live and on rebuilding.

Readers of files and reports are loaded when they are first needed: a note must not wait for them.
"""

from __future__ import annotations

from data_schema.journal import Entry
from data_schema.vocabulary import Action
from labbook.statements.assigning import apply_assign
from labbook.statements.correcting import apply_correct
from labbook.statements.deciding import apply_decide
from labbook.statements.declaring import apply_declare
from labbook.statements.scene import Apply, Scene

__all__ = ["APPLY", "Scene"]


def _ingest(scene: Scene, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.ingesting import apply_ingest

    return apply_ingest(scene, entry, prepared)


def _read(scene: Scene, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.ingesting import apply_read

    return apply_read(scene, entry, prepared)


def _withdraw(scene: Scene, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.withdrawing import apply_withdraw

    return apply_withdraw(scene, entry, prepared)


def _restore(scene: Scene, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.withdrawing import apply_restore

    return apply_restore(scene, entry, prepared)


def _dismiss(scene: Scene, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.withdrawing import apply_dismiss

    return apply_dismiss(scene, entry, prepared)


def _refuse(scene: Scene, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.ingesting import apply_refuse

    return apply_refuse(scene, entry, prepared)


def _report(scene: Scene, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    from labbook.statements.reporting import apply_report

    return apply_report(scene, entry, prepared)


def _merge(_scene: Scene, _entry: Entry, _prepared: object) -> list[tuple[str, str]]:
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
