"""A campaign whose values are stated, not simulated: kinematics of one hop, groups, and what a plate records of it.

The hop is a prescribed motion, not a solution of the equations of motion: ballistic phases are exact parabolas, so the
apex is known exactly. In stance the leg's force is prescribed over time: it sets in at touchdown, jumps at the
switch from soft to stiff spring and fades to nothing at lift-off; its size follows from the speeds and the travel.
The controller is the thesis's (4.2.5, 5.1.1): compression until the leg stops shortening, extension until it is
at its rest length. The foot's mass is neglected: body and centre of mass move alike in flight.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from data_schema.units import STANDARD_GRAVITY_M_S2
from labbook.demo.plate import RATE_HZ, record_of
from labbook.demo.truth import CONTROL_GAIN, REST_LENGTH_M, Hop, Scatter, Truth
from labbook.demo.writers import PlateRecord

FloatArray = NDArray[np.float64]

_COMPRESSION_POWER = 12
_EXTENSION_POWER = 3
"""The force at a time t from the switch is in proportion to 1 - (t / duration)^power: the damper of a compressing
leg makes it nearly constant, an extending spring lets it fade."""
_INTRUDING_SHARE = 0.55
"""Part of the extension during which the foot still sinks before the ground jams again (thesis 3.1.6)."""
_FOOT_RINGING_RAD_S = 60.0
_FOOT_RINGING_DAMPING = 0.35


class PrescribedHop:
    """What defines a hop. Heights are of the body above the undisturbed ground, times begin with the drop.

    `jamming_time_s` is how long the ground takes to stop the foot after touchdown (0: rigid ground), and
    `extension_intrusion_m` how much deeper the extending leg pushes it.
    """

    def __init__(
        self,
        drop_height_m: float,
        apex_height_m: float,
        rest_length_m: float = 0.27,
        compression_m: float = 0.105,
        jamming_time_s: float = 0.03,
        extension_intrusion_m: float = 0.02,
    ) -> None:
        g = STANDARD_GRAVITY_M_S2
        self.drop_height_m, self.apex_height_m, self.rest_length_m = drop_height_m, apex_height_m, rest_length_m
        self.jamming_time_s, self.extension_intrusion_m = jamming_time_s, extension_intrusion_m
        self.touchdown_speed_m_s = math.sqrt(2 * g * (drop_height_m - rest_length_m))
        # Where the ground first jams: the foot's speed dies quadratically.
        self.compression_intrusion_m = self.touchdown_speed_m_s * jamming_time_s / 3
        self.lift_off_height_m = rest_length_m - self.compression_intrusion_m - extension_intrusion_m
        self.lift_off_speed_m_s = math.sqrt(2 * g * (apex_height_m - self.lift_off_height_m))
        # The lowest height, where the soft spring is exchanged for the stiff one.
        self.switch_height_m = rest_length_m - compression_m - self.compression_intrusion_m
        self.compression_duration_s = _push_duration_s(
            self.touchdown_speed_m_s, rest_length_m - self.switch_height_m, _COMPRESSION_POWER
        )
        self.extension_duration_s = _push_duration_s(
            self.lift_off_speed_m_s, self.lift_off_height_m - self.switch_height_m, _EXTENSION_POWER
        )
        self.touchdown_s = self.touchdown_speed_m_s / g
        self.switch_s = self.touchdown_s + self.compression_duration_s
        self.lift_off_s = self.switch_s + self.extension_duration_s
        self.apex_s = self.lift_off_s + self.lift_off_speed_m_s / g
        self.landing_s = self.apex_s + math.sqrt(2 * max(apex_height_m - rest_length_m, 0.0) / g)
        assert 0 <= jamming_time_s < self.compression_duration_s, "the ground jams after the compression"

    def as_drawn(self) -> Hop:
        """Return what the demonstration draws a log from."""
        return Hop(
            lift_off_height_m=self.lift_off_height_m,
            apex_height_m=self.apex_height_m,
            switch_height_m=self.switch_height_m,
            switch_leg_m=self.switch_height_m + self.compression_intrusion_m,
            switch_s=self.switch_s,
            apex_s=self.apex_s,
            landing_s=self.landing_s,
            motion=lambda time_s: hop_motion(self, time_s)[:4],
        )


def hop_motion(hop: PrescribedHop, time_s: FloatArray) -> FloatArray:
    """Sample a hop at `time_s`, seconds after the drop, rising; after the apex the fall goes on for ever.

    Rows are the body's height, the leg's length and velocity, whether it extends, and the body's acceleration; SI
    units, up positive.
    """
    g = STANDARD_GRAVITY_M_S2
    drop, compression, extension, flight = (
        slice(start, stop) for start, stop in _between(time_s, hop.touchdown_s, hop.switch_s, hop.lift_off_s)
    )
    height, velocity, acceleration = (np.empty_like(time_s) for _ in range(3))
    foot_height, foot_velocity = np.zeros_like(time_s), np.zeros_like(time_s)
    leg_length, leg_velocity = np.full_like(time_s, hop.rest_length_m), np.zeros_like(time_s)

    height[drop] = hop.drop_height_m - g * time_s[drop] ** 2 / 2
    acceleration[drop] = -g

    since = time_s[compression] - hop.touchdown_s
    # Compression is an extension seen backwards in time.
    rise, speed, acceleration[compression] = _push(
        hop.switch_s - time_s[compression], hop.compression_duration_s, hop.touchdown_speed_m_s, _COMPRESSION_POWER
    )
    height[compression], velocity[compression] = hop.switch_height_m + rise, -speed
    if hop.jamming_time_s > 0:
        left = np.clip(hop.jamming_time_s - since, 0, hop.jamming_time_s) / hop.jamming_time_s
        foot_height[compression] = -hop.compression_intrusion_m * (1 - left**3)
        foot_velocity[compression] = -hop.touchdown_speed_m_s * left**2

    since = time_s[extension] - hop.switch_s
    rise, velocity[extension], acceleration[extension] = _push(
        since, hop.extension_duration_s, hop.lift_off_speed_m_s, _EXTENSION_POWER
    )
    height[extension] = hop.switch_height_m + rise
    intruding_s = _INTRUDING_SHARE * hop.extension_duration_s
    share = np.clip(since / intruding_s, 0, 1)
    foot_height[extension] = -hop.compression_intrusion_m - hop.extension_intrusion_m * share**2 * (3 - 2 * share)
    foot_velocity[extension] = -hop.extension_intrusion_m * 6 * share * (1 - share) / intruding_s

    for stance in (compression, extension):
        leg_length[stance] = height[stance] - foot_height[stance]
        leg_velocity[stance] = velocity[stance] - foot_velocity[stance]

    since = time_s[flight] - hop.apex_s
    height[flight], acceleration[flight] = hop.apex_height_m - g * since**2 / 2, -g
    ringing_m, leg_velocity[flight] = _ringing(time_s[flight] - hop.lift_off_s, hop.lift_off_speed_m_s)
    leg_length[flight] += ringing_m

    extending = np.zeros_like(time_s)
    extending[extension] = 1.0
    return np.stack([height, leg_length, leg_velocity, extending, acceleration])


def _push_duration_s(speed_m_s: float, travel_m: float, power: int) -> float:
    """Time in which the force of `_push` brings a body at rest to `speed_m_s` within `travel_m`."""
    linear = (power + 3) * speed_m_s
    return (math.sqrt(linear**2 + 8 * (power + 2) * STANDARD_GRAVITY_M_S2 * travel_m) - linear) / (
        2 * STANDARD_GRAVITY_M_S2
    )


def _push(
    time_s: FloatArray, duration_s: float, speed_m_s: float, power: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rise, velocity and acceleration of a body pushed from rest to `speed_m_s`, the force fading to nothing."""
    g = STANDARD_GRAVITY_M_S2
    greatest_m_s2 = (power + 1) / power * (speed_m_s / duration_s + g)
    faded = (time_s / duration_s) ** power
    acceleration = greatest_m_s2 * (1 - faded) - g
    velocity = time_s * (greatest_m_s2 * (1 - faded / (power + 1)) - g)
    rise = time_s**2 * (greatest_m_s2 * (0.5 - faded / ((power + 1) * (power + 2))) - g / 2)
    return rise, velocity, acceleration


