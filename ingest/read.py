"""Reads one file: recognises its format by content, lets that format's reader work, and gives the verdict."""

from __future__ import annotations

import re
from collections.abc import Sequence

from data_schema.errors import unknown_name
from data_schema.vocabulary import FileRole
from ingest.channels.columns import count_by_rate_flags
from ingest.formats import registry
from ingest.formats.chargers.sheet import check_packs
from ingest.formats.format import UNKNOWN, Format, Head, sniff
from ingest.model import FILE, Candidate, Declarations, Explanation, FindingCollector, ReadFile, Reading
from ingest.tables.layout import SecondHeader
from ingest.text import GROUPED, looks_like_utf16
from ingest.timebase.axis import FAULTS_OF_TIME

MOST_REJECTED = 0.01
"""A log of which a larger share of rows is rejected is refused."""
MOST_REJECTED_RECHARGES = 0.5
"""So is a sheet of recharges, whose rows stand each for itself: where most cannot be read, the columns are others."""
MOST_EQUAL = 0.1
"""Of a larger share of stamps that equal the one before, the clock stands still, or rows are written twice."""


def read_file(data: bytes, declared: Declarations) -> ReadFile:
    """Read the bytes of one file under the given declarations; nothing else has any influence.

    All findings are reported at once. Raises `UsageError` when a declaration itself has no meaning (an encoding, a time
    zone, a format).
    """
    findings = FindingCollector()
    head = sniff(data, declared, findings, read_file)
    candidates = [] if findings.refuse else _candidates(head, findings)
    chosen, evidence = (None, "") if findings.refuse else _chosen(head, candidates, findings)
    if chosen is None:
        reading = Reading()
        if not findings.refuse:
            _report_unknown(head, findings)
    else:
        try:
            reading = registry.reading(chosen, head, findings)
        except SecondHeader as found:
            reading = Reading()
            message = "Another header stands inside the data: export one table a file."
            findings.add(FILE, "second_header", message, lines=[found.header_line])
        if head.declared.packs and reading.charges:
            reading = check_packs(reading, head.declared.packs, findings)
        _judge_rows(reading, findings)
    name, version = reading.packed or ((UNKNOWN, 0) if chosen is None else (chosen.name, chosen.version))
    return ReadFile(
        reading.parts,
        reading.charges,
        reading.rows_read,
        reading.rows_rejected,
        reading.role,
        reading.declared or head.declared,
        format=name,
        reader_version=version,
        findings=findings.findings(),
        evidence=evidence,
        plugin=None if chosen is None else chosen.plugin,
        explanation=Explanation(
            ", ".join(dict.fromkeys(findings.encodings)) or None if head.source is None else head.source.encoding,
            tuple(Candidate(format_.name, format_.score, evidence) for format_, evidence in candidates),
            tuple(findings.tables),
        ),
        named_runs=_named_runs(head, findings),
    )


_RUN = re.compile(
    r"(?i)\b(?:run|trial|experiment|exp|test)(?:[ _-]*(?:name|id|no|number))?\b[\s:=.#,;|\"']+(?P<name>\w[\w.+-]*)"
)


def _named_runs(head: Head, findings: FindingCollector) -> tuple[str, ...]:
    """Return the words that stand for the name of a run in the lines above the first table, `# run r012`, be it in an
    archive of one file.
    """
    shape = findings.tables[0].text if findings.tables else None
    if head.source is None or shape is None:
        return findings.named_runs
    end = shape.header_line or shape.first_line
    above = [head.source.decode(line.content) for line in head.source.head_lines() if line.number < end]
    found = [match["name"] for text in (*head.source.comments, *above) for match in _RUN.finditer(text)]
    return tuple(dict.fromkeys(found))


