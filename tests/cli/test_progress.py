"""What a person at a terminal sees while work goes on; a script sees nothing of it."""

from __future__ import annotations

import contextlib
import io

import pytest

from labbook.terminal import counted


class Terminal(io.StringIO):
    """An error stream that a person looks at."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("stream", [Terminal(), io.StringIO()], ids=["terminal", "script"])
def test_what_is_done_is_counted_where_a_person_looks(stream: io.StringIO, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"TERM": "xterm", "COLUMNS": "120", "NO_COLOR": "1"}.items():
        monkeypatch.setenv(name, value)
    with contextlib.redirect_stderr(stream), counted("sweeping", 10_000, "jumps", shown=True) as advance:
        for more in (9_000, 100, 300):  # the first were there before
            advance(more)
    assert ("9,400/10,000 jumps" in stream.getvalue()) is stream.isatty()
    assert stream.isatty() or not stream.getvalue()
