"""Active damping: while the leg extends and the foot moves down, b_ad |v_f| is added to the leg's damping (Eq. 3.2)."""

from __future__ import annotations

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, ParameterIndex
from simulator.effects.shared import ACTIVE_DAMPING


def _functions(at: ParameterIndex) -> dict[str, Function]:
    coefficient = at("b_ad")
    return {"active_damping_kg_m": inner(lambda p: p[coefficient])}


EFFECT = Effect(
    name="active_damping",
    meaning="damping of the extending leg in proportion to the foot's speed into the ground",
    source="thesis Eq. 3.2",
    parameters=(ACTIVE_DAMPING,),
    excludes={
        "scaled_active_damping": "active damping is constant or scaled with the gain: leave out one of "
        "active_damping and scaled_active_damping"
    },
    functions=_functions,
)
