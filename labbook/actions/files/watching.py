"""Watching folders: what instruments write there is ingested once it is complete, one file a transaction.

Nothing is remembered between two watches: the book knows which bytes it has. What is to be done with a file is decided
by pure functions of the sizes and times that were seen (`look`, `due`), and `watch` looks, ingests and tells.

Folders are looked through again and again. Systems tell of changes too, but not on network drives that another computer
writes to, and it would save a twentieth of a second of the half that is allowed.
"""

from __future__ import annotations

import contextlib
import os
import struct
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path

from data_schema.errors import BookBusy, BookError, InputRefused, LabbookError
from data_schema.vocabulary import IngestStatus
from ingest.text import is_text
from labbook.actions.files.ingesting import (
    HAS_MORE,
    FileOutcome,
    IngestRequest,
    ingest_file_or_refuse,
    without_samples,
)
from labbook.actions.files.named_files import is_own_name, readable
from labbook.actions.files.rereading import OUTDATED
from labbook.actions.runs.rig_line import MissingHeight, RigLine, missing_heights, rig_lines_of
from labbook.book.opening import CONFIGURATION, Book, find_folder, open_book

STILL_S = 0.15
"""A file is complete when size and modification time were the same for this long; docs/performance.md has what it
takes from the end of a file to its line."""
RHYTHM = 1.5
"""A file that is written in blocks is complete when it was still for so many times the longest pause between two."""
RESTART_S = 20.0
"""A longer pause is none between two blocks: something was added to a file that was complete."""
UNENDED_S = 3.0
"""A file that lacks its end, as text whose last line has none, is taken for complete after so long."""
LOOK_EVERY_S = 0.05
_SHARE_OF_TIME = 4.0
"""So many times as long as a look took is waited at least until the next: on a slow drive it must not fill the time."""
AGAIN_S = 5.0
"""A file that the system would not let be read, or for which the book was busy, is tried again after so long."""
UNFINISHED = (".part", ".partial", ".filepart", ".tmp", ".temp", ".crdownload", ".download", ".swp", "~")
"""How the names end that programs give to files which they are still writing, and to copies of what was edited."""


_HEAD_BYTES = 4096
_ZIP, _ZIP_END = b"PK\3\4", b"PK\5\6"
_ZIP_END_BYTES = 22
"""Length of the record that ends an archive, without its comment."""
_LONGEST_COMMENT = 65_535
_UNKNOWN_HERE = 0xFFFFFFFF
"""Stands for a place or length that a larger record has, in archives beyond 4 GB."""
_WIDE_LINE_ENDS = {b"\xff\xfe": (b"\n\0", b"\r\0"), b"\xfe\xff": (b"\0\n", b"\0\r")}
"""Of UTF-16 text, by its byte order mark."""


class End(StrEnum):
    """Whether the end of a file is there, by its own bytes; of most formats only that nothing more comes tells."""

    THERE = "there"
    MISSING = "missing"
    UNKNOWN = "unknown"


