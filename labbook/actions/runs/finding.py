"""What needs a person's look: in a sentence, how grave it is, and the words of the command that mends it."""

from __future__ import annotations

import shlex
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TypeAlias

from data_schema.queries.runs import RunRow
from labbook.terminal import NOT_IN_JSON


class Gravity(StrEnum):
    """How grave a finding is; the gravest stands first."""

    WRONG = "wrong"
    """What is stored cannot be so, and counts."""
    CLAIM = "claim lost"
    """The report makes no claim for want of it."""
    MISSING = "missing"
    """A run has no number for want of it."""
    DOUBTFUL = "doubtful"
    """It may be wrong: a person has to look."""
    TO_DO = "to do"
    """It waits to be done, and no number of a run is known to lack it."""


class Blank(StrEnum):
    """What a person puts in its place in a command."""

    COLUMN = "COLUMN"
    DATE = "DATE"
    FILE = "FILE"
    INSTANT = "INSTANT"
    JUMPS = "JUMPS"
    MAH = "MAH"
    MINUTES = "MINUTES"
    OFFSET = "OFFSET"
    PACK = "PACK"
    RUN = "RUN"
    UNIT = "UNIT"
    WHY = "WHY"


Word: TypeAlias = "str | tuple[str, ...]"
"""A word of a command, or the parts of one."""
Cost: TypeAlias = tuple[str, bool]
"""What a finding costs the report, "" where nothing, and whether that is a claim."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """What one check found: what is wrong, in a sentence, and the words behind `labbook` that mend it.

    `day` is None where it is of no day, `run` and `file` are names. `costs` says what the report lacks for it, and
    `costs_claim` that this is a claim. `code` names the check.
    """

    what: str
    words: tuple[Word, ...] = field(metadata=NOT_IN_JSON)
    day: str | None = None
    run: str | None = None
    file: str | None = None
    costs: str = ""
    costs_claim: bool = False
    code: str = ""
    gravity: Gravity = Gravity.DOUBTFUL

    @property
    def command(self) -> str:
        """The command that mends it, quoted for a shell."""
        return shlex.join(["labbook", *map("".join, self.words)])

    @property
    def fill_in(self) -> tuple[str, ...]:
        """The words in the command that a person puts others for."""
        parts = (part for word in self.words for part in ([word] if isinstance(word, str) else word))
        return tuple(dict.fromkeys(str(part) for part in parts if isinstance(part, Blank)))


def found(
    what: str,
    *words: Word,
    run: RunRow | None = None,
    day: str | None = None,
    file: str | None = None,
    costs: str | Cost = "",
) -> Finding:
    """Return a finding, of the run's day where a run is given."""
    cost, is_claim = (costs, False) if isinstance(costs, str) else costs
    return Finding(
        what=what.removesuffix("."),
        words=words,
        day=day if run is None else run.day,
        run=None if run is None else run.name,
        file=file,
        costs=cost,
        costs_claim=is_claim,
    )


def correcting(target: str, *fields_given: Word) -> tuple[Word, ...]:
    """Return the words that correct a run or a charge."""
    return "correct", target, *fields_given, "--why", Blank.WHY
