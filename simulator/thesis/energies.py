"""Figure 3.5: the mechanical energies of one jump, with the leg's virtual spring (thesis 3.1.5, Eq. 3.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.scene import Scene
from simulator.thesis.ground import ground_functions
from simulator.thesis.motions import Motion

FloatArray = NDArray[np.float64]
_POINTS = 20_001


@dataclass(frozen=True, slots=True, eq=False)
class JumpEnergies:
    """Energies in J at the times of a motion, all of shape (n,); heights count from the undisturbed surface.

    `leg_spring_j` (LSP) takes the stiffness in force, `ground_spring_j` (GSP) is what pressing the ground to its
    present depth has cost and is not part of `total_j`. The foot's mass is with the grains it moves until lift-off, as
    in the thesis: their weight is lost from `foot_gravity_j` (GT) there, at once.
    """

    motion: Motion
    leg_spring_j: FloatArray
    body_kinetic_j: FloatArray
    body_gravity_j: FloatArray
    ground_spring_j: FloatArray
    foot_kinetic_j: FloatArray
    foot_gravity_j: FloatArray
    grain_gravity_j: FloatArray
    """The part of the foot's gravitational energy that is the grains' weight."""

    @property
    def total_j(self) -> FloatArray:
        """Total mechanical energy of body, leg and foot, J (Eq. 3.3)."""
        return np.asarray(
            self.leg_spring_j + self.body_kinetic_j + self.body_gravity_j + self.foot_kinetic_j + self.foot_gravity_j
        )


def jump_energies(scene: Scene, motion: Motion) -> JumpEnergies:
    """Compute the energies of a motion of the scene."""
    depth_m = motion.depth_m
    grains_kg = np.where(motion.flying, 0.0, ground_functions(scene, depth_m).added_mass_kg)
    stiffness = np.where(motion.extending, scene["k_extension"], scene["k_compression"])
    compression_m = motion.body_height_m - motion.foot_height_m - scene["rest_length"]
    grain_gravity_j = grains_kg * GRAVITY_M_S2 * motion.foot_height_m
    return JumpEnergies(
        motion=motion,
        leg_spring_j=0.5 * stiffness * compression_m**2,
        body_kinetic_j=0.5 * scene["body_mass"] * motion.body_velocity_m_s**2,
        body_gravity_j=scene["body_mass"] * GRAVITY_M_S2 * motion.body_height_m,
        ground_spring_j=_pressing_j(scene, depth_m),
        foot_kinetic_j=0.5 * (scene["foot_mass"] + grains_kg) * motion.foot_velocity_m_s**2,
        foot_gravity_j=scene["foot_mass"] * GRAVITY_M_S2 * motion.foot_height_m + grain_gravity_j,
        grain_gravity_j=grain_gravity_j,
    )


def _pressing_j(scene: Scene, depth_m: FloatArray) -> FloatArray:
    """Integrate K from the surface to each depth."""
    ground = ground_functions(scene, np.linspace(0.0, float(depth_m.max()), _POINTS))
    slices_j = 0.5 * (ground.resistance_n[1:] + ground.resistance_n[:-1]) * np.diff(ground.depth_m)
    return np.asarray(np.interp(depth_m, ground.depth_m, np.concatenate([[0.0], np.cumsum(slices_j)])))
