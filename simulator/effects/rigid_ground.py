"""Rigid ground: the force plate (thesis 3.2.2). The foot is held at the surface until the leg lifts it."""

from __future__ import annotations

from simulator.effects.effect import Effect

EFFECT = Effect(
    name="rigid_ground",
    meaning="ground that never yields: a force plate",
    source="thesis 3.2.2",
    needs=(("touchdown_impact",),),
    excludes={
        "hydrostatic_stiffness": "a foot stands on one ground: leave out rigid_ground or hydrostatic_stiffness",
        "emulated_ground": "a foot stands on one ground: leave out emulated_ground or rigid_ground",
    },
)
