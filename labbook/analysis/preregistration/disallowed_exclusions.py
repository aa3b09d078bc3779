"""What people left out for reasons that `[analysis]` does not allow: jumps they rejected, runs they declared void.

A verdict names its reason. A run is void for a reason in words, which counts as the one that it begins with: "misfire",
or "sensor fault: the string was off its drum". Whoever allows "other" allows every reason.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.queries.detections import DecisionRow, jump_decisions
from data_schema.queries.history import reasons_of_void_runs
from data_schema.queries.runs import list_runs
from data_schema.queries.signals import signals_of_runs
from data_schema.vocabulary import FileRole, ReasonCode, RunKind, RunState, Verdict
from labbook.analysis.outcomes.judging import UNKNOWN_FLIGHT_S


@dataclass(frozen=True, slots=True)
class DisallowedExclusion:
    """A run, the reason given, and how many of its jumps it took away; `jumps` is None where the whole run is void."""

    run: str
    reason: str
    jumps: int | None

    @property
    def sentence(self) -> str:
        """Say what was left out."""
        if self.jumps is None:
            return f"run {self.run} is void ({self.reason})"
        return f"{self.jumps} jump{'' if self.jumps == 1 else 's'} of run {self.run} rejected ({self.reason})"


def disallowed_exclusions(
    connection: sa.Connection, allowed: Collection[ReasonCode]
) -> tuple[DisallowedExclusion, ...]:
    """List what was left out for other reasons than those allowed, by run: void runs, then jumps of runs that count."""
    if ReasonCode.OTHER in allowed:
        return ()
    runs = {run.uid: run for run in list_runs(connection) if run.kind in (RunKind.JUMPS, RunKind.IDLE)}
    void = [
        DisallowedExclusion(runs[uid].name, reason, None)
        for uid, reason in reasons_of_void_runs(connection).items()
        if uid in runs and not is_allowed(reason, allowed)
    ]
    rejected = {
        sha256: Counter(item.reason_code for item in in_force(said) if _left_out(item, allowed))
        for sha256, said in jump_decisions(connection).items()
    }
    counts: Counter[tuple[str, str]] = Counter()
    if any(rejected.values()):
        for signal in signals_of_runs(connection, FileRole.LOG):
            if signal.run_uid in runs and runs[signal.run_uid].state is not RunState.VOID:
                for reason, count in rejected.get(signal.sha256, {}).items():
                    counts[signal.run_name, str(reason)] += count
    return (
        *sorted(void, key=lambda item: item.run),
        *(DisallowedExclusion(*key, count) for key, count in sorted(counts.items())),
    )


def in_force(decisions: Sequence[DecisionRow]) -> list[DecisionRow]:
    """Return the verdicts on one signal that stand: a later one about the same moment replaces an earlier one."""
    found: list[DecisionRow] = []
    for decision in decisions:
        found = [item for item in found if abs(item.anchor_s - decision.anchor_s) > UNKNOWN_FLIGHT_S / 2.0]
        found.append(decision)
    return found


def _left_out(decision: DecisionRow, allowed: Collection[ReasonCode]) -> bool:
    return decision.verdict is Verdict.REJECT and decision.reason_code not in allowed


def is_allowed(reason: str, allowed: Collection[ReasonCode]) -> bool:
    """Tell whether a reason begins with one that is allowed, written with blanks or underscores."""
    said = reason.strip().lower().replace("_", " ")
    return ReasonCode.OTHER in allowed or any(
        said.startswith(words) and not said[len(words) : len(words) + 1].isalnum()
        for code in allowed
        for words in [str(code).replace("_", " ")]
    )
