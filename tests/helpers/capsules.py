"""Capsules of the small book, and what somebody could make of one who packs its files again with fitting hashes."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

from data_schema import journal
from data_schema.journal import Entry
from data_schema.vocabulary import Action
from labbook.actions.report_command import write
from labbook.export.archive import member, write_archive
from labbook.export.capsule import SUMS, VERIFY, write_capsule
from labbook.export.crate import METADATA
from tests.helpers.books import ADA, SmallBook, copy_of, reported_book, small_book

Files = dict[str, bytes]


def capsule_of_small_book(folder: Path) -> Path:
    """Copy a capsule of the small book with its report, which is made once a test run; returns the file."""

    def made(above: Path) -> SmallBook:
        small = reported_book(above)
        with small.open() as book:
            write_capsule(book, above / "study.eln")
        return small

    copy_of("small-book-capsule", made, folder)
    return folder / "study.eln"


def capsule_of_drawn_report(folder: Path) -> Path:
    """Copy a capsule of the small book whose report has its pages, which is made once a test run."""

    def made(above: Path) -> SmallBook:
        small = small_book(above)
        with small.open() as book:
            write(book, None, None, ADA, lambda _step: None)
            write_capsule(book, above / "study.eln")
        return small

    copy_of("small-book-drawn-capsule", made, folder)
    return folder / "study.eln"


def files_of(capsule: Path) -> Files:
    """The files of a capsule by their paths below its folder."""
    with zipfile.ZipFile(capsule) as archive:
        return {name.partition("/")[2]: archive.read(name) for name in archive.namelist()}


def entries_of(files: Mapping[str, bytes]) -> list[Entry]:
    return [Entry.from_line(line) for line in files["journal.jsonl"].decode().splitlines()]


def forged(capsule: Path, out: Path, change: Callable[[Files], None]) -> Path:
    """Write a capsule again with changed files: crate, list of hashes and archive fit them."""
    files = files_of(capsule)
    at = datetime.fromisoformat(entries_of(files)[-1].at_utc)
    change(files)
    crate: dict[str, Any] = json.loads(files.pop(METADATA))
    members = {path: member(path, data) for path, data in files.items() if path != SUMS}
    listed = "".join(f"{one.sha256}  {path}\n" for path, one in members.items())
    members[SUMS] = member(SUMS, listed.encode())
    known = {node["@id"].removeprefix("./"): node for node in crate["@graph"] if node["@type"] == "File"}
    for path, one in members.items():
        if path not in known:
            known[path] = {"@id": f"./{path}", "@type": "File", "name": path}
            crate["@graph"].append(known[path])
        known[path] |= {"contentSize": str(one.n_bytes), "sha256": one.sha256}
    crate["@graph"] = [node for node in crate["@graph"] if node["@type"] != "File" or node in known.values()]
    crate["@graph"] = [
        node for node in crate["@graph"] if node["@type"] != "File" or node["@id"].removeprefix("./") in members
    ]
    metadata = member(METADATA, (json.dumps(crate, indent=1, ensure_ascii=False) + "\n").encode())
    others = [members[path] for path in sorted(members) if path not in (VERIFY, SUMS)]
    write_archive(out, "study", [metadata, members[VERIFY], members[SUMS], *others], at)
    return out


def rechained(files: Files, change: Callable[[Entry], Entry]) -> None:
    """Change entries of the journal, and give it a chain that fits."""
    entries: list[Entry] = []
    for command in journal.commands(entries_of(files)):
        after = (entries[-1].seq, entries[-1].hash) if entries else (0, journal.GENESIS)
        entries += journal.chain_entries([change(entry) for entry in command], after)
    files["journal.jsonl"] = "".join(f"{entry.line}\n" for entry in entries).encode()


def restated(files: Files) -> None:
    """Let the journal's entry of the report have the hashes of the files that are here."""
    folder = "report/"
    of_report = {
        path.removeprefix(folder): member(path, data).sha256 for path, data in files.items() if path.startswith(folder)
    }
    rechained(files, lambda entry: with_new(entry, files=of_report) if entry.action is Action.REPORT else entry)


def with_new(entry: Entry, **values: Any) -> Entry:
    """An entry that says something else."""
    return replace(entry, new={**(entry.new or {}), **values})
