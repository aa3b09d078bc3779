"""The zip archive of a capsule: the same bytes for the same files, and read as if somebody hostile had packed it.

Files are stored and not compressed: raw copies and samples are compressed already, and compressed bytes would depend on
the version of the library that made them. So every byte of a capsule is either one of a file, whose hash the crate
states, or one that `write_archive` writes of names, sizes and the time: written again, the archive has the same bytes.

Another program may have packed the files anew and compressed them: they are read all the same, into a folder that is
named, each no further than its crate states, all together no further than `MOST_EXPANSION` times the archive.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import stat
import struct
import unicodedata
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import pairwise, takewhile
from pathlib import Path, PurePosixPath
from types import TracebackType
from typing import IO, Self

from data_schema.disk import partial_path, path_in_errors, put_in_place
from data_schema.errors import InputRefused, UsageError

BLOCK = 1 << 20
ASK_AGAIN = "ask who gave you the capsule for another copy"
MOST_EXPANSION = 20
"""Times the archive that its files may have together: text that another program compressed has less."""
MOST_BESIDE = 64 * 2**20
"""Bytes that any archive's files may have, however small it is."""
MOST_DIRECTORY = 32 * 2**20
"""Bytes of the list of names at the end of an archive, which is in memory as a whole: of 200 000 files."""
LONGEST_NAME, LONGEST_PART = 1000, 200

_UNIX, _ENCRYPTED = 3, 0x1
_RIGHTS = (stat.S_IFREG | 0o644) << 16


@dataclass(frozen=True, slots=True)
class Member:
    """A file of a capsule: its path below the root folder, its bytes or where they lie, how many, and their sums."""

    path: str
    source: bytes | Path
    n_bytes: int
    sha256: str
    crc32: int


def member(path: str, source: bytes | Path) -> Member:
    """Read a file's bytes through; raises `OSError` where they cannot be read."""
    n_bytes, crc32, digest = 0, 0, hashlib.sha256()
    for block in _blocks(source):
        n_bytes, crc32 = n_bytes + len(block), zlib.crc32(block, crc32)
        digest.update(block)
    return Member(path, source, n_bytes, digest.hexdigest(), crc32)


def _blocks(source: bytes | Path) -> Iterator[bytes]:
    if isinstance(source, bytes):
        yield source
        return
    with source.open("rb") as stream:
        while block := stream.read(BLOCK):
            yield block


def write_archive(file: Path, root: str, members: Sequence[Member], at: datetime) -> None:
    """Write an archive with one folder; it appears whole or not at all, and replaces nothing.

    Parameters: where it goes, the folder's name, the files in their order, and the time that all of them get.
    Raises `UsageError` where the file exists, or where the bytes of a member are not those that were measured.
    """
    _refuse_existing(file)
    part = partial_path(file)
    year = min(max(at.year, 1980), 2107)
    try:
        with path_in_errors(file), zipfile.ZipFile(part, "w") as archive:
            for one in members:
                about = zipfile.ZipInfo(f"{root}/{one.path}", (year, at.month, at.day, at.hour, at.minute, at.second))
                about.create_system, about.external_attr, about.file_size = _UNIX, _RIGHTS, one.n_bytes
                with archive.open(about, "w") as stream:
                    for block in _blocks(one.source):
                        stream.write(block)
                if one.crc32 != about.CRC:
                    raise UsageError(f"{one.path} changed while it was packed: give the command again.")
        _refuse_existing(file)
        put_in_place(file)
    finally:
        part.unlink(missing_ok=True)


def _refuse_existing(file: Path) -> None:
    if os.path.lexists(file):
        raise UsageError(f"{str(file)!r} exists, and is not replaced: name another file, or remove it.")


def first_difference(file: Path, other: Path) -> int | None:
    """Return the first byte in which two files differ; None where there is none."""
    place = 0
    with file.open("rb") as stream, other.open("rb") as beside:
        while True:
            one, two = stream.read(BLOCK), beside.read(BLOCK)
            if one != two:
                same = takewhile(lambda pair: pair[0] == pair[1], zip(one, two, strict=False))
                return place + sum(1 for _pair in same)
            if not one:
                return None
            place += len(one)


_UNREADABLE = (
    *(zipfile.BadZipFile, zlib.error, struct.error, EOFError),
    *(NotImplementedError, UnicodeError, ValueError, OverflowError, RuntimeError, KeyError, OSError),
)
"""What the standard library raises of archives that are not as they should be."""


