"""A book: the folder, its configuration, its database, its store and its journal.

Opening never creates and never changes. `labbook init` makes a book, `labbook rebuild` makes its database anew.

labbook.toml proposes, the book decides: what the file adds is stated, what it changes in use is refused.

The tables, through the journal, are the one truth. Additions (a person, a level, a pack) become statements of whoever
gives the next command; so do changes while the book is still being described, before its first day, plan or file. A
later change to an existing fact is refused with the `labbook correct` that would make it.
"""

from __future__ import annotations

import contextlib
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from data_schema.engine import postgres_engine, reading, sqlite_engine
from data_schema.errors import BookMissing, BookVersion, InputRefused, UsageError, hide_password, unknown_name
from data_schema.journal import canonical
from data_schema.journal_file import JournalFile
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.files import imported_names
from data_schema.queries.study import (
    condition_levels,
    conditions_by_key,
    config_in_force,
    day_uids,
    person_uid,
    planned_runs,
    the_study,
)
from data_schema.schema import SCHEMA, schema_of
from data_schema.vocabulary import Action
from ingest.store import Store
from labbook.book.write_session import Statement, WriteSession, apply_waiting, now_utc, write_session_of
from labbook.config.parsing import Configuration, parse_configuration

CONFIGURATION = "labbook.toml"
DATABASE = "labbook.db"
JOURNAL = "journal.jsonl"
REPORTS = "reports"
"""The folder of the book that has a folder for each report made without `--out`."""
UNFINISHED_RESTORE = ".labbook-restore.json"
"""Stands in the folder of a restore until it is done."""


@dataclass(frozen=True)
class Book:
    """An open book."""

    folder: Path
    configuration: Configuration
    engine: sa.Engine
    store: Store
    mirror: JournalFile

    def reading(self) -> contextlib.AbstractContextManager[sa.Connection]:
        """Open a reading transaction."""
        return reading(self.engine)

    @contextlib.contextmanager
    def session(self, person: str | None, *, correcting: bool = False) -> Iterator[WriteSession]:
        """Open a writing transaction for one person; first takes over what labbook.toml proposes anew.

        `correcting` is for statements that may settle what labbook.toml and the book disagree about.
        """
        speaker = self.speaker(person)
        with write_session_of(self.engine, self.store, self.mirror, speaker) as session:
            propose(session, self.configuration, correcting=correcting)
            yield session
            if correcting:
                propose(session, self.configuration, correcting=True)

    def catch_up(self) -> None:
        """Let entries take effect that only the journal file has, before what a statement rests on is looked up."""
        apply_waiting(self.engine, self.store, self.mirror)

    def speaker(self, person: str | None) -> str:
        """Return who speaks: the person named by name or initials, or the only one there is."""
        return speaker_of(self.configuration, person)

    def close(self) -> None:
        """Give the database connections back."""
        self.engine.dispose()


def speaker_of(configuration: Configuration, person: str | None) -> str:
    """Return whom a name or initials mean; None means the only one there is."""
    people = configuration.people
    if person is None:
        if len(people) == 1:
            return next(iter(people))
        raise UsageError(
            f"a statement needs a person and this book has {len(people)}: add --as with one of "
            f"{', '.join(repr(name) for name in people)}."
        )
    for name, initials in people.items():
        if person in (name, initials):
            return name
    raise unknown_name("person", person, people, "New people are added under [people] in labbook.toml.")


@contextlib.contextmanager
def opened(start: Path | None = None) -> Iterator[Book]:
    """Open the book that holds `start` (default: the current folder), and close it afterwards."""
    book = open_book(find_folder(start))
    try:
        yield book
    finally:
        book.close()


def find_folder(start: Path | None) -> Path:
    """Return the nearest folder, from `start` (default: the current folder) upward, that holds a labbook.toml.

    Raises `BookMissing` where there is none, and where a book that lost its own lies nearer: the one above is another.
    """
    start, lost = start or Path.cwd(), None
    for folder in (start.resolve(), *start.resolve().parents):
        if (folder / CONFIGURATION).is_file():
            if lost is None or store_of(folder, read_configuration(folder)).root.resolve() == lost:
                return folder
            break
        if lost is None and _has_pieces(folder):
            lost = folder
    if lost is not None:
        raise _without_configuration(start if lost == start.resolve() else lost)
    raise BookMissing(
        f"there is no book in {start} or above it: go to a book's folder, name one with --book DIR, or make one with "
        "`labbook init DIR`."
    )


def _has_pieces(folder: Path) -> bool:
    return any((folder / name).is_file() for name in (JOURNAL, DATABASE))


def _without_configuration(folder: Path) -> BookMissing:
    if not _has_pieces(folder):
        return BookMissing(f"there is no book in {folder}: name the folder that holds its {CONFIGURATION}.")
    left = JOURNAL if (folder / JOURNAL).is_file() else DATABASE
    written = f", or have `labbook init {folder} --as NAME` write the last one that it holds" if left == JOURNAL else ""
    return BookMissing(f"{folder} has a book's {left} and no {CONFIGURATION}: put that back from a backup{written}.")


