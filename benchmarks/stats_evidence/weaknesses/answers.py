"""What programs answer to a question today, and whether that is right, wrong as known, or wrong otherwise."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any

from benchmarks.stats_evidence.weaknesses.case import NoNumber, Number, Peer
from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined

RIGHT_TO = 1e-6
"""Relative error up to which another program's number counts as right."""
ALIKE_TO = 0.05
"""Relative error up to which a wrong number is the one recorded: it is recorded to two digits."""
UNSPECIFIC = (DeprecationWarning, PendingDeprecationWarning, FutureWarning, ImportWarning, ResourceWarning)
"""Warnings that say nothing of the data."""


class Verdict(Enum):
    """How an answer stands to the truth and to what was recorded."""

    AS_RECORDED = "wrong"
    OTHERWISE_WRONG = "wrong, not as recorded"
    MENDED = "right now"
    NOT_INSTALLED = "not installed, as recorded"


@dataclass(frozen=True, slots=True)
class Answer:
    """A number (which may be NaN or infinite), or the words in its place."""

    number: float | None
    words: str
    """Reason of an undefined result, sentence of a refusal, name of an exception; empty where there is a number."""
    warned: tuple[str, ...] = ()
    """Categories of the warnings given."""

    @property
    def silent(self) -> bool:
        """Whether a number came without a warning."""
        return self.number is not None and not self.warned

    def text(self, digits: int) -> str:
        """Return the answer as a table holds it."""
        return self.words if self.number is None else f"{self.number:.{digits}g}"


def ours(call: Callable[[], Any]) -> Answer:
    """Return labbook's answer; nothing but a refusal may be raised."""
    try:
        found = call()
    except InputRefused as refusal:
        return Answer(None, str(refusal))
    return Answer(None, found.reason) if isinstance(found, Undefined) else Answer(float(found), "")


def theirs(peer: Peer) -> Answer | None:
    """Return another program's answer, None where it is not installed; raises where it cannot be asked that way."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            number, words = float(peer.answer()), ""
        except ModuleNotFoundError:
            return None
        except (AttributeError, TypeError):
            raise  # the program's interface is another than it was, and this question must be put anew
        except Exception as error:  # whatever a program raises is its answer
            number, words = None, type(error).__name__
    kinds = (one.category for one in caught if not issubclass(one.category, UNSPECIFIC))
    return Answer(number, words, tuple(dict.fromkeys(kind.__name__ for kind in kinds)))


def verdict(peer: Peer, answer: Answer | None, truth: Number | NoNumber) -> Verdict:
    """Compare an answer with the truth and with the wrong one recorded."""
    if answer is None:
        return Verdict.NOT_INSTALLED
    if isinstance(truth, Number) and answer.number is not None and alike(answer.number, truth.value(), RIGHT_TO):
        return Verdict.MENDED
    if _as_recorded(peer.recorded, answer):
        return Verdict.AS_RECORDED
    said_that_there_is_none = answer.number is None or math.isnan(answer.number)
    return Verdict.MENDED if isinstance(truth, NoNumber) and said_that_there_is_none else Verdict.OTHERWISE_WRONG


def alike(one: float, other: float, rel: float) -> bool:
    """Tell whether two numbers agree; an infinity agrees with itself alone."""
    return one == other or (math.isfinite(other) and abs(one - other) <= rel * abs(other))


def recorded_text(peer: Peer, digits: int) -> str:
    """Return the wrong answer recorded as a table holds it."""
    return peer.recorded if isinstance(peer.recorded, str) else f"{peer.recorded:.{digits}g}"


def _as_recorded(recorded: float | str, answer: Answer) -> bool:
    if isinstance(recorded, str):
        return recorded == answer.text(3)
    return answer.number is not None and alike(answer.number, recorded, ALIKE_TO)
