"""Figures 3.2 and 3.6: the ground's functions against depth (thesis 3.1.2), and how fast it takes energy (Eq. 3.4).

The same functions as the effects', here for arrays of depths; a test holds them against a simulated jump's losses.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulator.scene import Scene
from simulator.thesis.motions import Motion, Pair, sample_motions
from simulator.thesis.ranges import DEEPEST_M, FASTEST_M_S, SAMPLE_SPEEDS_M_S

FloatArray = NDArray[np.float64]
_POINTS, _SURFACE_POINTS = 401, 161


@dataclass(frozen=True, slots=True, eq=False)
class GroundFunctions:
    """K(z) in N, D(z) in N / (m/s)^2 and m_a(z) in kg at the depths z in m; all of shape (n,).

    The cone of grains under the foot is complete at `cone_depth_m`.
    """

    depth_m: FloatArray
    resistance_n: FloatArray
    drag_kg_m: FloatArray
    added_mass_kg: FloatArray
    cone_depth_m: float


def ground_functions(scene: Scene, depth_m: FloatArray | None = None) -> GroundFunctions:
    """Tabulate the ground's functions of a scene, by default at depths from the surface to `DEEPEST_M`."""
    depths = np.linspace(0.0, DEEPEST_M, _POINTS) if depth_m is None else np.asarray(depth_m, np.float64)
    radius_m = scene["foot_radius"]
    slope = scene["mu"] / math.tan(scene["cone_angle"])
    formed_m = np.clip(depths, 0.0, radius_m / slope)
    foot_m2 = math.pi * radius_m**2
    flat_m2 = math.pi * (radius_m - slope * formed_m) ** 2
    cone_m3 = math.pi * formed_m * (radius_m**2 - slope * radius_m * formed_m + slope**2 * formed_m**2 / 3.0)
    recruited_kg_m3 = scene["phi"] * scene["rho"] * scene["mu"]
    # An area and a volume are added, dimensionally odd, as in the author's code and every published number.
    stress_n_m2 = scene["sigma"] / math.cos(scene["cone_angle"]) * depths
    return GroundFunctions(
        depth_m=depths,
        resistance_n=scene["kg_scale"] * (scene["k_sh"] * cone_m3 / foot_m2 + stress_n_m2 * (foot_m2 + cone_m3)),
        drag_kg_m=scene["bg_scale"]
        * (scene["b_g"] * scene["c_g"])
        * (recruited_kg_m3 * flat_m2 + scene["added_mass_constant"]),
        added_mass_kg=recruited_kg_m3 * cone_m3 + scene["added_mass_constant"] * depths,
        cone_depth_m=radius_m / slope,
    )


@dataclass(frozen=True, slots=True, eq=False)
class PowerSurface:
    """Power in W, shape (velocities, depths), over depth in m and downward velocity of the foot in m/s (negative).

    `motions` start at the downward speeds `SAMPLE_SPEEDS_M_S`.
    """

    depth_m: FloatArray
    velocity_m_s: FloatArray
    power_w: FloatArray
    motions: tuple[Pair[Motion], ...]


def power_surface(scene: Scene, accuracy: float) -> PowerSurface:
    """Compute the surface -D(z) |v|^3 - K(z) |v| of a scene and the paths of three jumps with either controller."""
    ground = ground_functions(scene, np.linspace(0.0, DEEPEST_M, _SURFACE_POINTS))
    velocity_m_s = np.linspace(-FASTEST_M_S, 0.0, _SURFACE_POINTS)
    return PowerSurface(
        depth_m=ground.depth_m,
        velocity_m_s=velocity_m_s,
        power_w=ground_power_w(ground.resistance_n, ground.drag_kg_m, velocity_m_s[:, np.newaxis]),
        motions=tuple(sample_motions(scene, speed, accuracy) for speed in SAMPLE_SPEEDS_M_S),
    )


def ground_power_w(resistance_n: FloatArray, drag_kg_m: FloatArray, velocity_m_s: FloatArray) -> FloatArray:
    """Return the rate of Eq. 3.4, W (negative: lost); arrays broadcast against each other."""
    speed_m_s = np.abs(velocity_m_s)
    return np.asarray(-drag_kg_m * speed_m_s**3 - resistance_n * speed_m_s)
