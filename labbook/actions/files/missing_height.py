"""A log without body height: no jump is found in it, so the column that may be the height is asked about loudly."""

from __future__ import annotations

import difflib
import shlex
from collections.abc import Sequence
from dataclasses import dataclass

from data_schema.queries.runs import list_runs
from data_schema.vocabulary import CHANNELS, FileRole, IngestStatus, RunKind
from ingest.channels.names import channel_kind, squash
from ingest.model import ChannelData
from labbook.actions.files.ingesting import FileOutcome
from labbook.analysis.outcomes.detecting import BODY_HEIGHT
from labbook.book.opening import Book

_LIKE_HEIGHT = ("bodyheight", "height", "hgt", "bodyz", "z", "h", "pot", "string", "position", "hoehe")
_LENGTHS = ("m", "cm", "mm", "um", "in", "ft")
_WITHOUT_UNIT = (None, "1")
_MOST_COLUMNS = 12
_CLOSE = 0.7
"""A name this alike may be the channel misspelt; less alike it only shares letters with it."""
_QUOTED = set('"$`\\!')
"""What a shell reads within double quotes."""


@dataclass(frozen=True, slots=True)
class MissingHeight:
    """The columns of a log as (name in the file, kept as, nearest channel or None), and how to declare one of them."""

    columns: tuple[tuple[str, str, str | None], ...]
    command: str


def missing_heights(book: Book, outcomes: Sequence[FileOutcome]) -> list[MissingHeight | None]:
    """Find the logs among files just read that lack a body height and belong to a run of jumps, or to none yet."""
    lacking = [_is_log_without_height(outcome) for outcome in outcomes]
    jumped: set[str] = set()
    if any(lacking):
        with book.reading() as connection:
            jumped = {run.name for run in list_runs(connection) if run.kind is RunKind.JUMPS}
    return [
        _missing(outcome) if lacks and (not outcome.runs or jumped & set(outcome.runs)) else None
        for outcome, lacks in zip(outcomes, lacking, strict=True)
    ]


def missing_height_lines(path: str, missing: MissingHeight) -> list[str]:
    """Say it for people, before anything else of the file."""
    columns = [
        f"{name!r}" + (f" (kept as {kept}{'' if near is None else f', nearest channel {near}'})" if kept else "")
        for name, kept, near in missing.columns[:_MOST_COLUMNS]
    ]
    more = len(missing.columns) - len(columns)
    return [
        f"{path}: NO {BODY_HEIGHT}: no jump can be found in this log.",
        f"  its columns: {', '.join(columns)}{f' and {more} more' if more else ''}.",
        f"  say which one it is{_unit(missing)}: `{missing.command}` (`labbook channels` lists all channels).",
    ]


def _unit(missing: MissingHeight) -> str:
    return ", UNIT being the file's, such as mm" if "UNIT" in missing.command else ""


def _is_log_without_height(outcome: FileOutcome) -> bool:
    read = outcome.read
    return (
        read is not None
        and outcome.status is IngestStatus.IMPORTED
        and (read.role or FileRole.LOG) is FileRole.LOG
        and bool(read.parts)
        and not any(channel.name == BODY_HEIGHT for part in read.parts for channel in part.channels)
    )


def _missing(outcome: FileOutcome) -> MissingHeight:
    assert outcome.read is not None  # noqa: S101 - it was looked at
    channels = {channel.source_name: channel for part in outcome.read.parts for channel in part.channels}
    columns = tuple(
        (name, "", None)
        if channel_kind(channel.name) is not None and squash(name) == squash(channel.name)
        else (name, channel.name, None if channel_kind(channel.name) else _nearest(channel.name))
        for name, channel in channels.items()
    )
    name, unit = _likeliest(list(channels.values()))
    column = f"{name}={BODY_HEIGHT}:{unit}"
    quoted = shlex.quote(column) if set(column) & _QUOTED else f'"{column}"'
    return MissingHeight(columns, f"labbook ingest {shlex.quote(outcome.path)} --column {quoted}")


def _nearest(name: str) -> str | None:
    close = difflib.get_close_matches(name, CHANNELS, n=1, cutoff=_CLOSE)
    return close[0] if close else None


def _likeliest(channels: Sequence[ChannelData]) -> tuple[str, str]:
    """Return the column that reads most like a height and its unit; `NAME` and `UNIT` where the file does not tell."""

    def likeness(channel: ChannelData) -> float:
        given = squash(channel.name)
        return max(difflib.SequenceMatcher(None, given, like).ratio() for like in _LIKE_HEIGHT)

    free = [
        channel
        for channel in channels
        if channel_kind(channel.name) is None and channel.source_unit in (*_WITHOUT_UNIT, *_LENGTHS)
    ]
    best = max(free, key=likeness, default=None)
    if best is None:
        return "NAME", "UNIT"
    return best.source_name, "UNIT" if best.source_unit in _WITHOUT_UNIT else str(best.source_unit)
