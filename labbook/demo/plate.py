"""What a force plate records of a force on it, 1 kHz (thesis 3.2.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

RATE_HZ = 1000

_CLOCK_DRIFT = 20e-6
_FORCE_NOISE_N = 2.5
_FORCE_OFFSET_N = (-6.0, 0.4, 0.0)
_MOMENT_NOISE_NM = 0.25
_CENTRE_M = (0.012, -0.020)
_COP_LIMIT_M = 1.28


@dataclass(frozen=True, slots=True, eq=False)
class PlateRecord:
    """Force-plate samples: `time_ms` (n,), force and moment (n, 3), centre of pressure (n, 2); z down."""

    time_ms: FloatArray
    force_n: FloatArray
    moment_nm: FloatArray
    cop_m: FloatArray


def record_of(rng: np.random.Generator, fz_n: FloatArray, noise: float = 1.0) -> PlateRecord:
    """Record a vertical force, shape (n,), by a plate whose errors are multiplied by `noise`."""
    n = fz_n.size
    foot_m = np.array(_CENTRE_M) + np.cumsum(rng.normal(0, 2e-5, (n, 2)), axis=0)
    force_n = noise * rng.normal(0, _FORCE_NOISE_N, (n, 3)) + _FORCE_OFFSET_N
    force_n[:, 2] += fz_n
    moment_nm = noise * rng.normal(0, _MOMENT_NOISE_NM, (n, 3))
    moment_nm[:, 0] += fz_n * foot_m[:, 1]
    moment_nm[:, 1] -= fz_n * foot_m[:, 0]
    # As the program does: a quotient at every sample, meaningless where nothing stands on the plate.
    pressing_n = np.where(np.abs(force_n[:, 2]) < 1e-3, 1e-3, force_n[:, 2])
    cop_m = np.column_stack([-moment_nm[:, 1], moment_nm[:, 0]]) / pressing_n[:, None]
    time_ms = np.arange(n) * (1 + _CLOCK_DRIFT) * 1000 / RATE_HZ
    return PlateRecord(time_ms, force_n, moment_nm, np.clip(cop_m, -_COP_LIMIT_M, _COP_LIMIT_M))
