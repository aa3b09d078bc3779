"""Trace the ways through the house: which files a command enters, and which calls cross from file to file.

python scripts/trace_ways.py          traces every way in WAYS and prints the table of docs/architecture.md
python scripts/trace_ways.py report   lists the files that one way enters, with the calls that go upward

Each way is the real command, run in a process of its own in the small book of `tests/helpers/books.py`. Counted are
functions of the six packages that are called; imports, and the list of commands that is put together, are left out. A
call goes from the file of the nearest of our functions on the stack to the file that is entered, so that a library in
between does not hide it; several calls between the same two files are one. It goes upward where its target lies in a
higher layer than its origin; the layers are those of pyproject.toml.
"""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
import tempfile
import threading
import tomllib
from collections import Counter
from pathlib import Path
from types import FrameType
from typing import Any

PROJECT = Path(__file__).resolve().parents[1]
WAYS = {
    "ingest": ("ingest", "../new/r014.csv"),
    "sheet": ("ingest", "../new/2021-06-16.csv"),
    "report": ("report", "--foot", "small"),
    "stats": ("stats", "compare", "--where", "foot=small and k_gain=400"),
    "sim": ("sim", "run", "--scene", "sim2", "--accuracy", "1e-6"),
    "runs": ("runs", "list", "--where", "foot=small"),
}
"""The ways by the names they are asked for; a file under ../new is one that the book does not have yet."""

Calls = list[tuple[str, str]]
"""The files that call and are called."""

ENTRY = "labbook/cli/start.py"
"""Where a command begins: `labbook.cli.start.main`."""

_SETTING_UP = {"<module>", "application"}
"""Code that is no part of a way: what a module runs when it is loaded, and putting the commands together."""
_TRACED = "import sys; sys.path.insert(0, {project!r}); from scripts.trace_ways import trace; trace(sys.argv[1:])"


class Trace:
    """A profiler that keeps which file called which; switched on by `start`."""

    def __init__(self, packages: list[str]) -> None:
        self.calls: set[tuple[str, str]] = set()
        self._packages = tuple(f"{package}{os.sep}" for package in packages)
        self._names: dict[str, str | None] = {}
        self._setting_up: Counter[int] = Counter()  # by thread: one may load a module while another is on its way

    def start(self) -> None:
        """Trace this thread and those that it starts."""
        threading.setprofile(self._event)
        sys.setprofile(self._event)

    def _event(self, frame: FrameType, event: str, _argument: object) -> None:
        thread = threading.get_ident()
        if frame.f_code.co_name in _SETTING_UP:
            self._setting_up[thread] += (event == "call") - (event == "return")
        elif event == "call" and not self._setting_up[thread] and (entered := self._ours(frame)):
            caller = frame.f_back
            while caller and not self._ours(caller):
                caller = caller.f_back
            origin = self._ours(caller) if caller else ENTRY
            if origin and origin != entered:
                self.calls.add((origin, entered))

    def _ours(self, frame: FrameType) -> str | None:
        path = frame.f_code.co_filename
        if path not in self._names:
            name = os.path.relpath(path, PROJECT) if path.startswith(str(PROJECT)) else ""
            self._names[path] = name if name.startswith(self._packages) else None
        return self._names[path]


def trace(words: list[str]) -> None:
    """Run one command of labbook under the profiler and write the calls to the file named by the first word."""
    from labbook.cli.main import run

    traced = Trace(_importlinter()["root_packages"])
    try:
        traced.start()
        run(words[1:])
    finally:
        sys.setprofile(None)
        Path(words[0]).write_text(json.dumps(sorted(traced.calls)), encoding="utf-8")


def calls_of(words: tuple[str, ...]) -> Calls:
    """Run a command in a small book that has every file but the one under ../new; return its calls."""
    from tests.helpers.books import ingest_all, small_book

    with tempfile.TemporaryDirectory() as name:
        made = small_book(Path(name), ingested=False)
        for path in [file for file in made.instruments.rglob("*.csv") if f"../new/{file.name}" in words]:
            (made.folder.parent / "new").mkdir()
            path.rename(made.folder.parent / "new" / path.name)
        with made.open() as book:
            ingest_all(book, made.instruments)
        calls = Path(name) / "calls.json"
        answer = subprocess.run(
            [sys.executable, "-c", _TRACED.format(project=str(PROJECT)), str(calls), *words],
            cwd=made.folder,
            env={**os.environ, "PYTHONPATH": str(PROJECT), "LABBOOK_AS": "Ada Nwosu"},
            capture_output=True,
            text=True,
            check=False,
        )
        if answer.returncode not in (0, 1):
            raise SystemExit(f"labbook {' '.join(words)}: {answer.stderr}")
        return [(origin, entered) for origin, entered in json.loads(calls.read_text(encoding="utf-8"))]


def upward(calls: Calls) -> Calls:
    """Return the calls whose target lies in a higher layer of pyproject.toml than their origin."""
    ranks: dict[str, int] = {}
    for contract in _importlinter()["contracts"]:
        container = [*contract.get("containers", []), ""][0]
        for rank, layer in enumerate(reversed(contract.get("layers", []))):
            ranks |= {f"{container}.{name}".lstrip("."): rank for name in layer.replace(" ", "").split("|")}

    def place(file: str) -> tuple[str, int, int]:
        package, part = Path(file).with_suffix("").parts[:2]
        return package, ranks[package], ranks.get(f"{package}.{part}", 0)

    found = []
    for origin, entered in calls:
        (package, rank, inner), (other, other_rank, other_inner) = place(origin), place(entered)
        if other_rank > rank or (other == package and other_inner > inner):
            found.append((origin, entered))
    return found


def row(words: tuple[str, ...], calls: Calls) -> str:
    """Return what was traced of a command as a row of the table in docs/architecture.md."""
    files = {entered for _, entered in calls}
    crossing = [call for call in calls if Path(call[0]).parent != Path(call[1]).parent]
    return (
        f"| `{shlex.join(words)}` | {len(files)} | {len({Path(file).parent for file in files})} | {len(calls)} "
        f"({len(crossing)}) | {len(upward(calls))} |"
    )


def _importlinter() -> dict[str, Any]:
    settings: dict[str, Any] = tomllib.loads((PROJECT / "pyproject.toml").read_text())["tool"]["importlinter"]
    return settings


if __name__ == "__main__":
    sys.path.insert(0, str(PROJECT))
    if len(sys.argv) > 1:
        calls = calls_of(WAYS[sys.argv[1]])
        print(*sorted({entered for _, entered in calls}), sep="\n")
        print(*(f"upward: {origin} -> {entered}" for origin, entered in upward(calls)), sep="\n")
    else:
        for words in WAYS.values():
            print(row(words, calls_of(words)))
