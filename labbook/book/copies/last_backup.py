"""When the last backup was made, and where: a small file beside the book's journal, for a backup states nothing."""

from __future__ import annotations

from dataclasses import dataclass

from data_schema.disk import read_json
from ingest.store import Store

LAST_BACKUP = "last-backup.json"
"""The name of that file."""


@dataclass(frozen=True, slots=True)
class LastBackup:
    """When the last backup was complete, where it lies, and how many entries of the journal it holds."""

    at_utc: str
    where: str
    entries: int


def last_backup(store: Store) -> LastBackup | None:
    """Return when the last backup was made, and where; None where none is known of."""
    said = read_json(store.root / LAST_BACKUP)
    try:
        return LastBackup(str(said["at_utc"]), str(said["where"]), int(said["entries"]))
    except (KeyError, TypeError, ValueError):
        return None


def backup_line(last: LastBackup | None, entries: int) -> str:
    """Say in a line when the last backup was made, and what a book of so many entries has gained since."""
    if last is None:
        return "no backup yet: `labbook backup DEST` makes one."
    since = entries - last.entries
    gained = "nothing was stated since" if since <= 0 else f"{since} {'entry' if since == 1 else 'entries'} since"
    return f"last backup: {last.at_utc} in {last.where}; {gained}."
