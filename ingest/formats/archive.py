"""Archives: zip, and gzip of one file. Members are read in memory, in bounds, and never unpacked onto the disk.

What members hold together, the files of an archive or the sheets of a workbook, each read as a file of its own: parts
are named after their member, and of several members, a recharge names its own. Members that hold different things (logs
and recharges) have no one role, so such a file is refused and its members are ingested one by one.
"""

from __future__ import annotations

import dataclasses
import gzip
import io
import stat
import zipfile
import zlib
from collections import Counter
from collections.abc import Sequence
from pathlib import PurePosixPath

from data_schema.vocabulary import FileRole, Severity
from ingest.channels.names import clean_name
from ingest.containers import ArchiveRefusedError, check_zip, member_bytes, workbook_kind
from ingest.declared import ABSENT
from ingest.formats.format import FileReader, Format, Head
from ingest.model import (
    FILE,
    NOTE,
    ChargeRow,
    Declarations,
    FindingCollector,
    Limits,
    ReadFile,
    Reading,
    SignalPart,
)
from ingest.signals import combine
from ingest.spool import mapped

UNPACK = "unpack the archive and ingest its files one by one"
_SHEET_PACKED = "It holds the sheet of a study, which is read as a file of its own: save each as CSV and ingest those."
_OF_THE_SYSTEM = ("__MACOSX/", ".DS_Store", "Thumbs.db", "desktop.ini")
_GZIP_BEGINS = b"\x1f\x8b"


def _recognise_zip(head: Head) -> str | None:
    is_zip = head.data.startswith((b"PK\3\4", b"PK\5\6")) and workbook_kind(head.data) is None
    return "it begins as a zip archive" if is_zip else None


def _recognise_gzip(head: Head) -> str | None:
    return "it begins as a gzip archive" if head.data.startswith(_GZIP_BEGINS) else None


def _read_zip(head: Head, findings: FindingCollector) -> Reading:
    try:
        members = _members(head.data, head.declared.limits)
        declared = _deeper(head.declared, len(head.data), sum(len(content) for _name, content in members))
    except Exception as error:  # zipfile raises many kinds for a damaged file
        return _refuse(error, findings)
    return read_members(members, declared, head.read_file, findings, UNPACK)


def _read_gzip(head: Head, findings: FindingCollector) -> Reading:
    try:
        data = _expanded(head.data, head.declared.limits)
        result = head.read_file(data, _deeper(head.declared, len(head.data), len(data)))
    except (ArchiveRefusedError, gzip.BadGzipFile, zlib.error) as error:
        return _refuse(error, findings)
    findings.tables += result.explanation.tables
    findings.encodings += filter(None, [result.explanation.encoding])
    findings.named_runs = result.named_runs
    for finding in result.findings:
        findings.repeat(finding)
    if result.role is FileRole.SHEET:
        findings.add(FILE, "sheet_packed", _SHEET_PACKED)
    return result


def _refuse(error: Exception, findings: FindingCollector) -> Reading:
    why = str(error) if isinstance(error, ArchiveRefusedError) else f"it is damaged ({error})"
    findings.add(FILE, "archive_refused", f"The archive is not read: {why}; {UNPACK}.")
    return Reading()


