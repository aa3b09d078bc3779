"""`labbook rebuild`: raw copies and journal are the truth, everything else follows from them.

Every entry is applied again, in order, by the functions that applied it the first time. The new database takes the
place of the old one only when it is complete, in one transaction and with nobody writing meanwhile; the old one is kept
under another name, never deleted.

SQLite: the new content is copied into the file that is there, whoever else has it open, in one transaction, by
SQLite's own backup. A file that is
renamed over one in use would leave programs that write to the old one beside those that write to the new one, and a
write-ahead log that belongs to neither. Only a file that is no database any more is set aside by name.

A copy of the old database has its lasting name, and is synced, before any page of the new one is committed: from then
on nothing removes it. Where the replacing is cut off after that, there is a copy too many, never one too few.

PostgreSQL: the new tables grow in a schema of their own, which is then renamed. The two schemas change their names in
one transaction; until then the old tables are in use. Afterwards these lie in a schema `before_rebuild_<time>`, which
can be dropped when nothing is missing. The new tables have the owners and rights of the old ones. What a lab made on
the book's tables itself (views, foreign keys, functions) would stay on the old ones: it stops the rebuild before it has
begun, by name.
"""

from __future__ import annotations

import contextlib
import secrets
import shutil
import sqlite3
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import sqlalchemy as sa

from data_schema import journal
from data_schema.disk import exclusive_lock, stamp, sync, write_whole
from data_schema.engine import (
    BUSY_TIMEOUT_S,
    POSTGRES_SCHEMA,
    postgres_engine,
    reading,
    refuse_unfinished,
    sqlite_engine,
    translated_errors,
    writing,
)
from data_schema.errors import BookBusy, BookDamaged, BookError, UsageError
from data_schema.journal import GENESIS, Entry
from data_schema.journal_file import JournalFile, LeftOut
from data_schema.queries.files import lost_copies
from data_schema.schema import SCHEMA, schema_of
from data_schema.tables import METADATA
from data_schema.views import VIEWS
from data_schema.vocabulary import Action
from ingest.store import Store
from labbook.book.altered import AlteredRow, Differences, altered_rows, but_of_readings, differences, with_reports
from labbook.book.copies.copying import raw_of
from labbook.book.making import fill_sqlite, make_tables
from labbook.book.opening import (
    CONFIGURATION,
    DATABASE,
    check_schema,
    engine_of,
    journal_path,
    read_configuration,
    shown,
    store_of,
)
from labbook.book.replaying import Replay
from labbook.config.places import with_database

REBUILDING = "another program is rebuilding this book: wait until it has finished."
"""A second one would remove what the first has made so far."""


@dataclass(frozen=True, slots=True)
class Rebuilt:
    """How many entries were applied, where the old database is kept, and what differs from before.

    `left_out` is what stands at the end of the journal file and is no complete command. `altered` are the first of the
    `n_altered` rows of the old database that were not what labbook had written there. `left_behind` are a lab's own
    tables and views that the old database alone has. `n_lost` raw copies could not be read: `differences` say which
    files wait for them.
    """

    entries: int
    old: str | None
    differences: Differences
    left_out: LeftOut
    n_altered: int = 0
    altered: tuple[AlteredRow, ...] = ()
    left_behind: tuple[str, ...] = ()
    n_lost: int = 0

    @property
    def sentences(self) -> list[str]:
        """Return sentences on what differs, what had been altered, and what does not count."""
        found = [*self.differences.sentences, *(rows.sentence for rows in self.altered)]
        if self.n_altered > len(self.altered):
            found.append(f"{self.n_altered - len(self.altered)} more were altered in the old database.")
        if self.left_behind:
            found.append(f"of what you made yourselves the old database alone has {', '.join(self.left_behind)}.")
        return [*found, *([self.left_out.sentence] if self.left_out.sentence else [])]


@dataclass(frozen=True, slots=True)
class Place:
    """Where the database of a book goes: to a PostgreSQL database of this address, or to labbook.db in the book."""

    url: str | None