def _chosen(
    head: Head, candidates: Sequence[tuple[Format, str]], findings: FindingCollector
) -> tuple[Format | None, str]:
    """Return the format that reads, and by what evidence: the one declared, or the one that scores highest."""
    declared = None if head.declared.format is None else _named(head.declared.format)
    best = [each for each in candidates if each[0].score == candidates[0][0].score]
    is_container = len(best) == 1 and best[0][0].container
    if declared is not None and (declared.container or not is_container):
        return declared, "declared"
    if not candidates:
        return None, ""
    if len(best) > 1:
        listed = " and as ".join(f"{format_.name} ({evidence})" for format_, evidence in best)
        which = " or ".join(f"`--format {format_.name}`" for format_, _ in best if format_ not in registry.RECOGNISED)
        message = f"The file can be read as {listed}: say which with {which}."
        findings.add(FILE, "format_ambiguous", message)
        return None, ""
    return best[0]


def _candidates(head: Head, findings: FindingCollector) -> list[tuple[Format, str]]:
    """Return the formats that recognise the file, the one with the highest score first."""
    asked = (each for each in registry.all_formats() if each.may_be(head))
    found = [(each, seen) for each in asked if (seen := registry.recognition(each, head, findings)) is not None]
    return sorted(found, key=lambda each: -each[0].score)


def _named(name: str) -> Format:
    by_name = {format_.name: format_ for format_ in registry.all_formats()}
    if name not in by_name:
        raise unknown_name("format", name, by_name, "`labbook formats` lists all.")
    return by_name[name]


def _report_unknown(head: Head, findings: FindingCollector) -> None:
    if head.source is not None or not head.data:
        message = "The file is empty: copy it again from the instrument."
        findings.add(FILE, "file_empty", message)
    else:
        beginning = head.data[:8].hex(" ")
        page = looks_like_utf16(head.data)
        message = f"The file is neither text nor a format known here (it begins with {beginning}): "
        message += f"if it is text, say `--encoding {page}`." if page else "export it as delimited text."
        findings.add(FILE, "format_unknown", message, value=beginning)


def _judge_rows(reading: Reading, findings: FindingCollector) -> None:
    """Refuse a file of which nothing, or not enough, is left, rows within one tick of a coarse clock counted in."""
    equal = findings.count("time_duplicate")
    rejected = reading.rows_rejected - (equal if equal <= MOST_EQUAL * reading.rows_read else 0)
    if not reading.rows_read:
        if not findings.refuse:
            findings.add(FILE, "no_rows_kept", "The file holds no row of data.")
    elif rejected <= _most_rejected(reading) * reading.rows_read:
        return
    elif 2 * findings.count(GROUPED.rule) > reading.rows_rejected:
        message = "Numbers hold thousands separators, and may be misread by 1000: export without them."
        findings.refuse_for(GROUPED.rule, message)
    elif reading.rows_rejected == reading.rows_read:
        if not findings.refuse:
            findings.add(FILE, "no_rows_kept", f"None of the {reading.rows_read} rows could be read.")
    else:
        share = min(100 * reading.rows_rejected / reading.rows_read, 99.9)
        findings.add(
            FILE,
            "too_many_rejected",
            f"{reading.rows_rejected} of {reading.rows_read} rows ({share:.3g} %) are rejected, more than "
            f"{100 * _most_rejected(reading):g} %: correct the lines that the findings name, or export the file again"
            f"{_rate_advice(reading, findings)}.",
        )


def _rate_advice(reading: Reading, findings: FindingCollector) -> str:
    """Return how samples are counted by their rate, where most rows are rejected for their time."""
    rules = (*FAULTS_OF_TIME, "time_missing")
    faults = [finding for finding in findings.findings() if finding.rule in rules and finding.column]
    if 2 * sum(finding.count for finding in faults) <= reading.rows_rejected:
        return ""
    return f"; if samples were taken evenly, count them by the rate, {count_by_rate_flags(faults[0].column or '')}"


def _most_rejected(reading: Reading) -> float:
    return MOST_REJECTED_RECHARGES if reading.role is FileRole.CHARGE and not reading.parts else MOST_REJECTED
