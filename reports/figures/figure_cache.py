"""A cache of drawn figures in the user's cache folder: only what changed is drawn.

A file's name is a hash of all that the drawing is made of: what the figure shows of the report, and its width. The
folder's is a hash of what draws: sources, and versions of matplotlib and of what it lays out and writes with. Each
file begins with the hash of the rest; one that was cut off is drawn anew, and so is everything where somebody else
may write, who could put anything onto the page.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import mmap
import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import TypeVar

from data_schema.cache_folder import forget_old_versions, make_version_folder, places_above, why_not_trusted
from data_schema.second_process import has_core, run_in_fork
from reports.content import ReportContent
from reports.figures.kind import FigureKind, draw_figure, pdf_bytes, svg_bytes

KIND = "figures"
MOST_VERSIONS = 2
MOST_BYTES = 64 * 2**20
"""Of one version; beyond, the files go that were used longest ago."""
_DRAW_WITH = ("matplotlib", "numpy", "kiwisolver", "contourpy")
_HASH_BYTES = 32

T = TypeVar("T")


@cache
def drawing_version() -> str:
    """Hash of what draws: every source of `reports` and of the words that it uses, Python, and the libraries."""
    versions = [f"{name} {metadata.version(name)}" for name in _DRAW_WITH]
    digest = hashlib.sha256("\n".join([sys.version, *versions]).encode())
    reports = Path(__file__).parents[1]
    root = reports.parent
    for path in sorted([*reports.rglob("*.py"), *(root / "data_schema").glob("*.py")]):
        digest.update(str(path.relative_to(root)).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:20]


@dataclass(frozen=True, slots=True)
class Wanted:
    """A figure at a width in inches, and the formats that are wanted of it: "svg", "pdf"."""

    kind: FigureKind
    width_in: float
    formats: Sequence[str]


def cached_figures(
    content: ReportContent, wanted: Sequence[Wanted], meanwhile: Callable[[], T]
) -> tuple[list[dict[str, bytes]], T]:
    """Return figures of the report by format, in order: each as it was drawn before of the same, else drawn now, once.

    `meanwhile` is done too, and what it returns is returned. Where there is a core for it a second process draws from
    the first figure on, this one after that from the last on, until they meet. It hands its figures over in the folder;
    what does not arrive is drawn here.
    """
    folder = _folder()
    paths = [_paths(folder, content, one) for one in wanted]
    found = [_stored(one, some) for one, some in zip(wanted, paths, strict=True)]
    missing = [place for place, known in enumerate(found) if known is None]
    shared = len(missing) > 1 and folder is not None and has_core()
    begun: mmap.mmap | bytearray = mmap.mmap(-1, len(wanted)) if shared else bytearray(len(wanted))

    def draw(places: Iterable[int]) -> None:
        for place in places:
            if not begun[place]:
                begun[place] = 1
                found[place] = _drawn_anew(content, wanted[place], paths[place])

    if shared:
        importlib.import_module("matplotlib.backends.backend_svg")  # the copy has then all that drawing loads
    copy = run_in_fork(lambda: draw(missing)) if shared else None
    other = meanwhile()
    draw(reversed(missing))
    if copy:
        copy.result()
    for place in missing:
        if found[place] is None:
            found[place] = _stored(wanted[place], paths[place]) or _drawn_anew(content, wanted[place], paths[place])
    return [known for known in found if known is not None], other


def _paths(folder: Path | None, content: ReportContent, wanted: Wanted) -> dict[str, Path]:
    """Return the path of a figure in each format, nothing without a folder."""
    if folder is None:
        return {}
    shown = wanted.kind.absent(content) or wanted.kind.drawn(content)
    key = hashlib.sha256(f"{wanted.kind.name} {wanted.width_in!r} {shown!r}".encode()).hexdigest()
    return {name: folder / f"{key}.{name}" for name in wanted.formats}


def _stored(wanted: Wanted, paths: Mapping[str, Path]) -> dict[str, bytes] | None:
    """Return a figure from the cache, None where one of its formats is not there."""
    known = {name: data for name, path in paths.items() if (data := _read(path)) is not None}
    return known if len(known) == len(wanted.formats) else None


def _drawn_anew(content: ReportContent, wanted: Wanted, paths: Mapping[str, Path]) -> dict[str, bytes]:
    figure = draw_figure(wanted.kind, content, wanted.width_in)
    found = {"svg": svg_bytes(figure)}  # always first: the other format has its positions
    if "pdf" in wanted.formats:
        found["pdf"] = pdf_bytes(figure)
    for name, path in paths.items():
        _keep(path, found[name])
    return {name: found[name] for name in wanted.formats}


def forget_unused(most_bytes: int = MOST_BYTES) -> None:
    """Remove the figures of old versions, and those used longest ago beyond `most_bytes`."""
    if (current := _folder()) is None:
        return
    with contextlib.suppress(OSError):
        forget_old_versions(current, MOST_VERSIONS)
        files = sorted(((path.stat(), path) for path in current.iterdir()), key=lambda file: -file[0].st_mtime)
        total = 0
        for about, path in files:
            total += about.st_size
            if total > most_bytes:
                path.unlink()


def _folder() -> Path | None:
    """Return the folder of this version, made where it is missing; None where it cannot be, or is not one's own."""
    try:
        folder = make_version_folder(KIND, drawing_version())
        return None if any(map(why_not_trusted, places_above(folder))) else folder
    except OSError:
        return None


def _read(path: Path) -> bytes | None:
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


def _keep(path: Path, data: bytes) -> None:
    with contextlib.suppress(OSError):  # a full disk: it is drawn again the next time
        handle, part = tempfile.mkstemp(dir=path.parent, suffix=".part")
        try:
            with os.fdopen(handle, "wb") as stream:
                stream.write(hashlib.sha256(data).digest() + data)
            Path(part).replace(path)
        finally:
            Path(part).unlink(missing_ok=True)