def rebuild_database(
    folder: Path,
    step: Callable[[str], None],
    place: Place | None = None,
    *,
    may_lack: frozenset[str] | None = frozenset(),
) -> Rebuilt:
    """Make the database anew, where it is or in another `place`; an interrupted rebuild leaves the old one in use.

    A book that goes to another place is there once its labbook.toml says so, which is written last. Files wait for raw
    copies that are missing or damaged where these are, by SHA-256, among those that it `may_lack`, None for any; for
    others `BookDamaged` is raised and nothing changed.
    """
    configuration = read_configuration(folder)
    url = configuration.database.url if place is None else place.url
    moves = url != configuration.database.url
    moved = with_database(configuration.text, url) if moves else ""  # refused, if it is, before all the work
    mirror = JournalFile(journal_path(folder, configuration))
    if mirror.last() is None:
        raise UsageError(
            f"{mirror.path} holds no entry: write it anew from the database with `labbook rebuild --journal`, or make "
            "a book with `labbook init`."
        )
    store = store_of(folder, configuration)
    with exclusive_lock(mirror.path, REBUILDING):
        lost = unreadable_copies(store, mirror) if may_lack is None or may_lack else frozenset()
        lost = lost if may_lack is None else lost & may_lack
        replay = Replay(store, mirror, step, lost=lost)
        left_behind: list[str] = []
        try:
            if url is None:
                old, left_behind = _rebuild_sqlite(folder, replay)
            else:
                old = replace_postgres(url, replay.apply_to, replay.finish)
        except BookDamaged as error:
            missing = unreadable_copies(store, mirror) - lost
            if not missing:
                raise
            raise BookDamaged(
                f"{len(missing)} raw {'copy' if len(missing) == 1 else 'copies'} cannot be read, and nothing was "
                f"changed (the first: {str(error).split(': restore it')[0]}): put them back from a backup, or make the "
                "database without them by `labbook rebuild --keep-going`, which lists what is missing."
            ) from error
        if moves:
            write_whole(folder / CONFIGURATION, moved.encode())
            if configuration.database.url is None:
                old = set_aside(folder) or old
    engine = engine_of(folder, read_configuration(folder))
    try:
        with reading(engine) as connection:
            found = differences(connection, journal.stored(connection, action=Action.INGEST), replay.without_rows)
            altered = (0, ()) if old is None or moves else _altered(folder, store.root, url, old, connection, found)
    finally:
        engine.dispose()
    return Rebuilt(len(replay.hashes), old, found, replay.left_out, *altered, tuple(left_behind), len(lost))


def unreadable_copies(store: Store, mirror: JournalFile) -> frozenset[str]:
    """Return the SHA-256 of the raw copies that a journal names and that are missing or damaged; all are read."""
    return frozenset(sha256 for sha256 in raw_of(mirror.entries()) if not store.has_raw(sha256))


def _altered(
    folder: Path, store: Path, url: str | None, old: str, fresh: sa.Connection, found: Differences
) -> tuple[int, tuple[AlteredRow, ...]]:
    """Compare rows of the old database with the new ones; none where it is too damaged, or of another schema.

    Where other versions of readers made it, or other raw copies were lost, only what no reading gives.
    """
    engine = postgres_engine(url, schema=old) if url else sqlite_engine(folder / old)
    try:
        with reading(engine) as connection:
            if schema_of(connection) != SCHEMA:
                return 0, ()
            altered = altered_rows(connection, fresh)
            if found.other_versions or lost_copies(connection) != lost_copies(fresh):
                altered = but_of_readings(altered)
            return len(altered), tuple(with_reports(store, connection, fresh, altered))
    except (BookError, sa.exc.DBAPIError):
        return 0, ()
    finally:
        engine.dispose()


def _rebuild_sqlite(folder: Path, replay: Replay) -> tuple[str | None, list[str]]:
    """Return under which name the old database is kept, and what of a lab's own it alone has."""
    left: list[str] = []
    remove_leftovers(folder)
    path, fresh = folder / DATABASE, folder / f".{DATABASE}.rebuild.{secrets.token_hex(4)}"
    try:
        fill_sqlite(fresh)
        engine = sqlite_engine(fresh, scratch=True)
        try:
            replay.apply_to(engine)
        finally:
            engine.dispose()

        def finish() -> None:
            last = sqlite_engine(fresh, scratch=True)
            try:
                replay.finish(last, head_of_sqlite(path))
            finally:
                last.dispose()
            left.extend(_take_over_views(path, fresh))
            sync(fresh)

        return replace_sqlite(folder, fresh, finish), left
    finally:
        remove_leftovers(folder)


