"""Making what is dear once for all test processes that run side by side."""

from __future__ import annotations

import fcntl
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import pytest

T = TypeVar("T")


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], T]) -> T:
    """Return what `make` returned for a folder of this name, in whichever process asked first; it must be picklable."""
    parallel = "popen-" in factory.getbasetemp().name
    shared = factory.getbasetemp().parent if parallel else factory.getbasetemp()
    folder, result = shared / name, shared / f"{name}.pickle"
    with (shared / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not result.exists():
            folder.mkdir(exist_ok=True)
            result.write_bytes(pickle.dumps(make(folder)))
        found: T = pickle.loads(result.read_bytes())
    return found
