"""What every format is: a name, a version, how to recognise it by content, how to read it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ingest.findings import FindingCollector
from ingest.formats.head import Head
from ingest.model import Reading

UNKNOWN = "unknown"
"""Stands for the format of a file that none reads; no format has this name."""

Reader = Callable[[Head, FindingCollector], Reading]

SIGNATURE = 90
"""The file names its maker or format: magic bytes, a first line that no other program writes."""
LAYOUT = 60
"""The columns or records are laid out as only this format lays them out."""
NAMES = 30
"""Some names of columns are those of this format."""
ANY_TEXT = 1
"""It is text, and nothing else is known."""


@dataclass(frozen=True, slots=True)
class Recognition:
    """How strongly a file looks like a format (`SIGNATURE`, `LAYOUT`, `NAMES`, `ANY_TEXT`), and by what evidence."""

    score: int
    evidence: str


@dataclass(frozen=True, slots=True)
class Format:
    """One file format. `version` rises with every change of what its reader gives for the same bytes.

    `recognise` returns None for a file that is not of this format; of several formats the one with the highest score
    reads. `what` says what its files are, for lists. `plugin` names the distribution and version that a format of
    somebody else's comes from. A `container` holds files that are read as what is declared.
    """

    name: str
    version: int
    recognise: Callable[[Head], Recognition | None]
    read: Reader
    what: str | None = None
    plugin: str | None = None
    container: bool = False
