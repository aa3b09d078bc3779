"""A cache of files in the user's cache folder: what was computed once, under a hash of all that it was computed from.

The folder is named after a hash of what computes: sources, and versions of libraries. Each file begins with the hash
of the rest; one that was cut off is computed anew, and so is everything where somebody else may write, who could put
anything there. Every file may be deleted at any time.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import metadata
from pathlib import Path

MOST_VERSIONS = 2
MOST_BYTES = 64 * 2**20
"""Of one version; beyond, the files go that were used longest ago."""
_HASH_BYTES = 32
_PACKAGES = Path(__file__).parents[1]
"""Where this package lies, and those beside it."""
_reading = True


@contextlib.contextmanager
def without_caches() -> Iterator[None]:
    """Let all be computed anew for as long as this is open, for a check that may trust no cache."""
    global _reading
    before, _reading = _reading, False
    try:
        yield
    finally:
        _reading = before


@dataclass(frozen=True)
class FileCache:
    """Files of a kind; what they hold depends on source files and on `libraries`, by name.

    `sources` are patterns of files beside the packages: "stats/**/*.py"; each names some.
    """

    kind: str
    sources: tuple[str, ...]
    libraries: tuple[str, ...]

    @cached_property
    def version(self) -> str:
        """Hash of what computes."""
        versions = [f"{name} {_version_of(name)}" for name in self.libraries]
        digest = hashlib.sha256("\n".join([sys.version, *versions]).encode())
        files = {pattern: sorted(_PACKAGES.glob(pattern)) for pattern in self.sources}
        if missing := [pattern for pattern, found in files.items() if not found]:
            raise ValueError(f"the cache of {self.kind} depends on {missing[0]}, and there is no such file")
        for path in sorted(path for found in files.values() for path in found):
            digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
        return digest.hexdigest()[:20]

    @property
    def folder(self) -> Path | None:
        """The folder of this version, made where it is missing; None where it cannot be, or is not one's own.

        Making it changes the rights of all files that the process makes meanwhile: threads ask when it is there.
        """
        try:
            folder = cache_folder(self.kind) / self.version
            if not folder.is_dir():
                make_version_folder(self.kind, self.version)
            return None if any(map(why_not_trusted, places_above(folder))) else folder
        except OSError:
            return None

    def read(self, name: str) -> bytes | None:
        """Return what a file holds, None where it is not there or not whole."""
        if not _reading or (folder := self.folder) is None:
            return None
        path = folder / name
        try:
            if why_not_trusted(path):
                return None
            stored = path.read_bytes()
            data = stored[_HASH_BYTES:]
            if hashlib.sha256(data).digest() != stored[:_HASH_BYTES]:
                return None
            os.utime(path)  # used now
        except OSError:
            return None
        return data

    def has(self, name: str) -> bool:
        """Tell whether a file is there; what it holds is for `read` to judge."""
        return _reading and (folder := self.folder) is not None and (folder / name).is_file()

    def write(self, name: str, data: bytes) -> None:
        """Put a file there; on a full disk it is computed again the next time."""
        if (folder := self.folder) is None:
            return
        with contextlib.suppress(OSError):
            handle, part = tempfile.mkstemp(dir=folder, suffix=".part")
            try:
                with os.fdopen(handle, "wb") as stream:
                    stream.write(hashlib.sha256(data).digest() + data)
                Path(part).replace(folder / name)
            finally:
                Path(part).unlink(missing_ok=True)

    def forget_unused(self, most_bytes: int = MOST_BYTES) -> None:
        """Remove the files of old versions, and those used longest ago beyond `most_bytes`."""
        if (current := self.folder) is None:
            return
        with contextlib.suppress(OSError):
            forget_old_versions(current, MOST_VERSIONS)
            files = sorted(((path.stat(), path) for path in current.iterdir()), key=lambda file: -file[0].st_mtime)
            total = 0
            for about, path in files:
                total += about.st_size
                if total > most_bytes:
                    path.unlink()


@cache  # several caches depend on one library, whose whole description is parsed for it
def _version_of(library: str) -> str:
    return metadata.version(library)


CACHE_VARIABLE = "LABBOOK_CACHE"
"""Environment variable with the folder for what is computed once; otherwise the user's cache folder is taken."""
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
_VERSION = re.compile("[0-9a-f]{20}")


def cache_folder(kind: str) -> Path:
    """Return the folder for all versions of what is cached of a kind, such as "kernels"."""
    if given := os.environ.get(CACHE_VARIABLE):
        return Path(given) / f"labbook-{kind}"
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / "labbook" / kind


def make_version_folder(kind: str, version: str) -> Path:
    """Return the folder of a version, which is a hash of 20 hexadecimal digits; made where it is missing."""
    folder = cache_folder(kind) / version
    with for_nobody_else():
        folder.mkdir(parents=True, exist_ok=True)
    return folder


@contextlib.contextmanager
def for_nobody_else() -> Iterator[None]:
    """Make files and folders that nobody else can write to, whatever this user's usual rights are."""
    before = os.umask(0o077)
    os.umask(before | _OTHERS_WRITE)
    try:
        yield
    finally:
        os.umask(before)


def places_above(folder: Path) -> tuple[Path, ...]:
    """Return a version's folder and those above it in which somebody could put another in its place."""
    given = os.environ.get(CACHE_VARIABLE)
    return (folder, folder.parent, *([Path(given)] if given else []))


def why_not_trusted(place: Path) -> str | None:
    """Say who else could have put there what is read from a file or folder; None where nobody could."""
    found = place.stat()
    is_sticky = stat.S_ISDIR(found.st_mode) and found.st_mode & stat.S_ISVTX  # nobody replaces another's there
    if found.st_uid in (os.geteuid(), 0) and (is_sticky or not found.st_mode & _OTHERS_WRITE):
        return None
    return "others may write to it" if found.st_mode & _OTHERS_WRITE else "it belongs to somebody else"


def forget_old_versions(current: Path, n_retained: int) -> None:
    """Remove the folders of all but the `n_retained` latest versions, of which `current` is one."""
    others = [path for path in current.parent.iterdir() if _VERSION.fullmatch(path.name) and path != current]
    others.sort(key=lambda path: path.stat().st_mtime, reverse=True)
    for path in others[n_retained - 1 :]:
        shutil.rmtree(path, ignore_errors=True)
