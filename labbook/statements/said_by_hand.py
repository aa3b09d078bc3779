"""What people said of charges, as the journal has it: it outlives any reading of their sheet, and its absence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from data_schema.queries.readings import said_of_charges
from data_schema.vocabulary import Action
from labbook.statements.apply_context import ApplyContext


@dataclass(frozen=True, slots=True)
class SaidByHand:
    """What people said of one charge.

    `corrected` holds, by column, what stood before the first correction and what the last one says. `assigned` tells
    whether a person said to which run it belongs; `run_uid` is that run, None where it belongs to none.
    """

    corrected: Mapping[str, tuple[Any, Any]]
    assigned: bool
    run_uid: str | None
    dismissed: bool

    @property
    def spoken(self) -> bool:
        """Whether it was corrected or assigned at all."""
        return self.assigned or bool(self.corrected)


def said_by_hand(context: ApplyContext, uids: Sequence[str]) -> dict[str, SaidByHand]:
    """Return what people said of each of these charges."""
    return {uid: _of_one(said) for uid, said in said_of_charges(context.connection, uids).items()}


def _of_one(said: Sequence[tuple[Action, Mapping[str, Any], Mapping[str, Any]]]) -> SaidByHand:
    corrected: dict[str, tuple[Any, Any]] = {}
    assigned, run_uid, dismissed = False, None, False
    for action, old, new in said:
        if action in (Action.DISMISS, Action.RESTORE):
            dismissed = action is Action.DISMISS
        elif action in (Action.ASSIGN, Action.CORRECT):
            for name in new.keys() - {"run"} if action is Action.CORRECT else ():
                corrected[name] = (corrected[name][0] if name in corrected else old.get(name), new[name])
            if "run" in new:
                assigned, run_uid = True, new["run"]
                dismissed = dismissed and run_uid is None
    return SaidByHand(corrected, assigned, run_uid, dismissed)