def _take_over_views(path: Path, fresh: Path) -> list[str]:
    """Make the views that a lab made in the old database in the new one, too; returns tables and views left behind.

    None is taken over from a database that is too damaged. A table's rows follow from nothing in the journal.
    """
    left = [f"table {name}" for name in own_tables(path)]
    with contextlib.suppress(sqlite3.DatabaseError):
        if not path.exists():
            return left
        with contextlib.closing(_connect(path)) as old, contextlib.closing(_connect(fresh)) as new:
            views = old.execute("SELECT name, sql FROM sqlite_master WHERE type = 'view' ORDER BY rowid").fetchall()
            for name, statement in views:
                if name in VIEWS:
                    continue
                try:
                    new.execute(statement)
                    new.execute(f'SELECT * FROM "{name}" LIMIT 0')  # noqa: S608 - the name stands in the database
                except sqlite3.Error:
                    left.append(f"view {name}")
    return left


def own_tables(path: Path) -> list[str]:
    """Return names of the tables in a SQLite database that labbook did not make; none of one too damaged to say."""
    with contextlib.suppress(sqlite3.DatabaseError):
        if path.exists():
            with contextlib.closing(_connect(path)) as database:
                names = database.execute(
                    "SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY rowid"
                ).fetchall()
                return [name for (name,) in names if name not in METADATA.tables and not name.startswith("sqlite_")]
    return []


def rewrite_journal(folder: Path) -> int:
    """Write journal.jsonl anew from the database, where the file was lost, cut or damaged; returns how many entries.

    A file that was damaged is kept beside the new one, and so is what was cut off at the end of one that was not.
    """
    configuration = read_configuration(folder)
    path = journal_path(folder, configuration)
    engine = engine_of(folder, configuration)
    try:
        check_schema(engine, JournalFile(path))
        with writing(engine) as connection:  # alone, so that nobody appends to the old file meanwhile
            remedy = journal.MEND_BOTH if path.exists() and _known(path) is None else journal.MEND_TABLE
            entries = list(journal.verified_chain(journal.stored(connection), remedy=remedy))
            _replace_journal(path, entries)
    finally:
        engine.dispose()
    return len(entries)


def _replace_journal(path: Path, entries: list[Entry]) -> None:
    known = _known(path)
    beyond = 0 if known is not None else _readable_beyond(path, entries[-1].seq if entries else 0)
    if beyond:
        raise BookDamaged(
            f"{path} is damaged, and {beyond} of its entries that can be read are not in the database: restore a "
            "backup that has them, or move the file away, which gives them up, and give the command again."
        )
    if known is not None and known != [entry.hash for entry in entries[: len(known)]]:
        raise BookDamaged(
            f"{path} holds entries that the database does not have: the two belong to different books, or one is older "
            "than the other; put the right file there from a backup, or move this one away and give the command again."
        )
    fresh = JournalFile(path.with_name(f".{path.name}.{secrets.token_hex(4)}"))
    fresh.path.touch()
    fresh.append(entries)
    if path.exists():
        _copy_permissions(path, fresh.path)
    if known is None:
        damaged = path.with_name(f"{path.name}.before-rebuild.{stamp()}")
        shutil.copy2(path, damaged)
        sync(damaged)
        sync(damaged.parent)
    elif path.exists():
        JournalFile(path).keep_cut_off()
    fresh.path.replace(path)
    sync(path.parent)


def _copy_permissions(path: Path, fresh: Path) -> None:
    """Let a file that takes the place of another be read and written by the same people."""
    shutil.copymode(path, fresh)
    with contextlib.suppress(PermissionError):  # only its owner may give it to another group
        shutil.chown(fresh, group=path.stat().st_gid)


def _readable_beyond(path: Path, seq: int) -> int:
    """Return how many lines of a damaged journal are whole entries after number `seq`."""
    count = 0
    for line in path.read_bytes().splitlines():
        with contextlib.suppress(BookDamaged, UnicodeDecodeError):
            count += Entry.from_line(line.decode()).seq > seq
    return count


def _known(path: Path) -> list[str] | None:
    """Return the hashes in a journal file; None where it is damaged."""
    if not path.exists():
        return []
    try:
        return [entry.hash for entry in JournalFile(path).entries()]
    except BookDamaged:
        return None


