"""What a person at a terminal sees while work goes on; a script sees nothing of it."""

from __future__ import annotations

import contextlib
import io
import re
from types import SimpleNamespace

import pytest

from labbook import terminal
from labbook.terminal import before_work, counted


class Terminal(io.StringIO):
    """An error stream that a person looks at."""

    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def _a_wide_one(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"TERM": "xterm", "COLUMNS": "120", "NO_COLOR": "1"}.items():
        monkeypatch.setenv(name, value)


def seen_of(total: int, *advances: int) -> str:
    """What the terminal shows of a sweep that tells these advances."""
    with contextlib.redirect_stderr(Terminal()) as terminal, counted("sweeping", total, "jumps", shown=True) as advance:
        for more in advances:
            advance(more)
    return re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", terminal.getvalue())


def test_what_was_there_before_counts_as_done_and_not_in_the_rate(monkeypatch: pytest.MonkeyPatch) -> None:
    ticks = iter([0.0, 100.0, 102.0, 104.0])
    monkeypatch.setattr(terminal, "time", SimpleNamespace(perf_counter=lambda: next(ticks)))
    assert "9,400/10,000 jumps 100/s" in seen_of(10_000, 9_000, 100, 300)


def test_nothing_was_there_before() -> None:
    assert re.search(r"7/7 jumps [0-9,]+/s", seen_of(7, 0, 7))


def test_a_script_sees_no_bar_and_no_note() -> None:
    with contextlib.redirect_stderr(io.StringIO()) as stream:
        with counted("sweeping", 7, "jumps", shown=True) as advance:
            advance(7)
        before_work(["note: 1 of 2 scenes cannot be simulated."])
    assert stream.getvalue() == ""


def test_a_person_reads_the_note_before_long_work() -> None:
    with contextlib.redirect_stderr(Terminal()) as terminal:
        before_work(["note: 1 of 2 scenes cannot be simulated."])
    assert terminal.getvalue() == "note: 1 of 2 scenes cannot be simulated.\n"
