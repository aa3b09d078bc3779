"""The book that a server shows: opened again when its labbook.toml changed."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from pathlib import Path

from data_schema.errors import BookBusy
from labbook.book.opening import CONFIGURATION, Book, open_book


@dataclass
class OpenBook:
    """A book's folder, who speaks on the page, whether the page may state anything, and what tells it from others."""

    folder: Path
    person: str
    read_only: bool
    name: str = ""
    _book: Book | None = None
    _seen: tuple[int, int] = (0, 0)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def current(self) -> Book:
        """Return the book as its labbook.toml describes it now."""
        with self._lock:
            try:
                about = (self.folder / CONFIGURATION).stat()
            except OSError as error:
                raise BookBusy(f"{CONFIGURATION} cannot be read just now ({error.strerror}): try again.") from error
            seen = (about.st_mtime_ns, about.st_size)
            if self._book is None or seen != self._seen:
                fresh = open_book(self.folder)
                if self._book is not None:
                    self._book.close()
                self._book, self._seen = fresh, seen
            return self._book

    def close(self) -> None:
        """Close it."""
        with self._lock:
            if self._book is not None:
                self._book.close()
                self._book = None