PAGES_A_STEP = 8
"""Fewer than the smallest book has, so that the first step locks the file and does not finish."""

_RUBBISH = (sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_CORRUPT)


def replace_sqlite(
    folder: Path, fresh: Path, finish: Callable[[], None], busy_timeout_s: float = BUSY_TIMEOUT_S
) -> str | None:
    """Put `fresh` in the place of the book's database; returns under which name the old one is kept.

    `finish` brings `fresh` up to date; nobody else can write to the book while it runs, nor until all is done.
    """
    path = folder / DATABASE
    if path.exists():
        try:
            return _overwrite(path, fresh, finish, busy_timeout_s)
        except sqlite3.DatabaseError as error:
            _explain(path, error)
    finish()
    refuse_unfinished(fresh)
    old = set_aside(folder)
    fresh.rename(path)
    sync(folder)
    return old


def remove_leftovers(folder: Path) -> None:
    """Remove databases that were never finished, of this rebuild or of one that was interrupted."""
    for leftover in folder.glob(f".{DATABASE}.*"):
        leftover.unlink()


def head_of_sqlite(path: Path) -> tuple[int, str] | None:
    """Return number and hash of the last journal entry in a database; None where none can be read."""
    if not path.exists():
        return None
    try:
        with contextlib.closing(_connect(path)) as connection:
            row = connection.execute("SELECT seq, hash FROM journal ORDER BY seq DESC LIMIT 1").fetchone()
    except sqlite3.DatabaseError:
        return None
    return (0, GENESIS) if row is None else (row[0], row[1])


def _overwrite(path: Path, fresh: Path, finish: Callable[[], None], busy_timeout_s: float) -> str:
    copy = path.with_name(f".{DATABASE}.rebuild.{secrets.token_hex(4)}")
    old = path.with_name(f"{DATABASE}.before-rebuild.{stamp()}")
    locked = False

    def between_steps(status: int, _left: int, _all: int) -> None:
        nonlocal locked
        if status in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
            raise BookBusy(f"another program is writing to {path}: close it and run `labbook rebuild` again.")
        if not locked:  # the first step has locked the old database for writing; what it has copied is not committed
            locked = True
            finish()
            _copy(path, copy)
            sync(copy)
            copy.rename(old)
            sync(path.parent)

    with (
        contextlib.closing(_connect(path, busy_timeout_s)) as target,
        contextlib.closing(_connect(fresh)) as source,
    ):
        target.execute("PRAGMA journal_mode = wal")  # readers do not stop the copying, and it does not stop them
        source.backup(target, pages=PAGES_A_STEP, progress=between_steps)
    return old.name


def _copy(path: Path, to: Path) -> None:
    to.touch()
    with contextlib.closing(_connect(path)) as source, contextlib.closing(_connect(to)) as target:
        source.backup(target)


def _connect(path: Path, timeout_s: float = BUSY_TIMEOUT_S) -> sqlite3.Connection:
    """Connect to a file that exists."""
    return sqlite3.connect(path.resolve().as_uri() + "?mode=rw", uri=True, isolation_level=None, timeout=timeout_s)


def _explain(path: Path, error: sqlite3.DatabaseError) -> None:
    """Raise a readable form of an error; returns where the error means that the file is no database any more."""
    code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_ERROR) & 0xFF
    if code in _RUBBISH:
        return
    if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
        raise BookBusy(f"another program is writing to {path}: close it and run `labbook rebuild` again.") from error
    raise BookDamaged(
        f"{path} cannot be replaced ({error}): check the permissions of the book's folder and the space on its disk."
    ) from error


def set_aside(folder: Path) -> str | None:
    """Give what there is of the old database another name; its log too, also where the file itself is gone.

    A log that was left beside the new database would be read as belonging to it.
    """
    path = folder / DATABASE
    old = f"{DATABASE}.before-rebuild.{stamp()}"
    for suffix in ("-wal", "-shm"):
        piece = folder / f"{DATABASE}{suffix}"
        if piece.exists():
            piece.rename(folder / f"{old}{suffix}")
    if not path.exists():
        return None
    path.rename(folder / old)
    return old


FRESH = f"{POSTGRES_SCHEMA}_rebuild"
"""The schema in which new tables grow; what an interrupted rebuild left there is removed by the next."""

INSUFFICIENT_PRIVILEGE = "42501"
"""How the server names a refusal, in its own list of conditions."""


