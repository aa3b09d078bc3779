"""A pipe, a device or a link where a book has a file: refused in a sentence, never waited for, mended as a lost one."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from ingest.store import raw_path
from tests.cli.shell import good, process, refused
from tests.helpers.books import SmallBook
from tests.helpers.statements import in_file

SPECIAL: dict[str, Callable[[Path], object]] = {
    "pipe": os.mkfifo,
    "device": lambda path: path.symlink_to("/dev/zero"),
    "link": lambda path: path.symlink_to(path.with_name("kept elsewhere")),
}


@pytest.fixture(params=SPECIAL)
def put(request: pytest.FixtureRequest) -> Callable[[Path], object]:
    def instead(path: Path) -> None:
        path.rename(path.with_name("kept elsewhere"))
        SPECIAL[request.param](path)

    return instead


def test_a_raw_copy_that_is_no_file_is_told_and_the_original_mends_it(
    stated: SmallBook, tmp_path: Path, put: Callable[[Path], object]
) -> None:
    good(process("ingest", stated.log("r001"), at=stated.folder))
    with stated.open() as book:
        sha256 = next((entry.new or {})["sha256"] for entry in in_file(book) if entry.action == "ingest")
    copy = stated.folder / raw_path(sha256)
    put(copy)
    assert process("db", "check", at=stated.folder).code == 3
    refused(process("files", "reread", "r001.csv", at=stated.folder), 3, sha256[:12])
    refused(process("backup", tmp_path / "backup", at=stated.folder), 3, sha256[:12])
    process("ingest", stated.log("r001"), at=stated.folder)
    copy.with_name("kept elsewhere").unlink()
    good(process("db", "check", at=stated.folder))


def test_a_journal_that_is_no_file_is_refused(stated: SmallBook, tmp_path: Path, put: Callable[[Path], object]) -> None:
    put(stated.journal)
    for words in (["note", "r001", "x"], ["backup", tmp_path / "backup"]):
        refused(process(*words, at=stated.folder), 3, "journal.jsonl")
    assert process("db", "check", at=stated.folder).code == 3
