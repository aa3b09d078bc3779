"""`labbook db check`: is the book whole? All that it consists of is read and compared with what it should be.

These are the journal's chain in file and table, every raw copy, every file of samples, the files of reports, and
SQLite's own integrity check. The journal is replayed into a temporary database, with which every row of the tables is
compared: from readings in the cache where these are known, for a deep check from the raw copies. A file of the store
whose bytes are those that a reading in the cache remembers is not unpacked. Nothing is changed or mended; each problem
comes with its remedy.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import sqlalchemy as sa

from data_schema import journal
from data_schema.altered_schema import altered_schema
from data_schema.engine import reading
from data_schema.errors import BookError
from data_schema.journal import MEND_TABLE, Entry
from data_schema.journal_file import NOTHING, JournalFile, LeftOut
from data_schema.queries.detections import verdicts_waiting
from data_schema.queries.files import StoredFile, lost_copies, raw_copies, signal_files, waiting_files
from data_schema.vocabulary import Action
from ingest.store import STORED, Store, raw_path
from labbook.book.altered import MOST_NAMED, altered_since, but_of_readings, differences, with_reports
from labbook.book.copies.copying import Counted
from labbook.book.opening import REPORTS, check_schema, engine_of, journal_path, read_configuration, store_of
from labbook.book.replaying import Replay, replayed
from labbook.book.report_numbers import NUMBERS, numbers_files, numbers_path
from labbook.config.parsing import Configuration, settings_of_numbers
from reports.display import list_text
from reports.page.writing import MARK

_MADE_ANEW = (
    "Keep the database as it is, and run `labbook rebuild` to make it anew from the raw copies and the journal."
)
_PROBLEMS_OF_SQLITE = 20
"""The most problems listed of SQLite's integrity check, which can find very many in a damaged file."""

_THREADS = 4
"""Reading, unpacking and hashing of files release the interpreter."""

_T = TypeVar("_T")
_ReplayedJournal: TypeAlias = Callable[[int, frozenset[str]], AbstractContextManager[tuple[sa.Engine, Replay]]]
"""Is ready to replay so many entries without these raw copies; gives an empty database and what replays into it."""


@dataclass(frozen=True, slots=True)
class Health:
    """What was checked, each problem with its remedy, and the store's files that no row refers to.

    `waiting` entries of the journal file were cut off before the database had them; the next command applies them, and
    one that cannot take effect is a problem.
    What is `left_out` at the end of that file is no complete command; the next one that writes sets it aside.
    `reports` of those that were made still have their folder; `missing_numbers` say which have lost their numbers,
    `other_settings` which were made with another labbook.toml than that of now: no number depends on either.
    `verdicts_waiting` were given on samples that no reading in force has, `files_waiting` are refused by this labbook:
    both wait for a person. `lost_sentences` name raw copies without which the database was made.
    """

    whole: bool
    entries: int
    waiting: int
    left_out: LeftOut
    raw_copies: int
    signal_files: int
    reports: int
    problems: tuple[str, ...]
    missing_numbers: tuple[str, ...]
    other_settings: tuple[str, ...]
    orphans: tuple[str, ...]
    verdicts_waiting: int
    files_waiting: int
    lost_sentences: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Journal:
    """The hashes of all entries, in their order, and the entries of reports."""

    hashes: list[str]
    reports: list[Entry]


@dataclass(frozen=True, slots=True)
class _Database:
    """What was read from the database: the files it refers to, and its journal."""

    raw: list[StoredFile]
    samples: list[StoredFile]
    journal: _Journal | None
    verdicts_waiting: int = 0
    files_waiting: int = 0
    lost_sha256: frozenset[str] = frozenset()