_STAYS = (
    "it would stay with the old tables, and nothing was changed: drop it, rebuild, and make it again on the new ones."
)


def replace_postgres(
    url: str,
    fill: Callable[[sa.Engine], None],
    finish: Callable[[sa.Engine, tuple[int, str]], None],
    busy_timeout_s: float = BUSY_TIMEOUT_S,
) -> str | None:
    """Make the book's tables anew; returns the schema in which the old ones are kept, None where there were none.

    `fill` writes everything into an engine whose tables are empty; `finish` brings them up to date and gets number and
    hash of the old journal's last entry: nobody else can write to the book while it runs, nor until all is done.
    """
    engine, fresh = postgres_engine(url, busy_timeout_s=busy_timeout_s), postgres_engine(url, schema=FRESH)
    try:
        with translated_errors(), _allowed(engine), engine.begin() as connection:
            _refuse_dependents(connection, POSTGRES_SCHEMA, _STAYS)
            connection.exec_driver_sql(f"DROP SCHEMA IF EXISTS {FRESH} CASCADE")
            connection.exec_driver_sql(f"CREATE SCHEMA {FRESH}")
        with translated_errors():
            make_tables(fresh)
            fill(fresh)
        with _allowed(engine), translated_errors(), engine.begin() as connection:
            tables = set(sa.inspect(connection).get_table_names(POSTGRES_SCHEMA))
            if "journal" in tables:
                connection.exec_driver_sql("LOCK TABLE journal IN ACCESS EXCLUSIVE MODE")
                finish(fresh, journal.head(connection))
            else:
                finish(fresh, (0, journal.GENESIS))
            fresh.dispose()
            return _change_names(connection, sorted(tables))
    finally:
        fresh.dispose()
        with contextlib.suppress(sa.exc.SQLAlchemyError), engine.begin() as connection:  # else the next rebuild does it
            connection.exec_driver_sql(f"DROP SCHEMA IF EXISTS {FRESH} CASCADE")
        engine.dispose()


def _change_names(connection: sa.Connection, tables: list[str]) -> str | None:
    aside = None
    if tables:
        names = ", ".join(map(_quoted(connection), tables))
        connection.exec_driver_sql(f"LOCK TABLE {names}")  # those who read have finished then
        _refuse_dependents(connection, POSTGRES_SCHEMA, _STAYS)
        aside = f"before_rebuild_{stamp().lower()}"
        connection.exec_driver_sql(f"ALTER SCHEMA {POSTGRES_SCHEMA} RENAME TO {aside}")
    else:
        connection.exec_driver_sql(f"DROP SCHEMA IF EXISTS {POSTGRES_SCHEMA}")
    connection.exec_driver_sql(f"ALTER SCHEMA {FRESH} RENAME TO {POSTGRES_SCHEMA}")
    if aside is not None:
        rights = connection.execute(sa.text(_RIGHTS), {"old": aside}).scalars().all()
        for statement in rights:
            connection.exec_driver_sql(statement)
    return aside


_WHO = "CASE grantee WHEN 0 THEN 'PUBLIC' ELSE quote_ident(pg_get_userbyid(grantee)) END"
_RIGHTS = f"""
WITH schema AS (SELECT * FROM pg_namespace WHERE nspname = :old),
    relation AS (SELECT * FROM pg_class WHERE relnamespace = (SELECT oid FROM schema) AND relkind IN ('r', 'S', 'v'))
SELECT format('GRANT %s ON SCHEMA %I TO %s', privilege_type, '{POSTGRES_SCHEMA}', {_WHO})
    FROM schema, aclexplode(nspacl) WHERE grantee <> nspowner
UNION ALL
SELECT format('GRANT %s ON %s %I.%I TO %s', privilege_type, CASE relkind WHEN 'S' THEN 'SEQUENCE' ELSE 'TABLE' END,
    '{POSTGRES_SCHEMA}', relname, {_WHO}) FROM relation, aclexplode(relacl) WHERE grantee <> relowner
UNION ALL
SELECT format('ALTER TABLE %I.%I OWNER TO %I', '{POSTGRES_SCHEMA}', relname, pg_get_userbyid(relowner))
    FROM relation WHERE relkind IN ('r', 'v') AND pg_get_userbyid(relowner) <> current_user
UNION ALL
SELECT format('ALTER SCHEMA %I OWNER TO %I', '{POSTGRES_SCHEMA}', pg_get_userbyid(nspowner))
    FROM schema WHERE pg_get_userbyid(nspowner) <> current_user
"""  # noqa: S608 - nothing of it is given by anybody
"""Statements that give the new tables the rights and owners that the old ones of the same names have."""


