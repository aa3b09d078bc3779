"""What a force plate records of the robot hopping in place on rigid ground (thesis 3.2.2), 1 kHz."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from data_schema.units import STANDARD_GRAVITY_M_S2
from labbook.demo.hop import Hop, hop_motion

FloatArray = NDArray[np.float64]

RATE_HZ = 1000
ROBOT_MASS_KG = 2.0

_CLOCK_DRIFT = 20e-6
_APEX_M, _APEX_SD_M = 0.345, 0.004
_UNLOADED_S = 1.0
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


def plate_record(seed: int, hops: int) -> PlateRecord:
    """Record `hops` hops in place, the plate unloaded for a second before and after."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 2]))
    return record_of(rng, _ground_reaction_n(rng, hops))


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


def _ground_reaction_n(rng: np.random.Generator, hops: int) -> FloatArray:
    """Vertical force of the robot on the plate: its mass times (acceleration + g), apex after apex."""
    unloaded = np.zeros(int(_UNLOADED_S * RATE_HZ))
    apexes_m = rng.normal(_APEX_M, _APEX_SD_M, hops + 1)
    pieces, late_s = [unloaded], 0.0
    for start_m, apex_m in pairwise(apexes_m):
        hop = Hop(float(start_m), float(apex_m), jamming_time_s=0.0, extension_intrusion_m=0.0)
        time_s = np.arange(late_s, hop.apex_s, 1 / RATE_HZ)
        late_s = time_s.size / RATE_HZ + late_s - hop.apex_s
        acceleration = hop_motion(hop, time_s).body_acceleration_m_s2
        pieces.append(ROBOT_MASS_KG * np.clip(acceleration + STANDARD_GRAVITY_M_S2, 0, None))
    return np.concatenate([*pieces, unloaded])
