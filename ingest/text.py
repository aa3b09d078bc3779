"""Bytes of a text file to lines, and lines to cells: encodings, line ends, quotes, delimiters, the value of a cell.

Never by a statistical guess. Numbers are ASCII in every page met so far, so data stay bytes; only names and titles are
decoded. Only ASCII spellings count as numbers: Python's own `float` would also take `1_000` and Arabic digits.
"""

from __future__ import annotations

import codecs
import csv
import dataclasses
import functools
import re
import unicodedata
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from data_schema.errors import UsageError
from ingest.model import DEFAULT_LIMITS, FILE, MORE_LINES, NOTE, ROW, Declarations, FindingCollector
from ingest.spool import BLOCK_BYTES, beginning, blocks, release_bytes

DEFAULT_PAGE = "cp1252"
"""Of text that is neither marked nor UTF-8, where nothing is declared."""

HEAD_BYTES = 65_536
HEAD_LINES = 400
MOST_QUOTED_LINES = 5
"""Lines that the quoted cells of a row may span; more means that a quote was forgotten."""
SEPARATORS = b"\t;,|"
"""What may stand between cells, a byte each, where it is not known yet."""

_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_PACKED = (b"PK\3\4", b"PK\5\6", b"\x1f\x8b")
"""With what zip and gzip archives begin, which may hold text as it is."""
_MINUS = "\N{MINUS SIGN}".encode()
"""As typeset; a number's sign is a hyphen."""
_LINE_END = re.compile(rb"\r\n|\n|\r")
# A control character other than tab, line ends, form feed, Ctrl-Z, escape: no text holds many of these.
_CONTROL = bytes(set(range(32)) - {0x00, 0x09, 0x0A, 0x0C, 0x0D, 0x1A, 0x1B})


class Line(NamedTuple):  # of which a file has hundreds: a tuple is made in a quarter of a dataclass's time
    """A line without its end, or lines joined: 1-based number, where it starts, its bytes, whether it has an end."""

    number: int
    start: int
    content: bytes
    ended: bool


@dataclass(frozen=True, eq=False)
class TextSource:
    """Text as ASCII-compatible bytes: `data[start:]` without byte order mark, `encoding` for the names in it.

    `first_line` is the number of the line at `start`; one longer than `longest_line_bytes` is none of a table.
    `comments` are the lines that a declared comment sign took out, as far as they may hold facts.
    """

    data: bytes
    start: int
    encoding: str
    first_line: int = 1
    longest_line_bytes: int = DEFAULT_LIMITS.longest_line_bytes
    comments: tuple[str, ...] = ()

    def decode(self, content: bytes) -> str:
        """Return text for showing and comparing, its letters composed (NFC); a byte without meaning becomes U+FFFD."""
        return unicodedata.normalize("NFC", content.decode(self.encoding, errors="replace"))

    def head_lines(self, limit: int = HEAD_LINES) -> list[Line]:
        """Return the first whole lines, at most `limit`, within the longest line allowed; those that a quoted cell
        spans are one.
        """
        return self._joined[:limit]

    @cached_property
    def head(self) -> TextSource:
        """The text of the first whole lines."""
        if not self._physical:
            return self.section(self.start)
        return self.section(physical_line(self.data, self._physical[-1].start, len(self.data)).end)

    @cached_property
    def _physical(self) -> list[Line]:
        return self.lines_at(self.start, self.first_line, HEAD_LINES)

    @cached_property
    def _joined(self) -> list[Line]:
        """The lines that many look at: each format, and what finds the layout."""
        if not any(b'"' in line.content for line in self._physical):
            return self._physical
        return list(numbered_lines(self.head.data, self.start, SEPARATORS, number=self.first_line))

    def sample_lines(self, fraction: float) -> list[Line]:
        """Return twenty whole lines from the given fraction of the file on; their numbers mean nothing."""
        start = self.start + int((len(self.data) - self.start) * fraction)
        return self.lines_at(start, 1, 21)[1:]

    def section(self, stop: int) -> TextSource:
        """Return the text up to `data[stop]`, as if the file ended there; lines keep their numbers."""
        return dataclasses.replace(self, data=beginning(self.data, stop))

    def lines_at(self, start: int, number: int, limit: int = 60) -> list[Line]:
        """Return at most `limit` lines from `data[start:]`, the first of which has the given number."""
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


