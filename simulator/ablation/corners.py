"""How far a set of effects, chosen for a scene as it stands, is off at the corners of what is swept."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from data_schema.errors import UsageError
from simulator.ablation.outputs import Difference, difference, outputs_of
from simulator.ablation.study import STEPS_MORE, measured_scene
from simulator.scene import Scene
from simulator.sweep.axes import Axis

MOST_CORNERS = 16
"""With more corners only the two ends of each range are looked at, all else as in the scene."""


@dataclass(frozen=True, slots=True)
class Corner:
    """Values at the ends of what is swept, by name, and how far the chosen set is from all effects there."""

    at: Mapping[str, float]
    difference: Difference


@dataclass(frozen=True, slots=True)
class Corners:
    """The corners at which both sets were simulated; `refused` others have values that do not fit together."""

    compared: tuple[Corner, ...]
    refused: int

    @property
    def worst(self) -> Corner | None:
        """The corner at which the chosen set is farthest off; None where nothing could be compared."""
        return max(self.compared, key=lambda corner: corner.difference.largest, default=None)


def compare_at_corners(
    full: Scene,
    chosen: Scene,
    axes: Sequence[Axis],
    accuracy: float,
    step: Callable[[str], None] = lambda _done: None,
) -> Corners:
    """Simulate a scene with all its effects and with those chosen, at the corners of some axes.

    Of scenes with many jumps as many are made as to measure effects, and the last is looked at; `step` is called after
    each corner.
    """
    full, chosen = measured_scene(full), measured_scene(chosen)
    compared, refused = [], 0
    for number, ends in enumerate(_corners(axes), 1):
        step(f"corner {number} of what is swept")
        values = {axis.parameter: float(axis.values[place]) for axis, place in ends}
        try:
            all_effects, enough = full.changed(values), chosen.changed(values)
        except UsageError:
            refused += 1
            continue
        expected = outputs_of(all_effects, accuracy)
        found = outputs_of(enough, accuracy, STEPS_MORE * expected.most_steps)
        at = {axis.name: float(axis.coordinates[place]) for axis, place in ends}
        compared.append(Corner(at, difference(found, expected)))
    return Corners(tuple(compared), refused)


def _corners(axes: Sequence[Axis]) -> Iterator[tuple[tuple[Axis, int], ...]]:
    """Yield every combination of the axes' ends, by their places, or each end alone where they would be too many."""
    ends = [
        [(axis, place) for place in dict.fromkeys((int(axis.values.argmin()), int(axis.values.argmax())))]
        for axis in axes
    ]
    if math.prod(map(len, ends)) <= MOST_CORNERS:
        yield from itertools.product(*ends)
    else:
        yield from ((end,) for both in ends for end in both)
