"""One jump by the thesis's fixed-step scheme, by the names of its numbers."""

from __future__ import annotations

from simulator.kernel.layout import OUTCOMES
from simulator.kernel.rows import COLUMNS
from simulator.published import THESIS_STEP_S, published_run
from simulator.scene import Scene

Jump = dict[str, float]


def published_jump(scene: Scene, step_s: float = THESIS_STEP_S, to_liftoff: bool = False) -> Jump:
    """The row of one jump, by name."""
    run, work, row = published_run(scene)
    run(work, step_s, to_liftoff, row)
    return dict(zip(COLUMNS, row.tolist(), strict=True))


def outcome(jump: Jump) -> str:
    return OUTCOMES[int(jump["outcome"])]
