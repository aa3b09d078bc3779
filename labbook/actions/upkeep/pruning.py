"""`labbook db prune`: list leftovers in a book that nothing refers to, and remove them on request.

Nothing that a row or an entry of the journal refers to is ever removed. A file of the store is looked up, and removed,
while nobody can write; an ingest that has put its files there and not yet its rows looks for them once more when it can
(`statements`). Nothing is removed from a book that is not whole, for an old copy may be the only one that is.
"""

from __future__ import annotations

import re
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import sqlalchemy as sa

from data_schema import journal
from data_schema.disk import exclusive_lock
from data_schema.engine import writing
from data_schema.errors import BookDamaged, UsageError, unknown_name
from data_schema.queries.files import raw_copies, signal_files
from ingest.store import STORED, is_store_name, raw_path
from labbook.actions.upkeep.health import check_book
from labbook.book.copies.copying import Counted, raw_of
from labbook.book.opening import DATABASE, JOURNAL, Book
from labbook.book.rebuilding import REBUILDING, drop_old, old_schemas, own_tables
from labbook.book.report_numbers import numbers_files, numbers_path

_OLD_NAME = re.compile(rf"{re.escape(DATABASE)}\.before-rebuild\.\d{{8}}T\d{{12}}Z(-wal|-shm)?")
QUIET_S = 3600.0
"""A file that was written to less long ago may belong to a command that is at work."""
_OLD, _CUT_OFF, _ORPHAN = "an old database", "left by a command that was cut off", "a file of the store without a row"
_WITH_OWN = "an old database with tables of your own"
_FOREIGN = "not labbook's, never removed"
_SET_ASIDE = "set aside from the journal, removed only by its name"


@dataclass(frozen=True, slots=True)
class Leftover:
    """A leftover: the name by which it is removed, its kind, and its size where it has one.

    `by_name_only`: a person may want it, so that it is removed only when named. A `foreign` one is in a folder of the
    store under a name that labbook never gives, and is never removed.
    """

    name: str
    what: str
    n_bytes: int | None
    by_name_only: bool = False
    path: Path | None = None
    foreign: bool = False


def leftovers(book: Book, connection: sa.Connection) -> list[Leftover]:
    """List what nothing needs."""
    found = [_file(book, path, what, what.startswith(_WITH_OWN)) for path, what in _files(book, connection)]
    if connection.dialect.name == "postgresql":
        found += [Leftover(name, _OLD, n_bytes) for name, n_bytes in old_schemas(connection)]
    found += [_file(book, path, _SET_ASIDE, True) for path in _leftover_journals(book)]
    return found


def prune(book: Book, names: Sequence[str], counted: Counted) -> list[Leftover]:
    """Remove all leftovers, or only the named ones; returns what was removed.

    Raises `UsageError` for the name of a file that is not labbook's.
    """
    health = check_book(book.folder, counted)
    if not health.whole:
        raise BookDamaged(
            f"the book is not whole ({(*health.problems, *health.lost_sentences)[0]}), so nothing was removed: mend it "
            "first, `labbook db check` names all that it lacks."
        )
    with exclusive_lock(book.mirror.path, REBUILDING), writing(book.engine) as connection:
        found = named(leftovers(book, connection), names)
        if foreign := [one.name for one in found if names and one.foreign]:
            raise UsageError(
                f"{foreign[0]} is not labbook's, and nothing was removed: move it out of the store yourself."
            )
        chosen = [one for one in found if not one.foreign and (names or not one.by_name_only)]
        for one in chosen:
            if one.path is None:
                drop_old(connection, one.name)
        for one in chosen:  # after all that the database may refuse
            if one.path is not None:
                one.path.unlink()
    return chosen


def named(found: Sequence[Leftover], names: Sequence[str]) -> list[Leftover]:
    """Return the leftovers of these names, all where none is given."""
    by_name = {one.name: one for one in found}
    for name in names:
        if name not in by_name:
            raise unknown_name("leftover", name, by_name, "`labbook db prune` lists them.")
    return [one for one in found if not names or one.name in names]


def _file(book: Book, path: Path, what: str, by_name_only: bool = False) -> Leftover:
    name = str(path.relative_to(book.folder) if path.is_relative_to(book.folder) else path)
    return Leftover(name, what, path.lstat().st_size, by_name_only, path, foreign=what is _FOREIGN)


def _files(book: Book, connection: sa.Connection) -> Iterator[tuple[Path, str]]:
    old = sorted(book.folder.glob(f"{DATABASE}.before-rebuild.*"))
    for path in old:
        if _OLD_NAME.fullmatch(path.name):
            own = own_tables(path.with_name(path.name.removesuffix("-wal").removesuffix("-shm")))
            yield path, f"{_WITH_OWN} ({', '.join(own)}), removed only by its name" if own else _OLD
    begun = [*book.folder.glob(f".{DATABASE}.*"), *(book.folder / "reports").rglob(".*.part")]
    begun += [*book.store.root.glob(f".{JOURNAL}.*"), *book.store.root.glob(".last-backup.json.*")]
    yield from ((path, _CUT_OFF) for path in sorted(begun) if _is_quiet(path))
    spoken_of = _referenced_paths(book, connection)
    aside = b"".join(path.read_bytes() for path in _leftover_journals(book))
    for folder in STORED:
        for path in sorted((book.store.root / folder).rglob("*")):
            name = path.relative_to(book.store.root).as_posix()
            if path.is_dir() and not path.is_symlink():
                continue
            if not is_store_name(name):
                yield path, _FOREIGN
            elif name not in spoken_of and path.stem.encode() not in aside and _is_quiet(path):
                yield path, _CUT_OFF if path.name.startswith(".") else _ORPHAN


def _leftover_journals(book: Book) -> list[Path]:
    """List pieces cut off the journal, and damaged journals; a raw copy that one of them names may be wanted again."""
    return [
        path for why in ("cut-off", "before-rebuild") for path in sorted(book.store.root.glob(f"{JOURNAL}.{why}.*"))
    ]


def _is_quiet(path: Path) -> bool:
    return time.time() - path.stat().st_mtime > QUIET_S


def _referenced_paths(book: Book, connection: sa.Connection) -> set[str]:
    """Return the paths in the store that rows or the journal refer to; of its samples, those that have no rows yet."""
    referenced = {file.store_path for file in (*raw_copies(connection), *signal_files(connection))}
    entries = list(book.mirror.entries())
    referenced |= {raw_path(sha256) for sha256 in raw_of(entries)}
    referenced |= {numbers_path(Path(), sha256).as_posix() for sha256 in numbers_files(entries).values()}
    for entry in entries[journal.head(connection)[0] :]:
        if entry.reads:
            referenced |= {f"signals/{sha256[:2]}/{sha256}.parquet" for sha256 in (entry.new or {}).get("signals", ())}
    return referenced