def is_text(data: bytes) -> bool:
    """Tell text from binary by the first 64 KiB: a byte order mark, or few control characters and no field of NULs.

    NULs in the end do not count: a file that was allocated beforehand has a tail of them.
    """
    head = data[:HEAD_BYTES].rstrip(b"\0")
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
    """Find out the encoding of text: byte order mark, else strict UTF-8, else `page`; a tail of NULs is cut off.

    UTF-16 is transcoded, line ends of old Macintosh programs (CR alone) and typeset minuses are replaced; otherwise
    `data` is not copied.
    Raises `UsageError` when `page` is not an encoding.
    """
    wide = is_wide(page) and not is_text(data)
    source = _transcoded(data, page, findings) if wide else _without_mark(data, page, findings)
    source = _without_nul_tail(dataclasses.replace(source, longest_line_bytes=longest_line_bytes), findings)
    # One byte is found ten times as fast as three, and most logs have none.
    if source.encoding == "utf-8" and _MINUS[:1] in source.data and _MINUS in source.data:
        source = dataclasses.replace(source, data=source.data.replace(_MINUS, b"-"))
    data = source.data
    if b"\r" in data and b"\n" not in data:
        findings.add(NOTE, "line_ends_cr", "Lines end with CR alone; read as line ends.")
        return dataclasses.replace(source, data=data.replace(b"\r", b"\n"))
    return source


def _without_mark(data: bytes, page: str, findings: FindingCollector) -> TextSource:
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            if encoding == "utf-8":
                return TextSource(data, len(mark), "utf-8")
            return _transcoded(data[len(mark) :], encoding, findings)
    if data.isascii() or _is_utf8(data):
        return TextSource(data, 0, "utf-8")
    return TextSource(data, 0, page)


def _transcoded(data: bytes, encoding: str, findings: FindingCollector) -> TextSource:
    """Return text of two or four bytes a letter as UTF-8."""
    text = data.decode(encoding, errors="replace")
    findings.add(NOTE, "encoding_utf16", f"The text is {encoding.upper()}; read as such.")
    return TextSource(text.encode("utf-8", errors="replace"), 0, "utf-8")


def is_wide(page: str) -> bool:
    """Whether a page has two or four bytes a letter. Raises `UsageError` when it is not an encoding."""
    try:
        return codecs.lookup(page).name.startswith(("utf-16", "utf-32"))
    except LookupError as error:
        raise UsageError(f"{page!r} is not an encoding: give one as 'cp1252', 'cp1250' or 'latin-1'.") from error


def looks_like_utf16(data: bytes) -> str | None:
    """Return the page of UTF-16 without a byte order mark, most letters ASCII; None where the bytes are otherwise."""
    head = data[:HEAD_BYTES]
    even, odd = head[::2], head[1::2]
    for letters, zeros, page in ((even, odd, "utf-16-le"), (odd, even, "utf-16-be")):
        if 10 * zeros.count(0) > 9 * len(zeros) and 10 * letters.count(0) < len(letters):
            return page
    return None


def _without_nul_tail(source: TextSource, findings: FindingCollector) -> TextSource:
    stop = len(source.data)
    while stop > source.start and source.data[stop - 1] == 0:
        start = max(source.start, stop - BLOCK_BYTES)
        written = start + len(source.data[start:stop].rstrip(b"\0"))
        release_bytes(source.data, start, stop)
        stop = written
    if stop == len(source.data):
        return source
    findings.add(NOTE, "nul_padding", "The file ends in NUL bytes, as preallocated files do; they are cut off.")
    return source.section(stop)


def _is_utf8(data: bytes) -> bool:
    decoder = codecs.getincrementaldecoder("utf-8")("strict")
    try:
        for block in blocks(data, 0, len(data)):
            decoder.decode(block)
        decoder.decode(b"", final=True)
    except UnicodeDecodeError:
        return False
    return True


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


_MOST_COMMENTS = 60
_NUMBER_FIRST = re.compile(rb'(?m)^[ \t"]*[+-]?[.,]?\d')
"""How a line of data begins, and no comment or footer."""
_NOT_BLANK = re.compile(rb"(?m)^[ \t]*[^\s]")


