"""Several tests of one family: Holm's p-values, which keep the chance of any false alarm at alpha.

Holm's method asks nothing about how the tests depend on each other and rejects whatever Bonferroni's does, and more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from data_schema.errors import InputRefused
from data_schema.grouping import grouped
from data_schema.rounding import p_text
from data_schema.vocabulary import Undefined
from stats.checks import as_level, as_number
from stats.results import Result
from stats.scatter import Value

MOST_NAMED = 10
"""Of more tests than these with one reason only the first are named."""


def reasons_text(untested: Sequence[tuple[str, str]]) -> str:
    """Return names with the reason behind all that share it, from (name, reason)."""
    parts = []
    for reason, own in grouped([name for name, _ in untested], [why for _, why in untested]).items():
        names = ", ".join(own[:MOST_NAMED])
        more = f" and {len(own) - MOST_NAMED} more" if len(own) > MOST_NAMED else ""
        parts.append(f"{names}{more}, because {reason}")
    return "; ".join(parts)


def none_text(untested: Sequence[tuple[str, str]]) -> str:
    """Return what follows "none tested", from (name, reason): the one reason that all have, or names and reasons."""
    reasons = {reason for _name, reason in untested}
    return f", because {reasons.pop()}" if len(reasons) == 1 else f": {reasons_text(untested)}"


@dataclass(frozen=True, slots=True)
class HolmMember(Result):
    """One test of a family."""

    name: str
    """Of the test."""
    p: Value
    """As given, 0 to 1."""
    adjusted_p: Value
    """Holm's p-value."""
    rejected: bool | Undefined
    """Whether the adjusted p is at most alpha."""


@dataclass(frozen=True, slots=True)
class HolmFamily(Result):
    """A named family of tests with adjusted p-values, in the order given."""

    family: str
    """What the tests have in common, in words."""
    names: tuple[str, ...]
    """Of the m tests, in the order given; shape (m,)."""
    p: tuple[Value, ...]
    """The p-values as given, shape (m,)."""
    adjusted_p: tuple[Value, ...]
    """Holm's p-values (Holm 1979), each to be compared with alpha; at most 1; shape (m,)."""
    rejected: tuple[bool | Undefined, ...]
    """Whether the adjusted p is at most alpha, shape (m,)."""
    alpha: float
    """The chance allowed of rejecting any true hypothesis of the family."""

    def rows(self) -> tuple[HolmMember, ...]:
        """Return the tests, for `to_frame`."""
        columns = self.names, self.p, self.adjusted_p, self.rejected
        return tuple(HolmMember(*row) for row in zip(*columns, strict=True))

    def sentence(self) -> str:
        """Return the family in words: which tests are rejected, with adjusted p, or not made, and why."""
        untested = [(name, p.reason) for name, p in zip(self.names, self.p, strict=True) if isinstance(p, Undefined)]
        tested = len(self.names) - len(untested)
        undefined = f", {len(untested)} of them undefined and counted all the same" if untested else ""
        count = f"{len(self.names)} test{'' if len(self.names) == 1 else 's'}"
        head = f"Family {self.family} ({count}{undefined}), adjusted by Holm at {self.alpha:g}"
        if not untested:
            return f"{head}: {self._verdicts()}."
        if not tested:
            return f"{head}: none tested{none_text(untested)}."
        return f"{head}: {tested} tested, {self._verdicts()}; not tested: {reasons_text(untested)}."

    def _verdicts(self) -> str:
        """Return which tests are rejected."""
        found = [f"{one.name} ({p_text(one.adjusted_p, self.alpha)})" for one in self.rows() if one.rejected is True]
        return f"{', '.join(found) or 'none'} rejected"


def holm(
    p_values: Mapping[str, Value],
    family: str,
    *,
    alpha: float = 0.05,
) -> HolmFamily:
    """Adjust the p-values of a family by Holm's step-down method.

    The smallest of m is multiplied by m, the next by m - 1 and so on; none becomes smaller than one before it. A test
    whose p is undefined belongs to the family still: it counts in m. Raises `InputRefused` for a p that is no number or
    outside 0 to 1.

    >>> holm({"height": 0.04, "joules": 0.01}, "outcomes").adjusted_p
    (0.04, 0.02)
    """
    alpha = as_level("alpha", alpha)
    for name, p in p_values.items():
        if not isinstance(p, Undefined) and not _is_p(p):
            raise InputRefused(f"the p-value of {name!r} is {p!r}: give a number from 0 to 1.")
    defined = sorted((p, name) for name, p in p_values.items() if not isinstance(p, Undefined))
    adjusted_p: dict[str, float] = {}
    worst = 0.0
    for place, (p, name) in enumerate(defined):
        worst = adjusted_p[name] = max(worst, min(1.0, (len(p_values) - place) * p))
    adjusted = tuple(adjusted_p.get(name, p) for name, p in p_values.items())
    return HolmFamily(
        family=family,
        names=tuple(p_values),
        p=tuple(p_values.values()),
        adjusted_p=adjusted,
        rejected=tuple(p if isinstance(p, Undefined) else p <= alpha for p in adjusted),
        alpha=alpha,
    )


def _is_p(p: float) -> bool:
    try:
        return 0.0 <= as_number("p", p) <= 1.0
    except InputRefused:
        return False
