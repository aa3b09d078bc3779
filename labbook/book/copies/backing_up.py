"""`labbook backup`: what a book cannot be made anew without, in another folder: journal, raw copies, labbook.toml.

The database and the samples follow from these (`labbook restore`), so a book on PostgreSQL needs nothing else; the
password of its database stays out, for a backup is given to who only reads. The journal is taken first, as it stands at
one moment while others may write; raw copies are there before their entries, so all that it speaks of are found. In the
backup the journal is put last: whenever a backup is cut off, the folder holds the journal of the one before with all
raw copies that this speaks of. A labbook.toml that is newer than the journal is what a book has between an edit and the
next command. When the last backup was made, and where, stands in a small file beside the book's journal, for a backup
states nothing.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path

from data_schema import journal
from data_schema.disk import exclusive_lock, read_json, write_json, write_whole
from data_schema.engine import reading
from data_schema.errors import BookDamaged, LabbookError, UsageError
from data_schema.journal import Entry
from data_schema.journal_file import HeldEntries, JournalFile
from data_schema.journal_rules import checked
from ingest.store import Store, raw_path
from labbook.book.copies.copying import (
    CopiedRaw,
    Counted,
    begins_with,
    claim,
    copy_raw,
    put_journal,
    put_scene,
    raw_of,
    readable_hashes,
    refuse_cut_journal,
)
from labbook.book.opening import (
    CONFIGURATION,
    JOURNAL,
    check_schema,
    engine_of,
    journal_path,
    read_configuration,
    store_of,
    text_without_password,
)
from labbook.book.report_numbers import bring_numbers
from labbook.book.write_session import now_utc
from labbook.config.parsing import Configuration, own_text

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
    recorded = read_json(store.root / LAST_BACKUP)
    try:
        return LastBackup(str(recorded["at_utc"]), str(recorded["where"]), int(recorded["entries"]))
    except (KeyError, TypeError, ValueError):
        return None


def backup_line(last: LastBackup | None, entries: int) -> str:
    """Say in a line when the last backup was made, and what a book of so many entries has gained since."""
    if last is None:
        return "no backup yet: `labbook backup DEST` makes one."
    since = entries - last.entries
    gained = "nothing was stated since" if since <= 0 else f"{since} {'entry' if since == 1 else 'entries'} since"
    return f"last backup: {last.at_utc} in {last.where}; {gained}."


MARKER = "backup.json"
"""In a backup: of which book it is, by the hash of its first entry, and its last entry by number and hash."""
OF_DAMAGED_BOOK = "journal.jsonl.of-damaged-book"
"""The journal of a book that lacked a raw copy when it was backed up: `labbook restore --keep-going` takes it."""


@dataclass(frozen=True, slots=True)
class Backup:
    """A complete backup, what had to be written for it, and what a person should know of it."""

    last: LastBackup
    raw: CopiedRaw
    remarks: tuple[str, ...]


def back_up(folder: Path, destination: Path, counted: Counted) -> Backup:
    """Bring a backup of a book up to date, or begin one in an empty folder; others may write to the book meanwhile.

    Raises `BookDamaged` where the book lacks something; the backup then stays as it was before, but for what is new.
    """
    configuration = read_configuration(folder)
    described = text_without_password(own_text(configuration), configuration)
    store = store_of(folder, configuration)
    _refuse_inside(destination, (folder, store.root))
    marker = claim(
        destination,
        MARKER,
        {"book": _first(journal_path(folder, configuration)).hash},
        f"{destination} holds the backup of another book: name another folder.",
        f"{destination} holds other things than a backup: name an empty folder, or one that `labbook backup` made.",
    )
    with exclusive_lock(marker, f"another program is writing the backup {destination}: wait until it has finished."):
        entries, remarks = _journal_of_book(folder, configuration)
        known = readable_hashes(destination / JOURNAL)
        if not begins_with(entries, known or []):
            raise UsageError(
                f"{destination / JOURNAL} holds entries that this book does not have, being of another copy of it or "
                "of a later time: name another folder."
            )
        if (destination / JOURNAL).exists() and known is None:
            remarks.append("the journal in the backup was damaged and is written anew: is that disk failing?")
        wanted = raw_of(entries)
        raw = copy_raw(store, Store(destination), wanted, counted)
        lacking = [raw_path(one) for one in wanted if not (store.root / raw_path(one)).exists()]
        if lacking and not raw.problems:
            remarks.append(
                f"the book lacks {len(lacking)} of the raw copies that are in this backup ({lacking[0]}): copy them "
                f"from {destination} to {store.root}, then run `labbook db check`."
            )
        remarks += bring_numbers(store.root, destination, entries)
        outside = put_scene(destination, configuration)
        if outside is not None:
            remarks.append(f"the scene {outside} lies outside the book and is not in the backup: keep it too.")
        write_whole(destination / CONFIGURATION, described.encode())
        if raw.problems:
            put_journal(destination / OF_DAMAGED_BOOK, entries)
            raise BookDamaged(
                f"{len(raw.problems)} of {raw.raw_copies} raw copies could not be backed up ({raw.problems[0]}): all "
                f"others are in {destination}, with the book's journal as {OF_DAMAGED_BOOK}; a backup that was "
                "complete before stays as it was."
            )
        put_journal(destination / JOURNAL, entries)
        (destination / OF_DAMAGED_BOOK).unlink(missing_ok=True)
        last = LastBackup(now_utc(), str(destination.resolve()), len(entries))
        state = {"book": entries[0].hash, "at_utc": last.at_utc, "entries": last.entries, "last": entries[-1].hash}
        write_json(marker, state)
    try:
        write_json(store.root / LAST_BACKUP, asdict(last))
    except OSError as error:
        remarks.append(
            f"the book may not be written to ({error.strerror}): `labbook today` will not know of this backup."
        )
    return Backup(last, raw, tuple(remarks))


def _refuse_inside(destination: Path, places: tuple[Path, ...]) -> None:
    if any(destination.resolve().is_relative_to(place.resolve()) for place in places):
        raise UsageError(f"{destination} lies in the book itself: name a folder on another disk.")


def _first(path: Path) -> Entry:
    entry = next(JournalFile(path).entries(), None)
    if entry is None:
        raise UsageError(
            f"{path} holds no entry: write it anew from the database with `labbook rebuild --journal`, or make a book "
            "with `labbook init`."
        )
    return entry


def _journal_of_book(folder: Path, configuration: Configuration) -> tuple[HeldEntries, list[str]]:
    """Return the journal as its file has it, after asking the database, which the file is never behind, how far it is.

    Where the database cannot be asked, the file alone counts, and a remark notes that.
    """
    path = journal_path(folder, configuration)
    remarks, known = [], (0, journal.GENESIS)
    try:
        known = _head(folder, configuration)
    except LabbookError as error:
        remarks.append(f"the journal was not compared with the database, which could not be asked: {error}")
    entries = JournalFile(path).held()
    for _entry in checked(journal.verified_chain(entries)):
        pass
    refuse_cut_journal(
        entries,
        known,
        f"{path} has no such entry {known[0]} as the database: write the file anew from the database with `labbook "
        "rebuild --journal`, and back up then.",
    )
    left_out = JournalFile(path).left_out().sentence
    return entries, [*remarks, *([left_out] if left_out else [])]


def _head(folder: Path, configuration: Configuration) -> tuple[int, str]:
    engine = engine_of(folder, configuration)
    try:
        check_schema(engine, JournalFile(journal_path(folder, configuration)))
        with reading(engine) as connection:
            return journal.head(connection)
    finally:
        engine.dispose()
