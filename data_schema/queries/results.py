"""Results with their numbers and inputs: those stored, those current, and those that no report shows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter

import sqlalchemy as sa

from data_schema.row_hashes import STALE, note_written
from data_schema.tables.base import in_chunks, insert_texts, private_keys
from data_schema.tables.journal import config
from data_schema.tables.results import report, report_item, result, result_input, result_number


@dataclass(frozen=True, slots=True)
class NumberRow:
    """One stored number."""

    uid: str
    name: str
    value: float | None
    unit: str
    se: float | None
    shared_se: float | None
    ci_low: float | None
    ci_high: float | None
    ci_level: float | None
    df: float | None
    n: int | None
    undefined_reason: str | None


@dataclass(frozen=True, slots=True)
class InputRow:
    """One input of a result."""

    role: str
    input_kind: str
    input_uid: str
    input_sha256: str


@dataclass(frozen=True, slots=True)
class ResultRow:
    """A stored result."""

    uid: str
    kind: str
    scope_json: str
    key: str
    algorithm: str
    version: int
    payload_json: str
    stale: bool
    numbers: tuple[NumberRow, ...]
    inputs: tuple[InputRow, ...]


_HEAD = ("uid", "kind", "scope_json", "key", "algorithm", "version", "payload_json")

_NUMBER = [column for column in result_number.c if column.name not in ("id", "result")]


def results_by_key(connection: sa.Connection, keys: Sequence[str] | None = None) -> dict[str, ResultRow]:
    """Return stored results by key: all of them, or those among `keys`."""
    if keys is None:
        return _results(connection, sa.true())
    found: dict[str, ResultRow] = {}
    for some in in_chunks(keys):
        found |= _results(connection, result.c.key.in_(some))
    return found


def _results(connection: sa.Connection, wanted: sa.ColumnElement[bool]) -> dict[str, ResultRow]:
    heads = connection.execute(sa.select(result).where(wanted).order_by(result.c.id)).all()
    if not heads:  # as for most of what a first report asks for
        return {}
    numbers: dict[int, list[NumberRow]] = {row.id: [] for row in heads}
    inputs: dict[int, list[InputRow]] = {row.id: [] for row in heads}
    owned = sa.select(result.c.id).where(wanted)
    for owner, *rest in connection.execute(
        sa.select(result_number.c.result, *_NUMBER)
        .where(result_number.c.result.in_(owned))
        .order_by(result_number.c.id)
    ).all():
        numbers[owner].append(NumberRow(*rest))
    for owner, *rest in connection.execute(
        sa.select(result_input)
        .where(result_input.c.result.in_(owned))
        .order_by(result_input.c.result, result_input.c.role, result_input.c.input_kind, result_input.c.input_uid)
    ).all():
        inputs[owner].append(InputRow(*rest))
    return {
        row.key: ResultRow(
            row.uid, row.kind, row.scope_json, row.key, row.algorithm, row.version, row.payload_json, bool(row.stale),
            tuple(numbers[row.id]), tuple(inputs[row.id]),
        )
        for row in heads
    }  # fmt: skip


def add_results(connection: sa.Connection, rows: Sequence[ResultRow]) -> None:
    """Store results; those of the same kind and scope but other inputs become stale."""
    _outdate(connection, rows)
    head, input_values = attrgetter(*_HEAD), attrgetter(*InputRow.__slots__)
    newest_config = connection.execute(sa.select(sa.func.max(config.c.id))).scalar()
    for some in in_chunks(rows):
        heads = [(*head(row), newest_config, 0) for row in some]
        insert_texts(connection, result, (*_HEAD, "config", "stale"), heads)
        owners = private_keys(connection, result.c.key, [row.key for row in some])
        numbers = [
            {"result": owners[row.key], **{name: getattr(number, name) for name in NumberRow.__slots__}}
            for row in some
            for number in row.numbers
        ]
        if numbers:
            connection.execute(result_number.insert(), numbers)
        inputs = [(owners[row.key], *input_values(item)) for row in some for item in row.inputs]
        insert_texts(connection, result_input, ("result", *InputRow.__slots__), inputs)
        note_written(connection, "result", [row.uid for row in some])


def mark_current(connection: sa.Connection, rows: Sequence[ResultRow]) -> None:
    """Mark stored results current again (their inputs are as before), and others of the same kind and scope stale."""
    _outdate(connection, rows)
    for some in in_chunks(rows):
        connection.execute(result.update().where(result.c.key.in_([row.key for row in some])).values(stale=0))
        note_written(connection, STALE, [row.uid for row in some])


def _outdate(connection: sa.Connection, rows: Sequence[ResultRow]) -> None:
    """Mark every stored result of the same kind and scope as one of these as stale."""
    what = sa.tuple_(result.c.kind, result.c.scope_json)
    for some in in_chunks(rows):
        rivals = what.in_([(row.kind, row.scope_json) for row in some])
        outdated = result.update().where(rivals, result.c.stale == 0).values(stale=1).returning(result.c.uid)
        note_written(connection, STALE, connection.execute(outdated).scalars().all())


def mark_stale(connection: sa.Connection, changed: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """Mark all results downstream of changed (kind, uid) pairs as stale; returns (kind, scope) of these.

    Where nothing has been computed yet, it is not asked what changed.
    """
    if connection.execute(_ANY_RESULT).first() is None:
        return []
    outdated: list[sa.Row[int, str, str, str]] = []
    for some in in_chunks(results_depending_on(connection, list(dict.fromkeys(changed)))):
        fresh = sa.and_(result.c.uid.in_(some), result.c.stale == 0)
        outdated += connection.execute(
            sa.select(result.c.id, result.c.uid, result.c.kind, result.c.scope_json).where(fresh)
        ).all()
        connection.execute(result.update().where(fresh).values(stale=1))
    note_written(connection, STALE, [row.uid for row in outdated])
    return [(row.kind, row.scope_json) for row in sorted(outdated, key=lambda row: row.id)]


_ANY_RESULT = sa.select(result.c.id).limit(1)


def results_depending_on(connection: sa.Connection, inputs: Sequence[tuple[str, str]]) -> list[str]:
    """Return the uids of all results that have one of these (kind, uid) as an input, directly or through other results.

    Step by step and kind by kind: SQLite walks through all inputs of results at each step of a recursive query, and
    where it is asked for pairs.
    """
    found: dict[str, None] = {}
    step = list(inputs)
    while step:
        by_kind: dict[str, list[str]] = {}
        for kind, uid in step:
            by_kind.setdefault(kind, []).append(uid)
        above: list[str] = []
        for kind, uids in by_kind.items():
            for some in in_chunks(uids):
                above += connection.execute(_RESTING_ON, {"kind": kind, "uids": some}).scalars()
        step = [("result", uid) for uid in dict.fromkeys(above) if uid not in found]
        found |= dict.fromkeys(above)
    return list(found)


_RESTING_ON = sa.select(result.c.uid).where(
    result.c.id.in_(
        sa.select(result_input.c.result).where(
            result_input.c.input_kind == sa.bindparam("kind"),
            result_input.c.input_uid.in_(sa.bindparam("uids", expanding=True)),
        )
    )
)
"""Built once: every statement looks up the results that depend on its changes."""


def result_of_number(connection: sa.Connection, number_uid: str) -> tuple[ResultRow, NumberRow] | None:
    """Find a number by its provenance id, and the result it belongs to."""
    key = connection.execute(
        sa.select(result.c.key)
        .join(result_number, result_number.c.result == result.c.id)
        .where(result_number.c.uid == number_uid)
    ).scalar()
    if key is None:
        return None
    found = results_by_key(connection, [key])[key]
    return found, next(number for number in found.numbers if number.uid == number_uid)


def results_by_uid(connection: sa.Connection, uids: Sequence[str]) -> dict[str, ResultRow]:
    """Return those of these results that are stored, by their uids."""
    found = [row for some in in_chunks(uids) for row in _results(connection, result.c.uid.in_(some)).values()]
    return {row.uid: row for row in found}


def current_number(connection: sa.Connection, kind: str, scope_json: str, name: str) -> tuple[float, str] | None:
    """Return (value, unit) of a number in the newest result of this kind and scope that is not stale; None without."""
    row = connection.execute(
        sa.select(result_number.c.value, result_number.c.unit)
        .join(result, result_number.c.result == result.c.id)
        .where(
            result.c.kind == kind,
            result.c.scope_json == scope_json,
            result.c.stale == 0,
            result_number.c.name == name,
            result_number.c.value.is_not(None),
        )
        .order_by(result.c.id.desc())
    ).first()
    return None if row is None else (row.value, row.unit)


def numbers_beginning(connection: sa.Connection, beginning: str) -> list[str]:
    """Return the ids with this beginning of numbers that are stored or shown in a report: three at most."""
    columns = (result_number.c.uid, report_item.c.number_uid)
    queries = [sa.select(column).where(column.startswith(beginning, autoescape=True)) for column in columns]
    return list(connection.execute(sa.union(*queries).limit(3)).scalars())


def add_report_items(connection: sa.Connection, report_uid: str, shown: Mapping[str, float | None]) -> None:
    """Store which numbers a report shows, by their ids, with the values it printed.

    Each is linked to the stored number of that id; it stays without a link where there is none.
    """
    owner = connection.execute(sa.select(report.c.id).where(report.c.uid == report_uid)).scalar_one()
    keys = private_keys(connection, result_number.c.uid, sorted(shown))
    if shown:
        connection.execute(
            report_item.insert(),
            [
                {"report": owner, "number_uid": uid, "value": shown[uid], "result_number": keys.get(uid)}
                for uid in sorted(shown)
            ],
        )
        note_written(connection, "report", [report_uid])


def unshown_results(connection: sa.Connection) -> list[str]:
    """Return the uids of the results that no report shows, and on which no shown result depends, even indirectly."""
    shown = (
        sa.select(result.c.uid)
        .distinct()
        .join(result_number, result_number.c.result == result.c.id)
        .join(report_item, report_item.c.result_number == result_number.c.id)
    )
    below = sa.select(result.c.uid, result_input.c.input_uid).join(result_input, result_input.c.result == result.c.id)
    inputs: dict[str, list[str]] = {}
    for uid, used in connection.execute(below.where(result_input.c.input_kind == "result")):
        inputs.setdefault(uid, []).append(used)
    step = list(connection.execute(shown).scalars())
    needed: set[str] = set()
    while step:
        needed.update(step)
        step = [used for uid in step for used in inputs.get(uid, ()) if used not in needed]
    return [
        uid for uid in connection.execute(sa.select(result.c.uid).order_by(result.c.id)).scalars() if uid not in needed
    ]


def remove_results(connection: sa.Connection, uids: Sequence[str]) -> None:
    """Remove results with their numbers and inputs, in a writing transaction."""
    for some in in_chunks(uids):
        keys = sa.select(result.c.id).where(result.c.uid.in_(some)).scalar_subquery()
        for table in (result_input, result_number):
            connection.execute(table.delete().where(table.c.result.in_(keys)))
        connection.execute(result.delete().where(result.c.uid.in_(some)))
        for kind in ("result", STALE):
            note_written(connection, kind, some)
