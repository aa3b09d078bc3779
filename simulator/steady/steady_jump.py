"""The jump that a robot goes on repeating: the last of the many that a scene makes."""

from __future__ import annotations

import statistics
from dataclasses import dataclass

from simulator.jump import simulate
from simulator.result import JumpResult
from simulator.scene import Scene

JUMPS_NOT_COUNTED = 2
"""The first jumps of an experiment, left out of the published apexes (thesis 4.3.3)."""


@dataclass(frozen=True, slots=True)
class SteadyJump:
    """The last jump of a scene, touchdown to touchdown: SI units, joules over the whole jump.

    `apex_change_m` is the difference of its apex from the one before, and `apex_sd_m` the standard deviation of the
    scene's apexes without the first two.
    """

    apex_height_m: float
    apex_change_m: float
    apex_sd_m: float
    heat_j: float
    mechanical_j: float
    drag_j: float
    cost_j: float
    period_s: float
    max_depth_m: float
    touchdown_velocity_m_s: float
    impact_loss_j: float
    capped_time_s: float
    min_leg_length_m: float


def steady_jump(scene: Scene, accuracy: float) -> SteadyJump:
    """Simulate all jumps of a scene and return the last.

    Raises `RuntimeError` where a jump does not end in a touchdown, and `UsageError` for an accuracy that cannot be had.
    """
    jumps = simulate(scene, accuracy).jumps
    last = jumps[-1]
    apexes = [apex_of(scene, jump) for jump in jumps]
    if last.next_touchdown_time_s is None or last.next_touchdown_body_velocity_m_s is None:
        raise _stopped(scene, last)
    return SteadyJump(
        apex_height_m=apexes[-1],
        apex_change_m=apexes[-1] - apexes[-2],
        apex_sd_m=statistics.stdev(apexes[JUMPS_NOT_COUNTED:]),
        heat_j=last.jump_heat_J,
        mechanical_j=last.jump_mechanical_J,
        drag_j=last.jump_drag_J,
        cost_j=last.cost_J,
        period_s=last.next_touchdown_time_s,
        max_depth_m=last.max_depth_m,
        touchdown_velocity_m_s=last.next_touchdown_body_velocity_m_s,
        impact_loss_j=last.impact_loss_J,
        capped_time_s=last.capped_time_s,
        min_leg_length_m=last.min_leg_length_m,
    )


def apex_of(scene: Scene, jump: JumpResult) -> float:
    """Return a jump's apex height in m; raises `RuntimeError` where it has none."""
    if jump.apex_height_m is None:
        raise _stopped(scene, jump)
    return jump.apex_height_m


def _stopped(scene: Scene, jump: JumpResult) -> RuntimeError:
    return RuntimeError(f"{scene.name} does not go on jumping ({jump.outcome}), and has no steady jump")
