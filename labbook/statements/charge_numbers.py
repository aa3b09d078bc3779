"""The number that a charge has in its file, and keeps: its uid follows from it, and people name it by it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import repeat
from typing import Any

import sqlalchemy as sa

from data_schema.queries.readings import reading_entries
from data_schema.queries.sheet_rows import rows_of_file
from ingest.model import ChargeRow

Key = tuple[str, int, int]
"""Where a charge stands: its member, its line (minus its place where it has none), and its place among those there."""


def keys_of(charges: Sequence[ChargeRow]) -> list[Key]:
    """Return where the charges of a reading stand, no two of them at one place."""
    return _keys((row.line for row in charges), (row.member for row in charges))


def keys_in(said: Mapping[str, Any]) -> list[Key]:
    """Return where the charges stand that the entry of a reading names."""
    return _keys(said.get("charge_lines") or [], said.get("charge_members") or repeat(None))


def charge_numbers(
    connection: sa.Connection, file_uid: str, new: Mapping[str, Any], keys: Sequence[Key]
) -> dict[Key, int]:
    """Return the row numbers of a file's charges, no two of them the same.

    A charge keeps the number that it had first: what an entry says comes before what the book holds, and that before
    what follows from the order of readings, for an earlier labbook did not write numbers down; those of a first reading
    are the places of its charges. `new` is the entry of the reading that gave `keys`.
    """
    members = dict(zip(_without_members(keys), keys, strict=True))  # earlier labbooks named no members
    numbers: dict[Key, int] = {}
    taken: set[int] = set()

    def give(key: Key, number: int) -> None:
        if key not in numbers and number not in taken:
            numbers[key] = number
            taken.add(number)

    unsaid: list[Key] = []
    for earlier, said in enumerate([*reading_entries(connection, new["sha256"]), new]):
        stated = keys_in(said)
        if "charge_members" not in said:
            stated = [members.get(key, key) for key in stated]
        given = said.get("charge_numbers") or (range(1, len(stated) + 1) if earlier == 0 else None)
        unsaid += stated
        for key, number in zip(stated, given or (), strict=given is not None):
            give(key, number)
    rows = rows_of_file(connection, file_uid)
    standing = _keys((row.line for row in rows), repeat(None), [row.row_number for row in rows])
    for key, row in zip(standing, rows, strict=True):
        give(members.get(key, key), row.row_number)
    following = 1 + max(taken, default=0)
    for key in (*unsaid, *keys):
        if key not in numbers:
            give(key, following)
            following += 1
    return numbers


def numbers_held(said: Mapping[str, Any], *, first: bool) -> set[int] | None:
    """Return the numbers of the charges that a reading holds by its entry; None where an earlier labbook made it and
    did not write them down, or gave one number to several charges.
    """
    lines = said.get("charge_lines")
    numbers = said.get("charge_numbers") or (range(1, len(lines) + 1) if first and lines is not None else None)
    return None if numbers is None or len(set(numbers)) < len(numbers) else set(numbers)


def _without_members(keys: Sequence[Key]) -> list[Key]:
    return _numbered([("", line) for _, line, _ in keys])


def _keys(lines: Iterable[int | None], members: Iterable[str | None], places: Sequence[int] | None = None) -> list[Key]:
    listed = list(lines)
    return _numbered(
        (member or "", -place if line is None else line)
        for line, member, place in zip(listed, members, places or range(1, len(listed) + 1), strict=False)
    )


def _numbered(stands: Iterable[tuple[str, int]]) -> list[Key]:
    """Tell those apart that stand at one place, by their order."""
    seen: Counter[tuple[str, int]] = Counter()
    keys: list[Key] = []
    for stand in stands:
        seen[stand] += 1
        keys.append((*stand, seen[stand]))
    return keys
