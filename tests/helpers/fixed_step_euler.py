"""One jump by the thesis's fixed-step scheme, by the names of its numbers."""

from __future__ import annotations

from simulator.accuracy.fixed_step_euler import THESIS_STEP_S, fixed_step_euler_run
from simulator.kernel.layout import OUTCOMES
from simulator.kernel.rows import COLUMNS
from simulator.scene import Scene

Jump = dict[str, float]


def fixed_step_euler_jump(scene: Scene, step_s: float = THESIS_STEP_S, to_liftoff: bool = False) -> Jump:
    """The row of one jump, by name."""
    run, work, row = fixed_step_euler_run(scene)
    run(work, step_s, to_liftoff, row)
    return dict(zip(COLUMNS, row.tolist(), strict=True))


def outcome(jump: Jump) -> str:
    return OUTCOMES[int(jump["outcome"])]
