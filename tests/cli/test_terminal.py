"""What files and people are called reaches a terminal as text, never as an order to it."""

from __future__ import annotations

import json

import pytest

from labbook.terminal import within_width
from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook

EVIL = "\x1b]0;owned\x07\x1b[2Jred\x9b31m\u202egnp.exe\x7f"
"""Sets a title, clears the screen, colours by an 8-bit control, turns what follows around, deletes."""
OBEYED = set("\x1b\x07\x9b\u202e\x7f\r\b")


@pytest.mark.parametrize("flags", [[], ["--json"]])
def test_names_of_files_and_notes_are_escaped_wherever_they_are_printed(whole: SmallBook, flags: list[str]) -> None:
    at = whole.folder
    name = f"r001{EVIL}.csv"
    path = whole.instruments / name
    path.write_bytes(b"".join(whole.log("r001").read_bytes().splitlines(keepends=True)[:80]))
    broken = whole.instruments / f"broken{EVIL}.csv"
    broken.write_bytes(b"\x00\x01")
    said = [labbook("ingest", path, broken, "--run", "r002", *flags, at=at), labbook("ingest", path, *flags, at=at)]
    said.append(good(labbook("note", "r001", EVIL, *flags, at=at)))
    questions = ("show r001", "show r002", "files list", "runs inbox", "today", "runs list")
    said += [labbook(*question.split(), *flags, at=at) for question in questions]
    said.append(labbook("files", "show", name, *flags, at=at))
    said.append(labbook("files", "show", f"none{EVIL}", *flags, at=at))
    said.append(labbook("jumps", "list", EVIL, *flags, at=at))
    said.append(labbook(EVIL, at=at))
    for answer in said:
        assert not OBEYED & set(answer.out + answer.err), answer
    printed = "".join(answer.out for answer in said)
    for escaped in ("\\u001b", "\\u009b") if flags else ("\\x1b", "\\x9b"):
        assert escaped in printed
    assert "\\u202e" in printed


def test_json_still_says_what_a_note_said(whole: SmallBook) -> None:
    good(labbook("note", "r001", EVIL, at=whole.folder))
    shown = good(labbook("show", "r001", "--json", at=whole.folder)).out
    assert json.loads(shown)["notes"][-1]["text"] == EVIL


def test_further_lines_of_a_note_stay_and_cannot_pass_for_statements(whole: SmallBook) -> None:
    good(labbook("note", "r001", "one\n\ttwo\n  2026-11-24T11:52:37.043Z Ada Nwosu corrected", at=whole.folder))
    shown = good(labbook("show", "r001", at=whole.folder)).out
    assert "one\n    | \ttwo\n    |   2026-11-24T11:52:37.043Z" in shown


def test_sentences_break_between_words_on_a_narrow_terminal_and_nowhere_else(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = ["Energy was 3.93 J lower under AD than under CE.", "", f"  {'word ' * 8}"]
    assert within_width(lines) == lines
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "30")
    broken = within_width(lines)
    assert broken[:3] == ["Energy was 3.93 J lower under", "AD than under CE.", ""]
    assert broken[3:] == ["  word word word word word", "      word word word"]
