"""The log of one run: what the string potentiometer and the robot would have recorded (thesis 5.1.3, 5.1.5).

Per jump: rest on the clamp, lowering by hand to just past the 0.42 m mark, drop, stance, flight, a catch after
the apex and before the second touchdown, lifting back to the clamp. The hop itself is that of the group. Motions of
the hand are closed forms on arrays of seconds since each began; each starts and ends at rest, save the catch, which
begins at the speed of the fall. The logger adds sensor noise, quantisation, whole milliseconds, dropped packets.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError
from data_schema.units import STANDARD_GRAVITY_M_S2
from labbook.demo.campaign import DemoRun
from labbook.demo.truth import REST_LENGTH_M, Group, Hop, Truth

FloatArray = NDArray[np.float64]

_B_GAIN = 5.0
"""Damping gain of the leg, the same in all runs (assumed)."""
DECIMALS = {"k_gain": 4, "b_gain": 4, "b_ad_gain": 4, "controller_state": 4}
"""Decimals of the channels that are not written with six."""

_HEIGHT_NOISE_M = 0.001
_HEIGHT_STEP_M = 0.8 / 2**12
"""A 12-bit converter over a 0.8 m string."""
_LEG_NOISE_M = 0.00005
_LEG_RATE_NOISE_M_S = 0.01
_PACK_NOISE_V = 0.012
_PACK_STEP_V = 0.005
_PACK_SAG_V = 0.45
_PACK_DROOP_V_S = 1.2e-4
_DROP_CHANCE = 0.12
"""Chance of a dropped packet within a jump, and again in the pause after it."""
_LONGEST_DROP = 12


@dataclass(frozen=True, slots=True, eq=False)
class RunLog:
    """One run's log as recorded, and what is true of it.

    `time_ms` and the arrays in `channels` (name with unit -> values) have one element a recorded sample; `apex_ms`
    and `apex_height_m` one a jump that left the ground, on the log's clock; `dropped` one row (first missing,
    number missing; sample numbers before dropping) a dropped packet; `touched` says for each jump made whether
    a packet was dropped between its drop and its catch.
    """

    time_ms: NDArray[np.int64]
    channels: Mapping[str, FloatArray]
    apex_ms: FloatArray
    apex_height_m: FloatArray
    dropped: NDArray[np.int64]
    touched: NDArray[np.bool_]


def run_log(seed: int, truth: Truth, run: DemoRun, *, full: bool = False) -> RunLog:
    """Record a run with jumps; `full` for the whole 12 minutes. The same arguments give the same log."""
    if run.condition is None:
        raise UsageError(f"run {run.name} made no jumps: ask for the log of a run with a condition.")
    rng = np.random.default_rng(np.random.SeedSequence([seed, 1, int(run.name.lstrip("r"))]))
    group = truth.group(run.condition.foot, run.condition.k_gain)
    motion = _body_motion(
        rng, group, run.condition.b_ad_gain, run.apex_heights_m, run.misfired, FULL if full else SHORT
    )
    # The clock counts from the boot of the controller and shows whole milliseconds: steps of 3, 3, 4.
    boot_ms = int(rng.integers(15_000, 40_000))
    time_ms = boot_ms + np.arange(motion.height_m.size) * 1000 // RATE_HZ
    dropped, touched = _drop_packets(rng, motion)
    recorded = np.ones(time_ms.shape, dtype=np.bool_)
    for first, number in dropped:
        recorded[first : first + number] = False
    channels = _measure(rng, motion)
    held = {
        "k_gain": float(run.condition.k_gain),
        "b_gain": _B_GAIN,
        "b_ad_gain": float(run.condition.b_ad_gain),
    }
    channels |= {name: np.full(time_ms.shape, value) for name, value in held.items()}
    channels["controller_state"] = motion.extending.astype(np.float64)
    return RunLog(
        time_ms[recorded],
        {name: values[recorded] for name, values in channels.items()},
        boot_ms + 1000 * motion.apex_s,
        run.reached_apexes_m,
        dropped,
        touched,
    )


def _measure(rng: np.random.Generator, motion: BodyMotion) -> dict[str, FloatArray]:
    """Sensor noise and quantisation."""
    n = motion.height_m.size
    time_s = np.arange(n) / RATE_HZ
    pack_v = 15.45 - _PACK_DROOP_V_S * time_s - _PACK_SAG_V * motion.extending
    return {
        "body_height [m]": _quantise(motion.height_m + rng.normal(0, _HEIGHT_NOISE_M, n), _HEIGHT_STEP_M),
        "leg_length [m]": motion.leg_length_m + rng.normal(0, _LEG_NOISE_M, n),
        "leg_velocity [m/s]": motion.leg_velocity_m_s + rng.normal(0, _LEG_RATE_NOISE_M_S, n),
        "battery_voltage [V]": _quantise(pack_v + rng.normal(0, _PACK_NOISE_V, n), _PACK_STEP_V),
    }


def _quantise(values: FloatArray, step: float) -> FloatArray:
    """Round to whole converter steps."""
    return np.asarray(np.rint(values / step) * step)


def _drop_packets(rng: np.random.Generator, motion: BodyMotion) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Draw the lost stretches of samples: (first, number) rows, and which jumps they touch."""
    jumps = np.column_stack([motion.jump_start_s, motion.jump_end_s])
    n = jumps.shape[0]
    next_s = np.append(motion.jump_start_s[1:], motion.height_m.size / RATE_HZ)
    windows = np.concatenate([jumps, np.column_stack([motion.jump_end_s, next_s])])
    hit = rng.random(2 * n) < _DROP_CHANCE
    at_s = windows[:, 0] + rng.random(2 * n) * (windows[:, 1] - windows[:, 0])
    numbers = rng.integers(2, _LONGEST_DROP + 1, 2 * n)
    first = np.floor(at_s * RATE_HZ).astype(np.int64)
    order = np.argsort(first[hit])
    dropped = np.column_stack([first[hit], numbers[hit]])[order]
    ends = dropped.sum(axis=1)
    touched = np.array(
        [bool(np.any((dropped[:, 0] <= stop * RATE_HZ) & (ends >= start * RATE_HZ))) for start, stop in jumps],
        dtype=np.bool_,
    )
    return dropped, touched


