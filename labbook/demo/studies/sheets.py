"""The studies that are kept as sheets, as campaigns with a known truth: flasks, walks in the field, oscillations.

Nothing is simulated: what is true is drawn with normal errors, and written as people write it.
"""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from data_schema.units import STANDARD_GRAVITY_M_S2
from labbook.analysis.studies.characterisation import Oscillation

FLASK_RADII_MM, GRAIN_MM = (15.0, 20.0, 30.0, 45.0, 60.0), 3.4
LOOSE, COMPACTED, WALLS = 0.61, 0.63, (-0.25, -0.2)
"""Volume fractions without walls (thesis 5.1.2), and their change with grain size / flask radius (assumed)."""
THIN, WIDE = 1.3, 1.1
"""Specific resistance of two robots (thesis 2.2.3)."""


def flasks(chance: np.random.Generator, of_flask: float = 0.002, of_filling: float = 0.0015) -> str:
    """Draw a sheet of flasks with normal errors of their fractions: one of each flask, and one of each filling."""
    lines = ["radius_mm,state,water_ml"]
    for radius_mm in FLASK_RADII_MM:
        volume_ml, shared = 4.0 / 3.0 * math.pi * radius_mm**3 / 1e3, chance.normal(0.0, of_flask)
        for state, fraction, wall in zip(("loose", "compacted"), (LOOSE, COMPACTED), WALLS, strict=True):
            filled = fraction + wall * GRAIN_MM / radius_mm + shared + chance.normal(0.0, of_filling)
            lines.append(f"{radius_mm:g},{state},{volume_ml * (1.0 - filled):.9g}")
    return "\n".join(lines) + "\n"


def walks(chance: np.random.Generator) -> str:
    """Draw a sheet of four walks of which some are harder for both robots, and what either needs scatters by 3 %."""
    lines = ["walk,robot,mass_kg,distance_m,energy_Wh"]
    for walk in range(4):
        distance_m, hardness = chance.uniform(100.0, 600.0), chance.normal(0.0, 0.3)
        for robot, mass_kg, needed in (("thin", 8.1, THIN), ("wide", 8.3, WIDE)):
            scattered = needed * math.exp(hardness + chance.normal(0.0, 0.03))
            energy_wh = scattered * mass_kg * STANDARD_GRAVITY_M_S2 * distance_m / 3600.0
            lines.append(f"{walk},{robot},{mass_kg},{distance_m:.9g},{energy_wh:.9g}")
    return "\n".join(lines) + "\n"


GAINS, STIFFNESS, DAMPING = ((60.0, 0.0), (200.0, 1.5), (300.0, 3.0)), (2.56, 67.36), (3.32, 2.0)
"""Position and velocity gains, and the lines of physical coefficients over them (5.1.1; a lighter damping at 0)."""
MASSES_KG, RATE_HZ, LONGEST_S, DISPLACED_M = (1.0, 2.0), 300.0, 0.5, 0.03
POSITION_SD_M, VELOCITY_SD_M_S = 1e-4, 5e-3


def oscillations(
    chance: np.random.Generator,
    position_sd_m: float = POSITION_SD_M,
    velocity_sd_m_s: float = VELOCITY_SD_M_S,
    damping: tuple[float, float] = DAMPING,
) -> list[Oscillation]:
    """Draw oscillations of masses on a leg, sampled with normal errors of position and velocity."""
    found = []
    time_s = np.arange(0.0, LONGEST_S, 1.0 / RATE_HZ)
    for gain, damping_gain in GAINS:
        k, d = STIFFNESS[0] * gain + STIFFNESS[1], damping[0] * damping_gain + damping[1]
        for mass_kg in MASSES_KG:
            decay = d / (2.0 * mass_kg)
            turning = np.sqrt(complex(k / mass_kg - decay**2))
            envelope_m = DISPLACED_M * np.exp(-decay * time_s)
            x_m = mass_kg * STANDARD_GRAVITY_M_S2 / k + (envelope_m * np.cos(turning * time_s)).real
            turned = decay * np.cos(turning * time_s) + turning * np.sin(turning * time_s)
            v_m_s = -(envelope_m * turned).real
            x_m = x_m + chance.normal(0.0, position_sd_m, time_s.size)
            v_m_s = v_m_s + chance.normal(0.0, velocity_sd_m_s, time_s.size)
            name = f"{gain:g}_{mass_kg:g}.csv"
            found.append(Oscillation(name, gain, damping_gain, 0.2, mass_kg, time_s, x_m, v_m_s))
    return found


def write_flasks(folder: Path, seed: int) -> str:
    """Write flasks.csv and truth.json; returns the command that reads them."""
    _write(folder / "flasks.csv", flasks(_chance(seed)))
    _write_truth(folder, {"loose": LOOSE, "compacted": COMPACTED, "difference": COMPACTED - LOOSE})
    return shlex.join(["labbook", "study", "compaction", str(folder / "flasks.csv"), "--grain", f"{GRAIN_MM:g}"])


def write_walks(folder: Path, seed: int) -> str:
    """Write walks.csv and truth.json; returns the command that reads them."""
    _write(folder / "walks.csv", walks(_chance(seed)))
    _write_truth(folder, {"thin": THIN, "wide": WIDE, "wide / thin": WIDE / THIN})
    return shlex.join(["labbook", "study", "field", str(folder / "walks.csv")])


def write_oscillations(folder: Path, seed: int) -> str:
    """Write trials.csv, the logs that it names, and truth.json; returns the command that reads them."""
    sheet = ["file,gain,damping_gain,mass_kg,neutral_cm"]
    for one in oscillations(_chance(seed)):
        sheet.append(f"{one.file},{one.gain:g},{one.damping_gain:g},{one.mass_kg:g},20")
        rows = np.column_stack([1e3 * one.time_s, 1e3 * one.displacement_m, one.velocity_m_s])
        log = ["time_ms,position_mm,velocity (m/s)", *(f"{t:.3f},{x:.4f},{v:.5f}" for t, x, v in rows.tolist())]
        _write(folder / one.file, "\n".join(log) + "\n")
    _write(folder / "trials.csv", "\n".join(sheet) + "\n")
    _write_truth(
        folder,
        {
            **{f"stiffness at gain {gain:g} (N/m)": STIFFNESS[0] * gain + STIFFNESS[1] for gain, _ in GAINS},
            **{f"damping at gain {gain:g} (kg/s)": DAMPING[0] * gain + DAMPING[1] for _, gain in GAINS},
        },
    )
    return shlex.join(["labbook", "study", "characterisation", str(folder / "trials.csv")])


def _chance(seed: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence([seed, 6]))


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def _write_truth(folder: Path, truth: Mapping[str, float]) -> None:
    _write(folder / "truth.json", json.dumps(truth, indent=1) + "\n")