def check_book(folder: Path, counted: Counted, *, deep: bool = False, pages: bool = True) -> Health:
    """Check a book as far as it can be read; a `deep` check reads the raw copies again.

    Without `pages` the folders of reports are left alone, which a restored book does not have.
    """
    configuration = read_configuration(folder)
    store, mirror = store_of(folder, configuration), JournalFile(journal_path(folder, configuration))

    @contextlib.contextmanager
    def replayed_journal(entries: int, lost: frozenset[str]) -> Iterator[tuple[sa.Engine, Replay]]:
        with (
            counted(entries) as step,
            replayed(store, mirror, 0, step, use_cache=not deep, lost=lost) as (engine, replay),
        ):
            yield engine, replay
            replays.append(replay)

    replays: list[Replay] = []
    problems: list[str] = []
    database = _attempt(
        problems,
        lambda: _read_database(store.root, mirror, engine_of(folder, configuration), replayed_journal, problems),
    )
    database = database or _Database([], [], None)
    verified = replays[0].verified if replays else {}
    written = _attempt(problems, lambda: _read_file(mirror, replays))  # the table is never ahead of it
    left_out = NOTHING if written is None else mirror.left_out()
    waiting = 0
    if written is not None and database.journal is not None:
        problems += _compared(mirror.path, written.hashes, database.journal.hashes)
        waiting = max(0, len(written.hashes) - len(database.journal.hashes))
    problems = list(dict.fromkeys(problems))  # the replay meets a damaged entry too
    read = written or database.journal or _Journal([], [])
    reports, altered = altered_reports(folder, read.reports if pages else [])
    altered_numbers, missing_numbers = wrong_numbers(store.root, read.reports)
    problems += [*altered, *altered_numbers]
    if database.journal is None and written is None:
        mirror.refuse_other_form()  # then no backup of it helps either
        problems.append("neither the database nor journal.jsonl holds the whole journal: `labbook restore` a backup.")
    checks: list[tuple[StoredFile, Callable[[], object]]] = [
        (stored, partial(store.raw, stored.store_path, stored.sha256))
        for stored in database.raw
        if stored.store_path == raw_path(stored.sha256)  # else the row is altered, not the copy
        and stored.sha256 not in database.lost_sha256
    ]
    checks += [
        (stored, partial(store.check_samples, stored.store_path, stored.sha256, stored.name))
        for stored in database.samples
    ]

    def damage(check: tuple[StoredFile, Callable[[], object]]) -> list[str]:
        path, found = check[0].store_path, list[str]()
        if not store.is_as_verified(path, verified.get(path)):
            _attempt(found, check[1])
        return found

    with counted(len(checks)) as step, ThreadPoolExecutor(_THREADS) as pool:
        for (stored, _check), found in zip(checks, pool.map(damage, checks), strict=True):
            problems += found
            step(stored.name)
    spoken_of = {stored.store_path for stored in (*database.raw, *database.samples)}
    spoken_of |= {raw_path(stored.sha256) for stored in database.raw}
    spoken_of |= {numbers_path(Path(), sha256).as_posix() for sha256 in numbers_files(read.reports).values()}
    stored_files = {
        path.relative_to(store.root).as_posix()
        for folder in STORED
        for path in (store.root / folder).rglob("*")
        if path.is_file()
    }
    return Health(
        whole=not problems and not database.lost_sha256,
        entries=len(read.hashes),
        waiting=waiting,
        left_out=left_out,
        raw_copies=len(database.raw),
        signal_files=len(database.samples),
        reports=reports,
        problems=tuple(problems),
        missing_numbers=tuple(missing_numbers),
        other_settings=tuple(made_with_other_settings(configuration, read.reports)),
        orphans=() if database.journal is None else tuple(sorted(stored_files - spoken_of)),
        verdicts_waiting=database.verdicts_waiting,
        files_waiting=database.files_waiting,
        lost_sentences=tuple(
            f"the database was made without the raw copy {stored.store_path} of {stored.name}: {_mended(store, stored)}"
            for stored in database.raw
            if stored.sha256 in database.lost_sha256
        ),
    )


def _mended(store: Store, stored: StoredFile) -> str:
    if store.has_raw(stored.sha256):
        return "it is there again: run `labbook rebuild`."
    return "give the original file to `labbook ingest`, or put the copy back from a backup and run `labbook rebuild`."


def _attempt(problems: list[str], work: Callable[[], _T]) -> _T | None:
    """Do a part of the check; an error that stops it is a problem, and the other parts go on."""
    try:
        return work()
    except BookError as error:
        problems.append(str(error))
        return None