def end_of(path: Path) -> End:
    """Look at the first and the last bytes of a file; raises `OSError` where it cannot be read.

    An archive (.zip, .xlsx, .ods) ends with a record that says where the one before it lies, so that its end is
    certain. Text lacks its end where its last line has none; where it has one, more lines may follow.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
        size = file.seek(0, os.SEEK_END)
        if head.startswith(_ZIP):
            file.seek(max(0, size - _ZIP_END_BYTES - _LONGEST_COMMENT))
            return _end_of_archive(file.read(), size)
        file.seek(max(0, size - 2))
        last = file.read()
    if not head or not is_text(head):
        return End.UNKNOWN
    ends = _WIDE_LINE_ENDS.get(head[:2], (b"\n", b"\r"))
    return End.UNKNOWN if last.endswith(ends) else End.MISSING


def _end_of_archive(tail: bytes, size: int) -> End:
    """Look for the record that ends an archive, `size` bytes long: what it lists must end where it begins."""
    at = tail.rfind(_ZIP_END)
    if at < 0 or len(tail) - at < _ZIP_END_BYTES:
        return End.MISSING
    length, start, comment = struct.unpack_from("<IIH", tail, at + 12)
    if at + _ZIP_END_BYTES + comment != len(tail):
        return End.MISSING
    if _UNKNOWN_HERE not in (length, start) and start + length != size - len(tail) + at:
        return End.MISSING
    return End.UNKNOWN if comment else End.THERE  # a remark of NULs may be one that is still to be written


@dataclass(frozen=True, slots=True)
class Seen:
    """What one look saw of a file."""

    size_bytes: int
    modified_ns: int
    end: End = field(default=End.UNKNOWN, compare=False)


@dataclass(frozen=True, slots=True)
class Followed:
    """A file as it was seen last: so from `since_s` to `until_s`, times of one clock that never goes back.

    `pause_s` is the longest time that it was seen unchanged before it grew on. `taken`: it was ingested as it is, and
    is to be tried again at `again_s` where that is not None.
    """

    seen: Seen
    since_s: float
    until_s: float
    pause_s: float = 0.0
    taken: bool = False
    again_s: float | None = None

    def complete(self, still_s: float) -> bool:
        """Tell whether nothing more is expected of it, where `still_s` is enough for files written at once."""
        if self.seen.size_bytes == 0:
            return False
        if self.seen.end is End.THERE:
            return True
        least_s = UNENDED_S if self.seen.end is End.MISSING else still_s
        return self.until_s - self.since_s >= max(least_s, still_s, RHYTHM * self.pause_s)

    def as_taken(self, again_s: float | None = None) -> Followed:
        """Return the file once it was ingested as it was seen last, to be tried again then or when it changes."""
        return replace(self, taken=True, again_s=again_s)


Files = Mapping[Path, Followed]


def look(files: Files, seen: Mapping[Path, Seen], now_s: float) -> dict[Path, Followed]:
    """Return what is known of files after another look; one that is not there is remembered, as of a stick."""
    found = dict(files)
    for path, now in seen.items():
        before = files.get(path)
        if before is None:
            found[path] = Followed(now, now_s, now_s)
        elif before.seen == now:
            found[path] = replace(before, seen=now, until_s=now_s)
        else:
            pause_s = before.until_s - before.since_s
            longest_s = max(before.pause_s, pause_s if pause_s <= RESTART_S else 0.0)
            found[path] = Followed(now, now_s, now_s, longest_s)
    return found


def due(files: Files, now_s: float, still_s: float = STILL_S) -> list[Path]:
    """Return the files to be ingested now, first ended first: seen at `now_s`, complete and not taken so."""
    wanted = [
        (one.since_s, path)
        for path, one in files.items()
        if one.until_s == now_s
        and (not one.taken or (one.again_s is not None and one.again_s <= now_s))
        and one.complete(still_s)
    ]
    return [path for _since_s, path in sorted(wanted)]


def is_unfinished(name: str) -> bool:
    """Tell by its name whether a file is hidden, or is being written under a name for that time."""
    return name.startswith((".", "~")) or name.lower().endswith(UNFINISHED)


@dataclass(frozen=True, slots=True)
class Watching:
    """The watch has begun: the book is open and the folders are there."""

    folders: tuple[Path, ...]


@dataclass(frozen=True, slots=True)
class Arrived:
    """A file that was ingested, refused, or in the book before; how its runs do now, and what it lacks for jumps."""

    outcome: FileOutcome
    rig: tuple[RigLine, ...] = ()
    missing: MissingHeight | None = None


@dataclass(frozen=True, slots=True)
class Known:
    """Files found together that the book has; of `outdated` ones labbook.toml would have another reading now."""

    files: tuple[str, ...]
    outdated: int


@dataclass(frozen=True, slots=True)
class Trouble:
    """What hinders: the file or folder, and the sentence; "" where it is over."""

    about: str
    message: str


@dataclass(frozen=True, slots=True)
class Left:
    """Files that were not taken in when the watch ended: they were still being written, or are empty."""

    files: tuple[str, ...]


Happening = Watching | Arrived | Known | Trouble | Left


@dataclass(frozen=True, slots=True)
class Folders:
    """Folders whose files are looked at, those of folders below them too, but for hidden ones and the book's own."""

    book_folder: Path
    folders: Sequence[Path]

    def look(self, files: Files) -> tuple[dict[Path, Seen], dict[str, str]]:
        """Return what is there, and by its name why a folder cannot be read; `files` are known from earlier looks."""
        seen: dict[Path, Seen] = {}
        said: dict[str, str] = {}
        for folder in self.folders:
            self._look_into(folder, files, seen, said)
        return seen, said

    def name(self, path: Path) -> str:
        """Return what messages call a file: its path in the folder that is watched."""
        above = next(folder for folder in self.folders if path.is_relative_to(folder))
        return readable(path.relative_to(above))

    def _look_into(self, folder: Path, files: Files, seen: dict[Path, Seen], said: dict[str, str]) -> None:
        try:
            with os.scandir(folder) as entries:
                for entry in entries:
                    if is_unfinished(entry.name) or (folder == self.book_folder and is_own_name(entry.name)):
                        continue
                    path = folder / entry.name
                    if entry.is_dir(follow_symlinks=False):
                        self._look_into(path, files, seen, said)
                    elif entry.is_file():
                        with contextlib.suppress(FileNotFoundError):  # it is gone, or has its own name now
                            seen[path] = _seen(path, entry.stat(), files.get(path))
        except OSError as error:
            said[str(folder)] = f"The folder cannot be read ({error.strerror}): it is looked for again and again."