def _refuse_dependents(connection: sa.Connection, schema: str, sentence: str) -> None:
    """Raise `UsageError` where somebody else made something in the schema of a book, or on its tables."""
    made = set(sa.inspect(connection).get_table_names(schema)) - set(METADATA.tables)
    others = [f"table {name}" for name in sorted(made)]
    others += connection.execute(sa.text(_DEPENDENTS), {"schema": schema, "views": list(VIEWS)}).scalars().all()
    if others:
        raise UsageError(f"{', '.join(others)} in {schema} or on its tables: made by somebody else; {sentence}")


_DEPENDENTS = """
WITH book AS (
    SELECT oid, reltype FROM pg_class
    WHERE (relkind = 'r' OR (relkind = 'v' AND relname = ANY(:views)))
        AND relnamespace = (SELECT oid FROM pg_namespace WHERE nspname = :schema)
), found AS (
    SELECT DISTINCT d.classid, d.objid FROM pg_depend d
    JOIN book ON (d.refclassid = 'pg_class'::regclass AND d.refobjid = book.oid)
        OR (d.refclassid = 'pg_type'::regclass AND d.refobjid = book.reltype)
    WHERE d.deptype = 'n' OR d.classid IN ('pg_policy'::regclass, 'pg_publication_rel'::regclass)
)
SELECT DISTINCT CASE WHEN r.rulename = '_RETURN' THEN pg_describe_object('pg_class'::regclass, r.ev_class, 0)
    ELSE pg_describe_object(f.classid, f.objid, 0) END AS description
FROM found f
LEFT JOIN pg_rewrite r ON f.classid = 'pg_rewrite'::regclass AND r.oid = f.objid
LEFT JOIN pg_constraint c ON f.classid = 'pg_constraint'::regclass AND c.oid = f.objid
WHERE (c.oid IS NULL OR c.conrelid NOT IN (SELECT oid FROM book))
    AND (r.oid IS NULL OR r.rulename <> '_RETURN' OR r.ev_class NOT IN (SELECT oid FROM book))
ORDER BY description
"""
"""Whatever names the book's tables and views in its own definition, except the book's own foreign keys and views."""


@contextlib.contextmanager
def _allowed(engine: sa.Engine) -> Iterator[None]:
    """Say what a rebuild needs where the server refuses it."""
    try:
        yield
    except sa.exc.ProgrammingError as error:
        if getattr(error.orig, "sqlstate", None) != INSUFFICIENT_PRIVILEGE:
            raise
        raise UsageError(
            f"the database {shown(engine)} refused ({str(error.orig).splitlines()[0]}) and nothing was changed: "
            "rebuild as the role that owns the book's tables, and let it make schemas with GRANT CREATE ON DATABASE."
        ) from error


def _quoted(connection: sa.Connection) -> Callable[[str], str]:
    return connection.dialect.identifier_preparer.quote


def old_schemas(connection: sa.Connection) -> list[tuple[str, int]]:
    """List the schemas that hold old tables, with their sizes in bytes."""
    rows = connection.execute(
        sa.text(
            "SELECT n.nspname, coalesce(sum(pg_total_relation_size(c.oid)), 0) FROM pg_namespace n "
            "LEFT JOIN pg_class c ON c.relnamespace = n.oid AND c.relkind = 'r' "
            "WHERE n.nspname ~ '^before_rebuild_[0-9]{8}t[0-9]{12}z$' GROUP BY n.nspname ORDER BY n.nspname"
        )
    )
    return [(name, int(n_bytes)) for name, n_bytes in rows]


def drop_old(connection: sa.Connection, schema: str) -> None:
    """Remove a schema of old tables; raises `UsageError` where something that a lab made depends on them."""
    _refuse_dependents(connection, schema, "nothing was removed, drop it first.")
    with _allowed(connection.engine):
        connection.exec_driver_sql(f"DROP SCHEMA {_quoted(connection)(schema)} CASCADE")