def _between(time_s: FloatArray, *edges_s: float) -> list[tuple[int, int]]:
    """Index ranges of the phases that `edges_s` separate in a rising `time_s`."""
    cuts = [0, *(int(cut) for cut in np.searchsorted(time_s, edges_s)), time_s.size]
    return list(pairwise(cuts))


def _ringing(since_s: FloatArray, speed_m_s: float) -> tuple[FloatArray, FloatArray]:
    """Length over rest length and velocity of the leg in flight: the light foot rings on the soft spring."""
    decay_1_s = _FOOT_RINGING_DAMPING * _FOOT_RINGING_RAD_S
    omega_rad_s = _FOOT_RINGING_RAD_S * math.sqrt(1 - _FOOT_RINGING_DAMPING**2)
    envelope = speed_m_s * np.exp(-decay_1_s * since_s)
    sine, cosine = np.sin(omega_rad_s * since_s), np.cos(omega_rad_s * since_s)
    return envelope * sine / omega_rad_s, envelope * (cosine - decay_1_s / omega_rad_s * sine)


@dataclass(frozen=True, slots=True)
class StatedGroup:
    """A group whose values are stated, see `labbook.demo.truth.Group`.

    `saving` is (CE - AD) / CE, the same at every active-damping gain; `jamming_time_s` and
    `extension_intrusion_m` shape the stance in the logs only.
    """

    foot: str
    k_gain: int
    control_joules_per_jump: float
    saving: float
    control_apex_m: float
    apex_increase_m: float
    jamming_time_s: float
    extension_intrusion_m: float

    def joules_per_jump(self, b_ad_gain: int) -> float:
        """Energy from the pack for one jump, above the passive draw."""
        return self.control_joules_per_jump * (1.0 if b_ad_gain == CONTROL_GAIN else 1.0 - self.saving)

    def apex_height_m(self, b_ad_gain: int) -> float:
        """Mean apex height of the body above the undisturbed ground."""
        return self.control_apex_m + (0.0 if b_ad_gain == CONTROL_GAIN else self.apex_increase_m)

    def hop(self, rng: np.random.Generator, _b_ad_gain: int, start_m: float, apex_m: float) -> Hop:
        """Draw a jump from `start_m` that reaches `apex_m`; its stance is the same at all gains of active damping."""
        return PrescribedHop(
            start_m,
            apex_m,
            rest_length_m=REST_LENGTH_M,
            compression_m=0.105 + rng.normal(0, 0.002),
            jamming_time_s=self.jamming_time_s,
            extension_intrusion_m=self.extension_intrusion_m * rng.normal(1, 0.05),
        ).as_drawn()


