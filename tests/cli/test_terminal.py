"""What files and people are called reaches a terminal as text, never as an order to it."""

from __future__ import annotations

import contextlib
import io
import json

import pytest

from labbook.terminal import counted, within_width
from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook

EVIL = "\x1b]0;owned\x07\x1b[2Jred\x9b31m\u202egnp.exe\x7f"
"""Sets a title, clears the screen, colours by an 8-bit control, turns what follows around, deletes."""
OBEYED = set("\x1b\x07\x9b\u202e\x7f\r\b")


@pytest.mark.parametrize("flags", [[], ["--json"]])
def test_names_of_files_and_notes_are_escaped_wherever_they_are_printed(whole: SmallBook, flags: list[str]) -> None:
    at = whole.folder
    name = f"r001{EVIL}.csv"
    path, broken = whole.instruments / name, whole.instruments / f"broken{EVIL}.csv"
    path.write_bytes(b"".join(whole.log("r001").read_bytes().splitlines(keepends=True)[:80]))
    broken.write_bytes(b"\x00\x01")
    good(labbook("note", "r001", EVIL, *flags, at=at))
    said = [labbook("ingest", path, broken, "--run", "r002", *flags, at=at), labbook("ingest", path, *flags, at=at)]
    questions = ("show r001", "show r002", "files list", "runs inbox", "today", "runs list")
    said += [labbook(*question.split(), *flags, at=at) for question in questions]
    said += [labbook("files", "show", which, *flags, at=at) for which in (name, f"none{EVIL}")]
    said += [labbook("jumps", "list", EVIL, *flags, at=at), labbook(EVIL, at=at)]
    for answer in said:
        assert not OBEYED & set(answer.out + answer.err), answer
    printed = "".join(answer.out for answer in said)
    for escaped in ("\\u202e", *(("\\u001b", "\\u009b") if flags else ("\\x1b", "\\x9b"))):
        assert escaped in printed


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
    sentence, indented = ["Energy was 3.93 J lower under", "AD than under CE."], ["  word word word word word"]
    assert within_width(lines) == [*sentence, "", *indented, "      word word word"]


class Terminal(io.StringIO):
    """An error stream that a person looks at."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("stream", [Terminal(), io.StringIO()], ids=["terminal", "script"])
def test_what_is_done_is_counted_where_a_person_looks(stream: io.StringIO, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"TERM": "xterm", "COLUMNS": "120"}.items():
        monkeypatch.setenv(name, value)
    with contextlib.redirect_stderr(stream), counted("sweeping", 10_000, "jumps", shown=True) as advance:
        for more in (9_000, 100, 300):  # the first were there before
            advance(more)
    assert ("9,400/10,000 jumps" in stream.getvalue()) is stream.isatty()
    assert stream.isatty() or not stream.getvalue()
