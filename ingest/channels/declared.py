"""What is declared about one file: the command line over the one profile that recognises its header."""

from __future__ import annotations

import dataclasses

from data_schema.errors import nearest
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import ColumnDeclaration, Declarations, Profile
from ingest.tables.header_cells import parse_header


def declarations_for(declared: Declarations, names: tuple[str, ...], findings: FindingCollector) -> Declarations:
    """Return `declared` completed by the profile for a header of these names; what was said directly stands."""
    profile = _profile_for(declared.profiles, names, findings)
    if profile is not None:
        findings.add(NOTE, "profile_used", f"Read with profile {profile.name!r}.")
        declared = dataclasses.replace(
            declared,
            rate_hz=declared.rate_hz if declared.rate_hz is not None else profile.rate_hz,
            time_column=declared.time_column or profile.time_column,
            time_unit=declared.time_unit or profile.time_unit,
            columns={**profile.columns, **declared.columns},
        )
    _note_absent(declared, names, findings)
    return declared


def column_declaration(declared: Declarations, name: str, base: str) -> ColumnDeclaration | None:
    """Return what is declared about a column, by its full header cell or by its name without the unit."""
    return declared.columns.get(name) or declared.columns.get(base)


def _profile_for(profiles: tuple[Profile, ...], names: tuple[str, ...], findings: FindingCollector) -> Profile | None:
    present = set(names) | {parse_header(name).base for name in names}
    fitting = [profile for profile in profiles if profile.recognise and present.issuperset(profile.recognise)]
    most = max((len(profile.recognise) for profile in fitting), default=0)
    closest = [profile for profile in fitting if len(profile.recognise) == most]
    if len(closest) > 1:
        listed = " and ".join(repr(profile.name) for profile in closest)
        findings.add(
            FILE,
            "profile_ambiguous",
            f"Profiles {listed} recognise this file equally: add a column name to `recognise` of the right one.",
        )
        return None
    return closest[0] if closest else None


def _note_absent(declared: Declarations, names: tuple[str, ...], findings: FindingCollector) -> None:
    present = set(names) | {parse_header(name).base for name in names}
    wanted = list(declared.columns)
    if declared.time_column is not None:
        wanted.append(declared.time_column)
    for name in wanted:
        if name not in present:
            close = nearest(name, names)
            hint = f"did you mean {close!r}?" if close else f"the file has {', '.join(map(repr, names[:12]))}."
            findings.add(NOTE, "declared_column_absent", f"No column is named {name!r}: {hint}", column=name)