def samples_not_dropped(
    rng: np.random.Generator, n: int, dropped: int, longest: int, first: int = 0
) -> NDArray[np.bool_]:
    """Draw which samples of a log arrive where so many packets are dropped, none before the sample `first`."""
    recorded = np.ones(n, dtype=np.bool_)
    for _ in range(dropped):
        start = int(rng.integers(first, n))
        recorded[start : start + int(rng.integers(2, longest + 1))] = False
    return recorded


@dataclass(frozen=True, slots=True)
class _Wobble:
    """An unsteady hand: two sines that die away towards the end of a motion."""

    amplitude_m: float
    frequency_hz: float
    phase_rad: float

    def height_m(self, time_s: FloatArray, duration_s: float) -> FloatArray:
        """Deviation from the intended height; zero, and at rest, at both ends."""
        share = np.clip(time_s / duration_s, 0, 1)
        # Squared at the end, so that the robot is still when it is let go.
        envelope = 6.75 * share * (1 - share) ** 2 * self.amplitude_m
        angle = 2 * np.pi * self.frequency_hz * time_s + self.phase_rad
        return envelope * np.minimum(share * 8, 1) * (np.sin(angle) + 0.4 * np.sin(2.3 * angle))


def _carry_m(time_s: FloatArray, duration_s: float, start_m: float, end_m: float) -> FloatArray:
    """Move between two heights with the least jerk, as a hand does (Flash and Hogan 1985)."""
    share = np.clip(time_s / duration_s, 0, 1)
    return start_m + (end_m - start_m) * share**3 * (10 - 15 * share + 6 * share**2)


def _carry_duration_s(distance_m: float, acceleration_m_s2: float) -> float:
    """Time of a move over `distance_m` whose acceleration nowhere exceeds `acceleration_m_s2`, see `_carry_m`."""
    return math.sqrt(10 / math.sqrt(3) * distance_m / acceleration_m_s2)


def _catch_duration_s(speed_m_s: float, distance_m: float) -> float:
    """Time in which a fall at `speed_m_s` is stopped within `distance_m`, see `_catch_m`."""
    return 3 * distance_m / speed_m_s


def _catch_m(time_s: FloatArray, start_m: float, speed_m_s: float, distance_m: float) -> FloatArray:
    """Stop a fall: the speed dies quadratically and the body comes to rest `distance_m` lower."""
    left = np.clip(1 - time_s / _catch_duration_s(speed_m_s, distance_m), 0, 1)
    return start_m - distance_m * (1 - left**3)


RATE_HZ = 300
_CLAMP_HEIGHT_M = 0.46
_START_MARK_M = 0.42

