"""What the product says: a test names the facts of a sentence, and not its words."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TypeVar

import pytest

E = TypeVar("E", bound=BaseException)
LONG = 400


def says(text: object, *facts: object) -> str:
    """Return the first line of `text`, or of a list of lines, that has all `facts`.

    Of a line beyond 400 characters it is a sentence, and where no line has all facts, the whole text. A space that does
    not break counts as a space.
    """
    __tracebackhide__ = True
    whole = ("\n".join(map(str, text)) if isinstance(text, list | tuple) else str(text)).replace("\u00a0", " ")
    found = next((piece for piece in _pieces(whole) if all(str(fact) in piece for fact in facts)), None)
    if found is None:
        pytest.fail(f"nothing says all of {facts}:\n{whole}")
    return found


def refuses(error: type[E], *facts: object) -> pytest.RaisesExc[E]:
    """Expect an exception that says all `facts`."""
    return pytest.raises(error, check=lambda refused: bool(says(refused, *facts)))


def _pieces(whole: str) -> Iterator[str]:
    """Yield lines, sentences of long ones, and the whole text."""
    for line in whole.splitlines():
        yield from map(str.strip, re.split(r"(?<=\. )|(?<=>)(?=[^<])|(?=<)", line) if len(line) > LONG else [line])
    yield whole.strip()
