"""What people call an entry: for each command that states something, of a book with runs, logs and charges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from labbook.book.naming import Words, words_of
from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook, small_book
from tests.helpers.hopping_log import apex_s, hopping_log
from tests.helpers.statements import in_file

WHY = ("--why", "for this test")
SHEET = "2021-06-14.csv"
OFF = ("assign", f"{SHEET}#1", "none", *WHY)
CORRECTED = ("corrected", "correction", None)

Commands = Sequence[Sequence[str]]
CALLED: Mapping[str, tuple[Commands, tuple[str, str | None, str | None]]] = {
    "log assigned": ([("assign", "r001.csv", "none", *WHY)], ("assigned", "assignment", None)),
    "log assigned again": (
        [("assign", "r001.csv", "none", *WHY), ("assign", "r001.csv", "r001")],
        ("assigned", "assignment", None),
    ),
    "log moved": ([("assign", "r001.csv", "r002", *WHY)], CORRECTED),
    "charge taken off": ([OFF], ("assigned", "assignment", None)),
    "charge assigned": ([OFF, ("assign", f"{SHEET}#1", "r001")], ("assigned", "assignment", None)),
    "charge moved": ([("assign", f"{SHEET}#2", "none", *WHY), ("assign", f"{SHEET}#1", "r002", *WHY)], CORRECTED),
    "charge's run corrected": (
        [("assign", f"{SHEET}#2", "none", *WHY), ("correct", "CHARGE", "run=r002", *WHY)],
        CORRECTED,
    ),
    "charge's run taken away": ([("correct", "CHARGE", "run=none", *WHY)], ("assigned", "assignment", None)),
    "charge corrected": ([("correct", "r001", "mah=56.1", *WHY)], CORRECTED),
    "charge typed": ([("void", "r001", *WHY), OFF, ("charge", "r001", "56.1")], ("declared", None, None)),
    "charge dismissed": ([OFF, ("runs", "dismiss", f"{SHEET}#1", *WHY)], ("dismissed", "charge dismissed", None)),
    "charge restored": (
        [OFF, ("runs", "dismiss", f"{SHEET}#1", *WHY), ("runs", "restore", f"{SHEET}#1")],
        ("restored", "file or charge restored", "taken into use again"),
    ),
    "run corrected": ([("correct", "r001", "jumps=2", *WHY)], CORRECTED),
    "run void": ([("void", "r001", *WHY)], ("declared void", "void run or plan", None)),
    "run not void": ([("void", "r001", *WHY), ("void", "r001", "--undo", *WHY)], CORRECTED),
    "file withdrawn": ([("files", "withdraw", "r001.csv", *WHY)], ("withdrew", "file withdrawn", "withdrawn")),
    "file restored": (
        [("files", "withdraw", "r001.csv", *WHY), ("files", "restore", "r001.csv")],
        ("restored", "file or charge restored", "taken into use again"),
    ),
    "file taken in": ([("ingest", "../new.csv")], ("took in", "file", "ingested")),
    "file refused": ([("ingest", "../odd.csv")], ("refused", "refused file", None)),
    "file read again": (
        [("files", "reread", "r001.csv", "--column", "body_height [m]=body_height:m,offset=0.01")],
        ("read again", "file read again", "read anew"),
    ),
    "jump rejected": (
        [("jumps", "reject", "r001", "1", "--reason", "misfire")],
        ("rejected", "verdict", "rejected"),
    ),
    "jump accepted": ([("jumps", "accept", "r001", "1")], ("accepted", "verdict", "accepted")),
    "jump moved": ([("jumps", "move", "r001", "1", "--at", "APEX")], ("moved", "verdict", "given another apex")),
    "jump added": (
        [
            ("assign", "r001.csv", "none", *WHY),
            ("ingest", "../new.csv", "--run", "r001"),
            ("jumps", "add", "r001", "--at", f"{apex_s(4):.3f}"),
        ],
        ("added", "verdict", "added"),
    ),
    "jump cleared": (
        [("jumps", "accept", "r001", "1"), ("jumps", "clear", "r001", "1")],
        ("cleared", "verdict", "left to the protocol again"),
    ),
    "plan": ([("plan", "--seed", "7", "--n", "1")], ("declared", None, None)),
    "plan withdrawn": (
        [("plan", "--seed", "7", "--n", "1"), ("plan", "--withdraw", *WHY)],
        ("declared void", "void run or plan", None),
    ),
    "note": ([("note", "r001", "a word")], ("noted", None, None)),
    "report": ([("report",)], ("wrote", "report", None)),
}


@pytest.fixture
def book(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path)


def given(book: SmallBook, words: Sequence[str]) -> None:
    """Give a command, with the uid of the charge of r001 and a moment beside its first apex in place of their words."""
    shown = good(labbook("show", "r001", "--json", at=book.folder)).json
    charge = next((f"charge:{one['uid']}" for one in shown["charges"]), "")
    jumps = labbook("jumps", "list", "r001", "--json", at=book.folder)
    apex_s = jumps.json["jumps"][0]["jump"]["apex_s"] if jumps.code == 0 else 0.0
    in_words = {"CHARGE": charge, "APEX": f"{apex_s + 0.02:.3f}"}
    answer = labbook(*(in_words.get(word, word) for word in words), at=book.folder)
    assert answer.code == (2 if "../odd.csv" in words else 0), answer


@pytest.mark.parametrize("called", CALLED)
def test_an_entry_is_called_by_its_command(called: str, book: SmallBook) -> None:
    commands, words = CALLED[called]
    above = book.folder.parent
    above.joinpath("odd.csv").write_bytes(b"%PDF-1.7 not a log at all\n")
    above.joinpath("new.csv").write_bytes(hopping_log(10, shallow=[4]))
    for command in commands:
        given(book, command)
    with book.open() as opened:
        last = in_file(opened)[-1]
    assert words_of(last) == Words(*words)


def test_values_of_another_kind_change_no_name(book: SmallBook) -> None:
    with book.open() as opened:
        entries = in_file(opened)
    for entry in entries:
        odd = {"verdict": "accept"} if entry.entity_kind == "ingest" else {"findings": []}
        assert words_of(replace(entry, new={**(entry.new or {}), **odd})) == words_of(entry)
