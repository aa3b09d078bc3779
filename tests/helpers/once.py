"""Making what is dear once for all test processes that run side by side."""

from __future__ import annotations

import fcntl
import functools
import os
import pickle
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")
SHARED = "LABBOOK_TESTS_SHARED"
"""The environment variable with the folder of one test run; `tests/conftest.py` makes and removes it."""


def made_once(name: str, make: Callable[[Path], T]) -> T:
    """Return what `make` returned for a folder of this name, in whichever process asked first; it must be picklable."""
    shared = Path(os.environ.get(SHARED) or _outside_of_tests().name)
    folder, result = shared / name, shared / f"{name}.pickle"
    with (shared / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not result.exists():
            shutil.rmtree(folder, ignore_errors=True)  # of one that could not be made
            folder.mkdir()
            result.write_bytes(pickle.dumps(make(folder)))
        found: T = pickle.loads(result.read_bytes())
    return found


@functools.cache
def _outside_of_tests() -> tempfile.TemporaryDirectory[str]:
    """The folder of a script that makes the books of the tests, removed when it ends."""
    return tempfile.TemporaryDirectory()
