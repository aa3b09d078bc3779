"""Text as declarations see it: without comment lines, and ending where its footer begins."""

from __future__ import annotations

import dataclasses
import re

from ingest.model import Declarations
from ingest.text.source import TextSource

_MOST_COMMENTS = 60


def as_declared(source: TextSource, declared: Declarations) -> TextSource:
    """Return the text in the page declared, its comment lines blank, and without what a footer begins.

    Lines keep their numbers and places. A header row that begins with the comment sign stays a header.
    """
    encoding = source.encoding if source.encoding == "utf-8" else declared.encoding or source.encoding
    source = dataclasses.replace(source, encoding=encoding)
    if declared.footer is not None:
        found = re.search(rb"(?m)^[ \t]*" + re.escape(_encoded(declared.footer, source)), source.data)
        source = source if found is None else source.section(found.start())
    if declared.comment is None:
        return source
    own = {declared.header_row, declared.units_row}
    kept = {line.start for line in source.head_lines() if line.number in own}
    comments: list[str] = []

    def blank(match: re.Match[bytes]) -> bytes:
        if match.start() in kept:
            return match[0]
        if len(comments) < _MOST_COMMENTS:
            comments.append(source.decode(match[0]))
        return b" " * len(match[0])

    sign = re.escape(_encoded(declared.comment, source))
    data = re.sub(rb"(?m)^[ \t]*" + sign + rb"[^\r\n]*", blank, source.data)
    return dataclasses.replace(source, data=data, comments=tuple(comments))


def _encoded(text: str, source: TextSource) -> bytes:
    return text.encode(source.encoding, errors="replace")
