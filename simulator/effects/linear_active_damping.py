"""Active damping as a force of its own, b_ad |v_f|, in place of the product with the leg's speed: an option for ch.
4.
"""

from __future__ import annotations

from simulator.effects.effect import Effect

EFFECT = Effect(
    name="linear_active_damping",
    meaning="active damping as a force in proportion to the foot's speed alone",
    source="thesis 4.3 read otherwise",
    needs=(("active_damping", "scaled_active_damping"),),
)
