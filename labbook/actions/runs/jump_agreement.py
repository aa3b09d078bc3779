"""How far two people agree on the jumps on which both gave verdicts, each person's last one, and where they differ."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from data_schema.queries.detections import DecisionRow
from data_schema.vocabulary import Verdict
from labbook.actions.runs.review_queue import QueuedJump, jumps_by_run
from labbook.analysis.outcomes.detection import Detections
from labbook.config.parsing import Configuration
from stats.compare.agreement import Kappa, cohen_kappa


@dataclass(frozen=True, slots=True)
class Agreement:
    """Two people's verdicts on the same jumps: Cohen's kappa with the counts, and the jumps on which they differ.

    Of the jumps, `both_blind` had both verdicts given blind. `differ` is by run, day and number.
    """

    first: str
    second: str
    kappa: Kappa
    both_blind: int
    differ: tuple[QueuedJump, ...]


def agreement(
    detections: Detections,
    configuration: Configuration,
    people: tuple[str, str] | None = None,
    where: str | None = None,
) -> tuple[Agreement, ...]:
    """Return how two people agree, or without these all pairs who gave verdicts on the same jumps, by name.

    Of the runs that fulfil `where`, void ones left out. A verdict that was taken back is none.
    """
    jumps, _left_out = jumps_by_run(detections, configuration, where)
    said = [(item, {verdict.person: verdict for verdict in item.verdicts}) for item in jumps if item.verdicts]
    if people is not None:
        return (_agreement(*people, said),)
    everyone = sorted({person for _item, verdicts in said for person in verdicts})
    found = (_agreement(first, second, said) for first, second in itertools.combinations(everyone, 2))
    return tuple(one for one in found if one.kappa.n)


def _agreement(first: str, second: str, said: Sequence[tuple[QueuedJump, Mapping[str, DecisionRow]]]) -> Agreement:
    both = [(item, verdicts[first], verdicts[second]) for item, verdicts in said if {first, second} <= verdicts.keys()]
    return Agreement(
        first,
        second,
        cohen_kappa([_answer(one) for _item, one, _ in both], [_answer(other) for *_, other in both]),
        sum(one.blind and other.blind for _item, one, other in both),
        tuple(item for item, one, other in both if _answer(one) != _answer(other)),
    )


def _answer(said: DecisionRow) -> str:
    """Return what a person answers to the question whether this is a jump: who adds or moves one says yes."""
    return str(Verdict.ACCEPT if said.verdict in (Verdict.ADD, Verdict.MOVE) else said.verdict)


def agreement_lines(found: Agreement) -> tuple[list[str], tuple[str, ...], list[tuple[str, ...]]]:
    """Return the agreement in sentences, and head and rows of the jumps on which they differ."""
    names, kappa = (found.first, found.second), found.kappa
    counts = [
        f"{count} {one}" if one == other else f"{count} {one} by {names[0]}, {other} by {names[1]}"
        for one, row in zip(kappa.answers, kappa.counts, strict=True)
        for other, count in zip(kappa.answers, row, strict=True)
        if count
    ]
    lines = [kappa.sentence(names, "jump")]
    if counts:
        lines.append(f"{'; '.join(counts)}. Both blind: {found.both_blind}.")
    rows = [
        (
            item.run,
            str(item.number),
            f"{item.anchor_s if item.apex_s is None else item.apex_s:.3f} s",
            *(_said_by(item, name) for name in names),
        )
        for item in found.differ
    ]
    return lines, ("run", "jump", "at", *names), rows


def _said_by(item: QueuedJump, person: str) -> str:
    (verdict,) = (said for said in item.verdicts if said.person == person)
    return f"{verdict.verdict} ({verdict.reason_code})"