def _deeper(declared: Declarations, packed: int, expanded: int) -> Declarations:
    """Return the declarations for what is inside, with one level of nesting less, and the expansion that is left."""
    limits = declared.limits
    if limits.deepest_nesting < 1:
        raise ArchiveRefusedError("archives are nested too deep (limit deepest_nesting)")
    left = max(1, limits.largest_expansion * packed // max(packed, expanded))
    inside = None if declared.format in ("zip", "gzip") else declared.format
    limits = dataclasses.replace(limits, deepest_nesting=limits.deepest_nesting - 1, largest_expansion=left)
    return dataclasses.replace(declared, format=inside, limits=limits)


def _members(data: bytes, limits: Limits) -> list[tuple[str, bytes]]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        check_zip(archive, data, limits)
        wanted = [member for member in archive.infolist() if not member.is_dir() and not _is_of_the_system(member)]
        names = [member.filename for member in wanted]
        if len(set(names)) < len(names):
            raise ArchiveRefusedError("two of its members have one name")
        for member in wanted:
            _check_member(member)
        found = [(member.filename, member_bytes(archive, member)) for member in wanted]
    if not found:
        raise ArchiveRefusedError("it holds no file")
    return found


def _is_of_the_system(member: zipfile.ZipInfo) -> bool:
    last = member.filename.rpartition("/")[2]
    return member.filename.startswith(_OF_THE_SYSTEM[0]) or last in _OF_THE_SYSTEM or last.startswith("._")


def _check_member(member: zipfile.ZipInfo) -> None:
    name = member.orig_filename
    steps = name.replace("\\", "/").split("/")
    if not name or steps[0] == "" or ".." in steps or ":" in steps[0] or "\0" in name:
        raise ArchiveRefusedError(f"a member's name leads out of it ({name!r})")
    if stat.S_ISLNK(member.external_attr >> 16):
        raise ArchiveRefusedError(f"its member {name!r} is a link")
    if member.flag_bits & 1:
        raise ArchiveRefusedError(f"its member {name!r} is encrypted")
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ArchiveRefusedError(f"its member {name!r} is packed by method {member.compress_type}")


def _expanded(data: bytes, limits: Limits) -> bytes:
    """Return what a gzip archive holds, its checksums compared; several written one after another are one."""
    most = limits.most_expanded(len(data))
    packed = mapped(data) or io.BytesIO(data)
    packed.seek(0)  # mapped bytes stay where they were read to before
    with gzip.GzipFile(fileobj=packed) as archive:
        try:
            content = archive.read(most + 1)
        except EOFError as error:
            raise ArchiveRefusedError("it ends in the middle: copy it again") from error
    if len(content) > most:
        bounds = "limits largest_expansion, largest_expanded_bytes"
        raise ArchiveRefusedError(f"its {len(data)} bytes expand to more than {most} ({bounds})")
    return content


def read_members(
    members: Sequence[tuple[str, bytes]],
    declared: Declarations,
    read_file: FileReader,
    findings: FindingCollector,
    instead: str,
    *,
    of_workbook: bool = False,
) -> Reading:
    """Read the members, each a name and its bytes, under the same declarations; `instead` ends a refusal.

    Of a workbook, a few lines without a time column are left out where another sheet is a whole log, and its only sheet
    may be a study's. Otherwise members are files of their own, whose pages of text are reported.
    """
    results = [(name, read_file(data, declared)) for name, data in members]
    if of_workbook:
        results = _without_few_lines(members, results, findings)
    else:
        findings.encodings += filter(None, (result.explanation.encoding for _, result in results))
    _report(results, findings)
    if len(results) == 1:
        findings.named_runs = results[0][1].named_runs
    findings.tables += [table for _, result in results for table in result.explanation.tables]
    roles = {result.role for _, result in results}
    unknown = [name for name, result in results if result.role is None]
    if unknown:
        findings.add(FILE, "member_unknown", f"Member {unknown[0]!r} is no data that can be read: {instead}.")
    elif FileRole.SHEET in roles and of_workbook and len(results) == 1:
        result = results[0][1]
        packed = result.format, result.reader_version
        return Reading(rows_read=result.rows_read, role=FileRole.SHEET, packed=packed)
    elif FileRole.SHEET in roles:
        findings.add(FILE, "sheet_packed", _SHEET_PACKED)
    elif len(roles) > 1:
        listed = " and ".join(sorted(str(role) for role in roles if role is not None))
        findings.add(FILE, "members_differ", f"The members hold different things ({listed}): {instead}.")
    return combine([_reading(name, result, several=len(results) > 1) for name, result in _named(results)])


_FEW = 0.1
"""Of the lines of the whole log beside them, so many at most are its settings or its summary."""


def _without_few_lines(
    members: Sequence[tuple[str, bytes]], results: Sequence[tuple[str, ReadFile]], findings: FindingCollector
) -> list[tuple[str, ReadFile]]:
    """Return the results without those of a few lines beside a whole log, which describe it and hold no time."""
    counts = [data.count(b"\n") for _, data in members]
    whole = [count for count, (_, result) in zip(counts, results, strict=True) if result.parts and not result.refused]
    most = _FEW * max(whole, default=0)
    chosen = []
    for count, (name, result) in zip(counts, results, strict=True):
        timed = any(column.holds == "time" for table in result.explanation.tables for column in table.columns)
        if count > most or timed or result.role not in (FileRole.LOG, None):
            chosen.append((name, result))
            continue
        message = f"Member {name!r} has {count} lines and no time, beside a whole log: it stays in the raw copy only."
        findings.add(NOTE, "member_left_out", message, column=name)
    return chosen


def _report(results: Sequence[tuple[str, ReadFile]], findings: FindingCollector) -> None:
    """Report what was found in each member; a declared column needs to stand in one of them only."""
    absent = Counter(finding.column for _, result in results for finding in result.findings if finding.rule == ABSENT)
    for name, result in results:
        message = f"Member {name!r} was read as {result.format}, version {result.reader_version}."
        findings.add(NOTE, "member_read", message, column=name)
        for finding in result.findings:
            if finding.rule == ABSENT and absent[finding.column] < len(results):
                continue
            findings.repeat(finding, "" if finding.severity is Severity.NOTE else f"In {name!r}: ")


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
    return dataclasses.replace(result, parts=parts, charges=charges)


ZIP = Format("zip", 4, _recognise_zip, _read_zip, container=True, begins=b"PK")
GZIP = Format("gzip", 4, _recognise_gzip, _read_gzip, container=True, begins=_GZIP_BEGINS)
