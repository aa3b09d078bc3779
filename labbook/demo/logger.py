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
from numpy.random import Generator
from numpy.typing import NDArray

from data_schema.errors import UsageError
from data_schema.units import STANDARD_GRAVITY_M_S2
from labbook.demo.campaign import DemoRun
from labbook.demo.truth import REST_LENGTH_M, FloatArray, Group, Hop, Truth

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
    track = _drawn_motion(rng, truth.group(run.condition.foot, run.condition.k_gain), run, FULL if full else SHORT)
    height_m, leg_m, leg_rate_m_s, extending = np.concatenate(track.stretches, axis=1)
    # The clock counts from the boot of the controller and shows whole milliseconds: steps of 3, 3, 4.
    boot_ms, n = int(rng.integers(15_000, 40_000)), height_m.size
    time_ms = boot_ms + np.arange(n) * 1000 // RATE_HZ
    dropped, touched = _drop_packets(rng, np.array(track.jumps_s).reshape(-1, 2), n)
    recorded = np.ones(n, dtype=np.bool_)
    for first, number in dropped:
        recorded[first : first + number] = False
    pack_v = 15.45 - _PACK_DROOP_V_S * (np.arange(n) / RATE_HZ) - _PACK_SAG_V * extending
    channels = {
        "body_height [m]": _quantise(height_m + rng.normal(0, _HEIGHT_NOISE_M, n), _HEIGHT_STEP_M),
        "leg_length [m]": leg_m + rng.normal(0, _LEG_NOISE_M, n),
        "leg_velocity [m/s]": leg_rate_m_s + rng.normal(0, _LEG_RATE_NOISE_M_S, n),
        "battery_voltage [V]": _quantise(pack_v + rng.normal(0, _PACK_NOISE_V, n), _PACK_STEP_V),
        "k_gain": np.full(n, float(run.condition.k_gain)),
        "b_gain": np.full(n, _B_GAIN),
        "b_ad_gain": np.full(n, float(run.condition.b_ad_gain)),
        "controller_state": extending,
    }
    return RunLog(
        time_ms[recorded],
        {name: values[recorded] for name, values in channels.items()},
        boot_ms + 1000 * np.array(track.apexes_s),
        run.reached_apexes_m,
        dropped,
        touched,
    )


def _quantise(values: FloatArray, step: float) -> FloatArray:
    """Round to whole converter steps."""
    return np.asarray(np.rint(values / step) * step)