def _read_database(
    store: Path, mirror: JournalFile, engine: sa.Engine, replayed_journal: _ReplayedJournal, problems: list[str]
) -> _Database | None:
    """Read the database, as far as its tables are there; what is wrong with it is added to the problems."""
    try:
        check_schema(engine, mirror)
        with reading(engine) as connection:
            damage = _damage_of_sqlite(connection) if engine.dialect.name == "sqlite" else []
            problems += _with_remedy([*damage, *altered_schema(connection)], _MADE_ANEW)
            raw, samples = raw_copies(connection), signal_files(connection)
            lost = lost_copies(connection)
            read = _attempt(
                problems, lambda: _read_through(journal.verified_chain(journal.stored(connection), remedy=MEND_TABLE))
            )
            if read is not None:
                problems += _altered(store, connection, len(read.hashes), lost, replayed_journal)
            waiting = len(verdicts_waiting(connection)), len(waiting_files(connection))
        return _Database(raw, samples, read, *waiting, lost)
    except sa.exc.ProgrammingError as error:  # as PostgreSQL calls it where a table or column is not there
        problems.append(f"the tables cannot be read ({str(error.orig).splitlines()[0]}). {_MADE_ANEW}")
        return None
    finally:
        engine.dispose()


def _altered(
    store: Path, connection: sa.Connection, entries: int, lost: frozenset[str], replayed_journal: _ReplayedJournal
) -> list[str]:
    """Return which rows are not as labbook wrote them, what they should be, and which reports depend on them."""
    problems: list[str] = []
    try:
        with replayed_journal(entries, lost) as (engine, replay):
            altered, removed = altered_since(connection, engine, replay)
            with reading(engine) as fresh:
                if altered and differences(fresh, journal.stored(fresh), replay.without_rows).other_versions:
                    by_any = but_of_readings(altered)
                    if len(by_any) < len(altered):
                        problems.append(
                            f"{len(altered) - len(by_any)} rows come out otherwise with this labbook's readers than "
                            "with those of other versions that wrote them: run `labbook rebuild`, then check again."
                        )
                    altered = by_any
                found = with_reports(store, connection, fresh, altered)
            _attempt(problems, lambda: replay.apply_to(engine))  # what waits in the file
    except BookError as error:
        return [f"what should stand in the tables cannot be told: {error}"]
    remedy = "Run `labbook rebuild` to make the database anew from the raw copies and the journal."
    gone = f"the last {removed} entries of journal.jsonl are not in the table of entries, and what they state is."
    sentences = [*([gone] if removed else []), *(row.sentence for row in found)]
    problems += _with_remedy(sentences, remedy)
    if len(altered) > MOST_NAMED:
        tables = Counter(row.table for row in altered)
        counts = ", ".join(f"{count} of {table}" for table, count in tables.items())
        problems.append(f"altered in all: {counts}; the first {MOST_NAMED} are named above.")
    return problems


def _with_remedy(problems: list[str], remedy: str) -> list[str]:
    """Append the remedy once, to the last of several problems."""
    return [*problems[:-1], f"{problems[-1]} {remedy}".rstrip()] if problems else []


def _damage_of_sqlite(connection: sa.Connection) -> list[str]:
    """Return what SQLite finds wrong in its file, and which rows refer to missing ones."""
    found = connection.exec_driver_sql(f"PRAGMA integrity_check({_PROBLEMS_OF_SQLITE})").scalars().all()
    problems = [f"the database is damaged ({text})." for text in found if text != "ok"]
    broken = islice(connection.exec_driver_sql("PRAGMA foreign_key_check"), _PROBLEMS_OF_SQLITE)
    problems += [f"row {row[1]} of table {row[0]} refers to a row of {row[2]} that is not there." for row in broken]
    return problems


def _read_through(entries: Iterable[Entry]) -> _Journal:
    found = _Journal([], [])
    for entry in entries:
        found.hashes.append(entry.hash)
        if entry.action is Action.REPORT:
            found.reports.append(entry)
    return found


def _read_file(mirror: JournalFile, replays: Sequence[Replay]) -> _Journal:
    """Read the journal's file, where the replay did not come to its end."""
    last = mirror.last()
    for replay in replays:
        if last is not None and replay.reached == (last.seq, last.hash):
            return _Journal(replay.hashes, replay.reports)
    return _read_through(mirror.entries())