_MISFIRE_LEG_M = 0.215
_MISFIRE_RAD_S = 22.0
_MISFIRE_DAMPING = 0.7
_LEG_RELEASE_1_S = 40.0
_CATCH_SHARES = (0.6, 0.8)
"""When a hand catches: parts of the time from the apex to the second touchdown."""
_STOPPING_SHARE = 0.5
"""Part of the height left above the second touchdown that a catch uses up."""
_CLAMP_PLAY_M = 0.0007
_LIFTING_M_S2 = (2.5, 4.5)
"""Greatest acceleration of a hand that lifts 2 kg without haste."""


@dataclass(frozen=True, slots=True)
class Pace:
    """How long the pauses are: before the first jump, between a catch and the next lowering, at the end."""

    lead_in_s: float
    reset_s: float
    total_s: float | None


SHORT = Pace(lead_in_s=1.0, reset_s=2.0, total_s=None)
"""The pauses of resetting the ground cut to 2 s: a run of 25 jumps takes about 80 s."""
FULL = Pace(lead_in_s=12.0, reset_s=26.0, total_s=720.0)
"""The whole 12 minutes."""


@dataclass(frozen=True, slots=True, eq=False)
class BodyMotion:
    """True motion on the even grid of the logger, and the truth about its jumps.

    Arrays of motion have one element a sample; `apex_s` one a jump that left the ground; `jump_start_s` and
    `jump_end_s` (drop to catch) one a jump made.
    """

    height_m: FloatArray
    leg_length_m: FloatArray
    leg_velocity_m_s: FloatArray
    extending: NDArray[np.bool_]
    apex_s: FloatArray
    jump_start_s: FloatArray
    jump_end_s: FloatArray


@dataclass(slots=True)
class _Track:
    """Motion being put together, one stretch after another, on the common grid of samples."""

    clamp_m: float = _CLAMP_HEIGHT_M
    time_s: float = 0.0
    samples: int = 0
    heights: list[FloatArray] = field(default_factory=list)
    legs: list[FloatArray] = field(default_factory=list)
    leg_rates: list[FloatArray] = field(default_factory=list)
    extending: list[NDArray[np.bool_]] = field(default_factory=list)

    def stretch(self, duration_s: float) -> FloatArray:
        """Seconds since the stretch began, at the grid points inside it; moves the clock to its end."""
        end_s = self.time_s + duration_s
        stop = math.ceil(end_s * RATE_HZ)
        since_s = np.arange(self.samples, stop) / RATE_HZ - self.time_s
        self.time_s, self.samples = end_s, stop
        return since_s

    def add(
        self,
        height_m: FloatArray,
        leg_m: FloatArray | None = None,
        leg_rate: FloatArray | None = None,
        extending: NDArray[np.bool_] | None = None,
    ) -> None:
        """Append a stretch; a leg that is not given hangs at its rest length."""
        self.heights.append(height_m)
        self.legs.append(np.full(height_m.shape, REST_LENGTH_M) if leg_m is None else leg_m)
        self.leg_rates.append(np.zeros(height_m.shape) if leg_rate is None else leg_rate)
        self.extending.append(np.zeros(height_m.shape, np.bool_) if extending is None else extending)

    def rest(self, duration_s: float) -> None:
        """Rest on the clamp."""
        self.add(np.full(self.stretch(duration_s).shape, self.clamp_m))


def _body_motion(
    rng: np.random.Generator,
    group: Group,
    b_ad_gain: int,
    apex_heights_m: FloatArray,
    misfired: NDArray[np.bool_],
    pace: Pace,
) -> BodyMotion:
    """Draw the motion of a run of a group, with an active-damping gain, from the true apexes of its jumps
    (`apex_heights_m` and `misfired`, one a jump).
    """
    track = _Track()
    apexes, starts, ends = [], [], []
    track.rest(pace.lead_in_s)
    for apex_m, misfire in zip(apex_heights_m, misfired, strict=True):
        start_m = _START_MARK_M - abs(rng.normal(0.001, 0.0015))
        _lower(rng, track, start_m)
        starts.append(track.time_s)
        hop = group.hop(rng, b_ad_gain, start_m, float(apex_m))
        leg_m = REST_LENGTH_M
        if misfire:
            low_m, leg_m = _misfire(rng, track, hop)
        else:
            apexes.append(track.time_s + hop.apex_s)
            low_m = _fly_and_catch(rng, track, hop)
        ends.append(track.time_s)
        _lift(rng, track, low_m, leg_m, pace.reset_s)
    if pace.total_s is not None and track.time_s < pace.total_s:
        track.rest(pace.total_s - track.time_s)
    return BodyMotion(
        np.concatenate(track.heights),
        np.concatenate(track.legs),
        np.concatenate(track.leg_rates),
        np.concatenate(track.extending),
        np.array(apexes),
        np.array(starts),
        np.array(ends),
    )


