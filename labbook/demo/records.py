"""What is written of a campaign, whatever it is a campaign of: its records, its runs, and what is true of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from labbook.demo.writers import SheetRun

MARK = "synthetic"
"""Part of the name of every instrument's file."""
PlannedRun: TypeAlias = tuple[str, int, str, Mapping[str, str] | None]
"""Name, number of the day, block, and levels, which an idle run lacks."""


@dataclass(frozen=True, slots=True)
class Record:
    """What an instrument wrote, its path below `instruments`, and what is true of it, if that is told."""

    path: str
    content: bytes
    truth: Mapping[str, Any] | None = None


@dataclass(frozen=True, slots=True)
class Correction:
    """A fact that was written down wrong and put right later."""

    run: str
    field: str
    written: str
    right: str
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignFiles:
    """What is written of a campaign: its configuration, its sheets and records, and what is true.

    `records` are made one after the other. `runs`, if there are any, are made with `factors`, as `planned` from a seed
    where they were; `corrections` are stated after all is ingested.
    """

    configuration: str
    records: Iterable[Record]
    truth: Mapping[str, Any]
    runs: Sequence[SheetRun] = ()
    factors: tuple[str, ...] = ()
    planned: tuple[int, Sequence[PlannedRun]] | None = None
    corrections: Sequence[Correction] = ()
