"""A scene with only the effects that matter: what `--effects auto --within 1%` does to it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from data_schema.errors import UsageError
from simulator.ablation.study import Ablation, ablation_of_effects
from simulator.ablation.tolerance import tolerance_of
from simulator.changes import changed_by_words, without_auto
from simulator.scene import Scene

SEARCH_ACCURACY = 1e-6
"""The finest accuracy at which the smallest set is searched; the scene is then simulated to the one asked for."""

Step = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Auto:
    """Words for effects without `auto`, and the tolerance that goes with it; None where it was not said."""

    words: str | None
    tolerance: float | None
    accuracy: float

    def ablation(self, scene: Scene, step: Step, kept: frozenset[str] = frozenset()) -> Ablation | None:
        """Search the smallest set of the scene's effects, those `kept` in it; None without a tolerance.

        `step` is called after each set of effects tried.
        """
        if self.tolerance is None:
            return None
        return ablation_of_effects(scene, self.tolerance, self.accuracy, step, kept)


def auto_of(effects: str | None, within: str | None, accuracy: float) -> Auto:
    """Read `--effects` and `--within`; raises `UsageError` for one that misses the other, or is no tolerance."""
    words, auto = without_auto(effects)
    coarser = accuracy if accuracy > SEARCH_ACCURACY else SEARCH_ACCURACY
    if auto and within is None:
        raise UsageError(
            "--effects auto chooses effects by a tolerance: add --within, for example --effects auto --within 1%."
        )
    if within is not None and not auto:
        raise UsageError(f"--within {within} is for effects left out by themselves: add --effects auto.")
    return Auto(words, None if within is None else tolerance_of(within, coarser), coarser)


def with_enough(scene: Scene, ablation: Ablation | None) -> Scene:
    """Return the scene with the smallest set of effects that was found, and as it is where none was searched."""
    if ablation is None:
        return scene
    return changed_by_words(scene, effects=",".join(f"-{name}" for name in ablation.smallest.left_out.effects))
