"""The jumps whose results are stored, scene by scene, with their parameters spelled out (thesis ch. 3 to 5)."""

from dataclasses import dataclass
from fractions import Fraction

from benchmarks.reference_simulator.granular import reference_jump
from benchmarks.reference_simulator.hopping import reference_jumps
from benchmarks.reference_simulator.leg import (
    CostForce,
    FlightGains,
    ForceCap,
    GranularParameters,
    HoppingParameters,
    PlatformParameters,
    SwitchingRule,
)
from benchmarks.reference_simulator.result import ReferenceResult
from data_schema.errors import unknown_name

# The fit of damping over gain at gain 0 (thesis 5.1.1), in kg/s.
ZERO_GAIN_DAMPING_KG_S = Fraction("19.67")
# Of scenes in which jumps follow each other this many are stored.
STORED_JUMPS = 4


@dataclass(frozen=True, slots=True)
class ReferenceCase:
    """One named set of parameters."""

    name: str
    parameters: GranularParameters | HoppingParameters

    def compute(self, digits: int, order: int) -> tuple[ReferenceResult, ...]:
        """The case's jumps to `digits` digits."""
        if isinstance(self.parameters, GranularParameters):
            return (reference_jump(self.parameters, digits, order),)
        return reference_jumps(self.parameters, STORED_JUMPS, digits, order)


def stiffness_of_gain(gain: int) -> Fraction:
    """Leg stiffness in N/m of a controller gain (thesis 5.1.1)."""
    return Fraction("2.56") * gain + Fraction("67.36")


def damping_of_gain(gain: int) -> Fraction:
    """Active damping in kg/m of a controller gain (thesis 5.1.1); gain 0 is none."""
    return Fraction("3.32") * gain + ZERO_GAIN_DAMPING_KG_S if gain else Fraction(0)


def _bed(foot_radius_m: str, extension_gain: int, active_gain: int) -> GranularParameters:
    """Ch. 5: two feet on glass beads, dropped."""
    return GranularParameters(
        body_mass_kg=Fraction("1.8"),
        foot_mass_kg=Fraction("0.2"),
        compression_damping_kg_s=ZERO_GAIN_DAMPING_KG_S,
        extension_stiffness_n_m=stiffness_of_gain(extension_gain),
        extension_damping_kg_s=ZERO_GAIN_DAMPING_KG_S,
        active_damping_kg_m=damping_of_gain(active_gain),
        drop_height_m=Fraction("0.42"),
        switching_rule=SwitchingRule.LATCHED,
        foot_radius_m=Fraction(foot_radius_m),
        stiffness_scale=Fraction("1.4"),
        grain_density_kg_m3=Fraction(2500),
        packing_fraction=Fraction("0.62"),
    )


def _first_set(active_damping_kg_m: int) -> GranularParameters:
    """Ch. 3, first set of simulations: no cap in the dynamics, the stall torque in the cost."""
    return GranularParameters(
        active_damping_kg_m=Fraction(active_damping_kg_m),
        force_cap=ForceCap.NONE,
        cost_force=CostForce.TORQUE_LIMITED,
    )


def _second_set(
    *,
    active_damping_kg_m: int = 0,
    foot_radius_m: str = "0.03",
    extension_stiffness_n_m: str = "650",
    stiffness_scale: int = 1,
    flight_gains: FlightGains = FlightGains.SOFT,
    consistent: bool = False,
    immediate_contact: bool = False,
) -> GranularParameters:
    """Ch. 3, second set of simulations: a constant cap and the cost of the commanded force, unless `consistent`."""
    return GranularParameters(
        active_damping_kg_m=Fraction(active_damping_kg_m),
        foot_radius_m=Fraction(foot_radius_m),
        extension_stiffness_n_m=Fraction(extension_stiffness_n_m),
        stiffness_scale=Fraction(stiffness_scale),
        flight_gains=flight_gains,
        force_cap=ForceCap.TORQUE if consistent else ForceCap.CONSTANT,
        cost_force=CostForce.APPLIED if consistent else CostForce.COMMANDED,
        immediate_contact=immediate_contact,
    )


def _emulator(extension_gain: int, active_damping_kg_m: Fraction) -> HoppingParameters:
    """Ch. 4: the quarter robot on the emulated ground."""
    return HoppingParameters(
        body_mass_kg=Fraction("1.575"),
        foot_mass_kg=Fraction("0.175"),
        rest_length_m=Fraction("0.25"),
        compression_stiffness_n_m=Fraction("118.6"),
        compression_damping_kg_s=Fraction(19),
        extension_stiffness_n_m=stiffness_of_gain(extension_gain),
        extension_damping_kg_s=Fraction("0.5"),
        active_damping_kg_m=active_damping_kg_m,
        platform=PlatformParameters(),
    )


def _force_plate(extension_gain: int) -> HoppingParameters:
    """3.2.2: the whole robot on a force plate."""
    return HoppingParameters(
        body_mass_kg=Fraction("1.825"),
        foot_mass_kg=Fraction("0.175"),
        compression_damping_kg_s=Fraction(25),
        extension_stiffness_n_m=stiffness_of_gain(extension_gain),
    )


CASES: dict[str, tuple[ReferenceCase, ...]] = {
    "bed": (
        ReferenceCase("small foot, gain 300", _bed("0.038", 300, 0)),
        ReferenceCase("small foot, gain 400", _bed("0.038", 400, 0)),
        ReferenceCase("small foot, gain 400, active gain 150", _bed("0.038", 400, 150)),
        ReferenceCase("large foot, gain 300", _bed("0.051", 300, 0)),
    ),
    "sim1": (
        ReferenceCase("defaults", _first_set(0)),
        ReferenceCase("b_AD = 650", _first_set(650)),
    ),
    "sim2": (
        ReferenceCase("defaults", _second_set()),
        ReferenceCase("defaults, held gains in flight", _second_set(flight_gains=FlightGains.HELD)),
        ReferenceCase("defaults, immediate contact", _second_set(immediate_contact=True)),
        ReferenceCase("b_AD = 100", _second_set(active_damping_kg_m=100)),
        ReferenceCase(
            "R = 0.038, k_e = 1091.36", _second_set(foot_radius_m="0.038", extension_stiffness_n_m="1091.36")
        ),
        ReferenceCase("kg_scale = 100", _second_set(stiffness_scale=100)),
        ReferenceCase("consistent, defaults", _second_set(consistent=True)),
        ReferenceCase(
            "consistent, R = 0.038, k_e = 1091.36",
            _second_set(consistent=True, foot_radius_m="0.038", extension_stiffness_n_m="1091.36"),
        ),
    ),
    "emulator": (
        ReferenceCase("gain 100", _emulator(100, Fraction(0))),
        ReferenceCase("gain 200", _emulator(200, Fraction(0))),
        ReferenceCase("gain 300", _emulator(300, Fraction(0))),
        ReferenceCase("gain 400", _emulator(400, Fraction(0))),
        ReferenceCase("gain 300, b_AD = 166", _emulator(300, Fraction(166))),
        ReferenceCase("gain 400, b_AD = 664/3", _emulator(400, Fraction(664, 3))),
    ),
    "force_plate": tuple(ReferenceCase(f"gain {gain}", _force_plate(gain)) for gain in (300, 400, 500, 600)),
}


def cases(scene: str) -> tuple[ReferenceCase, ...]:
    """The cases of a scene; UnknownName if it has none."""
    if scene not in CASES:
        raise unknown_name("scene with a reference", scene, CASES)
    return CASES[scene]
