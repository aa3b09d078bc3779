"""The leg's force held between ticks, as a digital torque command is, in place of held gains."""

from __future__ import annotations

from simulator.effects.effect import Effect

EFFECT = Effect(
    name="held_force",
    meaning="the leg's force is computed at a tick and held until the next",
    source="comparison with held gains, thesis 3.1.3",
    needs=(("sampled_control",),),
    excludes={
        "continuous_foot_speed": "a held force knows no speed between ticks: leave out "
        "continuous_foot_speed or held_force"
    },
)