def open_book(folder: Path) -> Book:
    """Open the book in a folder; raises when it is not there, or its database has another schema."""
    configuration = read_configuration(folder)
    engine, mirror = engine_of(folder, configuration), JournalFile(journal_path(folder, configuration))
    try:
        check_schema(engine, mirror)
    except BaseException:
        engine.dispose()
        raise
    return Book(folder, configuration, engine, store_of(folder, configuration), mirror)


def read_configuration(folder: Path) -> Configuration:
    """Read labbook.toml; raises `BookMissing` where there is none."""
    path = folder / CONFIGURATION
    try:
        return parse_configuration(path.read_text(encoding="utf-8"), str(path), folder)
    except FileNotFoundError as error:
        raise _without_configuration(folder) from error
    except UnicodeDecodeError as error:
        raise UsageError(f"{path} is not UTF-8 text (byte {error.start}): save it as UTF-8.") from error


def engine_of(folder: Path, configuration: Configuration) -> sa.Engine:
    """Return an engine on the book's database; a SQLite file must exist."""
    if configuration.database.url:
        return postgres_engine(configuration.database.url)
    path = folder / DATABASE
    if not path.exists() and (folder / UNFINISHED_RESTORE).exists():
        raise BookMissing(f"the restore to {folder} was cut off: give the same `labbook restore` again, it goes on.")
    if not path.exists():
        raise BookMissing(
            f"{path} is missing: run `labbook rebuild` to make it from the raw copies and the journal, or `labbook "
            "init` if this book was never made."
        )
    return sqlite_engine(path)


def store_of(folder: Path, configuration: Configuration) -> Store:
    """Return the store of files: in the book, or at [store] path."""
    return Store(folder / (configuration.store.path or ""))


def journal_path(folder: Path, configuration: Configuration) -> Path:
    """Return where the journal's mirror lies: beside the store that it belongs to."""
    return store_of(folder, configuration).root / JOURNAL


def check_schema(engine: sa.Engine, mirror: JournalFile | None = None) -> None:
    """Refuse a database that is not labbook's, or has another schema, with the next command to give.

    No database is made from a journal of another form: where `mirror` is one, that is said instead.
    """
    with reading(engine) as connection:
        found = schema_of(connection)
        tables = sorted(sa.inspect(connection).get_table_names())
    if found is None or "journal" not in tables:
        what = "is empty" if not tables else f"was not made by labbook (it holds {', '.join(tables[:3])})"
        raise BookVersion(
            f"the database {shown(engine)} {what}: make a book with `labbook init DIR`, make it anew from "
            "journal.jsonl with `labbook rebuild`, or point [database] url in labbook.toml to the right one."
        )
    if found != SCHEMA:
        if mirror is not None:
            mirror.refuse_other_form()
        raise BookVersion(
            f"the database {shown(engine)} has schema {found}, and this labbook works with schema {SCHEMA}: make it "
            "anew from journal.jsonl with `labbook rebuild`, which keeps the old one."
        )


def shown(engine: sa.Engine) -> str:
    """Return the database's name without a password."""
    if engine.dialect.name == "sqlite":
        return DATABASE
    return hide_password(engine.url.render_as_string())


def propose(session: WriteSession, configuration: Configuration, *, correcting: bool = False) -> None:
    """Take over what the configuration adds; raises `InputRefused` when it contradicts existing facts.

    With `correcting`, contradictions are left to the correction that is being stated, and to the next command; factors
    that no longer fit the book's conditions are refused all the same, for no correction can settle them. The journal
    keeps the file's text without the database's password, and the hash of the text as it is.
    """
    in_force = config_in_force(session.connection)
    if in_force is not None and in_force.sha256 == configuration.sha256:
        return
    faults = [] if in_force is None else _unfitting_factors(session.connection, configuration, in_force.text)
    if faults:
        raise InputRefused("\n".join(faults))
    for name in sorted(configuration.people, key=lambda name: name != session.person):
        if person_uid(session.connection, name) is None:
            session.declare("person", name=name, initials=configuration.people[name])
    changes: list[_Change] = []
    for kind, label, identity, values in _proposed(session, configuration):
        uid = _standing(session.connection, kind, identity)
        if uid is None:
            session.declare(kind, **identity, **values)
        else:
            changes += _differences(session.connection, kind, label, uid, {**identity, **values})
    if changes and _in_use(session.connection):
        if correcting:
            return
        raise InputRefused("\n".join(change.sentence for change in changes))
    for change in changes:
        new, old = {change.field: change.proposed}, {change.field: change.standing}
        reason = "labbook.toml was changed before anything was measured"
        session.state(Statement(Action.SET, change.kind, change.uid, new=new, old=old, reason=reason))
    text = text_without_password(configuration.text, configuration)
    session.declare("config", sha256=configuration.sha256, text=text, read_utc=now_utc())


