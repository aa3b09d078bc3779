"""A capsule for sharing says nothing of what `[privacy]` leaves out, says so, and is checked as any other."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from data_schema.errors import InputRefused, UsageError
from labbook.actions.report_command import state_report, write
from labbook.export.capsule import write_capsule
from labbook.export.sharing import LEFT_OUT, Private, parts_left, read_origin
from labbook.export.verifying import verify
from tests.cli.shell import good, labbook
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.capsules import entries_of, files_of, forged
from tests.helpers.wording import refuses, says

BEN = "Ben Ode"
LEAVE_OUT = '\n[privacy]\nleave_out = ["people", "notes", "paths"]\n'


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    """A book of two people, with notes and reasons that name them, and a report with its pages elsewhere."""
    small = small_book(tmp_path_factory.mktemp("sharing") / "book", two_people=True)
    small.toml.write_text(f"# written by {ADA}\n{small.toml.read_text(encoding='utf-8')}{LEAVE_OUT}", encoding="utf-8")
    for words in (
        ("note", "r001", f"{BEN} held the string, as /home/ben/rig/notes.txt says", "--as", "BO"),
        ("jumps", "reject", "r001", "2", "--reason", "other", "--note", f"{ADA} saw it", "--as", BEN),
        ("correct", "r002", "duration_s=700", "--why", f"{ADA} timed it, see C:\\rig\\r002.mp4", "--as", ADA),
    ):
        good(labbook(*words, at=small.folder))
    with small.open() as opened:
        write(opened, None, small.folder.parent / "paper", ADA, lambda _step: None, summary=True)
    return small


def shared(book: SmallBook, file: Path) -> Path:
    with book.open() as opened:
        write_capsule(opened, file, for_sharing=True)
    return file


def test_nothing_says_what_is_left_out_and_all_of_it_can_be_checked(book: SmallBook, tmp_path: Path) -> None:
    file = shared(book, tmp_path / "shared.eln")
    files = files_of(file)
    for path, data in files.items():
        for private in (ADA, BEN, "held the string", "saw it", "/home/ben", "C:\\", "C:\\\\rig"):
            assert path.startswith(("raw/", "signals/")) or private.encode() not in data, (path, private)
    assert b'"person":"BO"' in files["journal.jsonl"]
    assert b"AN timed it" in files["journal.jsonl"]
    found = verify(file)
    assert not found.differences
    original = book.journal.read_text(encoding="utf-8").splitlines()
    head = json.loads(original[-1])["hash"]
    assert json.loads(files["origin.json"]) == {
        "left_out": ["people", "notes", "paths"],
        "entries": len(original),
        "head": head,
    }
    for said in (found.remarks[0], files["VERIFY.md"].decode(), files["ro-crate-metadata.json"].decode()):
        assert says(re.sub(r"\s+", " ", said), "for sharing", "people, notes, paths", head)


def test_all_else_is_as_in_the_book(book: SmallBook, tmp_path: Path) -> None:
    with book.open() as opened:
        write_capsule(opened, tmp_path / "whole.eln")
    whole, file = files_of(tmp_path / "whole.eln"), files_of(shared(book, tmp_path / "shared.eln"))
    assert whole.keys() ^ file.keys() == {"origin.json"}
    values = [
        [(one["path"], one["value"], one["se"]) for one in json.loads(of["report/numbers.json"])["numbers"].values()]
        for of in (whole, file)
    ]
    assert values[0] == values[1]
    for path in ("tables/conditions.csv", "tables/runs.csv", "report/summary.html"):
        assert path in file
    assert whole["tables/conditions.csv"] == file["tables/conditions.csv"]
    for one, other in zip(entries_of(whole), entries_of(file), strict=True):
        assert (one.seq, one.at_utc, one.action, one.entity_uid) == (
            other.seq, other.at_utc, other.action, other.entity_uid
        )  # fmt: skip


@pytest.mark.soak
def test_the_same_book_gives_the_same_bytes(book: SmallBook, tmp_path: Path) -> None:
    (tmp_path / "again").mkdir()
    first, again = shared(book, tmp_path / "shared.eln"), shared(book, tmp_path / "again" / "shared.eln")
    assert first.read_bytes() == again.read_bytes()


def test_where_it_comes_from_cannot_be_changed_unseen(book: SmallBook, tmp_path: Path) -> None:
    file = shared(book, tmp_path / "shared.eln")

    def change(files: dict[str, bytes]) -> None:
        files["origin.json"] = files["origin.json"].replace(b'"head": "', b'"head": "0')

    assert says(verify(forged(file, tmp_path / "forged.eln", change)).differences, "VERIFY.md")
    with refuses(InputRefused, "origin.json"):
        read_origin(b"[]")


def test_a_book_that_says_nothing_of_privacy_is_told_how(tmp_path: Path) -> None:
    small = small_book(tmp_path / "book")
    good(labbook("note", "r001", "a note", "--as", ADA, at=small.folder))
    with small.open() as opened:
        state_report(opened, None, ADA, lambda _step: None)
    with refuses(UsageError, "[privacy]", "leave_out"):
        shared(small, tmp_path / "shared.eln")


def test_a_name_that_toml_hides_is_refused(tmp_path: Path) -> None:
    small = small_book(tmp_path / "book", two_people=True)
    text = small.toml.read_text(encoding="utf-8").replace('"Ben Ode"', '"Ben \\u004fde"')
    small.toml.write_text(text + LEAVE_OUT, encoding="utf-8")
    with small.open() as opened:
        state_report(opened, None, ADA, lambda _step: None)
    with refuses(UsageError, "Ben Ode", "labbook.toml"):
        shared(small, tmp_path / "shared.eln")


@pytest.mark.parametrize(
    ("text", "without"),
    [
        ("see /home/ada/rig.txt", f"see {LEFT_OUT}"),
        ("see ~/rig.txt, and more", f"see {LEFT_OUT}, and more"),
        ('path = "/mnt/lab/my book"', f'path = "{LEFT_OUT}"'),
        ('path = "C:\\\\lab"', f'path = "{LEFT_OUT}"'),
        ("kg/s and N/m, 1/2, and/or", "kg/s and N/m, 1/2, and/or"),
        ("https://doi.org/10.1000/182", "https://doi.org/10.1000/182"),
        ("2021/06/14", "2021/06/14"),
        ("raw/ab/cd.zst", "raw/ab/cd.zst"),
    ],
)
def test_paths_are_left_out_and_units_are_not(text: str, without: str) -> None:
    assert Private({}, notes=False, paths=True).text(text) == without


def test_a_name_is_left_out_whole() -> None:
    private = Private({"Al": "A", "Ada Nwosu": "AN"}, notes=False, paths=False)
    assert private.text("Al and Ada Nwosu, Alan, Also Al's") == "A and AN, Alan, Also A's"


def test_parts_of_names_that_are_left_are_listed() -> None:
    files = {
        "tables/runs.csv": b"why_void\nnwosu dropped it\n",
        "labbook.toml": b"# ada.nwosu@uni.example",
        "a.csv": b"Nwosuan",
    }
    (left,) = parts_left(files, ["Ada Nwosu"])
    assert "Nwosu" in left
    assert "tables/runs.csv and 1 more" in left
    assert parts_left({"a.csv": b"Nwosuan, Ada"}, ["Ada Nwosu"]) == ()