def as_declared(source: TextSource, declared: Declarations, findings: FindingCollector) -> TextSource:
    """Return the text in the page declared, its comment lines blank, and without what a footer begins.

    Lines keep their numbers and places. A header row that begins with the comment sign stays a header. What looks like
    data and is cut or skipped by this is reported.
    """
    encoding = source.encoding if source.encoding == "utf-8" else declared.encoding or source.encoding
    source = dataclasses.replace(source, encoding=encoding)
    if declared.footer is not None:
        found = re.search(rb"(?m)^[ \t]*" + re.escape(_encoded(declared.footer, source)), source.data)
        if found is not None:
            _report_footer(source, declared.footer, found.start(), findings)
            source = source.section(found.start())
    if declared.comment is None:
        return source
    own = {declared.header_row, declared.units_row}
    header_starts = {line.start for line in source.head_lines() if line.number in own}
    comments: list[str] = []
    like_data: list[int] = []

    def blank(match: re.Match[bytes]) -> bytes:
        if match.start() in header_starts:
            return match[0]
        if len(comments) < _MOST_COMMENTS:
            comments.append(source.decode(match[0]))
        if _NUMBER_FIRST.match(match[0]):
            like_data.append(match.start())
        return b" " * len(match[0])

    sign = re.escape(_encoded(declared.comment, source))
    data = re.sub(rb"(?m)^[ \t]*" + sign + rb"[^\r\n]*", blank, source.data)
    if like_data:
        findings.add(
            ROW,
            "comment_like_data",
            f"Lines of numbers begin with the comment sign {declared.comment!r} and are skipped: correct `comment` in "
            "labbook.toml if they are data.",
            lines=[_line_number(source, start) for start in like_data[: MORE_LINES + 1]],
            count=len(like_data),
        )
    return dataclasses.replace(source, data=data, comments=tuple(comments))


def _report_footer(source: TextSource, footer: str, start: int, findings: FindingCollector) -> None:
    """Say where a footer ends the data, where lines follow it."""
    end = source.data.find(b"\n", start)
    following, rows = (
        0 if end < 0 else sum(1 for _ in pattern.finditer(source.data, end + 1))
        for pattern in (_NOT_BLANK, _NUMBER_FIRST)
    )
    if not following:
        return
    what = f"{rows} of {following} lines after it begin with a number" if rows else f"{following} lines follow"
    findings.add(
        ROW if rows else NOTE,
        "footer_ends_data",
        f"The data end at this line, which begins with the footer {footer!r}; {what}, and none is read"
        + (": correct `footer` in labbook.toml if they are data." if rows else "."),
        lines=[_line_number(source, start)],
    )


def _line_number(source: TextSource, start: int) -> int:
    return source.first_line + source.data.count(b"\n", source.start, start)


def _encoded(text: str, source: TextSource) -> bytes:
    return text.encode(source.encoding, errors="replace")


_LINE = re.compile(rb"([^\r\n]*)(?:\r\n|\n|\r|\Z)")


class LogicalLine(NamedTuple):
    """Content without line end, offset of the next line, number of physical lines.

    The lines that start before `tried` were looked through in vain for the end of an open quote.
    """

    content: bytes
    end: int
    spanned: int
    tried: int = 0


@functools.cache
def _quoted_row(separators: bytes) -> re.Pattern[bytes]:
    """Return what matches a line whose quotes are in place, with a group where the last one is open.

    As in Python's csv module a quote opens a cell only where the cell begins, but for spaces; else it is a mark of
    inches. What closes one stands before a separator, or ends the line.
    """
    between = re.escape(separators.replace(b" ", b" \t"))
    blanks = b"" if b" " in separators else b" *"  # else they are separators, with empty cells between them
    inside = rb'"[^"]*(?:""[^"]*)*'
    cell = rb"(?:" + blanks + inside + rb'"(?=[' + between + rb"]|\Z)|(?!" + blanks + rb'")[^' + between + rb"]*)"
    after = rb"[" + between + rb"]"
    # No possessive repeats, which match too little before Python 3.11.5: a line matches in one way, or in none.
    return re.compile(
        rb"(?:" + cell + rb"(?:" + after + cell + rb")*)?((?:\A|" + after + rb")" + blanks + inside + rb")?"
    )


