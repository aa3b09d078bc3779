"""What the robot's logger makes of a motion: sensor noise, quantisation, whole milliseconds, dropped packets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError
from labbook.demo.model import FULL, RATE_HZ, SHORT, BodyMotion, body_motion
from labbook.demo.records import DemoRun
from labbook.demo.truth import Truth

FloatArray = NDArray[np.float64]

B_GAIN = 5.0
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

    `time_ms` and the arrays in `channels` (name with unit -> values) have one element a kept sample; `apex_ms`
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
    motion = body_motion(rng, group, run.condition.b_ad_gain, run.apex_heights_m, run.misfired, FULL if full else SHORT)
    # The clock counts from the boot of the controller and shows whole milliseconds: steps of 3, 3, 4.
    boot_ms = int(rng.integers(15_000, 40_000))
    time_ms = boot_ms + np.arange(motion.height_m.size) * 1000 // RATE_HZ
    dropped, touched = _drop_packets(rng, motion)
    kept = np.ones(time_ms.shape, dtype=np.bool_)
    for first, number in dropped:
        kept[first : first + number] = False
    channels = _measure(rng, motion)
    held = {
        "k_gain": float(run.condition.k_gain),
        "b_gain": B_GAIN,
        "b_ad_gain": float(run.condition.b_ad_gain),
    }
    channels |= {name: np.full(time_ms.shape, value) for name, value in held.items()}
    channels["controller_state"] = motion.extending.astype(np.float64)
    return RunLog(
        time_ms[kept],
        {name: values[kept] for name, values in channels.items()},
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
