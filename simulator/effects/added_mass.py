"""Added mass: the grains that move with the foot while it intrudes (thesis 3.1.2).

m_a(z) = phi rho mu V(s) + C z
"""

from __future__ import annotations

from simulator.compiled import Function, Row, inner
from simulator.effects.effect import Effect, Energy, ParameterIndex
from simulator.effects.shared import ADDED_MASS_CONSTANT, CONE, PHI, RHO


def _functions(at: ParameterIndex) -> dict[str, Function]:
    from simulator.effects.cone import cone_volume_m3, flat_area_m2, formed_depth_m

    radius, mu, phi, rho, constant = at("foot_radius"), at("mu"), at("phi"), at("rho"), at("added_mass_constant")
    q_at, complete_at, density_at = at("recruitment_slope"), at("cone_depth"), at("recruited_density")

    @inner
    def prepare(p: Row) -> None:
        p[density_at] = p[phi] * p[rho] * p[mu]

    @inner
    def added_mass_kg(p: Row, depth_m: float) -> float:
        formed = formed_depth_m(p[complete_at], depth_m)
        return p[density_at] * cone_volume_m3(p[radius], p[q_at], formed) + p[constant] * depth_m

    @inner
    def added_mass_slope_kg_m(p: Row, depth_m: float) -> float:
        formed = formed_depth_m(p[complete_at], depth_m)
        return p[density_at] * flat_area_m2(p[radius], p[q_at], formed) + p[constant]

    return {"prepare": prepare, "added_mass_kg": added_mass_kg, "added_mass_slope_kg_m": added_mass_slope_kg_m}


EFFECT = Effect(
    name="added_mass",
    meaning="grains that move with the foot while it intrudes, lost when it stops",
    source="m_a(z) = phi rho mu V + C z, V as of hydrostatic_stiffness, and C is added_mass_constant; thesis 3.1.2; "
    "Aguilar & Goldman 2016",
    parameters=(*CONE, PHI, RHO, ADDED_MASS_CONSTANT),
    needs=(("hydrostatic_stiffness",),),
    energies=(Energy("grain_energy", "energy brought along by grains that join the foot", 1, "brought by the grains"),),
    derived=("recruited_density",),
    functions=_functions,
)
