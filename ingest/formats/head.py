"""The beginning of a file, from which its format is recognised: by content, never by name."""

from __future__ import annotations

from dataclasses import dataclass

from ingest.findings import NOTE, FindingCollector
from ingest.model import Declarations
from ingest.profiles import with_profile
from ingest.text.declared import as_declared
from ingest.text.source import DEFAULT_PAGE, TextSource, is_text, open_text

HEAD_LINES = 60
"""Lines from which a format is recognised, those that a quoted cell spans counted as one."""


@dataclass(frozen=True, slots=True, eq=False)
class Head:
    """All bytes of a file, and what can be told from the first of them.

    `source` is None when the file is not text; `lines` are its first lines, decoded; `declared` what was said about it.
    """

    data: bytes
    declared: Declarations
    source: TextSource | None
    lines: tuple[str, ...]

    def first_line(self) -> str:
        """Return the first line that is not blank, without NULs, or an empty text."""
        return next((line for line in (line.replace("\0", "").strip() for line in self.lines) if line), "")


def sniff(data: bytes, declared: Declarations, findings: FindingCollector) -> Head:
    """Tell text from binary, find the profile that applies, and decode the first lines of text.

    Raises `UsageError` for an unknown encoding.
    """
    if not is_text(data):
        return Head(data, with_profile(declared, None, findings), None, ())
    source = open_text(data, declared.encoding or DEFAULT_PAGE, findings, declared.limits.longest_line_bytes)
    declared = with_profile(declared, source, findings)
    source = as_declared(source, declared, findings)
    if source.encoding != "utf-8":
        message = f"The text is not UTF-8; names are read as {source.encoding}, the page declared for such files."
        findings.add(NOTE, "encoding_declared", message)
    lines = tuple(source.decode(line.content) for line in source.head_lines(HEAD_LINES))
    return Head(data, declared, source, lines)
