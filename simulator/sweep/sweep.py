"""A sweep: a scene, what of it is varied, and how accurately it is simulated."""

from __future__ import annotations

from dataclasses import dataclass, field

from data_schema.errors import UsageError
from simulator.scene import Scene
from simulator.sweep.checking import check_axes
from simulator.sweep.chunks import Chunks, chunks_for
from simulator.sweep.design import Design, row_count
from simulator.sweep.outputs import REFUSED
from simulator.sweep.refusals import Refusals, refusals_of

JUMP = "jump"
"""Dimension of the jumps of scenes that have several."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """A sweep that can be run; scenes whose values do not fit together are left out of it, and marked as refused.

    `labbook` is the version of the program that made it, kept with the result. Raises `UsageError` for an axis that
    nothing reads or that leaves its parameter's range, and where every scene would be refused.
    """

    scene: Scene
    design: Design
    accuracy: float = 1e-6
    labbook: str = ""
    refusals: Refusals = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_axes(self.scene, self.design)
        object.__setattr__(self, "refusals", refusals_of(self.scene, self.design))
        if not self.legal_rows:
            raise UsageError(f"no scene of the sweep can be simulated: it comes to {self.refusals.first}")

    @property
    def legal_rows(self) -> int:
        """How many of its scenes can be simulated."""
        return row_count(self.design) - self.refusals.count

    @property
    def jumps_wanted(self) -> int:
        """How many jumps are simulated, where all scenes make theirs."""
        return self.legal_rows * self.scene.jumps

    @property
    def refused(self) -> str:
        """How many of its scenes cannot be simulated, and why, in a sentence; empty where all can."""
        if not self.refusals.count:
            return ""
        be = "is" if self.refusals.count == 1 else "are"
        return (
            f"{self.refusals.count} of {row_count(self.design)} scenes cannot be simulated and {be} marked {REFUSED}, "
            f"the first at {self.refusals.first}"
        )

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
