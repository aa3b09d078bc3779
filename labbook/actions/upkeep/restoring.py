"""`labbook restore`: a book from a backup. Journal and raw copies are copied and checked, the database made from them.

A restore that was cut off leaves a folder that names its backup; the same command goes on there. It is done, and the
folder a book like any other, when all that it holds has been checked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import sqlalchemy as sa

from data_schema import journal
from data_schema.disk import exclusive_lock, read_json, sync, write_json, write_whole
from data_schema.engine import postgres_engine, reading
from data_schema.errors import BookDamaged, BookError, UsageError, hide_password
from data_schema.journal import Entry
from data_schema.journal_file import JournalFile
from data_schema.journal_rules import checked
from ingest.store import Store
from labbook.actions.upkeep.health import check_book
from labbook.book.altered import Differences, differences
from labbook.book.copies.backing_up import LAST_BACKUP, OF_DAMAGED_BOOK, LastBackup
from labbook.book.copies.backing_up import MARKER as OF_BACKUP
from labbook.book.copies.copying import (
    CopiedRaw,
    Counted,
    claim,
    copy_raw,
    put_journal,
    put_scene,
    raw_of,
    readable_hashes,
    refuse_cut_journal,
)
from labbook.book.making import last_configuration
from labbook.book.opening import (
    CONFIGURATION,
    JOURNAL,
    UNFINISHED_RESTORE,
    check_schema,
    engine_of,
    read_configuration,
    shown,
)
from labbook.book.rebuilding import Place, rebuild_database
from labbook.book.report_numbers import bring_numbers
from labbook.config.parsing import parse_configuration
from labbook.config.places import PLACES, with_database

MARKER = UNFINISHED_RESTORE
"""In a folder whose restore is not complete: from where, and into which database."""


@dataclass(frozen=True, slots=True)
class Restored:
    """What was restored and checked; `moved` where labbook.toml had to name another database or store than before.

    `remarks` say which numbers of reports the backup has not, and whether it has a later journal.
    """

    folder: str
    entries: int
    raw: CopiedRaw
    differences: Differences
    moved: bool
    remarks: tuple[str, ...]


def restore(
    source: Path,
    folder: Path,
    place: Place | None,
    step: Callable[[str], None],
    counted: Counted,
    *,
    keep_going: bool = False,
) -> Restored:
    """Make the book of a backup in an empty folder, or go on with one that was cut off.

    `place` None is labbook.db in the book; it must be given where the book was on PostgreSQL. With `keep_going` files
    wait for raw copies that the backup lacks, and a journal is taken that was kept when some could not be backed up.
    """
    entries, text = read_backup(source, keep_going=keep_going)
    original = parse_configuration(text, str(source / CONFIGURATION), source)
    if place is None and original.database.url is not None:
        raise UsageError(
            f"this book's database was {hide_password(original.database.url)}: say with --database URL into which "
            "empty one it is to be restored, or --sqlite for a file in the book."
        )
    url = None if place is None else place.url
    moved = original.store.path is not None or original.database.url != url
    text = with_database(text, url, without=PLACES) if moved else text
    marker = _claim_folder(source, folder, url, entries)
    with exclusive_lock(marker, f"another program is restoring to {folder}: wait until it has finished."):
        raw = copy_raw(Store(source), Store(folder), raw_of(entries), counted)
        if raw.problems and not keep_going:
            raise BookDamaged(
                f"{len(raw.problems)} of {raw.raw_copies} raw copies of {source} could not be restored (the first: "
                f"{raw.problems[0].split(': restore it')[0]}): back the book up again, which mends them, or bring "
                "them there from another backup, and try again; or add --keep-going, which restores all else and lists "
                "what is missing."
            )
        remarks = bring_numbers(source, folder, entries)
        if not keep_going and (later := later_journal(source)) is not None:
            remarks.append(later)
        put_scene(folder, original)
        write_whole(folder / CONFIGURATION, text.encode())
        put_journal(folder / JOURNAL, entries)
        differing = _existing_differences(folder, entries[-1])  # of a restore that was cut off while it checked
        if differing is None:
            differing = rebuild_database(folder, step, may_lack=None if keep_going else frozenset()).differences
        # as deeply as a book can be; pages of reports are not in a backup, and lost raw copies are listed elsewhere
        found = check_book(folder, counted, deep=True, pages=False)
        if found.problems:
            raise BookDamaged(
                f"the book restored in {folder} is not whole ({'; '.join(found.problems)}): restore from another "
                "backup."
            )
        at_utc = read_json(source / OF_BACKUP).get("at_utc")
        if at_utc is not None:  # `labbook today` knows of the backup that the book came from
            last = LastBackup(str(at_utc), str(source.resolve()), len(entries))
            write_json(Store(folder).root / LAST_BACKUP, asdict(last))
        marker.unlink()
        sync(folder)
    return Restored(str(folder.resolve()), len(entries), raw, differing, moved, tuple(remarks))


def read_backup(source: Path, *, keep_going: bool = False) -> tuple[list[Entry], str]:
    """Return the journal and the configuration of a backup; a copy of a book's folder serves as one.

    With `keep_going` the journal may be that of a book that lacked raw copies when it was backed up.
    """
    path = source / (OF_DAMAGED_BOOK if keep_going and newer_of_damaged_book(source) else JOURNAL)
    if not path.is_file() and (source / OF_BACKUP).exists():
        damaged = newer_of_damaged_book(source)
        instead = "`labbook restore --keep-going` restores it without the raw copies that its book lacked"
        raise UsageError(
            f"the backup {source} was never completed, it has no {JOURNAL}: give the `labbook backup` again that began "
            f"it, or name another one{f'; {instead}' if damaged else ''}."
        )
    if not path.is_file():
        raise UsageError(f"{source} is no backup, it has no {JOURNAL}: name a folder that `labbook backup` made.")
    try:
        mirror = JournalFile(path, "restore from another backup")
        entries = list(checked(mirror.entries(), mirror.remedy))
        text = last_configuration(entries)
        if (source / CONFIGURATION).is_file():
            text = (source / CONFIGURATION).read_bytes().decode("utf-8")
    except BookDamaged as error:
        raise BookDamaged(f"the backup {source} is damaged: {error}") from error
    except UnicodeDecodeError as error:
        raise UsageError(
            f"{source / CONFIGURATION} is not UTF-8 text (byte {error.start}): save it as UTF-8."
        ) from error
    recorded = read_json(source / OF_BACKUP)
    n_entries = recorded["entries"] if isinstance(recorded.get("entries"), int) else 0
    refuse_cut_journal(
        entries,
        (n_entries, str(recorded.get("last", ""))),
        f"the journal of the backup {source} ends at entry {len(entries)} and is not the one of {n_entries} entries "
        "that was backed up: back the book up again, or restore from another backup; where there is none, remove "
        f"{OF_BACKUP} from a copy of the folder to restore what its journal still holds.",
    )
    if not entries:
        raise UsageError(f"{source / JOURNAL} holds no entry: there is nothing to restore.")
    if text is None:
        raise UsageError(f"{source} has no {CONFIGURATION}: put the book's there, or name another backup.")
    return entries, text


def newer_of_damaged_book(source: Path) -> int:
    """Return how many entries the journal of a damaged book has in a backup; 0 where the backup's own has as many."""
    damaged = len(readable_hashes(source / OF_DAMAGED_BOOK) or ())  # one is left behind by a backup cut off at its end
    return damaged if damaged > len(readable_hashes(source / JOURNAL) or ()) else 0


