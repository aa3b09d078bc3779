"""Touchdown impact: a foot that meets unyielding ground stops at once, its kinetic energy is lost (thesis 3.2.2)."""

from __future__ import annotations

from simulator.effects.effect import Effect
from simulator.effects.shared import IMPACT_LOSS

EFFECT = Effect(
    name="touchdown_impact",
    meaning="inelastic touchdown: the foot takes the ground's speed at once",
    source="thesis 3.2.2",
    needs=(("rigid_ground", "emulated_ground"),),
    excludes={
        "hydrostatic_stiffness": "grains take the foot without an impact: leave out touchdown_impact",
        "massless_leg_in_flight": "a leg without mass meets the ground without an impact: leave out "
        "massless_leg_in_flight or touchdown_impact",
    },
    energies=(IMPACT_LOSS,),
)
