"""Which columns of a table the declarations mean: by name, by `name#2` among equal names, or by place from 1."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Collection, Mapping, Sequence

from data_schema.errors import nearest
from ingest.findings import NOTE, FindingCollector
from ingest.model import ColumnDeclaration, Declarations
from ingest.tables.header_cells import parse_header, squash

ABSENT = "declared_column_absent"
"""The rule of a declared column that the file does not have."""

_NUMBERED = re.compile(r"(.+)#(\d{1,4})")
_PLACE = re.compile(r"[1-9]\d{0,3}")


def positions_of(column: str, names: Sequence[str]) -> tuple[int, ...]:
    """Return the places, from 0, of the columns that a declaration means; `names` are the header's cells.

    A whole cell counts before its name without the unit, both before `name#2`, and a place only where no column is
    named so.
    """
    for spelled in (list(names), [parse_header(name).base for name in names]):
        found = tuple(position for position, name in enumerate(spelled) if name == column)
        if found:
            return found
    numbered = _NUMBERED.fullmatch(column)
    if numbered is not None:
        equal = positions_of(numbered[1], names)
        return equal[int(numbered[2]) - 1 : int(numbered[2])] if int(numbered[2]) else ()
    if _PLACE.fullmatch(column) and int(column) <= len(names):
        return (int(column) - 1,)
    return ()


def argument(text: str) -> str:
    """Return what stands behind a flag, in quotes where a shell would part it."""
    return text if re.fullmatch(r"[\w@%+=:,./#-]+", text, re.ASCII) else f'"{text}"'


def declared_columns(declared: Declarations, names: Sequence[str]) -> Mapping[int, ColumnDeclaration]:
    """Return what is declared about the columns of these names, by place from 0: directly, over what the profile says.

    Of several declarations of a column the one that means it alone counts, then the one by its whole header cell.
    """
    profile, direct = _by_position(declared.profile_columns, names), _by_position(declared.columns, names)
    return {**profile, **{position: _over(said, profile.get(position)) for position, said in direct.items()}}


def _by_position(columns: Mapping[str, ColumnDeclaration], names: Sequence[str]) -> dict[int, ColumnDeclaration]:
    found: dict[int, tuple[tuple[bool, bool], ColumnDeclaration]] = {}
    for column, said in columns.items():
        positions = positions_of(column, names)
        exactness = len(positions) == 1, column in names
        for position in positions:
            if position not in found or found[position][0] < exactness:
                found[position] = exactness, said
    return {position: said for position, (_, said) in found.items()}


def _over(said: ColumnDeclaration, profile: ColumnDeclaration | None) -> ColumnDeclaration:
    if profile is None:
        return said
    sign = said.sign if said.sign != 1 else profile.sign
    return ColumnDeclaration(said.channel or profile.channel, said.unit or profile.unit, sign)


def without(declared: Declarations, names: Collection[str]) -> Declarations:
    """Return the declarations without those of columns of these names, which another table of the file has."""
    columns, by_profile = (
        {name: said for name, said in declarations.items() if name not in names}
        for declarations in (declared.columns, declared.profile_columns)
    )
    return dataclasses.replace(declared, columns=columns, profile_columns=by_profile)


def note_absent(declared: Declarations, names: Sequence[str], findings: FindingCollector) -> None:
    """Report declarations of columns that the table does not have."""
    single = (declared.time_column, declared.date_column, declared.trials)
    for column in [*declared.columns, *declared.profile_columns, *(column for column in single if column is not None)]:
        if not positions_of(column, names):
            close = _nearest(column, names)
            hint = f"did you mean {close!r}?" if close else f"the file has {', '.join(map(repr, names[:12]))}."
            findings.add(NOTE, ABSENT, f"No column is named {column!r}: {hint}", column=column)


def _nearest(column: str, names: Sequence[str]) -> str | None:
    """Return the cell that is called so but for capitals, signs or its unit, else the one that looks most like it."""
    wanted = squash(parse_header(column).base)
    alike = [name for name in names if wanted and squash(parse_header(name).base) == wanted]
    return alike[0] if alike else nearest(column, names)
