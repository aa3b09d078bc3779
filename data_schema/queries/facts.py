"""Writing and reading the facts that people state, by kind and uid; references are uids on the outside.

Why a table refuses a row is put in words from the table's constraints, the same for both databases.
"""

from __future__ import annotations

import contextlib
import functools
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import sqlalchemy as sa

from data_schema.errors import InputRefused, UnknownName
from data_schema.tables import FACTS
from data_schema.tables.base import private_keys
from data_schema.tables.plain import change, fetch, insert


def insert_fact(connection: sa.Connection, kind: str, uid: str, values: Mapping[str, Any]) -> int:
    """Add one row; returns its private key. Raises `InputRefused` when the tables' rules forbid it."""
    table = FACTS[kind]
    row = _with_keys(connection, table, values)
    try:
        key = insert(connection, table, {"uid": uid, **row})
    except (sa.exc.StatementError, OverflowError, ValueError) as error:
        _pass_on_trouble(error)
        raise InputRefused(f"{kind} {_shown(values)} cannot be stored: {why_refused(error, table, values)}.") from error
    if (known := connection.info.get(_KNOWN)) is not None:
        known[table.name, uid] = key
    return key


def update_fact(connection: sa.Connection, kind: str, uid: str, values: Mapping[str, Any]) -> None:
    """Change columns of one row; raises `InputRefused` when the tables' rules forbid it."""
    table = FACTS[kind]
    row = _with_keys(connection, table, values)
    try:
        changed = change(connection, _update_row(kind), {"this_uid": uid, **row})
    except (sa.exc.StatementError, OverflowError, ValueError) as error:
        _pass_on_trouble(error)
        raise InputRefused(f"{kind} {_shown(values)} cannot be stored: {why_refused(error, table, values)}.") from error
    if changed != 1:
        raise UnknownName(f"there is no {kind} with uid {uid!r}: list what there is and use a name from there.")


def read_fact(connection: sa.Connection, kind: str, uid: str, columns: Iterable[str] | None = None) -> dict[str, Any]:
    """Return columns of one row by name, references as uids; all columns when none are named."""
    table = FACTS[kind]
    names = (
        [column.name for column in table.c if column.name not in ("id", "uid")] if columns is None else list(columns)
    )
    found = fetch(connection, _select_columns(kind, tuple(names)), {"this_uid": uid})
    if not found:
        raise UnknownName(f"there is no {kind} with uid {uid!r}: list what there is and use a name from there.")
    return dict(zip(names, found[0], strict=True))


def find_uid(connection: sa.Connection, kind: str, **natural: Any) -> str | None:
    """Return the uid of the row with these values (references as uids), or None."""
    table = FACTS[kind]
    row = _with_keys(connection, table, natural)
    given = {name: value for name, value in row.items() if value is not None}
    blank = tuple(name for name in row if name not in given)
    found = fetch(connection, _select_uid(kind, tuple(given), blank), given)
    return found[0][0] if found else None


def fact_exists(connection: sa.Connection, kind: str, uid: str) -> bool:
    """Tell whether there is such a row."""
    return find_uid(connection, kind, uid=uid) is not None


def key_of(connection: sa.Connection, kind: str, uid: str) -> int:
    """Return the private key of a row."""
    table = FACTS[kind]
    known: Keys = connection.info.get(_KNOWN, {})
    key = known.get((table.name, uid))
    if key is None:
        key = private_keys(connection, table.c.uid, [uid]).get(uid)
    if key is None:
        raise UnknownName(f"there is no {kind} with uid {uid!r}: list what there is and use a name from there.")
    return key


Keys = dict[tuple[str, str], int]
"""Private keys by table and uid."""
_KNOWN = "labbook_keys"


@contextlib.contextmanager
def remembering_keys(connection: sa.Connection, known: Keys) -> Iterator[None]:
    """Ask the database only once for the key of a row, in a transaction of which no part is rolled back.

    For a replay, in which one query in three would ask for keys. `known` are those of rows that stand already.
    """
    info = connection.info  # of a connection that is lost it cannot be asked for
    info[_KNOWN] = known
    try:
        yield
    finally:
        del info[_KNOWN]


def _referred(column: sa.Column[Any]) -> sa.Table | None:
    for foreign in column.foreign_keys:
        return foreign.column.table
    return None


def _with_keys(connection: sa.Connection, table: sa.Table, values: Mapping[str, Any]) -> dict[str, Any]:
    """Put private keys where the values name rows by their uids; all of them are looked up in one query."""
    referred = _references(table.name)
    uids = {name: uid for name, uid in values.items() if uid is not None and name in referred}
    known: Keys = connection.info.get(_KNOWN, {})
    found = {name: key for name, uid in uids.items() if (key := known.get((referred[name], uid))) is not None}
    asked = {name: uids[name] for name in uids if name not in found}
    if asked:
        keys = dict(zip(asked, fetch(connection, _select_keys(table.name, tuple(asked)), asked)[0], strict=True))
        for name, key in keys.items():
            if key is None:
                raise UnknownName(
                    f"there is no {name} with uid {uids[name]!r}: list what there is and use a name from there."
                )
            known[referred[name], uids[name]] = key
        found |= keys
    return {**values, **found}