def _ends_open(line: bytes, separators: bytes) -> bool | None:
    """Whether a quoted cell goes on in the next line; None where a quote is out of place."""
    if b'"' not in line:
        return False
    found = _quoted_row(separators).fullmatch(line)
    return None if found is None else found[1] is not None


def logical_line(
    data: bytes,
    position: int,
    stop: int,
    separators: bytes,
    between: bytes = b" ",
    most: int = MOST_QUOTED_LINES,
) -> LogicalLine:
    """Return the line at `position`, with those that its quoted cells take in; a quote that the next lines do not
    close, `most` with the first, takes none.

    `separators` are what stands between cells, `between` stands for the ends of the lines joined.
    """
    first = line = physical_line(data, position, stop)
    is_open = _ends_open(first.content, separators)
    if not is_open:
        return first
    lines = [first.content]
    while is_open and line.end < stop and len(lines) < most:
        position, line = line.end, physical_line(data, line.end, stop)
        lines.append(line.content)
        is_open = _ends_open(b'"' + line.content, separators)
    if is_open is False:
        return LogicalLine(between.join(lines), line.end, len(lines))
    return first._replace(tried=position)


def numbered_lines(
    data: bytes,
    start: int,
    separators: bytes = b"",
    between: bytes = b" ",
    most: int = MOST_QUOTED_LINES,
    number: int = 1,
) -> Iterator[Line]:
    """Yield every line from `start` on, the first of which has the given number; with `separators`, as `logical_line`
    joins them.
    """
    position, tried = start, 0
    ended = data[-1:] in (b"\n", b"\r")
    while position < len(data):
        if separators and position >= tried:
            line = logical_line(data, position, len(data), separators, between, most)
            tried = line.tried
        else:
            line = physical_line(data, position, len(data))
        yield Line(number, position, line.content, ended or line.end < len(data))
        position, number = line.end, number + line.spanned


def physical_line(data: bytes, position: int, stop: int) -> LogicalLine:
    """Return the line at `position` whatever quotes it holds."""
    match = _LINE.match(data, position, stop)
    if match is None:  # the pattern also matches nothing, at the end
        return LogicalLine(b"", stop, 1)
    return LogicalLine(match[1], match.end(), 1)


EXPONENT = rb"(?:[eE][+-]?\d+|[dD][+-]\d+)?"
"""D is that of double precision in Fortran, which writes a sign behind it."""
NUMBER_PATTERN = rb"[+-]?(?:\d+\.?\d*|\.\d+)" + EXPONENT
NUMBER = re.compile(NUMBER_PATTERN)
COMMA_NUMBER = re.compile(rb"[+-]?(?:\d+,\d*|,\d+)" + EXPONENT)
_INTEGER = re.compile(rb"[+-]?\d{1,19}")
_GROUPED = re.compile(rb"[+-]?\d{1,3}(?:(?:[ '.]\d{3})+(?:,\d+)?|(?:[ ',]\d{3})+(?:\.\d+)?)")
_MAY_GROUP = re.compile(rb"[+-]?[1-9]\d{0,2}[.,]\d{3}")
_NAN = re.compile(rb"[+-]?nan(?:\([0-9a-z_]*\))?")
_MISSING = frozenset(
    {b"", b"na", b"n/a", b"#n/a", b"null", b"none", b"-", b"--", b"---", b"1.#qnan", b"1.#ind", b"1.#snan"}
)
_INFINITE = frozenset({b"inf", b"infinity", b"1.#inf"})
CLOCK_PATTERN = rb"(?:\d{4}-\d\d-\d\d[ T])?\d{1,2}:\d\d:\d\d(?:[.,]\d+)?(?:Z|[+-]\d\d:?\d\d)?"
_CLOCK = re.compile(CLOCK_PATTERN + rb"|\d{4}-\d\d-\d\d(?:[ T]\d\d:\d\d)?")

_CLOCK_LIKE = re.compile(
    rb"(?:\d{1,4}([-./])\d{1,2}\1\d{1,4})?[ T,]*(?:\d{1,3}:\d\d(?::\d\d)?(?:[.,]\d+)? ?(?:[AaPp]\.?[Mm]\.?)?)?"
    rb"(?: +\d{1,4}([-./])\d{1,2}\2\d{1,4})?"
)

