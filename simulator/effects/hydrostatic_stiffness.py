"""Granular ground: the depth-dependent resistance K(z), without a restoring force (thesis 3.1.2).

    K(z) = kg_scale [k_sh V(s) / (pi R^2) + sigma z (pi R^2 + V(s)) / cos(cone_angle)]

An area and a volume are added, dimensionally odd; the author's code does so and every published number has it.
"""

from __future__ import annotations

import math

from simulator.compiled import Function, Row, inner
from simulator.effects.effect import Effect, Guard, ParameterIndex
from simulator.effects.shared import CONE, GROUND_LOSS
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    from simulator.effects.cone import cone_volume_m3, flat_area_m2, formed_depth_m

    radius, angle, mu = at("foot_radius"), at("cone_angle"), at("mu")
    k_sh, sigma, scale = at("k_sh"), at("sigma"), at("kg_scale")
    q_at, area_at = at("recruitment_slope"), at("foot_area")
    penetration_at, stress_at, complete_at = at("penetration_factor"), at("stress_factor"), at("cone_depth")

    @inner
    def prepare(p: Row) -> None:
        p[q_at] = p[mu] / math.tan(p[angle])
        p[area_at] = math.pi * p[radius] * p[radius]
        p[penetration_at] = p[scale] * p[k_sh] / p[area_at]
        p[stress_at] = p[scale] * p[sigma] / math.cos(p[angle])
        p[complete_at] = p[radius] / p[q_at]

    @inner
    def resistance_n(p: Row, depth_m: float) -> float:
        formed = formed_depth_m(p[complete_at], depth_m)
        volume = cone_volume_m3(p[radius], p[q_at], formed)
        return p[penetration_at] * volume + p[stress_at] * depth_m * (p[area_at] + volume)

    @inner
    def resistance_slope_n_m(p: Row, depth_m: float) -> float:
        formed = formed_depth_m(p[complete_at], depth_m)
        volume = cone_volume_m3(p[radius], p[q_at], formed)
        area = flat_area_m2(p[radius], p[q_at], formed)
        return p[penetration_at] * area + p[stress_at] * (p[area_at] + volume + depth_m * area)

    return {
        "prepare": prepare,
        "resistance_n": resistance_n,
        "resistance_slope_n_m": resistance_slope_n_m,
        "cone_kink_guard": inner(lambda p, x_b, v_b, x_f, v_f: -x_f - p[complete_at]),
    }


EFFECT = Effect(
    name="hydrostatic_stiffness",
    meaning="granular ground: a resistance that grows with depth, and holds the foot where it stops",
    source="K(z) = kg_scale [k_sh V / (pi R^2) + sigma z (pi R^2 + V) / cos(cone_angle)], where R is foot_radius, V = "
    "pi (R^2 s - q R s^2 + q^2 s^3 / 3), q = mu / tan(cone_angle) and s = min(z, R / q); thesis 3.1.2; Aguilar & "
    "Goldman 2016; Hubicki et al. 2016",
    lacks="a ground of finite depth or in layers, cohesion and adhesion, a power of the depth (Bekker), feet other "
    "than a flat disk",
    parameters=(
        *CONE,
        Parameter("k_sh", "ground", "N/m", "penetration stiffness", 0.0, 1e8),
        Parameter("sigma", "ground", "N/m^3", "depth-dependent stress", 1.0, 1e14),
        Parameter("kg_scale", "ground", "1", "factor on the whole stiffness function", 1e-3, 1e9),
    ),
    excludes={
        "rigid_ground": "a foot stands on one ground: leave out rigid_ground or hydrostatic_stiffness",
        "emulated_ground": "a foot stands on one ground: leave out emulated_ground or hydrostatic_stiffness",
        "touchdown_impact": "grains take the foot without an impact: leave out touchdown_impact",
    },
    energies=(GROUND_LOSS,),
    publishes=("max_depth_m", "unresisted_sink_m"),
    guards=(Guard("cone_kink", "z - R / q", "the cone of grains is complete", ("intruding",)),),
    derived=("recruitment_slope", "foot_area", "penetration_factor", "stress_factor", "cone_depth"),
    functions=_functions,
)
