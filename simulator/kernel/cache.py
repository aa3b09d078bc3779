"""Compiled kernels on disk, so that only the first process with a set of effects compiles.

numba's own cache looks at the file of the function it compiles: edit a function in another file that it calls, and the
old physics is served. Here the folder's name holds a hash of every source of the simulator, and of what compiled it.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import itertools
import sys
from collections.abc import Iterable, Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

from numba.core.bytecode import FunctionIdentity
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator
from numba.core.runtime.nrt import rtsys

from data_schema.errors import UsageError
from data_schema.file_cache import (
    CACHE_VARIABLE,
    for_nobody_else,
    forget_old_versions,
    make_version_folder,
    places_above,
    why_not_trusted,
)
from simulator.compiled import Function, compiled


def cached_entry(function: Function, types: tuple[Any, ...], what: str, effects: Iterable[str]) -> Function:
    """Compile a function that Python calls with arguments of these numba types, or load it from disk.

    It is composed for `effects`, and may be an inner one of a kernel; `what` distinguishes it from other entries for
    them. The fingerprint of the kernels does not include the module that defines it, so the name includes that module's
    hash.
    """
    name = (what, _source_hash(function.__module__), *effects)
    entry = compiled(getattr(function, "py_func", function))
    if hasattr(entry, "compile"):  # with NUMBA_DISABLE_JIT=1 it is the plain function
        give_unique_symbols(name)
        keep_on_disk(entry, name)
        with compiling_alone(name):
            entry.compile(types)
    return entry


@functools.cache
def _source_hash(module: str) -> str:
    return hashlib.sha256(Path(str(sys.modules[module].__file__)).read_bytes()).hexdigest()[:20]


KIND = "kernels"
MOST_VERSIONS = 3
USES_OF_KERNELS = ("ablation", "accuracy", "steady", "sweep", "thesis")
"""Parts of the simulator that use kernels and are no part of them."""


def fingerprint(sources: Path | None = None) -> str:
    """Hash of all sources that a kernel may be made of, of Python, numba and llvmlite.

    `sources` defaults to this package's folder; `USES_OF_KERNELS` are left out: an import contract keeps kernels free
    of them.
    """
    folder = sources or Path(__file__).parents[1]
    digest = hashlib.sha256(f"{sys.version} {metadata.version('numba')} {metadata.version('llvmlite')}".encode())
    for path in sorted(folder.rglob("*.py")):
        if path.relative_to(folder).parts[0] in USES_OF_KERNELS:
            continue
        digest.update(str(path.relative_to(folder)).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:20]


_FINGERPRINT = fingerprint()
"""Of the sources as this process has imported them: one that is edited later is none of what it compiles."""


def give_unique_symbols(effects: tuple[str, ...]) -> None:
    """Start numba's count of functions at a number of the effects' own, before anything of a kernel is compiled.

    The count is part of each symbol's name and starts at 1 in every process: kernels that two processes compiled would
    hold the same names for different functions, and a third that loads both would run one with the other's physics.
    """
    FunctionIdentity._unique_ids = itertools.count(int(_name(effects), 16) >> 20 << 20)


def _name(effects: tuple[str, ...]) -> str:
    return hashlib.sha256(" ".join(effects).encode()).hexdigest()[:16]


@contextlib.contextmanager
def compiling_alone(effects: tuple[str, ...]) -> Iterator[None]:
    """Hold the right to compile these effects' kernel: another process that wants it waits, and then loads it."""
    try:
        import fcntl

        folder = make_version_folder(KIND, _FINGERPRINT)
        file = (folder / f"{_name(effects)}.lock").open("w")
    except (ImportError, OSError):  # no such locks here, or no folder: each compiles for itself
        yield
        return
    with file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def keep_on_disk(kernel: Any, effects: tuple[str, ...]) -> None:
    """Let a compiled function look for its machine code on disk, and put it there.

    Raises `UsageError` where others could have put theirs there: it would run with the rights of who loads it.
    """
    try:
        folder = make_version_folder(KIND, _FINGERPRINT)
    except OSError:
        return  # a read-only home: every process compiles for itself
    _refuse_shared(folder)
    forget_old_versions(folder, MOST_VERSIONS)
    kernel._cache = _kernel_cache(kernel.py_func, folder, _name(effects))


def on_disk(kernel: Any) -> bool:
    """Whether there is machine code on disk for a function that looks for it there."""
    cache_file = getattr(kernel._cache, "_cache_file", None)
    return cache_file is not None and Path(cache_file._index_path).exists()


def _refuse_shared(folder: Path) -> None:
    for place in (*places_above(folder), *folder.glob("*.nb?")):
        if whose := why_not_trusted(place):
            raise UsageError(
                f"compiled kernels are not loaded from {str(place)!r}, for {whose} and could have put any program "
                f"there: remove it, or name a folder of your own in {CACHE_VARIABLE}."
            )


def _kernel_cache(function: Function, folder: Path, name: str) -> FunctionCache:
    class Locator(_CacheLocator):
        _py_file = function.__code__.co_filename  # numba names it where it warns

        def get_cache_path(self) -> str:
            return str(folder)

        def get_source_stamp(self) -> str:
            return _FINGERPRINT

        def get_disambiguator(self) -> str:
            return name

        @classmethod
        def from_function(cls, py_func: Function, py_file: str) -> Locator:
            return cls()

    class Implementation(CompileResultCacheImpl):
        _locator_classes: Any = (Locator,)

    class KernelCache(FunctionCache):
        _impl_class = Implementation

        def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
            # not the closure's cells, as numba's own: they hold functions whose pickles differ in each process
            return (sig, codegen.magic_tuple(), name)

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            base: Any = super()
            try:  # as numba's own, but for all that only compiling asks for: half a second, 60 MB
                rtsys.initialize(target_context)
                with base._guard_against_spurious_io_errors():
                    return base._load_overload(sig, target_context)
            except Exception:  # a file cut off by a full disk or a power cut: whatever it says, compile anew
                with contextlib.suppress(OSError):
                    base.flush()
                return None

        def save_overload(self, sig: Any, data: Any) -> None:
            base: Any = super()
            with (
                contextlib.suppress(OSError),
                for_nobody_else(),
            ):  # a folder that takes no files: every process compiles for itself
                base.save_overload(sig, data)

    make: Any = KernelCache
    result: FunctionCache = make(function)
    return result
