"""Mass of the emulator's platform: it moves with the foot, and slides on by itself where the foot leaves it moving."""

from __future__ import annotations

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, ParameterIndex
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    mass = at("platform_mass")
    return {"platform_mass_kg": inner(lambda p: p[mass])}


EFFECT = Effect(
    name="platform_mass",
    meaning="inertia of the emulator's platform and its motors, its weight carried by them",
    source="thesis 4.2.2: a second leg, driven by motors, is the ground",
    parameters=(
        Parameter("platform_mass", "ground", "kg", "mass that moves with the platform, rotors included", 1e-6, 1e3),
    ),
    needs=(("emulated_ground",),),
    functions=_functions,
)