COMMENT_STARTS = (b"#", b"%", b"//")
"""With which lines of remarks begin."""

BLANKS = b" \t\r\n"
"""What may stand around the content of a cell."""

INFINITY = float("inf")
NAN = float("nan")


@dataclass(frozen=True, slots=True)
class CellFault:
    """Why a cell is neither a number nor a missing value; `rule` and `message` of the finding."""

    rule: str
    message: str


_ROW_OUT = "the row is left out"
NOT_A_NUMBER = CellFault("not_a_number", f"A cell is no number; {_ROW_OUT}.")
NOT_FINITE = CellFault("not_finite", f"A cell is infinite or beyond what a number can hold; {_ROW_OUT}.")
GROUPED = CellFault(
    "thousands_separator",
    f"A number holds a thousands separator, which can be misread by 1000; {_ROW_OUT}; export without.",
)
OTHER_DECIMAL = CellFault(
    "decimal_sign_mixed",
    f"A number uses the other decimal sign than its file; {_ROW_OUT}; write one throughout.",
)


def parse_cell(cell: bytes, decimal: bytes) -> float | CellFault:
    """Return the number in a stripped cell, NaN for a missing value, or the fault. `decimal` is b"." or b","."""
    if NUMBER.fullmatch(cell):
        if decimal == b"." or b"." not in cell:
            return _finite(cell)
        return GROUPED if _GROUPED.fullmatch(cell) else OTHER_DECIMAL
    if COMMA_NUMBER.fullmatch(cell):
        if decimal == b",":
            return _finite(cell.replace(b",", b"."))
        return GROUPED if _GROUPED.fullmatch(cell) else OTHER_DECIMAL
    folded = cell.lower()
    if is_missing(folded):
        return NAN
    if is_infinite(folded):
        return NOT_FINITE
    return GROUPED if _GROUPED.fullmatch(cell) else NOT_A_NUMBER


def value_of(number: bytes) -> float:
    """Return the value of a cell that `NUMBER` matches."""
    return float(number.lower().replace(b"d", b"e"))


def _finite(cell: bytes) -> float | CellFault:
    value = value_of(cell)
    return NOT_FINITE if value in (INFINITY, -INFINITY) else value


def integer_of(cell: bytes) -> int | None:
    """Return the integer in a stripped cell, None where it holds none or one beyond 64 bits."""
    if not _INTEGER.fullmatch(cell):
        return None
    number = int(cell)
    return number if -(2**63) <= number < 2**63 else None


def is_missing(cell: bytes) -> bool:
    """Whether a stripped cell, lower case, is one of the spellings of a missing value."""
    unsigned = cell.lstrip(b"+-") or cell  # a lone plus is what is left of a damaged number
    return cell in _MISSING or unsigned in _MISSING or _NAN.fullmatch(cell) is not None


def is_infinite(cell: bytes) -> bool:
    """Whether a stripped cell, lower case, is one of the spellings of infinity."""
    return cell.lstrip(b"+-") in _INFINITE


def is_number(cell: bytes, comma: bool) -> bool:
    """Whether a stripped cell is a number, with a decimal comma too where `comma` allows it."""
    return NUMBER.fullmatch(cell) is not None or (comma and COMMA_NUMBER.fullmatch(cell) is not None)


def is_grouped(cell: bytes) -> bool:
    """Whether a stripped cell is a number with thousands separators."""
    return _GROUPED.fullmatch(cell) is not None


def may_group(cell: bytes) -> bool:
    """Whether a stripped cell is a number as `1,002` or `1.002`, whose sign may be a decimal or group thousands."""
    return _MAY_GROUP.fullmatch(cell) is not None


def decimal_sign_of(cells: Sequence[bytes]) -> tuple[bytes, bytes | None]:
    """Return the decimal sign of most numbers among stripped cells, and one of those with a comma where all of these
    may group thousands.
    """
    commas = [cell for cell in cells if COMMA_NUMBER.fullmatch(cell)]
    points = sum(b"." in cell for cell in cells if NUMBER.fullmatch(cell))
    if not commas or points > len(commas):
        return b".", None
    return b",", commas[0] if all(map(may_group, commas)) else None


