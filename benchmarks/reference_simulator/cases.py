"""The jumps whose results are stored, scene by scene, with their parameters spelled out (thesis ch. 3 to 5).

Effects and parameters have the names of the simulator's scenes, by which it finds the results, in SI units.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from benchmarks.reference_simulator.granular import reference_jump
from benchmarks.reference_simulator.hopping import reference_jumps
from benchmarks.reference_simulator.result import ReferenceResult
from data_schema.errors import unknown_name

# Of scenes in which jumps follow each other this many are stored.
STORED_JUMPS = 4
CONTACT_ONCE_RISEN = "contact_once_risen"


@dataclass(frozen=True, slots=True)
class ReferenceCase:
    """One named set of effects and parameters."""

    name: str
    effects: frozenset[str]
    values: Mapping[str, Fraction]

    @property
    def is_scene(self) -> bool:
        """Whether the simulator knows such a scene: contact at once it does not."""
        return "sampled_control" not in self.effects or CONTACT_ONCE_RISEN in self.effects

    def compute(self, digits: int, order: int) -> tuple[ReferenceResult, ...]:
        """The case's jumps to `digits` digits."""
        if "sampled_control" in self.effects:
            return (reference_jump(self.effects, self.values, digits, order),)
        return reference_jumps(self.effects, self.values, STORED_JUMPS, digits, order)


def _table(text: str) -> dict[str, str]:
    """Words by turns: a parameter and its value."""
    words = text.split()
    return dict(zip(words[::2], words[1::2], strict=True))


_LEG = _table("""
    stall_torque 3.5  body_mass 1.75  foot_mass 0.175  rest_length 0.27
    k_compression 250  k_extension 650  b_compression 0.5  b_extension 5  b_ad 0  force_cap 70
    upper_link 0.1  lower_link 0.2
    torque_constant 0.09549296586  velocity_constant 0.09549296586  motor_resistance 0.186
    switch_compression 0.05  guard_length 0.105
""")
_GROUND = _table("""
    foot_radius 0.03  kg_scale 1  bg_scale 1  cone_angle 1.0472  mu 2  k_sh 1600  sigma 120000  c_g 2.7  b_g 17.2
    added_mass_constant 1  rho 1000  phi 0.57
    control_rate 1000  switch_speed_tolerance 0  rest_tolerance 0  initial_velocity -1  initial_height 0
""")
_PLATFORM = _table("""
    platform_stiffness 1603  platform_damping 30  platform_drag 46.4  platform_travel 0.07
    release_time 0.01  reset_time 0.06  engage_time 0.01  release_tolerance 0.01  shortest_hold 0.05
""")
_OF_ALL = "leg_damping active_damping motor_heat"
_SAMPLED = (
    f"{_OF_ALL} hydrostatic_stiffness inertial_drag added_mass sampled_control {CONTACT_ONCE_RISEN} short_leg_guard"
)
_LATCHED = _SAMPLED.replace("short_leg_guard", "latched_switching torque_cap")
_HOPS = f"{_OF_ALL} touchdown_impact latched_switching short_leg_guard cost_of_whole_jump torque_cap"
_CONSISTENT = f"{_SAMPLED} torque_cap"
_SECOND_SET = f"{_SAMPLED} constant_force_cap cost_of_commanded_force"
"""Ch. 3, second set of simulations: a constant cap and the cost of the commanded force, unless they are consistent."""


def _case(name: str, effects: str, *tables: Mapping[str, str], **own: str | Fraction) -> ReferenceCase:
    values = {name: Fraction(value) for table in (_LEG, *tables, own) for name, value in table.items()}
    return ReferenceCase(name, frozenset(effects.split()), values)


def stiffness_of_gain(gain: int) -> Fraction:
    """Leg stiffness in N/m of a controller gain (thesis 5.1.1)."""
    return Fraction("2.56") * gain + Fraction("67.36")


