"""Bytes of a text file: byte order mark, encoding, line ends; never a statistical guess.

Numbers are ASCII in every page met so far, so data stay bytes; only names and titles are decoded.
"""

from __future__ import annotations

import codecs
import dataclasses
import re
from dataclasses import dataclass

from data_schema.errors import UsageError
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import DEFAULT_LIMITS
from ingest.spool.mapped_bytes import beginning, blocks

DEFAULT_PAGE = "cp1252"
"""Of text that is neither marked nor UTF-8, where nothing is declared."""

HEAD_BYTES = 65_536
MOST_QUOTED_LINES = 5
"""Lines that one quoted cell may span; more means that a quote was forgotten."""

_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_PACKED = (b"PK\3\4", b"PK\5\6", b"\x1f\x8b")
"""With what zip and gzip archives begin, which may hold text as it is."""
_LINE_END = re.compile(rb"\r\n|\n|\r")
# A control character other than tab, line ends, form feed, Ctrl-Z, escape: no text holds many of these.
_CONTROL = bytes(set(range(32)) - {0x00, 0x09, 0x0A, 0x0C, 0x0D, 0x1A, 0x1B})


@dataclass(frozen=True, slots=True)
class Line:
    """One physical line without its end: 1-based number, where it starts, its bytes, whether it has an end."""

    number: int
    start: int
    content: bytes
    ended: bool


@dataclass(frozen=True, slots=True, eq=False)
class TextSource:
    """Text as ASCII-compatible bytes: `data[start:]` without byte order mark, `encoding` for the names in it.

    `first_line` is the number of the line at `start`; one longer than `longest_line_bytes` is none of a table.
    `comments` are the lines that a declared comment sign took out, as far as they may tell facts.
    """

    data: bytes
    start: int
    encoding: str
    first_line: int = 1
    longest_line_bytes: int = DEFAULT_LIMITS.longest_line_bytes
    comments: tuple[str, ...] = ()

    def decode(self, content: bytes) -> str:
        """Return text for showing and comparing; a byte that has no meaning becomes U+FFFD."""
        return content.decode(self.encoding, errors="replace")

    def head_lines(self, limit: int = 400) -> list[Line]:
        """Return the first whole lines, at most `limit`, within the longest line allowed."""
        return _join_quoted(self._lines(self.start, self.first_line, limit))

    def sample_lines(self, fraction: float, limit: int = 20) -> list[Line]:
        """Return whole lines from the given fraction of the file on; their numbers mean nothing."""
        start = self.start + int((len(self.data) - self.start) * fraction)
        return self._lines(start, 1, limit + 1)[1:]

    def lines_at(self, start: int, number: int, limit: int = 60) -> list[Line]:
        """Return at most `limit` lines from `data[start:]`, the first of which has the given number."""
        return self._lines(start, number, limit)

    def section(self, stop: int) -> TextSource:
        """Return the text up to `data[stop]`, as if the file ended there; lines keep their numbers."""
        return dataclasses.replace(self, data=beginning(self.data, stop))

    def _lines(self, start: int, number: int, limit: int) -> list[Line]:
        lines: list[Line] = []
        stop = min(len(self.data), start + self.longest_line_bytes)
        for end in _LINE_END.finditer(self.data, start, stop):
            lines.append(Line(number, start, self.data[start : end.start()], True))
            start, number = end.end(), number + 1
            if len(lines) == limit:
                return lines
        if start < stop == len(self.data):
            lines.append(Line(number, start, self.data[start:], False))
        return lines


def _join_quoted(lines: list[Line]) -> list[Line]:
    """Join lines that a quoted cell spans; a quote that the next few lines do not close stays as it is."""
    if not any(b'"' in line.content for line in lines):
        return lines
    joined: list[Line] = []
    position = 0
    while position < len(lines):
        first = lines[position]
        for spanned in range(1, MOST_QUOTED_LINES + 1):
            members = lines[position : position + spanned]
            content = b" ".join(line.content for line in members)
            if content.count(b'"') % 2 == 0:
                joined.append(Line(first.number, first.start, content, members[-1].ended))
                break
        else:
            spanned = 1
            joined.append(first)
        position += spanned
    return joined


def is_text(data: bytes) -> bool:
    """Tell text from binary by the first 64 KiB: a byte order mark, or few control characters and no field of NULs."""
    head = data[:HEAD_BYTES]
    if head.startswith(_PACKED):
        return False
    if any(head.startswith(mark) for mark, _ in _MARKS):
        return True
    control = len(head) - len(head.translate(None, _CONTROL))
    # Lost sectors of a memory card (runs of 512 NULs) occur inside text; a mostly empty head does not.
    return control * 100 <= len(head) and head.count(0) * 3 <= len(head)


def open_text(
    data: bytes, page: str, findings: FindingCollector, longest_line_bytes: int = DEFAULT_LIMITS.longest_line_bytes
) -> TextSource:
    """Find out the encoding of text: byte order mark, else strict UTF-8, else `page`.

    UTF-16 is transcoded, and line ends of old Macintosh programs (CR alone) are replaced; otherwise `data` is not
    copied.
    Raises `UsageError` when `page` is not an encoding.
    """
    try:
        codecs.lookup(page)
    except LookupError as error:
        raise UsageError(f"{page!r} is not an encoding: give one as 'cp1252', 'cp1250' or 'latin-1'.") from error
    source = dataclasses.replace(_without_mark(data, page, findings), longest_line_bytes=longest_line_bytes)
    data = source.data
    if b"\r" in data:
        if b"\n" not in data:
            findings.add(NOTE, "line_ends_cr", "Lines end with CR alone; read as line ends.")
            return dataclasses.replace(source, data=data.replace(b"\r", b"\n"))
        _note_mixed_ends(data, findings)
    return source


def _without_mark(data: bytes, page: str, findings: FindingCollector) -> TextSource:
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            if encoding == "utf-8":
                return TextSource(data, len(mark), "utf-8")
            text = data[len(mark) :].decode(encoding, errors="replace")
            findings.add(NOTE, "encoding_utf16", f"The text is {encoding.upper()}; read as such.")
            return TextSource(text.encode("utf-8", errors="replace"), 0, "utf-8")
    if data.isascii() or _is_utf8(data):
        return TextSource(data, 0, "utf-8")
    return TextSource(data, 0, page)


def _is_utf8(data: bytes) -> bool:
    decoder = codecs.getincrementaldecoder("utf-8")("strict")
    try:
        for block in blocks(data, 0, len(data)):
            decoder.decode(block)
        decoder.decode(b"", final=True)
    except UnicodeDecodeError:
        return False
    return True


def _note_mixed_ends(data: bytes, findings: FindingCollector) -> None:
    head = data[:HEAD_BYTES].rstrip(b"\r")
    crlf = head.count(b"\r\n")
    if crlf != head.count(b"\r") or crlf != head.count(b"\n"):
        findings.add(NOTE, "line_ends_mixed", "Lines end in different ways (CRLF, LF, CR); each is read as a line end.")


def refuse_long_line(source: TextSource, findings: FindingCollector) -> bool:
    """Report a first line beyond the longest allowed; such a file has no rows."""
    longest = source.longest_line_bytes
    window = source.data[source.start : source.start + longest]
    if len(source.data) - source.start <= longest or _LINE_END.search(window):
        return False
    findings.add(
        FILE,
        "line_too_long",
        f"The first line is longer than {longest} bytes (limit longest_line_bytes): this is no table of rows; export "
        "one sample a line.",
        lines=[1],
    )
    return True