def is_clock(cell: bytes) -> bool:
    """Whether a stripped cell is a date with time (ISO-8601) or a time of day."""
    return _CLOCK.fullmatch(cell) is not None


def is_clock_like(cell: bytes) -> bool:
    """Whether a stripped cell is a date, a time of day or both, in whatever order people write them."""
    return is_clock(cell) or (cell != b"" and _CLOCK_LIKE.fullmatch(cell) is not None)


def split_cells(line: bytes, delimiter: bytes) -> list[bytes] | None:
    """Split a line into stripped cells, quotes (`"`, doubled inside) honoured; None when a quote is out of place.

    A delimiter of one space means any run of spaces and tabs. Other blanks, as a damaged byte may be one, stay.
    """
    if b'"' not in line:
        if delimiter == b" ":
            return [cell for cell in line.replace(b"\t", b" ").rstrip(b"\r\n").split(b" ") if cell]
        return [cell.strip(BLANKS) for cell in line.split(delimiter)]
    text = line.decode("latin-1")
    if delimiter == b" ":
        text = text.replace("\t", " ").strip()
    rows = csv.reader([text], delimiter=delimiter.decode("latin-1"), strict=True, skipinitialspace=True)
    try:
        cells = [cell.encode("latin-1").strip(BLANKS) for cell in next(rows)]
    except csv.Error:
        return None
    return [cell for cell in cells if cell] if delimiter == b" " else cells


def too_wide(width: int, declared: Declarations, findings: FindingCollector) -> bool:
    """Report rows of more columns than a file may have; they are not read."""
    most = declared.limits.most_columns
    if width <= most:
        return False
    message = f"The rows have {width} columns, more than {most} (limit most_columns); "
    findings.add(FILE, "too_many_columns", message + "export one sample a line, not one a column.")
    return True


# A single space stands for any run of blanks; last, because blanks also pad other separators.
BETWEEN_CELLS = tuple(bytes([sign]) for sign in SEPARATORS)
CANDIDATES = (*BETWEEN_CELLS, b" ")
ONE_COLUMN = b"\x1f"
"""Stands for no delimiter: a character that no line holds."""


def texts_of(source: TextSource, line: Line, delimiter: bytes) -> list[str]:
    """Return the cells of a line as text; none where a quote is out of place."""
    return [source.decode(cell) for cell in split_cells(line.content, delimiter) or []]


_CLOCK_COMMA = re.compile(rb"(?m)(?<=\d:[0-5]\d:[0-5]\d),(?=(?:\d{3}|\d{6})(?:,|\s*$))")


def with_clock_points(source: TextSource, findings: FindingCollector) -> TextSource:
    """Return a text with a point for the comma before the milliseconds of clock times, `12:00:00,010`, of the same
    length, where a comma stands between cells, too, and the line above the first such row has so many fewer.
    """
    lines = [line.content for line in source.head_lines() if line.content.strip()]
    first = next((at for at, line in enumerate(lines) if _CLOCK_COMMA.search(line)), 0)
    fewer = len(_CLOCK_COMMA.findall(lines[first])) if first else 0
    if not fewer or lines[first - 1].count(b",") != lines[first].count(b",") - fewer:
        return source
    message = (
        "The comma before milliseconds of a clock time is read as their decimal sign, as the header has fewer cells."
    )
    findings.add(NOTE, "clock_decimal_comma", message)
    data = source.data[: source.start] + _CLOCK_COMMA.sub(b".", source.data[source.start :])
    return dataclasses.replace(source, data=data)


# A name begins with a letter, so that a row of numbers or clock times, cut anywhere, is none.
_NUMBER = re.compile(rb"[+-]?(?:\d+[.,]?\d*|\.\d+)" + EXPONENT + rb"(?:\s*[A-Za-z%/*^0-9]{1,8})?")
_DEBUG_LINE = re.compile(rb"\s*([A-Za-z_][\w ./\[\]()-]{0,60}?)\s*[:=]\s*(\S.*?)\s*")


class DebugLine(NamedTuple):
    """A line that programs print beside, or instead of, a table: `Acceleration: 9.46`, `motor1: -2957986`.

    The name before the colon or equals sign, and the text after it, both stripped.
    """

    name: bytes
    value: bytes


