"""A simulated motion as the pictures draw it: the last jump of a scene."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from data_schema.errors import UsageError
from labbook.presenting.simulation.simulated import mode_name, title_text
from reports.drawn import FloatArray, ModeSpan, Trajectory
from simulator.kernel.layout import FLIGHT, MODES
from simulator.parameter import GRAVITY_M_S2
from simulator.result import SceneResult
from simulator.scene import Scene


def drawn_trajectory(result: SceneResult) -> Trajectory:
    """Return the last jump's motion; raises `UsageError` where none was recorded.

    The leg's force is that on the body, from its acceleration; where the rail rubs, that is in it.
    """
    if result.trajectory is None:
        raise UsageError(f"the motion of scene {result.scene.name} was not kept: simulate it with its trajectory.")
    scene, jump = result.scene, result.jump
    motion = result.trajectory
    last = motion["jump"].to_numpy() == motion["jump"].to_numpy().max(initial=0)
    time_s, body_m, foot_m, acceleration_m_s2, modes = (
        motion[name].to_numpy()[last] for name in ("time", "body_height", "foot_height", "body_acceleration", "mode")
    )
    marks = [
        (name, jump.touchdown_time_s + after_s)
        for name, after_s in (("lift-off", jump.liftoff_time_s), ("apex", jump.apex_time_s))
        if after_s is not None
    ]
    which = f", jump {len(result.jumps)} of {scene.jumps}" if scene.jumps > 1 else ""
    return Trajectory(
        title=title_text(scene, which, jump.outcome),
        time_s=time_s,
        body_height_m=body_m,
        foot_height_m=foot_m,
        leg_force_n=scene["body_mass"] * (acceleration_m_s2 + GRAVITY_M_S2),
        ground_height_m=_ground_m(scene, time_s, foot_m, modes == FLIGHT),
        spans=_spans(scene, time_s, modes),
        marks=tuple(marks),
    )


def _spans(scene: Scene, time_s: FloatArray, modes: np.ndarray[tuple[int], np.dtype[np.int64]]) -> tuple[ModeSpan, ...]:
    changes = np.flatnonzero(np.diff(modes)) + 1
    edges = [0, *changes.tolist(), len(modes) - 1]
    spans = (
        (float(time_s[first]), float(time_s[last]), MODES[int(modes[first])])
        for first, last in pairwise(edges)
        if time_s[last] > time_s[first]
    )
    return tuple(ModeSpan(start, end, mode, mode_name(scene, mode)) for start, end, mode in spans)


def _ground_m(
    scene: Scene, time_s: FloatArray, foot_m: FloatArray, flight: np.ndarray[tuple[int], np.dtype[np.bool_]]
) -> FloatArray:
    """Height of the ground under the foot.

    A rigid ground stays at 0, grains keep the hollow that the foot has pressed. The emulator's platform bears the foot,
    and is drawn on its way back up from lift-off on, some milliseconds after its release.
    """
    if "rigid_ground" in scene.effects:
        return np.zeros_like(foot_m)
    if "emulated_ground" not in scene.effects:
        return np.asarray(np.minimum.accumulate(np.minimum(foot_m, 0.0)))
    ground_m = np.where(flight, 0.0, foot_m)
    for first in np.flatnonzero(flight & ~np.roll(flight, 1)):
        if first == 0:
            continue
        rest = slice(first, first + int(np.argmin(flight[first:])) if not flight[first:].all() else None)
        share = np.clip((time_s[rest] - time_s[first] - scene["release_time"]) / scene["reset_time"], 0.0, 1.0)
        ground_m[rest] = foot_m[first] * (1.0 - share**3 * (10.0 - 15.0 * share + 6.0 * share**2))
    return ground_m