@functools.cache
def _references(kind: str) -> dict[str, str]:
    """Return the tables that the references of a kind's table refer to, by their names."""
    referred = {column.name: _referred(column) for column in FACTS[kind].c}
    return {name: table.name for name, table in referred.items() if table is not None}


# A sheet of runs writes thousands of rows of few shapes: building a query takes longer than asking it.
@functools.cache
def _select_keys(kind: str, names: tuple[str, ...]) -> sa.Select[Any]:
    """Select the private keys behind the uids given for these references."""
    found = []
    for name in names:
        referred = _referred(FACTS[kind].c[name])
        assert referred is not None  # noqa: S101 - `_with_keys` asks for references only
        found.append(sa.select(referred.c.id).where(referred.c.uid == sa.bindparam(name)).scalar_subquery().label(name))
    return sa.select(*found)


@functools.cache
def _select_uid(kind: str, given: tuple[str, ...], blank: tuple[str, ...]) -> sa.Select[Any]:
    """Select the uid of the row with the values given under the names of these columns, and none in the blank ones."""
    table = FACTS[kind]
    matches = [table.c[name] == sa.bindparam(name) for name in given]
    return sa.select(table.c.uid).where(*matches, *(table.c[name].is_(None) for name in blank))


@functools.cache
def _select_columns(kind: str, names: tuple[str, ...]) -> sa.Select[Any]:
    """Select columns of the row with the uid `this_uid`."""
    table = FACTS[kind]
    columns = [_public_column(table.c[name]).label(name) for name in names]
    return sa.select(*columns).where(table.c.uid == sa.bindparam("this_uid"))


@functools.cache
def _update_row(kind: str) -> sa.Update:
    """Change the columns that are given of the row with the uid `this_uid`."""
    table = FACTS[kind]
    return table.update().where(table.c.uid == sa.bindparam("this_uid"))


def _public_column(column: sa.Column[Any]) -> sa.ColumnElement[Any]:
    """Select a column as it looks from outside: a reference is the uid of the row it refers to."""
    referred = _referred(column)
    if referred is None:
        return column
    other = referred.alias()
    return sa.select(other.c.uid).where(other.c.id == column).scalar_subquery()


def _shown(values: Mapping[str, Any]) -> str:
    for name in ("name", "key", "label", "date_local"):
        if values.get(name):
            return str(values[name])
    return ", ".join(f"{name}={value}" for name, value in values.items())


def _pass_on_trouble(error: Exception) -> None:
    """Raise again what is not about the values: locks, rights, a full disk, damage."""
    if isinstance(error, sa.exc.OperationalError) or type(error) is sa.exc.DatabaseError:
        raise error


_COMPARISON = re.compile(r"(?:(\w+) IS NULL OR )?(\w+) (>=|<=|>|<) (-?[\w.]+)")
_CHOICE = re.compile(r"(?:\w+ IS NULL OR )?(\w+) IN \((.+)\)")
_BOUNDS = {">=": "{} or more", "<=": "{} or less", ">": "more than {}", "<": "less than {}"}
_CALLED_BY = ("name", "key", "label", "date_local")
"""Columns by which people call a row."""


def why_refused(error: Exception, table: sa.Table, values: Mapping[str, Any]) -> str:
    """Say which rule of `table` the `values` break and what it allows; any other message is returned as it is."""
    original = getattr(error, "orig", None) or error
    message = str(original).strip().splitlines()[0]
    if isinstance(original, OverflowError) or "out of range" in message:
        return f"a whole number goes from {-(2**63)} to {2**63 - 1}"
    words = set(re.findall(r"\w+", message))
    for rule in table.constraints:
        if isinstance(rule, sa.CheckConstraint) and rule.name in words:
            return rule_in_words(rule)
        if isinstance(rule, sa.UniqueConstraint) and (rule.name in words or _named_by_columns(rule, message)):
            return _duplicate_message(table.name, [column.name for column in rule.columns], values)
    return message


def rule_in_words(rule: sa.CheckConstraint) -> str:
    """Say what a check demands: `jumps_made >= 0` is "jumps_made must be 0 or more"."""
    test = str(rule.sqltext)
    comparison = _COMPARISON.fullmatch(test)
    if comparison is not None:
        absent, column, sign, bound = comparison.groups()
        return f"{column} must be {_BOUNDS[sign].format(bound)}{'' if absent is None else ', or not known'}"
    choice = _CHOICE.fullmatch(test)
    if choice is not None:
        return f"{choice[1]} must be one of {choice[2].replace(chr(39), '')}"
    return f"it must hold that {test}"


def _named_by_columns(rule: sa.UniqueConstraint, message: str) -> bool:
    """SQLite names the columns of a key that is there already, not the constraint."""
    columns = ", ".join(f"{column.table.name}.{column.name}" for column in rule.columns)
    return message.removeprefix("UNIQUE constraint failed: ") == columns


def _duplicate_message(kind: str, columns: list[str], values: Mapping[str, Any]) -> str:
    called = next((values[name] for name in _CALLED_BY if name in columns and name in values), None)
    if called is not None:
        return f"there is a {kind} {called} already"
    return f"there is a {kind} with the same {' and '.join(columns)} already"
