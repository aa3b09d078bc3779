"""Formats that are recognised but not read: the refusal says what the file is and what to export instead."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from ingest.findings import FILE, FindingCollector
from ingest.formats.format import SIGNATURE, Clue, Format, Head, Recognition
from ingest.model import Reading

_TEXT = "export its data as delimited text with a header, units and time"


@dataclass(frozen=True, slots=True)
class _Signature:
    name: str
    what: str
    instead: str
    clue: Clue
    matches: Callable[[Head], bool] = lambda _head: True


def _first_line(pattern: str) -> Callable[[Head], bool]:
    compiled = re.compile(pattern)
    return lambda head: compiled.match(head.first_line()) is not None


_RUN_SHEET = r"run[,;\t]date[,;\t]position[,;\t]kind\b"

_SIGNATURES = (
    _Signature("pdf", "a PDF document", "give the data it was made from", Clue(begins=(b"%PDF-",))),
    _Signature("image", "an image", _TEXT, Clue(begins=(b"\x89PNG", b"\xff\xd8\xff", b"GIF8", b"II*\0", b"MM\0*"))),
    _Signature(
        "video",
        "a video",
        "keep it beside the book",
        Clue(says=(b"ftyp",)),
        lambda head: head.data[4:8] == b"ftyp",
    ),
    _Signature(
        "run_sheet",
        "a run sheet",
        "state its runs with `labbook runs import FILE`",
        Clue(says=(b"position",)),
        _first_line(_RUN_SHEET),
    ),
)


def _format(signature: _Signature) -> Format:
    def refuse(_head: Head, findings: FindingCollector) -> Reading:
        findings.add(FILE, "format_not_read", f"This is {signature.what}, which is not read: {signature.instead}.")
        return Reading()

    def recognise(head: Head) -> Recognition | None:
        """Its first bytes or lines."""
        known = signature.clue.is_in(head) and signature.matches(head)
        return Recognition(SIGNATURE, f"it begins as {signature.what}") if known else None

    return Format(
        signature.name,
        1,
        recognise,
        refuse,
        f"{signature.what[0].upper()}{signature.what[1:]}: not read; {signature.instead}.",
        clue=signature.clue,
    )


RECOGNISED = tuple(_format(signature) for signature in _SIGNATURES)
"""One format a signature; their readers refuse."""
