"""`labbook backup DEST --check`: can the book be restored from a backup? Nothing is written, and no book is needed.

The journal's chain is followed to the entry that the backup was complete with, every raw copy and the numbers of every
report are compared with their hashes, and the journal is played back from the raw copies into a temporary database.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from data_schema import journal
from data_schema.engine import reading
from data_schema.errors import LabbookError
from data_schema.journal_file import JournalFile
from data_schema.vocabulary import Action
from ingest.store import Store, raw_path
from labbook.actions.upkeep.health import wrong_numbers
from labbook.actions.upkeep.restoring import later_journal, read_backup
from labbook.book.altered import Differences, differences
from labbook.book.copies.copying import raw_of
from labbook.book.opening import CONFIGURATION, JOURNAL
from labbook.book.replaying import replayed
from labbook.config.parsing import parse_configuration


@dataclass(frozen=True, slots=True)
class CheckedBackup:
    """What a backup holds, what is wrong with it, and what a restore of it would tell."""

    entries: int
    raw_copies: int
    problems: tuple[str, ...]
    missing_numbers: tuple[str, ...]
    differences: Differences


def check_backup(source: Path, step: Callable[[str], None]) -> CheckedBackup:
    """Check a backup by itself; raises where it has no journal that can be followed."""
    entries, text = read_backup(source)
    later = later_journal(source)
    problems = [] if later is None else [later]
    try:
        parse_configuration(text, str(source / CONFIGURATION), source)
    except LabbookError as error:
        problems.append(str(error))
    store, wanted = Store(source), raw_of(entries)
    lost = []
    for sha256 in wanted:
        try:
            store.raw(raw_path(sha256), sha256)
        except LabbookError as error:
            lost.append(sha256)
            problems.append(f"{str(error).split(': restore it')[0]}: back the book up again, which mends it.")
        step(sha256)
    altered, missing = wrong_numbers(source, [entry for entry in entries if entry.action is Action.REPORT])
    problems += altered
    found = Differences()
    try:
        with (
            replayed(
                store,
                JournalFile(source / JOURNAL),
                len(entries),
                step,
                use_cache=False,
                lost=frozenset(lost),
            ) as (engine, replay),
            reading(engine) as connection,
        ):
            found = differences(connection, journal.stored(connection), replay.without_rows)
    except LabbookError as error:
        problems.append(str(error))
    return CheckedBackup(len(entries), len(wanted), tuple(problems), tuple(missing), found)
