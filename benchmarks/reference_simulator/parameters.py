"""The parameters of a reference jump: exact rational numbers in SI units, named as in the physics they stand for."""

from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction

GRAVITY = Fraction("9.81")


class ForceCap(StrEnum):
    """What clips the leg force in the equations of motion."""

    NONE = "none"
    CONSTANT = "constant"
    TORQUE = "torque"


class CostForce(StrEnum):
    """Which force the motors pay for."""

    COMMANDED = "commanded"
    APPLIED = "applied"
    TORQUE_LIMITED = "torque_limited"  # the commanded force, cut to the stall torque: first set of simulations


class SwitchingRule(StrEnum):
    """When a sampled leg passes from compression to extension and back."""

    UNLATCHED = "unlatched"
    LATCHED = "latched"


class FlightGains(StrEnum):
    """The gains from lift-off on: those of compression, or the last ones of stance."""

    SOFT = "soft"
    HELD = "held"


@dataclass(frozen=True, slots=True, kw_only=True)
class LegParameters:
    """Robot, leg, controller and motors (thesis Eq. 3.1, 3.2, 3.5; 3.2.1)."""

    body_mass_kg: Fraction
    foot_mass_kg: Fraction
    rest_length_m: Fraction = Fraction("0.27")
    compression_stiffness_n_m: Fraction = Fraction(250)
    extension_stiffness_n_m: Fraction = Fraction(650)
    compression_damping_kg_s: Fraction = Fraction("0.5")
    extension_damping_kg_s: Fraction = Fraction(5)
    active_damping_kg_m: Fraction = Fraction(0)
    force_cap: ForceCap = ForceCap.TORQUE
    constant_cap_n: Fraction = Fraction(70)
    stall_torque_n_m: Fraction = Fraction(7)  # both motors
    cost_force: CostForce = CostForce.APPLIED
    upper_link_m: Fraction = Fraction("0.1")
    lower_link_m: Fraction = Fraction("0.2")
    torque_constant_n_m_a: Fraction = Fraction("0.09549296586")
    motor_resistance_ohm: Fraction = Fraction("0.186")


@dataclass(frozen=True, slots=True, kw_only=True)
class GranularParameters(LegParameters):
    """One jump on granular ground under 1 kHz sampled control (thesis 3.1.2, 3.1.3, 5.1.1).

    At time 0 the foot touches the undisturbed surface, the leg at rest length, both masses at `initial_velocity_m_s`.
    """

    body_mass_kg: Fraction = Fraction("1.75")
    foot_mass_kg: Fraction = Fraction("0.175")
    initial_velocity_m_s: Fraction = Fraction(-1)
    drop_height_m: Fraction | None = None  # body height of a drop from rest; stands in place of the initial velocity
    switching_rule: SwitchingRule = SwitchingRule.UNLATCHED
    flight_gains: FlightGains = FlightGains.SOFT
    # Soft gains can press the foot down again at the instant of lift-off. With immediate contact the stance goes on
    # then; without, contact is looked for only once the foot has risen, as in every published number.
    immediate_contact: bool = False
    tick_s: Fraction = Fraction("0.001")
    switch_compression_m: Fraction = Fraction("0.05")
    shortest_leg_m: Fraction = Fraction("0.105")
    foot_radius_m: Fraction = Fraction("0.03")
    stiffness_scale: Fraction = Fraction(1)  # kg_scale
    drag_scale: Fraction = Fraction(1)  # bg_scale
    cone_angle_rad: Fraction = Fraction("1.0472")
    recruitment_rate: Fraction = Fraction(2)  # mu
    penetration_stiffness_n_m: Fraction = Fraction(1600)  # k_sh
    depth_stress_n_m3: Fraction = Fraction(120000)  # sigma
    surrounding_mass_factor: Fraction = Fraction("2.7")  # c_g
    inertial_drag_factor: Fraction = Fraction("17.2")  # b_g
    shed_mass_kg_m: Fraction = Fraction(1)  # C
    grain_density_kg_m3: Fraction = Fraction(1000)  # rho
    packing_fraction: Fraction = Fraction("0.57")  # phi


@dataclass(frozen=True, slots=True, kw_only=True)
class HoppingParameters(LegParameters):
    """Repeated jumps under continuous control on rigid ground, or on the emulated ground of thesis 4.2.

    The start is at rest with the toe at 0 and the leg at rest length; on emulated ground the hold phase begins then.
    """

    platform: "PlatformParameters | None" = None  # None is rigid ground
    switch_compression_m: Fraction = Fraction("0.05")
    shortest_leg_m: Fraction = Fraction("0.105")
    velocity_tolerance_m_s: Fraction = Fraction("0.02")
    length_tolerance_m: Fraction = Fraction("0.005")
    folded_leg_m: Fraction = Fraction("0.101")
    straight_leg_m: Fraction = Fraction("0.2999")
    longest_jump_s: Fraction = Fraction(2)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlatformParameters:
    """The emulated ground (thesis 4.2): a massless platform that a ratchet lets sink, and the clock that lifts it."""

    stiffness_n_m: Fraction = Fraction(1603)
    damping_kg_s: Fraction = Fraction(30)
    lift_kg_m: Fraction = Fraction("46.4")
    travel_m: Fraction = Fraction("0.07")
    yield_margin_n: Fraction = Fraction(0)
    release_length_m: Fraction = Fraction("0.01")
    shortest_hold_s: Fraction = Fraction("0.05")
    release_s: Fraction = Fraction("0.01")
    reset_s: Fraction = Fraction("0.06")
    engage_s: Fraction = Fraction("0.01")
