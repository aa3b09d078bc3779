"""Emulated ground: a motor-driven platform with a ratchet (thesis 4.2).

While it yields (platform down by z, moving down at speed w) it pushes up with k z + alpha w + beta w^2; the ratchet
holds it where it stops. After the leg's push-off the platform is released and led back to the top.
"""

from __future__ import annotations

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, Energy, ParameterIndex
from simulator.effects.shared import GROUND_LOSS, IMPACT_LOSS
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    stiffness, damping, drag = at("platform_stiffness"), at("platform_damping"), at("platform_drag")
    travel = at("platform_travel")
    return {
        "resistance_n": inner(lambda p, depth_m: p[stiffness] * depth_m),
        "resistance_slope_n_m": inner(lambda p, depth_m: p[stiffness]),
        "linear_drag_kg_s": inner(lambda p: p[damping]),
        "quadratic_drag_kg_m": inner(lambda p, depth_m: p[drag]),
        "travel_m": inner(lambda p: p[travel]),
    }


EFFECT = Effect(
    name="emulated_ground",
    meaning="a platform that yields like grains under a ratchet, and is led back up after push-off",
    source="thesis 4.2.1 to 4.2.3",
    parameters=(
        Parameter("platform_stiffness", "ground", "N/m", "stiffness of the platform", 1.0, 1e9),
        Parameter("platform_damping", "ground", "kg/s", "linear damping of the platform", 0.0, 1e4),
        Parameter("platform_drag", "ground", "kg/m", "quadratic damping of the platform", 0.0, 1e4),
        Parameter("platform_travel", "ground", "m", "travel of the platform down to its stop", 1e-3, 1.0),
        Parameter("release_time", "ground", "s", "time the pawl takes to rise", 0.0, 1.0),
        Parameter("reset_time", "ground", "s", "time in which the platform is led back up", 1e-3, 5.0),
        Parameter("engage_time", "ground", "s", "time the pawl takes to fall", 0.0, 1.0),
        Parameter(
            "release_tolerance", "ground", "m", "leg this near to its rest length releases the platform", 0.0, 0.1
        ),
        Parameter("shortest_hold", "ground", "s", "time the platform holds at least before a release", 0.0, 5.0),
    ),
    needs=(("touchdown_impact",), ("latched_switching",)),
    excludes={
        "hydrostatic_stiffness": "a foot stands on one ground: leave out emulated_ground or hydrostatic_stiffness",
        "rigid_ground": "a foot stands on one ground: leave out emulated_ground or rigid_ground",
    },
    energies=(
        GROUND_LOSS,
        IMPACT_LOSS,
        Energy("reset_work", "work of the platform's reset", 1, "platform's reset"),
    ),
    publishes=("max_depth_m",),
    functions=_functions,
)
