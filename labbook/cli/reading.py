"""Questions about what a person wrote, answered by options or at a terminal."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import typer

from labbook.plan.local_time import SheetQuestion
from labbook.terminal import asking, say

_Done = TypeVar("_Done")


def with_answers(attempt: Callable[[dict[str, str | None]], _Done], answers: dict[str, str | None]) -> _Done:
    """Call `attempt` with the answers given as options; ask for one that is missing at a terminal, refuse elsewhere."""
    while True:
        try:
            return attempt(answers)
        except SheetQuestion as question:
            if not asking() or answers.get(question.option) is not None:
                raise
            listed = ", ".join(f"{choice}: {meaning}" for choice, meaning in question.choices.items())
            say(f"{question.sentence} ({listed}).", err=True)
            chosen = ""
            while chosen not in question.choices:
                chosen = typer.prompt(" or ".join(question.choices), err=True).strip()
            answers = {**answers, question.option: chosen}
