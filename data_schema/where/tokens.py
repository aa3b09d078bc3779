"""Cut the text of `--where` into words, comparisons and marks; every token knows where it stands."""

from __future__ import annotations

import operator
import re
import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from data_schema.errors import UsageError

LONGEST_TEXT = 10_000
"""Characters that a condition may have."""


class Operator(StrEnum):
    """How a column is compared with one value."""

    EQUAL = "="
    NOT_EQUAL = "!="
    LESS = "<"
    LESS_OR_EQUAL = "<="
    GREATER = ">"
    GREATER_OR_EQUAL = ">="


COMPARE: Mapping[Operator, Callable[[Any, Any], Any]] = {
    Operator.EQUAL: operator.eq,
    Operator.NOT_EQUAL: operator.ne,
    Operator.LESS: operator.lt,
    Operator.LESS_OR_EQUAL: operator.le,
    Operator.GREATER: operator.gt,
    Operator.GREATER_OR_EQUAL: operator.ge,
}
"""What each makes of two values, and of a column of a database and a value: a condition in SQL."""


@dataclass(frozen=True, slots=True)
class Word:
    """A name or value as written (quotes and escapes removed), and the character it starts at, from 1."""

    text: str
    position: int = field(default=0, compare=False)


OPERATORS = {**{str(one): one for one in Operator}, "==": Operator.EQUAL, "<>": Operator.NOT_EQUAL}
"""Every spelling of a comparison."""

_KEYWORDS = frozenset({"and", "or", "not", "in"})
_TOKEN = re.compile(
    r"""(?P<quoted>"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*')|(?P<operator>[=!<>]+)|(?P<mark>[(),])|(?P<bare>[\w.+\-:/]+)""",
    re.DOTALL,
)
_ESCAPE = re.compile(r"\\(.)", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Token:
    """A piece of the text; `kind` is quoted, operator, mark, bare, keyword or end."""

    kind: str
    text: str
    position: int

    def __str__(self) -> str:
        return "the end" if self.kind == "end" else repr(self.text)


def tokens(text: str) -> list[Token]:
    """Cut `text` into tokens; the last one has the kind `end`.

    Raises `UsageError` with the position of the first character that cannot be read.
    """
    if len(text) > LONGEST_TEXT:
        raise UsageError(
            f"the condition of --where has {len(text)} characters, at most {LONGEST_TEXT} are read: shorten it."
        )
    found: list[Token] = []
    place = 0
    while place < len(text):
        # A database refuses NUL and broken UTF-8 with an error of its own, far from what the person typed.
        if unicodedata.category(text[place]) in ("Cc", "Cs") and not text[place].isspace():
            raise UsageError(f"character {place + 1} of --where is not printable: take it out.")
        if text[place].isspace():
            place += 1
            continue
        match = _TOKEN.match(text, place)
        if match is None:
            raise UsageError(_unreadable(text[place], place + 1))
        found.append(_token(match))
        place = match.end()
    found.append(Token("end", "", len(text) + 1))
    return found


def _unreadable(character: str, position: int) -> str:
    if character in "'\"":
        return f"the quote at character {position} of --where is never closed: add a second {character}."
    return (
        f"{character!r} at character {position} of --where means nothing here: write comparisons such as kind=jumps, "
        "joined by 'and', 'or', 'not', and put quotes round a value with unusual characters."
    )


def _token(match: re.Match[str]) -> Token:
    kind, text, position = str(match.lastgroup), match.group(), match.start() + 1
    if kind == "quoted":
        inside = text[1:-1]
        for escape in _ESCAPE.finditer(inside):
            if escape.group(1) not in "\\'\"":
                raise UsageError(
                    f"{escape.group()!r} at character {position + 1 + escape.start()} of --where is not an escape: "
                    "after a backslash comes a quote or a second backslash."
                )
        text = _ESCAPE.sub(r"\1", inside)
        if any(unicodedata.category(character) in ("Cc", "Cs") for character in text):
            raise UsageError(f"the value at character {position} of --where has an unprintable character: take it out.")
    elif kind == "operator" and text not in OPERATORS:
        raise UsageError(f"{text!r} at character {position} of --where is not a comparison: use =, !=, <, <=, > or >=.")
    elif kind == "bare" and text.lower() in _KEYWORDS:
        return Token("keyword", text.lower(), position)
    return Token(kind, text, position)
