"""A weakness: an input on which programs in wide use return wrong numbers, with the truth and how it is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

TO_THE_LAST_DIGIT = 1e-14
"""Relative error that labbook may have where a case says nothing else."""


@dataclass(frozen=True, slots=True)
class Number:
    """The truth is a number."""

    value: Callable[[], float]
    how: str
    """How it is known: "exact arithmetic" (on the doubles given), "mpmath", "definition"."""
    rel: float = TO_THE_LAST_DIGIT


@dataclass(frozen=True, slots=True)
class NoNumber:
    """There is no such number: the answer is a reason, or the input is refused, in a sentence that holds `cause`."""

    cause: str
    instead: str = "no such number"
    """What the truth is called in the table."""


@dataclass(frozen=True, slots=True)
class Peer:
    """What another program answers."""

    library: str
    call: str
    """Function, and what of its answer where that is not plain."""
    answer: Callable[[], Any]
    """Returns a number, or something that `float` takes; may raise."""
    recorded: float | str
    """The wrong answer known: a number to two digits, "nan", or the name of an exception."""


@dataclass(frozen=True, slots=True)
class Question:
    """One number asked of all programs."""

    what: str
    truth: Number | NoNumber
    ours: Callable[[], Any]
    """labbook's answer: a number or `Undefined`; or it raises `InputRefused`."""
    others: tuple[Peer, ...]
    digits: int = 3
    """How many are shown, so that right and wrong can be told apart."""


@dataclass(frozen=True, slots=True)
class Weakness:
    """One case."""

    name: str
    """"W1" to "W27"."""
    title: str
    data: str
    """The values themselves, or how they were made."""
    questions: tuple[Question, ...]
