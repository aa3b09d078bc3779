"""A robot that stands, hops in place with flights of different heights, and stands again; its truth is known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

REST_LENGTH_M = 0.26
STANDING_M = 0.235
RATE_HZ = 500
_GRAVITY_M_S2 = 9.80665
_STANCE_S = 0.22

Floats = NDArray[np.float64]


def standing_log(seed: int, jumps: int, zero_m: float = 0.0, noise_m: float = 0.0004) -> tuple[Floats, Floats, Floats]:
    """Return times in s and heights in m, which lie `zero_m` too high, shape (n,), and the true apexes, (jumps,)."""
    rng = np.random.default_rng(seed)
    stance_phase = np.arange(0, _STANCE_S, 1 / RATE_HZ) / _STANCE_S
    standing = np.full(RATE_HZ, STANDING_M)
    pieces, apexes = [standing], []
    for _ in range(jumps):
        rise_m, depth_m = rng.uniform(0.04, 0.09), rng.uniform(0.045, 0.105)
        speed_m_s = np.sqrt(2 * _GRAVITY_M_S2 * rise_m)
        fly_s = np.arange(0, 2 * speed_m_s / _GRAVITY_M_S2, 1 / RATE_HZ)
        pieces.append(REST_LENGTH_M - depth_m * np.sin(np.pi * stance_phase))
        pieces.append(REST_LENGTH_M + speed_m_s * fly_s - _GRAVITY_M_S2 * fly_s**2 / 2)
        apexes.append(REST_LENGTH_M + rise_m)
    landing = REST_LENGTH_M - 0.06 * np.sin(np.pi * stance_phase[: stance_phase.size // 2])
    pieces += [landing, np.linspace(landing[-1], STANDING_M, RATE_HZ // 5), standing]
    height_m = np.concatenate(pieces)
    time_s = np.arange(height_m.size) / RATE_HZ
    return time_s, height_m + zero_m + rng.normal(0, noise_m, height_m.size), np.array(apexes)


def as_csv(head: str, time_s: Floats, values: Floats, places: int) -> str:
    """Write a log of milliseconds and one column."""
    rows = zip((1000 * time_s).tolist(), values.tolist(), strict=True)
    return f"{head}\n" + "".join(f"{ms:.0f},{value:.{places}f}\n" for ms, value in rows)
