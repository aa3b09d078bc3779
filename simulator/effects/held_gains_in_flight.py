"""In flight the leg keeps the gains of the last stance, as the published code does (set 2)."""

from __future__ import annotations

from simulator.effects.effect import Effect

EFFECT = Effect(
    name="held_gains_in_flight",
    meaning="the last gains of stance are held in flight; off, the leg is soft there",
    source="published with the second set of simulations, thesis 3.3",
    excludes={
        "massless_leg_in_flight": "a massless leg needs no gains in flight: leave out held_gains_in_flight or "
        "massless_leg_in_flight"
    },
)
