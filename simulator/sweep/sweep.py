"""A sweep: a scene, what of it is varied, and how accurately it is simulated."""

from __future__ import annotations

from dataclasses import dataclass

from simulator.scene import Scene
from simulator.sweep.checking import check_sweep
from simulator.sweep.chunks import Chunks, chunks_for
from simulator.sweep.design import Design

JUMP = "jump"
"""Dimension of the jumps of scenes that have several."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """A sweep that can be run. Raises `UsageError` where one of its scenes cannot be simulated.

    `labbook` is the version of the program that made it, kept with the result.
    """

    scene: Scene
    design: Design
    accuracy: float = 1e-6
    labbook: str = ""

    def __post_init__(self) -> None:
        check_sweep(self.scene, self.design)

    @property
    def chunks(self) -> Chunks:
        """How its rows are divided."""
        return chunks_for(self.design, self.scene.jumps)

    @property
    def dims(self) -> dict[str, int]:
        """Dimensions of the result and their lengths."""
        jumps = {JUMP: self.scene.jumps} if self.scene.jumps > 1 else {}
        return {**self.design.dims, **jumps}

    @property
    def assumed(self) -> tuple[str, ...]:
        """Names of the parameters without a source that the result rests on; what is swept is not assumed."""
        swept = {axis.parameter for axis in self.design.axes}
        return tuple(name for name in self.scene.assumed if name not in swept)
