"""What members hold together: the files of an archive, the sheets of a workbook, each read as a file of its own.

Parts are named after their member, and of several members, a recharge names its own. Members that hold different things
(logs and recharges) have no one role, so such a file is refused and its members are ingested one by one.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from pathlib import PurePosixPath

from data_schema.vocabulary import Severity
from ingest.channels.declared import ABSENT
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import ChargeRow, Declarations, Finding, ReadFile, Reading, SignalPart
from ingest.several import combine
from ingest.tables.header_cells import clean_name


def read_members(
    members: Sequence[tuple[str, bytes]],
    declared: Declarations,
    findings: FindingCollector,
    instead: str,
    *,
    packed_text: bool = False,
) -> Reading:
    """Read the members, each a name and its bytes, under the same declarations; `instead` ends a refusal.

    `packed_text`: the members are files of their own, whose pages of text are worth telling.
    """
    from ingest.read import read_file  # the registry that it reads by holds the formats that have members

    results = [(name, read_file(data, declared)) for name, data in members]
    _report(results, findings)
    if packed_text:
        findings.encodings += filter(None, (result.explanation.encoding for _, result in results))
    findings.tables += [table for _, result in results for table in result.explanation.tables]
    roles = {result.role for _, result in results}
    unknown = [name for name, result in results if result.role is None]
    if unknown:
        findings.add(FILE, "member_unknown", f"Member {unknown[0]!r} is no data that can be read: {instead}.")
    elif len(roles) > 1:
        listed = " and ".join(sorted(str(role) for role in roles if role is not None))
        findings.add(FILE, "members_differ", f"The members hold different things ({listed}): {instead}.")
    return combine([_reading(name, result, several=len(results) > 1) for name, result in _named(results)])


def _report(results: Sequence[tuple[str, ReadFile]], findings: FindingCollector) -> None:
    """Report what was found in each member; a declared column needs to stand in one of them only."""
    absent = Counter(finding.column for _, result in results for finding in result.findings if finding.rule == ABSENT)
    for name, result in results:
        message = f"Member {name!r} was read as {result.format}, version {result.reader_version}."
        findings.add(NOTE, "member_read", message, column=name)
        for finding in result.findings:
            if finding.rule == ABSENT and absent[finding.column] < len(results):
                continue
            repeat(finding, findings, "" if finding.severity is Severity.NOTE else f"In {name!r}: ")


def repeat(finding: Finding, findings: FindingCollector, where: str = "") -> None:
    """Report what was found in a member as found in the file, `where` before its message."""
    lines = () if finding.line is None else (finding.line, *finding.more_lines)
    findings.add(
        finding.severity,
        finding.rule,
        where + finding.message,
        column=finding.column,
        lines=lines,
        count=finding.count,
        value=finding.value,
    )


def _named(results: Sequence[tuple[str, ReadFile]]) -> list[tuple[str, ReadFile]]:
    """Return the results under names for their parts: the members' without folder and ending, all different."""
    seen: Counter[str] = Counter()
    named = []
    for number, (name, result) in enumerate(results, start=1):
        path = PurePosixPath(name)
        short = clean_name(path.stem if len(path.suffix) <= 5 and " " not in path.suffix else path.name)
        short = short or f"member_{number}"
        seen[short] += 1
        named.append((short if seen[short] == 1 else f"{short}_{seen[short]}", result))
    return named


def _reading(name: str, result: ReadFile, *, several: bool) -> Reading:
    def part_name(part: SignalPart) -> str:
        return name if len(result.parts) == 1 else f"{name}_{part.part}"

    def member(charge: ChargeRow) -> str | None:
        return "/".join(filter(None, (name, charge.member))) if several else charge.member

    charges = tuple(dataclasses.replace(charge, member=member(charge)) for charge in result.charges)
    parts = tuple(dataclasses.replace(part, part=part_name(part)) for part in result.parts)
    return Reading(parts, charges, result.rows_read, result.rows_rejected, result.role)
