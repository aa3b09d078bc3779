"""What every format is: a name, a version, how to recognise it by the beginning of a file, how to read it."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ingest.declared import composed, with_profile
from ingest.model import NOTE, Declarations, FindingCollector, ReadFile, Reading
from ingest.text import (
    DEFAULT_PAGE,
    HEAD_BYTES,
    TextSource,
    as_declared,
    is_text,
    is_wide,
    open_text,
    with_clock_points,
)

HEAD_LINES = 60
"""Lines from which a format is recognised, those that a quoted cell spans counted as one."""


class NoText(Exception):
    """A format of text was asked to read a file that is none."""


FileReader = Callable[[bytes, Declarations], ReadFile]
"""What reads one file, as `ingest.read.read_file` does: formats that hold files read these by it."""


@dataclass(frozen=True, slots=True, eq=False)
class Head:
    """All bytes of a file, and what the first of them show.

    `source` is None when the file is not text; `lines` are its first lines, decoded; `declared` its declarations.
    `beginning` is what clues are looked for in: the first bytes and lines, as stored and as read, and what is declared
    of instrument and columns, in lower case and without NULs. `read_file` reads what is packed inside.
    """

    data: bytes
    declared: Declarations
    source: TextSource | None
    lines: tuple[str, ...]
    beginning: bytes
    read_file: FileReader

    @property
    def text(self) -> TextSource:
        """Return the text; raises `NoText` where the file is none."""
        if self.source is None:
            raise NoText
        return self.source

    def first_line(self) -> str:
        """Return the first line that is not blank, without NULs, or an empty text."""
        return next((line for line in (line.replace("\0", "").strip() for line in self.lines) if line), "")


def sniff(data: bytes, declared: Declarations, findings: FindingCollector, read_file: FileReader) -> Head:
    """Tell text from binary, find the profile that applies, and decode the first lines of text.

    Raises `UsageError` for an unknown encoding.
    """
    declared = composed(declared)
    page = declared.encoding or DEFAULT_PAGE
    if not is_wide(page) and not is_text(data):
        declared = with_profile(declared, None, findings)
        return Head(data, declared, None, (), _beginning(data, None, (), declared), read_file)
    source = with_clock_points(open_text(data, page, findings, declared.limits.longest_line_bytes), findings)
    declared = with_profile(declared, source, findings)
    source = as_declared(source, declared, findings)
    if source.encoding != "utf-8":
        message = f"The text is not UTF-8; names are read as {source.encoding}, the page declared for such files."
        findings.add(NOTE, "encoding_declared", message)
    lines = tuple(source.decode(line.content) for line in source.head_lines(HEAD_LINES))
    return Head(data, declared, source, lines, _beginning(data, source, lines, declared), read_file)


def _beginning(data: bytes, source: TextSource | None, lines: Sequence[str], declared: Declarations) -> bytes:
    columns = (*declared.columns.values(), *declared.profile_columns.values())
    facts = (declared.instrument, *(fact for column in columns for fact in (column.channel, column.unit)))
    texts = (
        text.lower().encode(errors="replace") for text in (*lines, *filter(None, facts))
    )  # letters beyond ASCII, too
    # Of UTF-16, the first bytes are half as many letters; a header that is declared may stand below them.
    further = b"" if source is None else source.head.data[source.start + HEAD_BYTES // 2 :]
    return b"\n".join([data[:HEAD_BYTES], *texts, further]).replace(b"\0", b"").lower()


def spelt(word: str) -> bytes:
    """Return a clue to a name in any spelling that `squash` takes for it: signs may stand between its letters."""
    return rb"[\W_]*".join(re.escape(letter.encode()) for letter in word)


UNKNOWN = "unknown"
"""Stands for the format of a file that none reads; no format has this name."""

Reader = Callable[[Head, FindingCollector], Reading]

SIGNATURE_BYTES = 64
"""In so many bytes a file of binary numbers shows what it is."""
SIGNATURE = 90
"""The file names its maker or format: magic bytes, a first line that no other program writes."""
LAYOUT = 60
"""The columns or records are laid out as only this format lays them out."""
NAMES = 30
"""Some names of columns are those of this format."""
ANY_TEXT = 1
"""It is text, and nothing else is known."""


@dataclass(frozen=True, slots=True)
class Format:
    """One file format. `version` rises with every change of what its reader gives for the same bytes.

    `recognise` returns by what evidence a file is of this format, None where it is not; `score` is how strong such
    evidence is (`SIGNATURE`, `LAYOUT`, `NAMES`, `ANY_TEXT`): of several formats the one with the highest reads. A file
    that does not begin as `begins`, a pattern of its first bytes, or whose beginning holds none of the `clues`,
    patterns in lower case, is not even shown to it; without `recognise` files are read as it where that is declared.
    `what` describes its files, for lists. `plugin` names the distribution and version that a format of somebody else's
    comes from. A `container` holds files that are read as what is declared.
    """

    name: str
    version: int
    recognise: Callable[[Head], str | None] | None
    read: Reader
    what: str | None = None
    plugin: str | None = None
    container: bool = False
    begins: bytes = b""
    clues: tuple[bytes, ...] = ()
    score: int = SIGNATURE

    def may_be(self, head: Head) -> bool:
        """Whether a file begins so, and holds one of the clues."""
        begins = re.match(self.begins, head.data[:SIGNATURE_BYTES], re.DOTALL) is not None
        return begins and (not self.clues or any(re.search(clue, head.beginning) for clue in self.clues))


def any_text(head: Head) -> str | None:
    """Text of no other format."""
    source = head.text
    filled = source.data[source.start : source.start + HEAD_BYTES].strip(b"\0\r\n\x1a \t")
    return "text of no maker known here" if filled else None


def signed(name: str, version: int, begins: str, read: Reader) -> Format:
    """Return a format of text whose first line begins with its maker's words, in any case."""

    def recognise(head: Head) -> str | None:
        known = head.source is not None and head.first_line().lower().startswith(begins.lower())
        return f"{begins} on the first line" if known else None

    recognise.__doc__ = f"`{begins}` on the first line."
    return Format(name, version, recognise, read, clues=(re.escape(begins.lower().encode()),))