def _compared(path: Path, written: Sequence[str], entries: Sequence[str]) -> list[str]:
    """Compare the hashes in the journal's file and table; what the file has more is applied by the next command."""
    pairs = enumerate(zip(written, entries, strict=False), start=1)
    differing = next((seq for seq, (a, b) in pairs if a != b), None)
    if differing is not None:
        return [
            f"entry {differing} of {path} is not entry {differing} of the database: the two belong to different books; "
            "put the right files together."
        ]
    if len(written) < len(entries):
        return [
            f"{path} ends at entry {len(written)}, the database at {len(entries)}: restore the file from a backup, or "
            "write it anew from the database with `labbook rebuild --journal`."
        ]
    return []


_MOST_NAMED = 5
_TAKEN_OUT = {False: "nothing", True: "a table"}
"""What now stands instead of a setting, by whether it was nothing: tables of settings come and go as a whole."""


def wrong_numbers(store: Path, reports: Sequence[Entry]) -> tuple[list[str], list[str]]:
    """Return which numbers of reports made in this book were altered in its store, and which are not there."""
    altered, missing = [], []
    for called, sha256 in numbers_files(reports).items():
        path = numbers_path(store, sha256)
        mend = f"from a backup or as the {NUMBERS} beside the report's page"
        if not path.exists():
            missing.append(f"the numbers of report {called} are not in {path}: it can be put there {mend}.")
        elif not _is(path, sha256):
            altered.append(f"{path}, the numbers of report {called}, was altered. Put it back, {mend}, or remove it.")
    return altered, missing


def altered_reports(book_folder: Path, reports: Sequence[Entry]) -> tuple[int, list[str]]:
    """Return how many reports still have their folder, and of those whose files are not as written which and how.

    `reports` are all entries of reports, in the order of the journal. Those of another book were written elsewhere, and
    a folder holds the files of the last report written there: one named by a person perhaps those of another book.
    """
    standing = {}
    for number, entry in enumerate(reports, start=1):
        new = entry.new or {}
        if entry.origin is None and new.get("folder") is not None:
            standing[book_folder / new["folder"]] = number, new
    found, problems = 0, []
    for folder, (number, new) in standing.items():
        of_another = _read(folder / MARK) not in (None, b"", new["made_at"].encode())
        if not folder.is_dir() or (of_another and folder.parent != book_folder / REPORTS):
            continue
        found += 1
        wrong = {name: _read(folder / name) for name, sha256 in new["files"].items() if not _is(folder / name, sha256)}
        if wrong:
            listed = [f"{name} {'is missing' if data is None else 'was altered'}" for name, data in wrong.items()]
            more = [f"{len(listed) - _MOST_NAMED} more files"] if len(listed) > _MOST_NAMED else []
            problems.append(
                f"report {number}, made {new['made_at']} of {new['where'] or 'all runs'}, is not as it was written: "
                f"{list_text([*listed[:_MOST_NAMED], *more])}. Put its files back, or remove its folder and make the "
                "report again."
            )
    return found, problems


def _read(path: Path) -> bytes | None:
    try:
        return path.read_bytes()
    except OSError:
        return None


def _is(path: Path, sha256: str) -> bool:
    data = _read(path)
    return data is not None and hashlib.sha256(data).hexdigest() == sha256


def made_with_other_settings(configuration: Configuration, reports: Sequence[Entry]) -> list[str]:
    """Return what labbook.toml says otherwise now than when reports were made, of what their numbers rest on.

    What was added since, as a robot, bears on no earlier number.
    """
    now = settings_of_numbers(configuration)
    by_difference: dict[str, list[int]] = {}
    for number, entry in enumerate(reports, start=1):
        changes = [
            f"{name} {_shown(was)}, labbook.toml says {_shown(now[name]) if name in now else _TAKEN_OUT[was is None]}"
            for name, was in (entry.new or {}).get("settings", {}).items()
            if name not in now or was != now[name]
        ]
        more = [f"{len(changes) - _MOST_NAMED} more"] if len(changes) > _MOST_NAMED else []
        if changes:
            by_difference.setdefault("; ".join([*changes[:_MOST_NAMED], *more]), []).append(number)
    return [
        f"numbers of report{'s' if numbers[1:] else ''} {list_text([str(number) for number in numbers])} were computed "
        f"with {difference}."
        for difference, numbers in by_difference.items()
    ]


def _shown(value: Any) -> str:
    return "nothing" if value is None else json.dumps(value, ensure_ascii=False)
