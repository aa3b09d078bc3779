"""What was declared about a file: the profile that applies to it, and the columns of a table that are meant.

A direct declaration takes precedence over a profile. A column is named by its name, by `name#2` among equal names, or
by its place from 1.
"""

from __future__ import annotations

import dataclasses
import re
import unicodedata
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from fnmatch import fnmatchcase

import msgspec

from data_schema.errors import nearest
from ingest.channels.names import parse_header, squash, strip_comment
from ingest.model import (
    FILE,
    NOTE,
    ColumnDeclaration,
    Declarations,
    FindingCollector,
    Profile,
    ReadingSettings,
    TableUse,
)
from ingest.text import CANDIDATES, TextSource, texts_of


def composed(declared: Declarations) -> Declarations:
    """Return declarations with the letters of all texts composed (NFC), as those of a file's text are."""
    text = unicodedata.normalize("NFC", msgspec.json.encode(declared).decode())
    return msgspec.json.decode(text.encode(), type=Declarations)


def with_profile(declared: Declarations, source: TextSource | None, findings: FindingCollector) -> Declarations:
    """Return `declared` completed by the profile for a file, as far as its name and its first lines show one."""
    if not declared.profiles:
        return declared
    fitting = [profile for profile in declared.profiles if _fits(profile, declared, _headers(profile, source))]
    return _completed(declared, fitting, findings)


def with_profile_for_names(declared: Declarations, names: Sequence[str], findings: FindingCollector) -> Declarations:
    """Return `declared` completed by the profile for a table of these columns, where none was found before."""
    if declared.profile is not None or not declared.profiles:
        return declared
    present = _present(names)
    return _completed(declared, [p for p in declared.profiles if _fits(p, declared, [present])], findings)


def _fits(profile: Profile, declared: Declarations, headers: Sequence[Collection[str]]) -> bool:
    if declared.profile is not None:
        return profile.name == declared.profile
    if profile.files is not None:
        if declared.file_name is None or not fnmatchcase(declared.file_name.lower(), profile.files.lower()):
            return False
    elif not profile.recognise:
        return False
    return not profile.recognise or any(set(header).issuperset(profile.recognise) for header in headers)


def _headers(profile: Profile, source: TextSource | None) -> list[frozenset[str]]:
    """Return the names in those of the first lines that may hold all the profile asks for, under each delimiter."""
    if source is None or not profile.recognise:
        return []
    encoding = source.encoding if source.encoding == "utf-8" else profile.encoding or source.encoding
    page = dataclasses.replace(source, encoding=encoding)
    delimiters = CANDIDATES if profile.delimiter is None else (profile.delimiter.encode("latin-1", "replace"),)
    found = []
    for line in source.head_lines():
        text = page.decode(line.content)
        if all(name in text for name in profile.recognise):
            rows = [texts_of(page, line, delimiter) for delimiter in delimiters if delimiter in line.content]
            found += [_present(list(map(strip_comment, cells))) for cells in [*rows, [text]]]
    return found


def _present(names: Sequence[str]) -> frozenset[str]:
    return frozenset(names) | {parse_header(name).base for name in names}


def _completed(declared: Declarations, fitting: Sequence[Profile], findings: FindingCollector) -> Declarations:
    """Return `declared` completed by the most specific profile: the one with more columns, then the longer pattern."""
    if not fitting:
        return declared
    highest = max(map(_specificity, fitting))
    closest = [profile for profile in fitting if _specificity(profile) == highest]
    if len(closest) > 1:
        listed = " and ".join(repr(profile.name) for profile in closest)
        message = f"Profiles {listed} fit this file equally: say which with `--profile {closest[0].name}`, "
        message += "or let one of them ask for more in `recognise` or `files`."
        findings.add(FILE, "profile_ambiguous", message)
        return dataclasses.replace(declared, profiles=())
    (profile,) = closest
    findings.add(NOTE, "profile_used", f"Read with profile {profile.name!r}.")
    settings = {
        setting.name: getattr(profile, setting.name)
        for setting in dataclasses.fields(ReadingSettings)
        if setting.name != "columns" and getattr(declared, setting.name) is None
    }
    return dataclasses.replace(
        declared,
        **settings,
        profile_columns={**declared.profile_columns, **profile.columns},
        profile=profile.name,
        profiles=(),
    )


