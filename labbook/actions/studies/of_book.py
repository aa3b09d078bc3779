"""A study of a book, and what of the book it comes from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

import sqlalchemy as sa

from data_schema import journal
from labbook.config.parsing import Configuration

S = TypeVar("S")


@dataclass(frozen=True, slots=True)
class OfBook(Generic[S]):
    """A study with its sources by name: the book's configuration, the runs selected, the journal as it was read."""

    study: S
    sources: tuple[tuple[str, str], ...]


def book_sources(
    connection: sa.Connection, configuration: Configuration, where: str | None
) -> tuple[tuple[str, str], ...]:
    """Name what a study comes from, in the reading transaction that it is computed in."""
    entries, head = journal.head(connection)
    return (
        ("Study", configuration.study.name),
        ("Runs", where or "all"),
        ("labbook.toml", f"SHA-256 {configuration.sha256}"),
        ("Journal", f"{entries} entries, the last {head}, which name every file by its hash"),
    )