def _seen(path: Path, status: os.stat_result, before: Followed | None) -> Seen:
    """Return what is there; the end of a file that was taken as it is, or has nothing in it, is not looked at."""
    now = Seen(status.st_size, status.st_mtime_ns)
    if status.st_size and not (before is not None and before.taken and before.seen == now):
        with contextlib.suppress(OSError):  # the one who reads it all will say why
            return replace(now, end=end_of(path))
    return now


@dataclass
class _Watch:
    """The folders, what is known of their files, and what was said of them."""

    folders: Folders
    request: IngestRequest
    files: dict[Path, Followed] = field(default_factory=dict)
    troubles: dict[str, str] = field(default_factory=dict)
    said: dict[Path, str] = field(default_factory=dict)
    """Of each file, the hash of what it held when it was last ingested here, or why it was not."""
    refused: set[Path] = field(default_factory=set)

    def look(self, now_s: float) -> list[Trouble]:
        """Look at all files; returns what hinders now, and what no longer does."""
        seen, said = self.folders.look(self.files)
        self.files = look(self.files, seen, now_s)
        return [*self._news(said)]

    def _news(self, said: Mapping[str, str]) -> Iterator[Trouble]:
        """Yield what is said of folders for the first time, and which are there again."""
        for about, message in said.items():
            if self.troubles.get(about) != message:
                yield Trouble(about, message)
        yield from (Trouble(about, "") for about in self.troubles if about not in said)
        self.troubles = dict(said)

    def take(self, book: Book, path: Path, now_s: float) -> Arrived | Trouble | None:
        """Ingest a file; None where nothing is new. Raises `BookError` where the book is at fault."""
        name, again_s = self.folders.name(path), None
        try:
            outcome = without_samples(ingest_file_or_refuse(book, path, self.request))
        except BookBusy as error:
            self._set_taken(path, now_s + AGAIN_S)
            return self._trouble_once(path, name, str(error))
        except BookError:
            raise
        except LabbookError as error:
            self._set_taken(path)
            self.refused.add(path)
            return self._trouble_once(path, name, str(error))
        if outcome.status is IngestStatus.REFUSED and not outcome.sha256:
            again_s = now_s + AGAIN_S
        self._set_taken(path, again_s)
        if not outcome.sha256 and not path.exists():
            return None
        if outcome.status is IngestStatus.REFUSED:
            self.refused.add(path)
        else:
            self.refused.discard(path)
        said = outcome.sha256 or _message(outcome)
        if self.said.get(path) == said and outcome.status is not IngestStatus.IMPORTED:
            return None
        self.said[path] = said
        (missing,) = missing_heights(book, [outcome])
        (rig,) = rig_lines_of(book, [outcome])
        return Arrived(replace(outcome, name=name), tuple(rig), missing)

    def _set_taken(self, path: Path, again_s: float | None = None) -> None:
        self.files[path] = self.files[path].as_taken(again_s)

    def _trouble_once(self, path: Path, name: str, message: str) -> Trouble | None:
        if self.said.get(path) == message:
            return None
        self.said[path] = message
        return Trouble(name, message)

    def try_refused_again(self) -> None:
        """Have the files that were refused tried again, though they did not change."""
        for path in self.refused:
            self._set_taken(path, 0.0)
            self.said.pop(path, None)
        self.refused.clear()


