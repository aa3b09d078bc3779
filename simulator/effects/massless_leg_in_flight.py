"""In flight the leg has no mass: it is at its rest length at once, the body alone flies."""

from __future__ import annotations

from simulator.effects.effect import Effect
from simulator.effects.shared import IMPACT_LOSS

EFFECT = Effect(
    name="massless_leg_in_flight",
    meaning="the foot follows the body in flight, its mass neglected",
    source="the usual spring-loaded inverted pendulum, for comparison",
    excludes={
        "held_gains_in_flight": "a massless leg needs no gains in flight: leave out held_gains_in_flight or "
        "massless_leg_in_flight",
        "touchdown_impact": "a leg without mass meets the ground without an impact: leave out "
        "massless_leg_in_flight or touchdown_impact",
    },
    energies=(IMPACT_LOSS,),
)