def later_journal(source: Path) -> str | None:
    """Say that a backup holds a later journal, of a book that lacked raw copies; None where it does not."""
    n_entries = newer_of_damaged_book(source)
    if not n_entries:
        return None
    return (
        f"the last `labbook backup` lacked raw copies, and {source / OF_DAMAGED_BOOK} holds the book's {n_entries} "
        "entries: mend the book and back it up again, or take them with `labbook restore --keep-going`."
    )


def _claim_folder(source: Path, folder: Path, url: str | None, entries: list[Entry]) -> Path:
    """Make the folder that of this restore; a database on a server must be empty when the restore begins."""
    if folder.resolve().is_relative_to(source.resolve()):
        raise UsageError(f"{folder} lies in the backup itself: name a folder elsewhere.")
    if url is not None and not (folder / MARKER).exists():
        _refuse_filled(url)
    return claim(
        folder,
        MARKER,
        {"source": str(source.resolve()), "book": entries[0].hash, "database": url and hide_password(url)},
        f"{folder} holds the unfinished restore of another backup, or into another database: finish that with the "
        "command that began it, or name an empty folder.",
        f"{folder} is not empty: name an empty folder, or one that is not there yet.",
    )


def _refuse_filled(url: str) -> None:
    engine = postgres_engine(url)
    try:
        with reading(engine) as connection:
            tables = sorted(sa.inspect(connection).get_table_names())
        if tables:
            raise UsageError(
                f"the database {shown(engine)} is not empty (it holds {', '.join(tables[:3])}): give --database with "
                "the address of an empty one."
            )
    finally:
        engine.dispose()


def _existing_differences(folder: Path, last: Entry) -> Differences | None:
    """Return what differs in a database that goes as far as it has to; None where there is none that can be asked."""
    try:
        engine = engine_of(folder, read_configuration(folder))
        try:
            check_schema(engine)
            with reading(engine) as connection:
                reached = journal.head(connection) == (last.seq, last.hash)
                return differences(connection, journal.stored(connection)) if reached else None
        finally:
            engine.dispose()
    except BookError:
        return None
