"""The journal's file: append-only lines, of which only complete commands count.

An incomplete command at the end of the file, left by a power cut, does not count. Its bytes are not thrown away: before
the next command is written, they are moved to a file beside the journal. A last line that lacks only its newline is
complete, as its hash shows.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import overload

from data_schema.disk import SPECIAL, is_special, stamp, sync, today_utc
from data_schema.errors import BookDamaged
from data_schema.journal import MEND_FILE, Entry, verified_chain

CUT_OFF = "cut-off"
"""Part of the name of the file that keeps what was cut off."""


@dataclass(frozen=True, slots=True)
class LeftOut:
    """The end of a journal file that does not count: how many lines, the last perhaps half a one, and bytes."""

    lines: int
    n_bytes: int

    @property
    def sentence(self) -> str | None:
        """Say in words what does not count and what becomes of it; None where all of the file does."""
        if not self.n_bytes:
            return None
        several = self.lines > 1
        return (
            f"{self.lines} line{'s' if several else ''} at the end of journal.jsonl ({self.n_bytes} bytes) "
            f"{'do' if several else 'does'} not count, being what is left of a command that was cut off; the next "
            f"command that writes keeps {'them' if several else 'it'} as journal.jsonl.{CUT_OFF}.TIME."
        )


NOTHING = LeftOut(0, 0)


class JournalFile:
    """The mirror of the journal on disk, append-only; an incomplete command at its end does not count.

    `remedy` is the advice for mending a damaged file.
    """

    def __init__(self, path: Path, remedy: str = MEND_FILE) -> None:
        self.path = path
        self.remedy = remedy

    def entries(self) -> Iterator[Entry]:
        """Read and verify every entry of every complete command."""
        yield from verified_chain((self._entry(line) for line in self._read(None).lines), remedy=self.remedy)

    def refuse_other_form(self) -> None:
        """Raise `BookVersion` where the journal is of another form; whether it is damaged is not looked at."""
        with contextlib.suppress(BookDamaged):
            next(self.entries(), None)

    def held(self) -> HeldEntries:
        """Return all entries, not verified, in little memory."""
        return HeldEntries(self._read(None).lines, self.remedy)

    def _entry(self, line: str) -> Entry:
        return Entry.from_line(line, self.remedy)

    def tail(self, after_seq: int) -> list[Entry]:
        """Return the entries of complete commands after `after_seq`, reading from the end of the file."""
        for part in self._tail_parts():
            newest: list[Entry] = []
            for line in reversed(part.lines):
                entry = self._entry(line)
                if entry.seq <= after_seq:
                    return newest[::-1]
                newest.append(entry)
            if part.start == 0 or (newest and newest[-1].seq == after_seq + 1):
                return newest[::-1]
        raise AssertionError("the last part is the whole file")

    def damage(self) -> str | None:
        """Say what is wrong with the file, None where nothing is.

        It is read through once a day, and where it was changed since it was found whole: its size and time of change
        then stand in a file beside it.
        """
        state = self._file_state()
        if self._found_whole():
            return None
        try:
            for _entry in self.entries():
                pass
        except BookDamaged as error:
            return str(error)
        self._remember_whole(state)
        return None

    def _found_whole(self) -> bool:
        try:
            return self._remembered().read_text(encoding="utf-8") == self._file_state()
        except (OSError, UnicodeDecodeError):
            return False

    def _remember_whole(self, state: str) -> None:
        with contextlib.suppress(OSError):  # then it is read again
            self._remembered().write_text(state, encoding="utf-8")

    def _remembered(self) -> Path:
        return self.path.with_name(f".whole.{self.path.name}")

    def _file_state(self) -> str:
        """Return size and time of change of the file, to be compared with those of the last check; none if missing."""
        try:
            found = self.path.stat()
        except OSError:
            return "none"
        return f"{found.st_size} {found.st_mtime_ns} {today_utc()}"

    def last(self) -> Entry | None:
        """Return the last entry of the last complete command."""
        lines = self._last_part().lines
        return self._entry(lines[-1]) if lines else None

    def left_out(self) -> LeftOut:
        """Return how much at the end of the file does not count."""
        rest = self._last_part().rest
        return LeftOut(rest.count(b"\n") + (not rest.endswith(b"\n")) if rest else 0, len(rest))

    def keep_cut_off(self) -> Path | None:
        """Copy what does not count to a file beside the journal; returns its path, None where all counts."""
        rest = self._last_part().rest
        if not rest:
            return None
        leftover = self.path.with_name(f"{self.path.name}.{CUT_OFF}.{stamp()}")
        try:
            leftover.write_bytes(rest)
            sync(leftover)
        except BaseException:
            leftover.unlink(missing_ok=True)
            raise
        sync(leftover.parent)
        return leftover

    def append(self, entries: list[Entry]) -> None:
        """Write complete commands at the end and sync them to the disk; what a cut-off one left is set aside first.

        Raises `OSError` where nothing was written that counts, `BookDamaged` where all of it stands there all the same.
        """
        whole = self._found_whole()
        self.keep_cut_off()
        part = self._last_part()
        lines = (b"" if part.ended else b"\n") + "".join(entry.line + "\n" for entry in entries).encode()
        with self.path.open("r+b", buffering=0) as handle:
            handle.truncate(part.end)
            written = 0
            try:
                while written < len(lines):
                    written += os.pwrite(handle.fileno(), lines[written:], part.end + written)
                os.fsync(handle.fileno())
            except BaseException as error:
                try:
                    handle.truncate(part.end)
                except OSError:
                    if written == len(lines):
                        raise BookDamaged(
                            f"the disk failed while {self.path} was written ({error}): check it. What was said stands "
                            "there already: do not say it again, the next command applies it."
                        ) from error
                raise
        if whole:
            self._remember_whole(self._file_state())

    def _last_part(self) -> _Part:
        """Read as much of the end of the file as holds a complete command."""
        for part in self._tail_parts():
            if part.lines or part.start == 0:
                return part
        raise AssertionError("the last part is the whole file")

    def _tail_parts(self) -> Iterator[_Part]:
        """Read ever more of the end of the file, at last all of it."""
        for last_bytes in _FROM_THE_END:
            part = self._read(last_bytes)
            yield part
            if part.start == 0:
                return

    def _read(self, last_bytes: int | None) -> _Part:
        if is_special(self.path):
            raise BookDamaged(f"{self.path} {SPECIAL}: {self.remedy}.")
        lines: list[str] = []
        n_bytes, unended = 0, b""
        try:
            with self.path.open("rb") as handle:
                size = handle.seek(0, os.SEEK_END)
                start = 0 if last_bytes is None else max(0, size - last_bytes)
                handle.seek(start)
                if start:  # a part begins within a line
                    start += len(handle.readline())
                for line in handle:
                    if line.endswith(b"\n"):
                        lines.append(line[:-1].decode())
                    else:
                        unended = line
                    n_bytes += len(line)
        except FileNotFoundError as error:
            raise BookDamaged(f"{self.path} is missing: {self.remedy}.") from error
        except UnicodeDecodeError as error:
            raise BookDamaged(
                f"{self.path} is not the text that was written (byte {start + n_bytes + error.start}): {self.remedy}."
            ) from error
        whole = _whole(unended) if unended else None
        if whole is not None:
            lines.append(whole)
        complete = lines[: len(lines) - _cut_off(lines)]
        ended = whole is None or len(complete) < len(lines)
        dropped = [line.encode() for line in lines[len(complete) :]]
        rest = b"".join(line + b"\n" for line in dropped) + unended if whole is None else b"\n".join(dropped)
        return _Part(start, complete, start + n_bytes - len(rest), ended, rest)


class HeldEntries(Sequence[Entry]):
    """Entries of a journal by their lines, each read when it is asked for: a tenth of the memory of all of them."""

    def __init__(self, lines: Sequence[str], remedy: str = MEND_FILE) -> None:
        self._lines = lines
        self._remedy = remedy

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._lines)

    @overload
    def __getitem__(self, place: int) -> Entry: ...
    @overload
    def __getitem__(self, place: slice) -> HeldEntries: ...
    def __getitem__(self, place: int | slice) -> Entry | HeldEntries:
        """Return one, or some."""
        if isinstance(place, slice):
            return HeldEntries(self._lines[place], self._remedy)
        return Entry.from_line(self._lines[place], self._remedy)


@dataclass(frozen=True, slots=True)
class _Part:
    """The complete lines of complete commands from byte `start` of a journal up to byte `end`.

    `ended`: the last of them has its newline; `rest`: the bytes after `end`.
    """

    start: int
    lines: list[str]
    end: int
    ended: bool
    rest: bytes


_FROM_THE_END: tuple[int | None, ...] = (1 << 16, 1 << 20, None)
"""How many bytes of the end are read: almost always the first are enough."""


def _whole(line: bytes) -> str | None:
    """Return the text of a last line without newline where all of it is there and fits its hash."""
    try:
        text = line.decode()
        Entry.from_line(text)
    except (UnicodeDecodeError, BookDamaged):
        return None
    return text


def _cut_off(lines: Sequence[str]) -> int:
    """Return how many of the last lines belong to a command whose last line is not there."""
    count, awaited = 0, None
    for line in reversed(lines):
        following = Entry.from_line(line).following
        if following == 0 or awaited not in (None, following):
            break
        count, awaited = count + 1, following + 1
    return count
