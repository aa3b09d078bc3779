"""Active damping that follows the foot's speed between ticks, as an analogue damper would."""

from __future__ import annotations

from simulator.effects.effect import Effect

EFFECT = Effect(
    name="continuous_foot_speed",
    meaning="active damping by the foot's speed at every instant, not as sampled",
    source="comparison with sampling, thesis 3.1.3",
    needs=(("sampled_control",), ("active_damping", "scaled_active_damping")),
    excludes={"held_force": "a held force knows no speed between ticks: leave out continuous_foot_speed or held_force"},
)