@dataclass(frozen=True, slots=True)
class _Change:
    """A fact that labbook.toml states otherwise than the book."""

    kind: str
    label: str
    uid: str
    field: str
    standing: Any
    proposed: Any

    @property
    def sentence(self) -> str:
        assignment = f"{self.field}={'' if self.proposed is None else self.proposed}"
        command = f"labbook correct {shlex.quote(self.label)} {shlex.quote(assignment)}"
        return (
            f"labbook.toml says {self.label} {self.field} = {_shown(self.proposed)}, the book says "
            f'{_shown(self.standing)}: write that there, or state the change with `{command} --why "..."`.'
        )


def _shown(value: Any) -> str:
    return "nothing" if value is None else str(value)


def _proposed(
    session: WriteSession, configuration: Configuration
) -> Iterator[tuple[str, str, dict[str, Any], dict[str, Any]]]:
    """Yield (kind, label, key values, other values) of each proposed row; parents before what refers to them."""
    study = configuration.study
    yield (
        "study",
        "study",
        {"name": study.name},
        {
            "kind": str(study.kind),
            "reference_voltage_v": study.reference_voltage_v,
            "jumps_nominal": study.jumps_nominal,
            "time_zone": study.time_zone,
        },
    )
    study_uid = _standing(session.connection, "study", {})
    for name, factor in configuration.factors.items():
        yield (
            "factor",
            f"factor:{name}",
            {"study": study_uid, "name": name},
            {"kind": str(factor.kind), "unit": factor.unit},
        )
        factor_uid = find_uid(session.connection, "factor", study=study_uid, name=name)
        for level in factor.levels:
            yield (
                "level",
                f"level:{name}={level.label}",
                {"factor": factor_uid, "label": level.label},
                {"value": level.value, "attributes_json": canonical(dict(level.attributes))},
            )
    for name, robot in configuration.robots.items():
        values = asdict(robot)
        yield "robot", f"robot:{name}", {"name": name, "valid_from_utc": ""}, values
    for name, battery in configuration.batteries.items():
        yield (
            "battery",
            f"battery:{name}",
            {"name": name},
            {"cells": battery.cells, "capacity_mah": battery.capacity_mah},
        )
    for name, instrument in configuration.instruments.items():
        values = asdict(instrument)
        yield "instrument", f"instrument:{name}", {"name": name}, values


def _standing(connection: sa.Connection, kind: str, identity: Mapping[str, Any]) -> str | None:
    """Return the uid of a proposed row where it exists already; a book has one study, whatever its name."""
    if kind == "study":
        study = the_study(connection)
        return None if study is None else study.uid
    return find_uid(connection, kind, **identity)


def _differences(
    connection: sa.Connection, kind: str, label: str, uid: str, proposed: Mapping[str, Any]
) -> list[_Change]:
    standing = read_fact(connection, kind, uid, proposed)
    return [
        _Change(kind, label, uid, field, standing[field], value)
        for field, value in proposed.items()
        if standing[field] != value
    ]


def _unfitting_factors(connection: sa.Connection, configuration: Configuration, text_in_force: str) -> list[str]:
    """Return where the file's factors no longer fit the book's conditions; unused factors may be dropped."""
    if not conditions_by_key(connection):
        return []
    used: dict[str, set[str]] = {}
    for levels in condition_levels(connection).values():
        for name, label in levels.items():
            used.setdefault(name, set()).add(label)
    proposed = configuration.factors
    found = [
        f"the book has conditions with a level of factor {name}, and labbook.toml no longer names it: put "
        f"[factors.{name}] back as it was."
        for name in used
        if name not in proposed
    ]
    found += [
        f"labbook.toml adds factor {name}, and the book has conditions without a level of it: take [factors.{name}] "
        "out, or make another book for the wider study."
        for name in proposed
        if name not in used
    ]
    for name in proposed:
        if name in used:
            missing = used[name] - {level.label for level in proposed[name].levels}
            found += [
                f"the book has conditions with {name}={label}, and labbook.toml no longer names that level: put it "
                f"back among the levels of [factors.{name}]."
                for label in sorted(missing)
            ]
    before = parse_configuration(text_in_force, "the book's configuration").factors
    for name in used.keys() & proposed.keys():
        stands, control = before[name].control if name in before else None, proposed[name].control
        if control != stands:
            found.append(
                f"labbook.toml says {name} control = {_shown(control)}, the book has conditions under control = "
                f"{_shown(stands)}: write that there, or make another book for the other comparison."
            )
    return found


def text_without_password(text: str, configuration: Configuration) -> str:
    """Return a labbook.toml's text without its password, for the journal and for backups: who reads these needs no
    access to the database.
    """
    url = configuration.database.url
    if url is None:
        return text
    masked = hide_password(url)
    if masked != url and url not in text:
        raise InputRefused(
            "the url under [database] in labbook.toml is written with backslashes, so that its password cannot be kept "
            "out of journal and backups: write the url in single quotes, without them."
        )
    return text.replace(url, masked)


def _in_use(connection: sa.Connection) -> bool:
    """Tell whether the book's description has been built on: a day, a plan or a file."""
    return bool(day_uids(connection) or planned_runs(connection) or imported_names(connection))
