"""A reference case in the words of the simulator's scenes: which effects are on, and the value of each parameter."""

from collections.abc import Mapping
from fractions import Fraction

from benchmarks.reference_simulator.parameters import (
    CostForce,
    FlightGains,
    ForceCap,
    GranularParameters,
    HoppingParameters,
    SwitchingRule,
)

_LEG = {
    "body_mass": "body_mass_kg",
    "foot_mass": "foot_mass_kg",
    "rest_length": "rest_length_m",
    "k_compression": "compression_stiffness_n_m",
    "k_extension": "extension_stiffness_n_m",
    "b_compression": "compression_damping_kg_s",
    "b_extension": "extension_damping_kg_s",
    "b_ad": "active_damping_kg_m",
    "force_cap": "constant_cap_n",
    "upper_link": "upper_link_m",
    "lower_link": "lower_link_m",
    "torque_constant": "torque_constant_n_m_a",
    "velocity_constant": "torque_constant_n_m_a",
    "motor_resistance": "motor_resistance_ohm",
    "switch_compression": "switch_compression_m",
    "guard_length": "shortest_leg_m",
}
_GRANULAR = {
    "foot_radius": "foot_radius_m",
    "kg_scale": "stiffness_scale",
    "bg_scale": "drag_scale",
    "cone_angle": "cone_angle_rad",
    "mu": "recruitment_rate",
    "k_sh": "penetration_stiffness_n_m",
    "sigma": "depth_stress_n_m3",
    "c_g": "surrounding_mass_factor",
    "b_g": "inertial_drag_factor",
    "added_mass_constant": "shed_mass_kg_m",
    "rho": "grain_density_kg_m3",
    "phi": "packing_fraction",
}
_HOPPING = {"switch_speed_tolerance": "velocity_tolerance_m_s", "rest_tolerance": "length_tolerance_m"}
_PLATFORM = {
    "platform_stiffness": "stiffness_n_m",
    "platform_damping": "damping_kg_s",
    "platform_drag": "lift_kg_m",
    "platform_travel": "travel_m",
    "release_time": "release_s",
    "reset_time": "reset_s",
    "engage_time": "engage_s",
    "release_tolerance": "release_length_m",
    "shortest_hold": "shortest_hold_s",
}
_CAPS = {ForceCap.NONE: (), ForceCap.CONSTANT: ("constant_force_cap",), ForceCap.TORQUE: ("torque_cap",)}
_COSTS = {
    CostForce.APPLIED: (),
    CostForce.COMMANDED: ("cost_of_commanded_force",),
    CostForce.TORQUE_LIMITED: ("cost_torque_cap",),
}


def effects(p: GranularParameters | HoppingParameters) -> frozenset[str] | None:
    """The effects of a scene that is this case; None where no scene can be, as with contact at once."""
    common = {"leg_damping", "active_damping", "motor_heat", *_CAPS[p.force_cap], *_COSTS[p.cost_force]}
    if isinstance(p, HoppingParameters):
        ground = "rigid_ground" if p.platform is None else "emulated_ground"
        return frozenset(
            common | {ground, "touchdown_impact", "latched_switching", "short_leg_guard", "cost_of_whole_jump"}
        )
    if p.immediate_contact:
        return None
    common |= {"hydrostatic_stiffness", "inertial_drag", "added_mass", "contact_once_risen", "sampled_control"}
    common.add("latched_switching" if p.switching_rule == SwitchingRule.LATCHED else "short_leg_guard")
    if p.flight_gains == FlightGains.HELD:
        common.add("held_gains_in_flight")
    return frozenset(common)


def values(p: GranularParameters | HoppingParameters) -> dict[str, Fraction]:
    """The parameters of a scene that is this case, in SI units, by their names in a scene file."""
    found = {"stall_torque": p.stall_torque_n_m / 2} | _read(p, _LEG)
    if isinstance(p, HoppingParameters):
        platform = {} if p.platform is None else _read(p.platform, _PLATFORM)
        return found | _read(p, _HOPPING) | platform | {"initial_velocity": Fraction(0), "initial_height": Fraction(0)}
    dropped = p.drop_height_m is not None
    return (
        found
        | _read(p, _GRANULAR)
        | {
            "control_rate": 1 / p.tick_s,
            "switch_speed_tolerance": Fraction(0),
            "rest_tolerance": Fraction(0),
            "initial_velocity": Fraction(0) if dropped else p.initial_velocity_m_s,
            "initial_height": Fraction(0) if p.drop_height_m is None else p.drop_height_m - p.rest_length_m,
        }
    )


def _read(p: object, names: Mapping[str, str]) -> dict[str, Fraction]:
    return {name: Fraction(getattr(p, field)) for name, field in names.items()}
