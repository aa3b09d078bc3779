"""Inertial drag of the grains: a force D(z) v^2 against intrusion (thesis 3.1.2).

D(z) = bg_scale b_g c_g [phi rho mu A(s) + C]
"""

from __future__ import annotations

from simulator.compiled import Function, Row, inner
from simulator.effects.effect import Effect, ParameterIndex
from simulator.effects.shared import ADDED_MASS_CONSTANT, CONE, GROUND_LOSS, PHI, RHO
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    from simulator.effects.cone import flat_area_m2, formed_depth_m

    radius, mu, phi, rho, constant = at("foot_radius"), at("mu"), at("phi"), at("rho"), at("added_mass_constant")
    b_g, c_g, scale = at("b_g"), at("c_g"), at("bg_scale")
    q_at, complete_at, per_area_at, rest_at = (
        at("recruitment_slope"),
        at("cone_depth"),
        at("drag_per_area"),
        at("drag_constant"),
    )

    @inner
    def prepare(p: Row) -> None:
        factor = p[scale] * p[b_g] * p[c_g]
        p[per_area_at] = factor * p[phi] * p[rho] * p[mu]
        p[rest_at] = factor * p[constant]

    @inner
    def quadratic_drag_kg_m(p: Row, depth_m: float) -> float:
        formed = formed_depth_m(p[complete_at], depth_m)
        return p[per_area_at] * flat_area_m2(p[radius], p[q_at], formed) + p[rest_at]

    return {"prepare": prepare, "quadratic_drag_kg_m": quadratic_drag_kg_m}


EFFECT = Effect(
    name="inertial_drag",
    meaning="drag of the grains, quadratic in the foot's speed",
    source="D(z) v^2 with D = bg_scale b_g c_g [phi rho mu A + C], where A = pi (R - q s)^2, R, q and s as of "
    "hydrostatic_stiffness, and C is added_mass_constant; thesis 3.1.2; Aguilar & Goldman 2016; Hubicki et al. 2016",
    parameters=(
        *CONE,
        PHI,
        RHO,
        ADDED_MASS_CONSTANT,
        Parameter("b_g", "ground", "1", "scale of the inertial drag", 0.0, 1e4),
        Parameter("c_g", "ground", "1", "factor for the surrounding mass", 0.0, 1e3),
        Parameter("bg_scale", "ground", "1", "factor on the whole drag function", 0.0, 1e4),
    ),
    needs=(("hydrostatic_stiffness",),),
    energies=(GROUND_LOSS,),
    derived=("drag_per_area", "drag_constant"),
    functions=_functions,
)