def _drop_packets(rng: Generator, jumps_s: FloatArray, samples: int) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Draw the lost stretches of samples: (first, number) rows, and which jumps they touch.

    `jumps_s` has the drop and the catch of each jump, shape (jumps, 2).
    """
    pauses_s = np.column_stack([jumps_s[:, 1], np.append(jumps_s[1:, 0], samples / RATE_HZ)])
    windows_s = np.concatenate([jumps_s, pauses_s])
    n = len(windows_s)
    hit = rng.random(n) < _DROP_CHANCE
    at_s = windows_s[:, 0] + rng.random(n) * (windows_s[:, 1] - windows_s[:, 0])
    numbers = rng.integers(2, _LONGEST_DROP + 1, n)
    first = np.floor(at_s * RATE_HZ).astype(np.int64)
    dropped = np.stack([first[hit], numbers[hit]], axis=1)[np.argsort(first[hit])]
    begins, ends = dropped[:, 0], dropped.sum(axis=1)
    touched = [np.any((begins <= stop * RATE_HZ) & (ends >= start * RATE_HZ)) for start, stop in jumps_s]
    return dropped, np.array(touched, np.bool_)


def _wobble_m(rng: Generator, time_s: FloatArray, duration_s: float) -> FloatArray:
    """Draw how far an unsteady hand is off: two sines that are zero, and at rest, at both ends of its motion."""
    amplitude_m, frequency_hz, phase_rad = rng.uniform(0.0015, 0.004), rng.uniform(2.5, 5.0), rng.uniform(0, 2 * np.pi)
    share = np.clip(time_s / duration_s, 0, 1)
    # Squared at the end, so that the robot is still when it is let go.
    envelope = 6.75 * share * (1 - share) ** 2 * amplitude_m
    angle = 2 * np.pi * frequency_hz * time_s + phase_rad
    return np.asarray(envelope * np.minimum(share * 8, 1) * (np.sin(angle) + 0.4 * np.sin(2.3 * angle)))


def _carry_m(time_s: FloatArray, duration_s: float, start_m: float, end_m: float) -> FloatArray:
    """Move between two heights with the least jerk, as a hand does (Flash and Hogan 1985)."""
    share = np.clip(time_s / duration_s, 0, 1)
    return start_m + (end_m - start_m) * share**3 * (10 - 15 * share + 6 * share**2)


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


@dataclass(slots=True)
class _Track:
    """Motion being put together, one stretch after another, on the even grid of the logger.

    A stretch is of shape (4, n): body height and leg length in m, the leg's velocity in m/s, and 1 where it extends.
    `apexes_s` are the times of the apexes reached, `jumps_s` those of each drop and catch.
    """

    clamp_m: float = _CLAMP_HEIGHT_M
    time_s: float = 0.0
    samples: int = 0
    stretches: list[FloatArray] = field(default_factory=list)
    apexes_s: list[float] = field(default_factory=list)
    jumps_s: list[tuple[float, float]] = field(default_factory=list)

    def since(self, duration_s: float) -> FloatArray:
        """Return the seconds since a stretch began, at the grid points inside it; moves the clock to its end."""
        end_s = self.time_s + duration_s
        stop = math.ceil(end_s * RATE_HZ)
        since_s = np.arange(self.samples, stop) / RATE_HZ - self.time_s
        self.time_s, self.samples = end_s, stop
        return since_s

    def hang(self, height_m: FloatArray) -> None:
        """Append a stretch in which the leg hangs at its rest length."""
        still = np.zeros(height_m.shape)
        self.stretches.append(np.stack([height_m, still + REST_LENGTH_M, still, still]))

    def rest(self, duration_s: float) -> None:
        """Rest on the clamp."""
        self.hang(np.full(self.since(duration_s).shape, self.clamp_m))


def _drawn_motion(rng: Generator, group: Group, run: DemoRun, pace: Pace) -> _Track:
    """Draw the motion of a run of a group from the true apexes of its jumps."""
    track, b_ad_gain = _Track(), 0 if run.condition is None else run.condition.b_ad_gain
    track.rest(pace.lead_in_s)
    for apex_m, misfire in zip(run.apex_heights_m, run.misfired, strict=True):
        start_m = _START_MARK_M - abs(rng.normal(0.001, 0.0015))
        _lower(rng, track, start_m)
        dropped_s = track.time_s
        hop = group.hop(rng, b_ad_gain, start_m, float(apex_m))
        low_m, leg_m = _misfire(rng, track, hop) if misfire else (_fly_and_catch(rng, track, hop), REST_LENGTH_M)
        track.jumps_s.append((dropped_s, track.time_s))
        _lift(rng, track, low_m, leg_m, pace.reset_s)
    if pace.total_s is not None and track.time_s < pace.total_s:
        track.rest(pace.total_s - track.time_s)
    return track


def _lower(rng: Generator, track: _Track, start_m: float) -> None:
    """From the clamp to the start mark, holding still for a moment before letting go."""
    lowering_s = rng.uniform(0.35, 0.6)
    duration_s = lowering_s + rng.uniform(0.15, 0.35)
    since_s = track.since(duration_s)
    track.hang(_carry_m(since_s, lowering_s, track.clamp_m, start_m) + _wobble_m(rng, since_s, duration_s))


def _fly_and_catch(rng: Generator, track: _Track, hop: Hop) -> float:
    """Drop, stance, flight and catch; returns the height at which the hand has stopped the body."""
    track.apexes_s.append(track.time_s + hop.apex_s)
    falling_s = rng.uniform(*_CATCH_SHARES) * (hop.landing_s - hop.apex_s)
    track.stretches.append(hop.motion(track.since(hop.apex_s + falling_s)))
    caught_m = hop.apex_height_m - STANDARD_GRAVITY_M_S2 * falling_s**2 / 2
    speed_m_s = STANDARD_GRAVITY_M_S2 * falling_s
    distance_m = _STOPPING_SHARE * (caught_m - REST_LENGTH_M)
    # The speed dies quadratically, and the body comes to rest so much lower.
    catching_s = 3 * distance_m / speed_m_s
    left = np.clip(1 - track.since(catching_s) / catching_s, 0, 1)
    track.hang(caught_m - distance_m * (1 - left**3))
    return caught_m - distance_m


def _misfire(rng: Generator, track: _Track, hop: Hop) -> tuple[float, float]:
    """A jump whose leg only pushes the foot down: the body settles on the bent leg until it is picked up.

    Returns the heights of the body and the length of the leg at the end.
    """
    track.stretches.append(hop.motion(track.since(hop.switch_s)))
    since_s = track.since(rng.uniform(0.5, 0.9))
    damped_rad_s = _MISFIRE_RAD_S * math.sqrt(1 - _MISFIRE_DAMPING**2)
    decay_1_s = _MISFIRE_DAMPING * _MISFIRE_RAD_S
    swing = np.exp(-decay_1_s * since_s) * (
        np.cos(damped_rad_s * since_s) + decay_1_s / damped_rad_s * np.sin(damped_rad_s * since_s)
    )
    settled_m = _MISFIRE_LEG_M - (REST_LENGTH_M - hop.lift_off_height_m)
    height_m = settled_m - (settled_m - hop.switch_height_m) * swing
    leg_m = _MISFIRE_LEG_M - (_MISFIRE_LEG_M - hop.switch_leg_m) * swing
    track.stretches.append(np.stack([height_m, leg_m, np.gradient(leg_m, 1 / RATE_HZ), np.ones(leg_m.size)]))
    return float(height_m[-1]), float(leg_m[-1])


def _lift(rng: Generator, track: _Track, low_m: float, leg_m: float, reset_s: float) -> None:
    """Back above the clamp, down onto it, and rest while the ground is stirred and smoothed."""
    track.clamp_m = _CLAMP_HEIGHT_M + rng.normal(0, _CLAMP_PLAY_M)
    over_m = track.clamp_m + rng.uniform(0.006, 0.018)
    # so long that the hand's acceleration nowhere exceeds what is drawn, see `_carry_m`
    lifting_s = math.sqrt(10 / math.sqrt(3) * (over_m - low_m) / rng.uniform(*_LIFTING_M_S2))
    settling_s = rng.uniform(0.2, 0.4)
    resting_s = reset_s * rng.uniform(0.93, 1.07) - lifting_s - settling_s
    since_s = track.since(lifting_s)
    bent_m = (REST_LENGTH_M - leg_m) * np.exp(-_LEG_RELEASE_1_S * since_s)
    height_m = _carry_m(since_s, lifting_s, low_m, over_m)
    track.stretches.append(
        np.stack([height_m, REST_LENGTH_M - bent_m, _LEG_RELEASE_1_S * bent_m, np.zeros(since_s.size)])
    )
    track.hang(_carry_m(track.since(settling_s), settling_s, over_m, track.clamp_m))
    track.rest(resting_s)
