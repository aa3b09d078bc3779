"""Which of the declared profiles applies to a file, and what is then in force: what was said directly stands."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence
from fnmatch import fnmatchcase

from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import Declarations, Profile, ReadingSettings
from ingest.tables.header_cells import parse_header, strip_comment
from ingest.text.cells import split_cells
from ingest.text.delimiters import CANDIDATES
from ingest.text.source import TextSource


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
            for delimiter in delimiters:
                cells = split_cells(line.content, delimiter) or []
                found.append(_present([strip_comment(page.decode(cell)) for cell in cells]))
            found.append(_present([strip_comment(text)]))
    return found


def _present(names: Sequence[str]) -> frozenset[str]:
    return frozenset(names) | {parse_header(name).base for name in names}


def _completed(declared: Declarations, fitting: Sequence[Profile], findings: FindingCollector) -> Declarations:
    """Return `declared` with what the most specific profile says: more columns named first, then the longer pattern."""
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
    said = {
        setting.name: getattr(profile, setting.name)
        for setting in dataclasses.fields(ReadingSettings)
        if setting.name != "columns" and getattr(declared, setting.name) is None
    }
    return dataclasses.replace(
        declared,
        **said,
        profile_columns={**declared.profile_columns, **profile.columns},
        profile=profile.name,
        profiles=(),
    )


def _specificity(profile: Profile) -> tuple[int, int]:
    pattern = profile.files or ""
    return len(profile.recognise), sum(letter not in "*?" for letter in pattern)
