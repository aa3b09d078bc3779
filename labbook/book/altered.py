"""Rows altered outside labbook: rows of the database compared with those that the raw copies and the journal give.

A row is suspected where it does not fit the hash that was made when it was written; what it should be follows from
replaying the journal into another database.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile, zip_longest
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from data_schema.queries.reports import list_reports
from data_schema.row_hashes import GROUPS, Altered, Misfit, row_hashes, rows_of, stored_hashes
from data_schema.tables import FACTS, design
from data_schema.tables.runs import run
from labbook.book.report_numbers import reports_depending_on

MOST_NAMED = 20
"""So many groups of rows are compared value by value; a careless command alters all there are."""

_NAMES = ("name", "original_name", "label", "key", "date_local", "part", "line", "number", "position")
"""Columns by which a person knows a row, the best first."""


@dataclass(frozen=True, slots=True)
class WrongValue:
    """A value that differs from raw copies and journal; no `column` where the whole row is extra or missing."""

    table: str
    name: str
    column: str | None
    stands: Any
    should_be: Any

    @property
    def sentence(self) -> str:
        """Describe the value: where it is, what it is and what it should be."""
        if self.column is None:
            return f"{self.name} {'is missing' if self.stands is None else 'should not be there'}"
        stands, should_be = _shortened_pair(self.stands, self.should_be)
        return f"{self.name}: {self.column} is {stands} and should be {should_be}"


@dataclass(frozen=True, slots=True)
class AlteredRows:
    """Rows of one owner that were altered: the values, where it is known what they should be, and who printed them."""

    rows: Altered
    values: tuple[WrongValue, ...]
    reports: tuple[str, ...]
    hash_only: bool = False
    """Whether the rows are as they should be, so that only their hash was altered or removed."""

    @property
    def sentence(self) -> str:
        """Say what was altered, and the reports that rest on it."""
        what = "; ".join(value.sentence for value in self.values[:5]) or f"{self.rows.kind} {self.rows.uid}"
        printed = f"; reports that rest on it: {', '.join(self.reports)}" if self.reports else ""
        if self.rows.how is Misfit.MOVED:
            return f"moved in the database: {what} stands after what was stated later{printed}."
        if self.hash_only:
            return f"altered in the database: the hash of {what}, whose rows are as they should be."
        more = f" and {len(self.values) - 5} more" if len(self.values) > 5 else ""
        how = {
            Misfit.ALTERED: "altered in the database",
            Misfit.ADDED: "added to the database",
            Misfit.REMOVED: "removed from the database",
        }
        rewritten = any(value.column is not None for value in self.values)
        return f"{how[Misfit.ALTERED if rewritten else self.rows.how]}: {what}{more}{printed}."


def describe_altered(
    store: Path, book: sa.Connection, fresh: sa.Connection | None, suspected: Sequence[Altered]
) -> list[AlteredRows]:
    """Return which values of suspected rows are wrong; `fresh` holds the right ones, None where these are not known.

    The numbers of its reports are in its `store`.
    """
    found, made = [], list_reports(book)
    for item in suspected:
        values = () if fresh is None else tuple(_wrong_values(book, fresh, item))
        concerned = reports_depending_on(store, made, _inputs(book, fresh, item))
        reports = tuple(report.called for report in concerned)
        hash_only = fresh is not None and not values and item.how is not Misfit.MOVED
        found.append(AlteredRows(item, values, reports, hash_only))
    return found


def differing(book: sa.Connection, fresh: sa.Connection) -> list[Altered]:
    """Hash all rows of a book and return where they differ from those of one just made, by the hashes it has."""
    found = []
    for kind in GROUPS:
        here, there = row_hashes(book, kind), stored_hashes(fresh, kind)
        for uid in dict.fromkeys((*here, *there)):
            if here.get(uid) != there.get(uid):
                how = Misfit.REMOVED if uid not in here else Misfit.ADDED if uid not in there else Misfit.ALTERED
                found.append(Altered(kind, uid, how))
    return found


def _wrong_values(book: sa.Connection, fresh: sa.Connection, item: Altered) -> Iterable[WrongValue]:
    here, there = _by_table(book, item), _by_table(fresh, item)
    for table in dict.fromkeys((*here, *there)):
        for row, other in _pairs(here.get(table, []), there.get(table, [])):
            name = f"{table} {_name(row or other or {}, item.uid)}"
            if row is None or other is None:
                yield WrongValue(table, name, None, row, other)
                continue
            for column, value in row.items():
                if repr(value) != repr(other[column]):
                    yield WrongValue(table, name, column, value, other[column])


def _by_table(connection: sa.Connection, item: Altered) -> dict[str, list[dict[str, Any]]]:
    found: dict[str, list[dict[str, Any]]] = {}
    for table, row in rows_of(connection, item.kind, item.uid):
        found.setdefault(table, []).append(row)
    return found


def _pairs(
    here: Sequence[dict[str, Any]], there: Sequence[dict[str, Any]]
) -> Iterable[tuple[dict[str, Any] | None, dict[str, Any] | None]]:
    """Put rows beside each other by their uids, those of tables without one in their order."""
    if any("uid" in row for row in (*here, *there)):
        left, right = ({row["uid"]: row for row in rows} for rows in (here, there))
        return [(left.get(uid), right.get(uid)) for uid in dict.fromkeys((*left, *right))]
    return zip_longest(here, there)


def _name(row: Mapping[str, Any], owner: str) -> str:
    known = next((f" ({name} {row[name]})" for name in _NAMES if row.get(name) is not None), "")
    return f"{row.get('uid', f'of {owner}')}{known}"


def _inputs(book: sa.Connection, fresh: sa.Connection | None, item: Altered) -> list[tuple[str, str]]:
    """Return under which names results rest on altered rows."""
    rows = rows_of(book, item.kind, item.uid) + ([] if fresh is None else rows_of(fresh, item.kind, item.uid))
    samples = [("signal", row["sha256"]) for table, row in rows if table == "signal"]
    runs = [("run", row["run"]) for _table, row in rows if row.get("run")]
    return [(item.kind, item.uid), *samples, *runs, *_referring(book, item.kind, item.uid)]


def _referring(book: sa.Connection, kind: str, uid: str) -> list[tuple[str, str]]:
    """Return the conditions and runs that refer to a fact: those of a level, of a day, with a battery."""
    fact = FACTS.get(kind)
    if fact is None or kind in _RESTED_ON:
        return []
    found = []
    for owner in (design.level, design.condition, run):
        for member in GROUPS[owner.name][1]:
            columns = [column for column in member.table.c if column.references(fact.c.id)]
            source: sa.FromClause = member.table
            for table, on in member.joins:
                source = source.join(table, on)
            for column in columns:
                query = sa.select(owner.c.uid).select_from(source).join(fact, column == fact.c.id)
                for (other,) in book.execute(query.where(fact.c.uid == uid)):
                    found += [(owner.name, other), *_referring(book, owner.name, other)]
    return found


_RESTED_ON = ("condition", "run", "person", "study")
"""Results name the first two as their inputs; all there is refers to the others."""

_MOST_SHOWN = 60


def _shortened_pair(stands: Any, should_be: Any) -> tuple[str, str]:
    """Return two values to be read side by side; of long texts what is around the first difference."""
    texts = [str(value) for value in (stands, should_be)]
    if max(map(len, texts)) <= _MOST_SHOWN:
        return repr(stands), repr(should_be)
    same = sum(1 for _pair in takewhile(lambda pair: pair[0] == pair[1], zip(*texts, strict=False)))
    begin = max(0, same - _MOST_SHOWN // 3)
    shown = [
        f"{'...' if begin else ''}{text[begin : begin + _MOST_SHOWN]!r}"
        f"{'...' if len(text) > begin + _MOST_SHOWN else ''}"
        for text in texts
    ]
    return shown[0], shown[1]