def debug_line(content: bytes) -> DebugLine | None:
    """Return the parts of a line `name: value` or `name = value`, None for any other line."""
    match = _DEBUG_LINE.fullmatch(content)
    return None if match is None else DebugLine(match[1], match[2])


def is_single_number(line: DebugLine | None) -> bool:
    """Whether the text after the name is one number, a unit perhaps behind it: such a line is no row of a table."""
    return line is not None and _NUMBER.fullmatch(line.value) is not None


_ROWS_JUDGED = 60
_CLOSE = 0.98
"""Splits of this share of the best quality may be meant as well."""


@dataclass(frozen=True, slots=True)
class Row:
    """A line split into cells; `data_like` when at least half of its cells are numbers, times or missing."""

    line: Line
    cells: list[bytes]
    data_like: bool
    share: float


@dataclass(frozen=True, slots=True)
class Split:
    """The sample under one delimiter: `head` the first lines, `rows` the data rows of the usual `width`."""

    delimiter: bytes
    width: int
    head: tuple[Row, ...]
    rows: tuple[Row, ...]
    quality: float


def best_split(head: list[Line], further: list[Line], delimiter: bytes | None = None) -> Split | None:
    """Return the sample under its most likely delimiter, None when no line looks like data.

    Judged on rows of numbers only, so that titles and header lines with other separators do not disturb it: every
    candidate splits the sample, the one that gives most rows of one width and of nothing but numbers wins.
    `head` are the first lines of the file, `further` lines from deeper inside; `delimiter` is the one declared.
    """
    possible: list[Split] = []
    best = 0.0
    for tried in _frequent([*head, *further]) if delimiter is None else [delimiter]:
        split = _split(head, further, tried, _CLOSE * best)
        if split is not None and split.rows:
            possible.append(split)
            best = max(best, split.quality)
    if not possible:
        return None
    close = [split for split in possible if split.quality >= _CLOSE * best]
    return max(close, key=lambda split: (_has_header(split), split.width > 1))


def _frequent(lines: list[Line]) -> list[bytes]:
    """Return the delimiters that half of the lines hold, and that there may be none."""
    filled = [line for line in lines if line.content.strip() and not _is_debug(line)]
    return [
        *(sign for sign in CANDIDATES if sum(sign in line.content for line in filled) * 2 >= len(filled)),
        ONE_COLUMN,
    ]


def row_of(line: Line, delimiter: bytes) -> Row:
    """Split one line and judge whether it holds data."""
    cells = split_cells(line.content, delimiter) or []
    numbers = empty = 0
    for cell in cells:
        if is_number(cell, comma=True) or is_clock(cell) or is_grouped(cell):
            numbers += 1
        elif is_missing(cell.lower()):
            empty += 1
    share = (numbers + empty) / len(cells) if cells else 0.0
    return Row(line, cells, numbers > 0 and share >= 0.5 and not _is_debug(line), share)


def _is_debug(line: Line) -> bool:
    return is_single_number(debug_line(line.content))


def _split(head: list[Line], further: list[Line], delimiter: bytes, least: float = 0.0) -> Split | None:
    """Split the sample; None where the rows from deeper inside already rule out a quality of `least`."""
    deeper = [row for line in further if (row := row_of(line, delimiter)).data_like]
    if len(deeper) + min(len(head), _ROWS_JUDGED) < least:
        return None
    rows = []
    data_rows = []
    for line in head:
        row = row_of(line, delimiter)
        rows.append(row)
        if row.data_like:
            data_rows.append(row)
            if len(data_rows) == _ROWS_JUDGED:
                break
    data_rows += deeper
    widths = Counter(len(row.cells) for row in data_rows)
    if not widths:
        return Split(delimiter, 0, tuple(rows), (), 0.0)
    width, _ = widths.most_common(1)[0]
    usual = tuple(row for row in data_rows if len(row.cells) == width)
    return Split(delimiter, width, tuple(rows), usual, sum(row.share for row in usual))


def _has_header(split: Split) -> bool:
    """Whether some line above the first data row has as many cells and no number."""
    for row in split.head:
        if row.data_like:
            return False
        if len(row.cells) == split.width and row.share == 0.0:
            return True
    return False
