"""The lab notebook of a robotics lab that counts: the command line, and from Python `labbook.open(FOLDER)`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from labbook.export.read_only_book import ReadOnlyBook

__all__ = ["open"]


def open(folder: str | Path | None = None) -> ReadOnlyBook:  # noqa: A001 - as `xarray.open_dataset`, by the package's name
    """Open a book for reading alone; its methods return frames, samples and results.

    Parameters
    ----------
    folder : the book's folder, or one within it; without it the one that holds the current folder

    Raises
    ------
    BookMissing : there is no book there
    """
    from labbook.export.read_only_book import open_read_only  # the command line does not wait for it

    return open_read_only(folder)