class Archive:
    """An archive that somebody sent, open for reading: one folder, and the files in it by their paths below it.

    Nothing of it is believed but names that are harmless on any system; how many bytes a file has is counted.
    """

    def __init__(self, file: Path) -> None:
        self.file = file
        self.n_bytes = file.stat().st_size
        self.root, self._entries = "", dict[str, zipfile.ZipInfo]()
        self._stream = file.open("rb")
        try:
            _refuse_large_directory(self._stream, self.n_bytes, file)
            self._zip = zipfile.ZipFile(self._stream)
            self.root, self._entries = _harmless(self._zip.infolist(), file)
        except _UNREADABLE as error:
            self.close()
            raise _not_a_capsule(file, f"it cannot be read as a zip archive ({error})") from error
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Give the file back."""
        self._stream.close()

    @property
    def paths(self) -> list[str]:
        """The paths of its files below its folder, in its order."""
        return list(self._entries)

    def read(self, path: str, most: int) -> bytes:
        """Return the bytes of a file; raises `InputRefused` where it has more than `most`, or cannot be read."""
        return b"".join(self._read(path, most))

    def extract(self, path: str, most: int, folder: Path) -> Member:
        """Write a file below a folder, and return what was written.

        Raises `InputRefused` where it has more than `most` bytes, or cannot be read; what was written of it is removed.
        """
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            with target.open("xb") as stream:
                for block in self._read(path, most):
                    stream.write(block)
        except BaseException:
            target.unlink(missing_ok=True)
            raise
        return member(path, target)

    def refuse_more_than(self, n_bytes: int, folder: Path) -> None:
        """Raise `InputRefused` where its files state more bytes than such an archive can have, or a disk has room."""
        most = MOST_BESIDE + MOST_EXPANSION * self.n_bytes
        if n_bytes > most:
            raise _not_a_capsule(
                self.file,
                f"its files state {n_bytes} bytes together, where an archive of {self.n_bytes} has at most {most}",
            )
        needed, free = 2 * n_bytes, shutil.disk_usage(folder).free  # unpacked, and packed again to be compared
        if needed > free:
            raise UsageError(
                f"{self.file} needs {needed} bytes in {folder}, which has {free}: make room, or set TMPDIR to a folder "
                "on another disk."
            )

    def _read(self, path: str, most: int) -> Iterator[bytes]:
        n_bytes = 0
        try:
            with self._zip.open(self._entries[path]) as stream:
                while block := stream.read(BLOCK):
                    n_bytes += len(block)
                    if n_bytes > most:
                        raise InputRefused(f"{path} has more than the {most} bytes that it may have: {ASK_AGAIN}.")
                    yield block
        except _UNREADABLE as error:
            raise InputRefused(f"{path} cannot be read from the archive ({error}): {ASK_AGAIN}.") from error


_END = struct.Struct("<4s4H2LH")
_END_64_BYTES, _SIZE_64 = 76, slice(40, 48)
"""Of both records that an archive of more than 4 GB has before its end, and where they have its size."""


def _refuse_large_directory(stream: IO[bytes], n_bytes: int, file: Path) -> None:
    """Raise `InputRefused` for what is no archive, and for one whose list of names would fill the memory."""
    stream.seek(max(0, n_bytes - _END.size))
    end = stream.read(_END.size)
    if len(end) < _END.size or not end.startswith(b"PK\5\6"):
        raise _not_a_capsule(file, "it is not a zip archive, was cut off, or something was added at its end")
    size = _END.unpack(end)[5]
    if size == 0xFFFFFFFF and n_bytes >= _END.size + _END_64_BYTES:
        stream.seek(n_bytes - _END.size - _END_64_BYTES)
        size = int.from_bytes(stream.read(_END_64_BYTES)[_SIZE_64], "little")
    if size > MOST_DIRECTORY:
        raise _not_a_capsule(file, f"its list of names has {size} bytes, more than {MOST_DIRECTORY}")
    stream.seek(0)


def _harmless(entries: Iterable[zipfile.ZipInfo], file: Path) -> tuple[str, dict[str, zipfile.ZipInfo]]:
    """Return the one folder, and its files by path below it; raises `InputRefused` for names that are not harmless."""
    found: dict[str, zipfile.ZipInfo] = {}
    roots, folded = set[str](), dict[str, str]()
    for entry in entries:
        name = entry.orig_filename
        why = _why_not(entry)
        if why is not None:
            raise _not_a_capsule(file, f"{name[:LONGEST_PART]!r} in it {why}")
        root, _slash, path = name.partition("/")
        roots.add(root)
        if entry.is_dir():
            continue
        same = folded.setdefault(unicodedata.normalize("NFC", name).casefold(), name)
        if path in found or same != name:
            raise _not_a_capsule(file, f"it holds {name!r} twice, or a name that differs in its letters' case alone")
        if not path:
            raise _not_a_capsule(file, f"{name!r} in it lies in no folder, where all files lie in one")
        found[path] = entry
    if len(roots) != 1:
        raise _not_a_capsule(file, f"it has {len(roots)} folders at its root, where a capsule has one")
    _refuse_file_and_folder(folded, file)
    return roots.pop(), found


def _refuse_file_and_folder(folded: Mapping[str, str], file: Path) -> None:
    """Raise `InputRefused` where a file has the name of the folder of another."""
    parts = sorted(PurePosixPath(name).parts for name in folded)
    for before, after in pairwise(parts):
        if after[: len(before)] == before:
            raise _not_a_capsule(file, f"{'/'.join(before)!r} in it is a file and a folder")


def _why_not(entry: zipfile.ZipInfo) -> str | None:
    """Say why an entry is not read; None where it may be."""
    name, kind = entry.orig_filename, entry.external_attr >> 16
    parts = name.removesuffix("/").split("/")
    if len(name.encode(errors="replace")) > LONGEST_NAME or any(len(part.encode()) > LONGEST_PART for part in parts):
        return "has too long a name"
    if any(unicodedata.category(sign) in ("Cc", "Cs") for sign in name) or "\\" in name or ":" in name:
        return "has signs in its name that no file of a capsule has"
    if any(part in ("", ".", "..") for part in parts):
        return "does not lie below the folder of the archive"
    if stat.S_IFMT(kind) not in (0, stat.S_IFREG, stat.S_IFDIR):
        return "is no file but a link or a device"
    if entry.flag_bits & _ENCRYPTED:
        return "is encrypted: unpack it with its password, and pack it without"
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        return "is compressed by a method that few programs know"
    return None


def _not_a_capsule(file: Path, why: str) -> InputRefused:
    return InputRefused(
        f"{str(file)!r} is not read, for {why}: {ASK_AGAIN}, as labbook wrote it, and compare its SHA-256."
    )
