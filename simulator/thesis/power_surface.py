"""Figure 3.6: how fast the ground takes energy from the foot, and where the foot goes on that surface (Eq. 3.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulator.scene import Scene
from simulator.thesis.controllers import Pair, both_controllers
from simulator.thesis.ground_functions import ground_functions
from simulator.thesis.motions import Motion, motion_of
from simulator.thesis.ranges import DEEPEST_M, FASTEST_M_S, SAMPLE_SPEEDS_M_S

FloatArray = NDArray[np.float64]
_POINTS = 161


@dataclass(frozen=True, slots=True, eq=False)
class PowerSurface:
    """Power in W, shape (velocities, depths), over depth in m and downward velocity of the foot in m/s (negative).

    `motions` start at the downward speeds `touchdown_speeds_m_s`.
    """

    depth_m: FloatArray
    velocity_m_s: FloatArray
    power_w: FloatArray
    touchdown_speeds_m_s: tuple[float, ...]
    motions: tuple[Pair[Motion], ...]


def power_surface(scene: Scene, accuracy: float) -> PowerSurface:
    """Compute the surface -D(z) |v|^3 - K(z) |v| of a scene and the paths of three jumps with either controller."""
    ground = ground_functions(scene, np.linspace(0.0, DEEPEST_M, _POINTS))
    velocity_m_s = np.linspace(-FASTEST_M_S, 0.0, _POINTS)
    return PowerSurface(
        depth_m=ground.depth_m,
        velocity_m_s=velocity_m_s,
        power_w=ground_power_w(ground.resistance_n, ground.drag_kg_m, velocity_m_s[:, np.newaxis]),
        touchdown_speeds_m_s=SAMPLE_SPEEDS_M_S,
        motions=tuple(sample_motions(scene, speed, accuracy) for speed in SAMPLE_SPEEDS_M_S),
    )


def ground_power_w(resistance_n: FloatArray, drag_kg_m: FloatArray, velocity_m_s: FloatArray) -> FloatArray:
    """Return the rate of Eq. 3.4, W (negative: lost); arrays broadcast against each other."""
    speed_m_s = np.abs(velocity_m_s)
    return np.asarray(-drag_kg_m * speed_m_s**3 - resistance_n * speed_m_s)


def sample_motions(scene: Scene, touchdown_speed_m_s: float, accuracy: float) -> Pair[Motion]:
    """Simulate one jump with either controller, body and foot arriving at this downward speed."""
    started = both_controllers(scene.changed({"initial_velocity": -touchdown_speed_m_s}))
    return Pair(ce=motion_of(started.ce, accuracy), ad=motion_of(started.ad, accuracy))