def _specificity(profile: Profile) -> tuple[int, int]:
    pattern = profile.files or ""
    return len(profile.recognise), sum(letter not in "*?" for letter in pattern)


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
    """Return the value of a flag, in quotes where a shell would split it."""
    return text if re.fullmatch(r"[\w@%+=:,./#-]+", text, re.ASCII) else f'"{text}"'


_LONGEST_FLAG = 60
_OF_SHELL = frozenset('"`$\\!')


def flag_names(names: Sequence[str]) -> tuple[str, ...]:
    """Return how a flag names each column so that it means no other: its name without the unit, else its whole header
    cell, `#2` behind the second of equal ones, else its place. `names` are the header's cells.
    """
    bases = [parse_header(name).base for name in names]
    whole, by_base = Counter(names), Counter(bases)
    seen: Counter[str] = Counter()
    found = []
    for place, (name, base) in enumerate(zip(names, bases, strict=True), start=1):
        seen[name] += 1
        if _can_stand(base) and (whole[base] == 1 if name == base else not whole[base] and by_base[base] == 1):
            found.append(base)
        elif _can_stand(name):
            found.append(name if whole[name] == 1 else f"{name}#{seen[name]}")
        else:
            found.append(str(place))
    return tuple(found)


def flag_of(tables: Iterable[TableUse], column: str) -> str:
    """Return how flags name a column of the first table that has it; its name where none has."""
    for table in tables:
        names = [each.name for each in table.columns]
        if column in names:
            return flag_names(names)[names.index(column)]
    return column


def _can_stand(name: str) -> bool:
    """Whether a shell takes a name, in quotes, as it is, and `--column` takes it for a name."""
    fits = 0 < len(name) <= _LONGEST_FLAG and name == name.strip() and name.isprintable()
    return fits and not _OF_SHELL.intersection(name)


def declared_columns(declared: Declarations, names: Sequence[str]) -> Mapping[int, ColumnDeclaration]:
    """Return the declarations of the columns of these names, by place from 0: direct ones, then those of the profile.

    Of several declarations of a column each fact is that of the one that means it alone, then of the one by its whole
    header cell.
    """
    profile, direct = _by_position(declared.profile_columns, names), _by_position(declared.columns, names)
    both = {position: _merged(own, profile[position]) for position, own in direct.items() if position in profile}
    return {**profile, **direct, **both}


def _by_position(columns: Mapping[str, ColumnDeclaration], names: Sequence[str]) -> dict[int, ColumnDeclaration]:
    found: dict[int, ColumnDeclaration] = {}
    meant = [(positions_of(column, names), column in names, declaration) for column, declaration in columns.items()]
    for positions, _, declaration in sorted(meant, key=lambda each: (len(each[0]) != 1, not each[1])):
        found |= {
            position: _merged(found[position], declaration) if position in found else declaration
            for position in positions
        }
    return found


def _merged(first: ColumnDeclaration, other: ColumnDeclaration) -> ColumnDeclaration:
    """Return a declaration completed by another one."""
    measured = first if first.unit or first.calibrations else other  # a calibration is one in its unit
    return ColumnDeclaration(
        first.channel or other.channel, measured.unit, first.sign or other.sign, measured.calibrations
    )


def without(declared: Declarations, names: Collection[str]) -> Declarations:
    """Return the declarations without those of columns of these names, which another table of the file has."""
    columns, by_profile = (
        {name: declaration for name, declaration in declarations.items() if name not in names}
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
    """Return the cell of this name, ignoring capitals, signs and its unit, else the most similar one."""
    wanted = squash(parse_header(column).base)
    alike = [name for name in names if wanted and squash(parse_header(name).base) == wanted]
    return alike[0] if alike else nearest(column, names)
