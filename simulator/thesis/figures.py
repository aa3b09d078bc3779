"""The data of all figures of ch. 3 that a simulation can make, each computed when it is first asked for."""

from __future__ import annotations

from functools import cached_property

from simulator.scene_file import load_scene
from simulator.thesis.comparisons import (
    OverDamping,
    OverGround,
    OverVelocity,
    over_damping,
    over_ground,
    over_velocity,
)
from simulator.thesis.energies import JumpEnergies, jump_energies
from simulator.thesis.ground import GroundFunctions, PowerSurface, ground_functions, power_surface
from simulator.thesis.motions import Motion, Pair, both_controllers, sample_motions


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