def _lower(rng: np.random.Generator, track: _Track, start_m: float) -> None:
    """From the clamp to the start mark, holding still for a moment before letting go."""
    lowering_s, holding_s = rng.uniform(0.35, 0.6), rng.uniform(0.15, 0.35)
    wobble = _Wobble(rng.uniform(0.0015, 0.004), rng.uniform(2.5, 5.0), rng.uniform(0, 2 * np.pi))
    since_s = track.stretch(lowering_s + holding_s)
    track.add(_carry_m(since_s, lowering_s, track.clamp_m, start_m) + wobble.height_m(since_s, lowering_s + holding_s))


def _fly_and_catch(rng: np.random.Generator, track: _Track, hop: Hop) -> float:
    """Drop, stance, flight and catch; returns the height at which the hand has stopped the body."""
    falling_s = rng.uniform(*_CATCH_SHARES) * (hop.landing_s - hop.apex_s)
    motion = hop.motion(track.stretch(hop.apex_s + falling_s))
    track.add(motion.body_height_m, motion.leg_length_m, motion.leg_velocity_m_s, motion.extending)
    caught_m = hop.apex_height_m - STANDARD_GRAVITY_M_S2 * falling_s**2 / 2
    speed_m_s = STANDARD_GRAVITY_M_S2 * falling_s
    distance_m = _STOPPING_SHARE * (caught_m - hop.rest_length_m)
    since_s = track.stretch(_catch_duration_s(speed_m_s, distance_m))
    track.add(_catch_m(since_s, caught_m, speed_m_s, distance_m))
    return caught_m - distance_m


def _misfire(rng: np.random.Generator, track: _Track, hop: Hop) -> tuple[float, float]:
    """A jump whose leg only pushes the foot down: the body settles on the bent leg until it is picked up.

    Returns the heights of the body and the length of the leg at the end.
    """
    motion = hop.motion(track.stretch(hop.switch_s))
    track.add(motion.body_height_m, motion.leg_length_m, motion.leg_velocity_m_s, motion.extending)
    since_s = track.stretch(rng.uniform(0.5, 0.9))
    damped_rad_s = _MISFIRE_RAD_S * math.sqrt(1 - _MISFIRE_DAMPING**2)
    decay_1_s = _MISFIRE_DAMPING * _MISFIRE_RAD_S
    swing = np.exp(-decay_1_s * since_s) * (
        np.cos(damped_rad_s * since_s) + decay_1_s / damped_rad_s * np.sin(damped_rad_s * since_s)
    )
    depth_m = hop.rest_length_m - hop.lift_off_height_m
    settled_m = _MISFIRE_LEG_M - depth_m
    height_m = settled_m - (settled_m - hop.switch_height_m) * swing
    leg_m = _MISFIRE_LEG_M - (_MISFIRE_LEG_M - hop.switch_leg_m) * swing
    track.add(height_m, leg_m, np.gradient(leg_m, 1 / RATE_HZ), np.ones(since_s.shape, np.bool_))
    return float(height_m[-1]), float(leg_m[-1])


def _lift(rng: np.random.Generator, track: _Track, low_m: float, leg_m: float, reset_s: float) -> None:
    """Back above the clamp, down onto it, and rest while the ground is stirred and smoothed."""
    track.clamp_m = _CLAMP_HEIGHT_M + rng.normal(0, _CLAMP_PLAY_M)
    over_m = track.clamp_m + rng.uniform(0.006, 0.018)
    lifting_s = _carry_duration_s(over_m - low_m, rng.uniform(*_LIFTING_M_S2))
    settling_s = rng.uniform(0.2, 0.4)
    resting_s = reset_s * rng.uniform(0.93, 1.07) - lifting_s - settling_s
    since_s = track.stretch(lifting_s)
    bent_m = (REST_LENGTH_M - leg_m) * np.exp(-_LEG_RELEASE_1_S * since_s)
    track.add(_carry_m(since_s, lifting_s, low_m, over_m), REST_LENGTH_M - bent_m, _LEG_RELEASE_1_S * bent_m)
    track.add(_carry_m(track.stretch(settling_s), settling_s, over_m, track.clamp_m))
    track.rest(resting_s)
