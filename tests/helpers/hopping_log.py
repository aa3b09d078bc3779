"""A robot that hops in place and stays on the ground in the end, as a CSV log; nothing follows its last landing."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

REST_LENGTH_M = 0.27
RATE_HZ = 300
RISE_M = 0.10
STANCE_S = 0.2
_GRAVITY_M_S2 = 9.80665
_SPEED_M_S = math.sqrt(2 * _GRAVITY_M_S2 * RISE_M)
FLIGHT_S = 2 * _SPEED_M_S / _GRAVITY_M_S2
LEAD_IN_S = 1.0


def landing_s(number: int) -> float:
    """When stance `number` (from 1) begins."""
    return LEAD_IN_S + FLIGHT_S / 2 + (number - 1) * (STANCE_S + FLIGHT_S)


def apex_s(number: int) -> float:
    """When the jump out of stance `number` is highest."""
    return landing_s(number) + STANCE_S + FLIGHT_S / 2


def hopping_log(
    jumps: int,
    *,
    rise_m: float = RISE_M,
    lost_s: Iterable[tuple[float, float]] = (),
    held_s: Iterable[tuple[float, float]] = (),
    shallow: Iterable[int] = (),
) -> bytes:
    """Write so many jumps and the last landing; rows in `lost_s` (from, to) are missing, in `held_s` they repeat.

    Stances in `shallow` are too flat for a detector: the jump after such a one is not found. Each jump rises `rise_m`
    above the rest length; times are those of `landing_s` where that is `RISE_M`.
    """
    speed_m_s = math.sqrt(2 * _GRAVITY_M_S2 * rise_m)
    flight_s = 2 * speed_m_s / _GRAVITY_M_S2
    end_s = LEAD_IN_S + flight_s / 2 + jumps * (STANCE_S + flight_s) + 1.0
    time_s = np.arange(round(end_s * RATE_HZ)) / RATE_HZ
    since = time_s - LEAD_IN_S - flight_s / 2
    number, phase = np.divmod(since, STANCE_S + flight_s)
    depth_m = speed_m_s * STANCE_S / math.pi
    fly_s = phase - STANCE_S
    height = np.where(
        phase < STANCE_S,
        REST_LENGTH_M - depth_m * np.sin(math.pi * np.minimum(phase, STANCE_S) / STANCE_S),
        REST_LENGTH_M + speed_m_s * fly_s - _GRAVITY_M_S2 * fly_s**2 / 2,
    )
    flat = np.isin(number + 1, [*shallow]) & (phase < STANCE_S)
    height[flat] = REST_LENGTH_M - 0.2 * (REST_LENGTH_M - height[flat])
    height[time_s < LEAD_IN_S] = REST_LENGTH_M + rise_m
    stays = (number >= jumps) & (phase > STANCE_S / 2) | (number > jumps)
    height[stays] = REST_LENGTH_M - depth_m
    rng = np.random.default_rng(7)
    columns = np.column_stack(
        [time_s * 1000, height + rng.normal(0, 0.0005, height.size), rng.normal(15.4, 0.01, height.size)]
    )
    for begin, end in held_s:
        rows = np.flatnonzero((time_s > begin) & (time_s < end))
        columns[rows, 1:] = columns[rows[0], 1:]
    keep = np.ones(time_s.size, dtype=np.bool_)
    for begin, end in lost_s:
        keep &= (time_s < begin) | (time_s > end)
    lines = [f"{ms:.3f},{m:.6f},{volt:.5f}\n" for ms, m, volt in columns[keep].tolist()]
    return ("time [ms],body_height [m],battery_voltage [V]\n" + "".join(lines)).encode()
