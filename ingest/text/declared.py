"""Text as declarations see it: without comment lines, and ending where its footer begins."""

from __future__ import annotations

import dataclasses
import re

from ingest.findings import MORE_LINES, NOTE, ROW, FindingCollector
from ingest.model import Declarations
from ingest.text.source import TextSource

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
    kept = {line.start for line in source.head_lines() if line.number in own}
    comments: list[str] = []
    like_data: list[int] = []

    def blank(match: re.Match[bytes]) -> bytes:
        if match.start() in kept:
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
