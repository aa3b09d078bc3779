"""The cost counts the whole jump, touchdown to touchdown: a robot that goes on jumping works its leg in flight too."""

from __future__ import annotations

from simulator.effects.effect import Effect

EFFECT = Effect(
    name="cost_of_whole_jump",
    meaning="the cost counts from touchdown to touchdown; off, until the last lift-off",
    source="thesis 4.3: the charge of 100 jumps, divided by 100",
)
