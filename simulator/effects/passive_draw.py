"""Passive draw of the robot's electronics from the battery, over the time of a jump (thesis 5.1.4)."""

from __future__ import annotations

from simulator.effects.effect import Effect
from simulator.parameter import Parameter

EFFECT = Effect(
    name="passive_draw",
    meaning="what the electronics draw from the battery, whatever the legs do",
    source="thesis 5.1.4",
    parameters=(Parameter("passive_power", "drive", "W", "power drawn by the electronics", 0.0, 1e3),),
    publishes=("passive_J",),
)
