"""The data of all figures of ch. 3 that a simulation can make, each computed when it is first asked for.

Figure 3.5: the mechanical energies of one jump, with the leg's virtual spring (thesis 3.1.5, Eq. 3.3).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.thesis.comparisons import (
    OverDamping,
    OverGround,
    OverVelocity,
    over_damping,
    over_ground,
    over_velocity,
)
from simulator.thesis.ground import GroundFunctions, PowerSurface, ground_functions, power_surface
from simulator.thesis.motions import Motion, Pair, both_controllers, sample_motions

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


class ThesisFigures:
    """Figures 3.2 to 3.13; set 1 is the shipped scene `sim1`, set 2 `sim2`. `accuracy` is that of every simulation."""

    def __init__(self, accuracy: float = 1e-6) -> None:
        self.accuracy = accuracy
        self.set_1 = load_scene("sim1")
        self.set_2 = load_scene("sim2")

    @cached_property
    def ground_functions(self) -> GroundFunctions:
        """Figure 3.2."""
        return ground_functions(self.set_1)

    @cached_property
    def example(self) -> Pair[Motion]:
        """Figure 3.4: the jump of set 1's own initial velocity."""
        return sample_motions(self.set_1, -self.set_1["initial_velocity"], self.accuracy)

    @cached_property
    def energies(self) -> Pair[JumpEnergies]:
        """Figure 3.5: the energies of figure 3.4's jumps."""
        scenes = both_controllers(self.set_1)
        return Pair(ce=jump_energies(scenes.ce, self.example.ce), ad=jump_energies(scenes.ad, self.example.ad))

    @cached_property
    def power_surface(self) -> PowerSurface:
        """Figure 3.6."""
        return power_surface(self.set_1, self.accuracy)

    @cached_property
    def over_velocity(self) -> OverVelocity:
        """Figures 3.8 and 3.9."""
        return over_velocity(self.set_1, self.accuracy)

    @cached_property
    def over_ground(self) -> OverGround:
        """Figures 3.11 and 3.12."""
        return over_ground(self.set_1, self.accuracy)

    @cached_property
    def over_damping(self) -> OverDamping:
        """Figure 3.13."""
        return over_damping(self.set_2, self.accuracy)
