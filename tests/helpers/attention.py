"""What needs attention in a book, by the check that found it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from labbook.actions.runs.attention import Finding, attention
from labbook.analysis.outcomes.detection import Detections
from labbook.book.opening import Book
from tests.cli.shell import good, labbook


def found_in(book: Book, **asked: str) -> dict[str, list[Finding]]:
    """Look at an open book, or at what is asked for of it."""
    with book.reading() as connection:
        found = attention(Detections(connection, book.store), book.configuration, **asked)
    by_code: dict[str, list[Finding]] = {}
    for one in found.findings:
        by_code.setdefault(one.code, []).append(one)
    return by_code


def told(at: Path, *words: str) -> dict[str, list[dict[str, Any]]]:
    """Ask the command line: `labbook attention`, or these words instead."""
    by_code: dict[str, list[dict[str, Any]]] = {}
    for one in good(labbook(*(words or ("attention",)), "--json", at=at)).json["findings"]:
        by_code.setdefault(one["code"], []).append(one)
    return by_code


def runs_told(at: Path, code: str, *words: str) -> list[str]:
    """The runs, by name, that one check names."""
    return sorted(one["run"] for one in told(at, *words).get(code, []))