def watch(
    start: Path | None,
    folders: Sequence[Path],
    request: IngestRequest,
    stop: Callable[[], bool] = lambda: False,
    *,
    still_s: float = STILL_S,
    once: bool = False,
) -> Generator[Happening, None, None]:
    """Ingest what is in folders and what appears there, and yield what happens, until `stop()`.

    Args:
        start: the book's folder or one below it; None for the current one.
        folders: are gone through with all folders below them, but for hidden ones and the book's own.
        request: what holds for all files; a file takes the place of those that were its beginning, whatever it says.
        stop: is asked before each file, and twenty times a second.
        still_s: how long size and modification time of a complete file have been the same, s.
        once: end when all that was there at first is taken in; what grows meanwhile is left.

    What was yielded is in the book. Raises a `LabbookError` where the book cannot be used or a folder is none.
    """
    book_folder = find_folder(start)
    for folder in folders:
        if not folder.is_dir():
            raise InputRefused(f"{folder} is no folder: name the folder that the instruments write to.")
    roots = list(dict.fromkeys(folder.resolve() for folder in folders))
    watched = _Watch(Folders(book_folder.resolve(), roots), replace(request, replace_beginnings=True))
    configured, book = _stamp(book_folder), open_book(book_folder)
    try:
        with book.session(request.person):
            pass  # what a command that was killed left in the journal file takes effect
        yield Watching(tuple(folders))
        first_s, now_s, at_fault = 0.0, 0.0, False
        while not stop():
            if (stamp := _stamp(book_folder)) != configured:
                configured = stamp
                try:
                    opened = open_book(book_folder)
                except LabbookError as error:
                    at_fault = True
                    yield Trouble(CONFIGURATION, str(error))
                else:
                    book.close()
                    book = opened
                    watched.try_refused_again()
                    if at_fault:
                        at_fault = False
                        yield Trouble(CONFIGURATION, "")
            now_s = time.monotonic()
            first_s = first_s or now_s
            troubles = watched.look(now_s)
            looked_s = time.monotonic() - now_s
            yield from troubles
            yield from _take_all(watched, book, due(watched.files, now_s, still_s), stop)
            if once and not _awaited(watched.files, first_s):
                break
            _sleep(max(LOOK_EVERY_S, _SHARE_OF_TIME * looked_s), stop)
        left = [
            watched.folders.name(path) for path, one in watched.files.items() if not one.taken and one.until_s == now_s
        ]
        if left:
            yield Left(tuple(sorted(left)))
    finally:
        book.close()


def _take_all(watched: _Watch, book: Book, paths: Sequence[Path], stop: Callable[[], bool]) -> Iterator[Happening]:
    """Ingest files one after the other; several that the book has are told together, after the others."""
    known: list[Arrived] = []
    for path in paths:
        if stop():
            break
        happened = watched.take(book, path, time.monotonic())
        if isinstance(happened, Arrived) and _is_calm(happened.outcome):
            known.append(happened)
        elif happened is not None:
            yield happened
    if len(known) == 1:
        yield from known
    elif known:
        outdated = sum(OUTDATED in each.outcome.messages for each in known)
        yield Known(tuple(each.outcome.name for each in known), outdated)


def _is_calm(outcome: FileOutcome) -> bool:
    """Tell whether the book has a file, and there is nothing to do about it."""
    to_do = outcome.of_other_run or outcome.raw_restored or outcome.changes
    return outcome.status is IngestStatus.DUPLICATE and not to_do and {*outcome.messages} <= {OUTDATED, HAS_MORE}


def _awaited(files: Files, first_s: float) -> bool:
    """Tell whether a file that was there at `first_s`, and has not grown since, is still to be taken in."""
    return any(not one.taken and one.since_s == first_s and one.seen.size_bytes > 0 for one in files.values())


def _message(outcome: FileOutcome) -> str:
    return "" if outcome.read is None else " ".join(finding.message for finding in outcome.read.findings)


def _stamp(book_folder: Path) -> tuple[int, int] | None:
    """Return by what a change of labbook.toml is seen."""
    try:
        status = (book_folder / CONFIGURATION).stat()
    except OSError:
        return None
    return status.st_size, status.st_mtime_ns


def _sleep(seconds: float, stop: Callable[[], bool]) -> None:
    """Wait, but no longer than until `stop()`."""
    ends_s = time.monotonic() + seconds
    while not stop() and (left_s := ends_s - time.monotonic()) > 0:
        time.sleep(min(left_s, LOOK_EVERY_S))
