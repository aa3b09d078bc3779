"""What must hold between the values of a scene, beyond each one's own box."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from simulator.parameter import GRAVITY_M_S2

DEEPEST_M = 1.0
"""Depth down to which a granular ground must carry the grains that it adds to the foot."""

Values = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Rule:
    """A rule for scenes in which all of `effects` are on, on the parameters that it `reads`.

    `fault` gives the sentence, None where the rule is met.
    """

    effects: frozenset[str]
    reads: frozenset[str]
    fault: Callable[[Values], str | None]


def _links(p: Values) -> str | None:
    if p["upper_link"] < p["lower_link"]:
        return None
    return (
        f"upper_link = {p['upper_link']:g} m is not shorter than lower_link = {p['lower_link']:g} m, and such a leg "
        "cannot fold: give a shorter upper_link or a longer lower_link."
    )


def _rest_length(p: Values) -> str | None:
    shortest, longest = p["lower_link"] - p["upper_link"], p["lower_link"] + p["upper_link"]
    if shortest * (1.0 + 1e-9) < p["rest_length"] < longest * (1.0 - 1e-9):  # 0.1 + 0.2 is a little more than 0.3
        return None
    return (
        f"rest_length = {p['rest_length']:g} m is out of the leg's reach, which is between {shortest:g} m (folded) and "
        f"{longest:g} m (straight): give a length inside, or other links."
    )


def least_bearing_ratio(p: Values) -> float:
    """Return the least of K(z) / (m_a(z) g) over depths of 0 to 1 m.

    Below 1 the ground would neither hold a foot at rest nor let it sink: both conditions of a jammed foot fail at
    once. While the cone forms, w = V(z) / z is a parabola in z, and so K / z and m_a / z are polynomials; their
    ratio is least at an end or where its derivative's numerator, a quartic, has a root. Once the cone is complete the
    ratio is monotone.
    """
    import numpy as np

    radius, q = p["foot_radius"], p["mu"] / math.tan(p["cone_angle"])
    penetration, stress, recruited = _bearing_factors(p)
    area, complete = math.pi * radius**2, min(radius / q, DEEPEST_M)
    z = np.polynomial.Polynomial([0.0, 1.0])
    w = np.polynomial.Polynomial([area, -math.pi * q * radius, math.pi * q**2 / 3.0])
    resistance = penetration * w + stress * (area + z * w)
    weight = GRAVITY_M_S2 * (recruited * w + p["added_mass_constant"])
    level = resistance.deriv() * weight - resistance * weight.deriv()
    roots: list[float] = np.real(level.roots()).tolist()
    inside = [depth for depth in roots if 0.0 < depth < complete]
    ratios = [float(resistance(depth) / weight(depth)) for depth in (0.0, complete, *inside)]
    volume = complete * float(w(complete))
    deepest = penetration * volume + stress * DEEPEST_M * (area + volume)
    carried = GRAVITY_M_S2 * (recruited * volume + p["added_mass_constant"] * DEEPEST_M)
    return min(*ratios, deepest / carried)


def _bearing_factors(p: Values) -> tuple[float, float, float]:
    """Return what multiplies V and z (area + V) in K, and V in m_a."""
    penetration = p["kg_scale"] * p["k_sh"] / (math.pi * p["foot_radius"] ** 2)
    return penetration, p["kg_scale"] * p["sigma"] / math.cos(p["cone_angle"]), p["phi"] * p["rho"] * p["mu"]


def _bearing(p: Values) -> str | None:
    penetration, stress, recruited = _bearing_factors(p)
    area = math.pi * p["foot_radius"] ** 2
    if penetration >= GRAVITY_M_S2 * recruited and stress * area >= GRAVITY_M_S2 * p["added_mass_constant"]:
        return None  # each term of K carries its own of m_a, at any depth
    ratio = least_bearing_ratio(p)
    if ratio >= 1.0:
        return None
    return (
        f"with kg_scale = {p['kg_scale']:g} the ground cannot carry the grains that the foot takes along (K < m_a g): "
        f"give at least kg_scale = {1.001 * p['kg_scale'] / ratio:.4g}, or leave out added_mass."
    )


def _release(p: Values) -> str | None:
    if p["release_tolerance"] >= p["rest_tolerance"]:
        return None
    return (
        f"release_tolerance = {p['release_tolerance']:g} m is less than rest_tolerance = {p['rest_tolerance']:g} m, so "
        "the leg turns soft before the platform sees it stiff and is never released: give at least rest_tolerance."
    )


def _switching(p: Values) -> str | None:
    if p["rest_tolerance"] < p["switch_compression"]:
        return None
    return (
        f"rest_tolerance = {p['rest_tolerance']:g} m is not less than switch_compression = "
        f"{p['switch_compression']:g} m, so the leg would turn stiff and soft without end: give a smaller "
        "rest_tolerance."
    )


def _guard(p: Values) -> str | None:
    longest = p["rest_length"] - p["rest_tolerance"]
    if p["guard_length"] < longest:
        return None
    return (
        f"guard_length = {p['guard_length']:g} m is not less than rest_length - rest_tolerance = {longest:g} m, so the "
        "leg would turn stiff and soft without end: give a shorter guard_length."
    )


_GROUND = "foot_radius mu cone_angle kg_scale k_sh sigma phi rho added_mass_constant"


def _rule(effects: str, reads: str, fault: Callable[[Values], str | None]) -> Rule:
    return Rule(frozenset(effects.split()), frozenset(reads.split()), fault)


RULES = (
    _rule("", "upper_link lower_link", _links),
    _rule("", "upper_link lower_link rest_length", _rest_length),
    _rule("hydrostatic_stiffness added_mass", _GROUND, _bearing),
    _rule("latched_switching", "rest_tolerance switch_compression", _switching),
    _rule("latched_switching short_leg_guard", "rest_length rest_tolerance guard_length", _guard),
    _rule("emulated_ground latched_switching", "release_tolerance rest_tolerance", _release),
)
