"""Where two effects work on each other: without both, something changes otherwise than without each would suggest."""

from __future__ import annotations

import math
from dataclasses import dataclass

from data_schema.vocabulary import Undefined
from simulator.ablation.measure import Ablation

OUTPUTS = ("cost", "apex", "depth")
TELLING = 0.1
"""Part of the tolerance from which on a surprise is worth telling."""


@dataclass(frozen=True, slots=True)
class Together:
    """The relative change of an output without an effect and its partner, and that expected from each alone.

    Expected is that the two factors by which the output changes multiply.
    """

    partner: str
    output: str
    change: float | Undefined
    expected: float

    @property
    def surprise(self) -> float:
        """How far the change is from what is expected; infinite where the jump ends otherwise without both."""
        return math.inf if isinstance(self.change, Undefined) else abs(self.change - self.expected)


def worst_together(ablation: Ablation, effect: str) -> Together | None:
    """Return the pair with this effect, and the output, that are farthest from what is expected.

    None where all is as expected, to a tenth of the tolerance, and where the effect cannot be left out alone.
    """
    found = [
        Together(partner, output, both, (1.0 + mine) * (1.0 + others) - 1.0)
        for (name, partner), pair in ablation.pairs.items()
        if name == effect and effect in ablation.alone and partner in ablation.alone
        for output, both, mine, others in zip(
            OUTPUTS,
            pair.difference.changes,
            ablation.alone[effect].difference.changes,
            ablation.alone[partner].difference.changes,
            strict=True,
        )
        if not isinstance(mine, Undefined) and not isinstance(others, Undefined)
    ]
    worst = max(found, key=lambda item: item.surprise, default=None)
    return worst if worst is not None and worst.surprise > TELLING * ablation.tolerance else None
