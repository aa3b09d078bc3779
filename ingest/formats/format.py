"""What every format is: a name, a version, how to recognise it by content, how to read it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ingest.findings import FindingCollector
from ingest.model import Reading
from ingest.sniff import Head

Reader = Callable[[Head, FindingCollector], Reading]


@dataclass(frozen=True, slots=True)
class Format:
    """One file format. `version` rises with every change of what its reader gives for the same bytes."""

    name: str
    version: int
    recognise: Callable[[Head], bool]
    read: Reader