def damping_of_gain(gain: int) -> Fraction:
    """Damping in kg/s, of active damping in kg/m, of a controller gain (thesis 5.1.1)."""
    return Fraction("3.32") * gain + Fraction("19.67")


def _bed(foot: str, radius_m: str, gain: int, active_gain: int = 0) -> ReferenceCase:
    """Ch. 5: two feet on glass beads, dropped."""
    active = f", active gain {active_gain}" if active_gain else ""
    return _case(
        f"{foot} foot, gain {gain}{active}",
        _LATCHED,
        _GROUND,
        _table("body_mass 1.8  foot_mass 0.2  kg_scale 1.4  rho 2500  phi 0.62  initial_velocity 0"),
        initial_height="0.15",
        foot_radius=radius_m,
        k_extension=stiffness_of_gain(gain),
        b_compression=damping_of_gain(0),
        b_extension=damping_of_gain(0),
        b_ad=damping_of_gain(active_gain) if active_gain else "0",
    )


def _emulator(gain: int, b_ad: str = "0") -> ReferenceCase:
    """Ch. 4: the quarter robot on the emulated ground."""
    table = _table("body_mass 1.575  rest_length 0.25  k_compression 118.6  b_compression 19  b_extension 0.5")
    named = f", b_AD = {b_ad}" if b_ad != "0" else ""
    return _hops(f"gain {gain}{named}", "emulated_ground", gain, table, _PLATFORM, b_ad=b_ad)


def _hops(name: str, ground: str, gain: int, *tables: Mapping[str, str], b_ad: str = "0") -> ReferenceCase:
    own, (table, *others) = _table("switch_speed_tolerance 0.02  rest_tolerance 0.005"), tables
    start = _table("initial_velocity 0  initial_height 0")
    values = {"k_extension": str(stiffness_of_gain(gain)), "b_ad": b_ad}
    return _case(name, f"{_HOPS} {ground}", table, values, own, *others, start)


def _first_set(name: str, **own: str) -> ReferenceCase:
    """Ch. 3, first set of simulations: no cap in the dynamics, the stall torque in the cost."""
    return _case(name, f"{_SAMPLED} cost_torque_cap", _GROUND, **own)


def _second_set(name: str, effects: str = _SECOND_SET, **own: str) -> ReferenceCase:
    return _case(name, effects, _GROUND, **own)


CASES: dict[str, tuple[ReferenceCase, ...]] = {
    "bed": (
        _bed("small", "0.038", 300),
        _bed("small", "0.038", 400),
        _bed("small", "0.038", 400, 150),
        _bed("large", "0.051", 300),
    ),
    "sim1": (_first_set("defaults"), _first_set("b_AD = 650", b_ad="650")),
    "sim2": (
        _second_set("defaults"),
        _second_set("defaults, held gains in flight", f"{_SECOND_SET} held_gains_in_flight"),
        _second_set("defaults, immediate contact", _SECOND_SET.replace(CONTACT_ONCE_RISEN, "")),
        _second_set("b_AD = 100", b_ad="100"),
        _second_set("R = 0.038, k_e = 1091.36", foot_radius="0.038", k_extension="1091.36"),
        _second_set("kg_scale = 100", kg_scale="100"),
        _second_set("consistent, defaults", _CONSISTENT),
        _second_set("consistent, R = 0.038, k_e = 1091.36", _CONSISTENT, foot_radius="0.038", k_extension="1091.36"),
    ),
    "emulator": (
        *(_emulator(gain) for gain in (100, 200, 300, 400)),
        _emulator(300, "166"),
        _emulator(400, "664/3"),
    ),
    "force_plate": tuple(
        _hops(f"gain {gain}", "rigid_ground", gain, _table("body_mass 1.825  b_compression 25"))
        for gain in (300, 400, 500, 600)
    ),
}


def cases(scene: str) -> tuple[ReferenceCase, ...]:
    """The cases of a scene; UnknownName if it has none."""
    if scene not in CASES:
        raise unknown_name("scene with a reference", scene, CASES)
    return CASES[scene]