GROUPS = (
    StatedGroup("large", 400, 42.6, 0.09, 0.345, 0.0010, 0.022, 0.014),
    StatedGroup("large", 300, 41.5, 0.05, 0.318, 0.0005, 0.022, 0.012),
    StatedGroup("small", 400, 42.0, 0.15, 0.325, 0.0030, 0.030, 0.022),
    StatedGroup("small", 300, 41.0, 0.12, 0.292, 0.0020, 0.030, 0.019),
)
STATED = Truth(groups=GROUPS, scatter=Scatter(run_mah=1.8))
"""A campaign of the size of chapter 5: numbers of tests were frozen with it."""
ROBOT_MASS_KG = 2.0
_APEX_M, _APEX_SD_M = 0.345, 0.004


def hops_in_place(apexes_m: FloatArray) -> tuple[list[PrescribedHop], FloatArray]:
    """Hop from apex to apex on rigid ground; returns the hops, and their force on a plate that is empty for a second
    before and after.
    """
    unloaded, late_s = np.zeros(RATE_HZ), 0.0
    hops = [
        PrescribedHop(float(start_m), float(apex_m), jamming_time_s=0.0, extension_intrusion_m=0.0)
        for start_m, apex_m in pairwise(apexes_m)
    ]
    pieces = [unloaded]
    for hop in hops:
        time_s = np.arange(late_s, hop.apex_s, 1 / RATE_HZ)
        late_s = time_s.size / RATE_HZ + late_s - hop.apex_s
        acceleration = hop_motion(hop, time_s)[4]
        pieces.append(ROBOT_MASS_KG * np.clip(acceleration + STANDARD_GRAVITY_M_S2, 0, None))
    return hops, np.concatenate([*pieces, unloaded])


def plate_record(seed: int, hops: int) -> PlateRecord:
    """Record `hops` prescribed hops in place."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 2]))
    return record_of(rng, hops_in_place(rng.normal(_APEX_M, _APEX_SD_M, hops + 1))[1])
