"""The studies that are recorded in sheets, as campaigns with a known truth: flasks, walks in the field, oscillations.

A mass on a spring and a damper moves as the closed form says, which is exact; no scene has flasks or walks, so what is
true of them is drawn with normal errors. All is written as instruments and people write it: water to the graduation,
charges to the charger's last digit, logs with packets that were dropped.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.random import Generator

from data_schema.units import STANDARD_GRAVITY_M_S2
from labbook.demo.files import STUDY_TOML
from labbook.demo.writers import CampaignFiles, Record
from labbook.studies.characterisation import Condition, Trial

_TITLE = """\
# Demonstration: a campaign that is kept as a sheet, drawn with known truth (truth.json). Nothing in it was measured.

"""
FLASK_RADII_MM, GRAIN_MM = (20.0, 25.0, 35.0, 50.0, 70.0), 3.4
LOOSE, COMPACTED, WALLS = 0.61, 0.63, (-0.25, -0.2)
"""Volume fractions without walls (thesis 5.1.2), and their change with grain size / flask radius (assumed)."""
THIN, WIDE = 1.3, 1.1
"""Specific resistance of two robots (thesis 2.2.3)."""
ROBOTS_V = 37.0
"""Of the robots' batteries (assumed)."""


def round_as_read(water_ml: float) -> str:
    """Write a volume as it is read from a measuring cylinder: of 100 ml to 0.1 ml, of larger ones to 1 ml."""
    return f"{water_ml:.1f}" if water_ml < 100.0 else f"{water_ml:.0f}"


def flasks(
    chance: Generator,
    of_flask: float = 0.002,
    of_filling: float = 0.0015,
    read: Callable[[float], str] = round_as_read,
) -> str:
    """Draw a sheet of flasks with normal errors of their fractions: one of each flask, and one of each filling."""
    lines = ["radius_mm,state,water_ml"]
    for radius_mm in FLASK_RADII_MM:
        volume_ml, shared = 4.0 / 3.0 * math.pi * radius_mm**3 / 1e3, chance.normal(0.0, of_flask)
        for state, fraction, wall in zip(("loose", "compacted"), (LOOSE, COMPACTED), WALLS, strict=True):
            filled = fraction + wall * GRAIN_MM / radius_mm + shared + chance.normal(0.0, of_filling)
            lines.append(f"{radius_mm:g},{state},{read(volume_ml * (1.0 - filled))}")
    return "\n".join(lines) + "\n"


def walks(chance: Generator) -> str:
    """Draw a sheet of four walks of which some are harder for both robots, and what either needs scatters by 3 %.

    Charges are what the charger says, in whole mAh; distances are read to 0.1 m.
    """
    lines = ["walk,robot,mass_kg,distance_m,charge_mAh,voltage_V"]
    for walk in range(4):
        distance_m, hardness = chance.uniform(100.0, 600.0), chance.normal(0.0, 0.3)
        for robot, mass_kg, needed in (("thin", 8.1, THIN), ("wide", 8.3, WIDE)):
            scattered = needed * math.exp(hardness + chance.normal(0.0, 0.03))
            energy_j = scattered * mass_kg * STANDARD_GRAVITY_M_S2 * distance_m
            charge_mah = energy_j / ROBOTS_V / 3.6
            lines.append(f"{walk},{robot},{mass_kg},{distance_m:.1f},{charge_mah:.0f},{ROBOTS_V:g}")
    return "\n".join(lines) + "\n"


GAINS = ((60.0, 0.0), (200.0, 1.5), (300.0, 3.0), (400.0, 4.5))
"""Position and velocity gains (assumed)."""
STIFFNESS, DAMPING = (2.56, 67.36), (3.32, 19.67)
"""Lines of physical coefficients over them (thesis 5.1.1)."""
LENGTHS_CM = {15: 1.25, 20: 1.0, 29: 0.98}
"""Neutral lengths (thesis fig. 4.5), and how much stiffer and more damped a leg of each is (assumed)."""
MASSES_KG, DISPLACED_M = (1.0, 1.5, 2.0), (0.03, 0.02)
"""Masses, and how far each is pushed down, one trajectory after the other (assumed; the thesis made ten of each)."""
RATE_HZ, LONGEST_S, DROPPED = 300.0, 0.5, 0.01
POSITION_SD_M, VELOCITY_SD_M_S = 1e-4, 5e-3


def oscillations(
    chance: Generator,
    position_sd_m: float = POSITION_SD_M,
    velocity_sd_m_s: float = VELOCITY_SD_M_S,
    damping: tuple[float, float] = DAMPING,
    lengths_cm: Sequence[int] = (20,),
    displaced_m: Sequence[float] = DISPLACED_M[:1],
    dropped: float = DROPPED,
) -> list[Trial]:
    """Draw oscillations of masses on a leg, sampled with normal errors of position and velocity; packets get lost."""
    found = []
    for length_cm, (gain, damping_gain), mass_kg, (trial, start_m) in itertools.product(
        lengths_cm, GAINS, MASSES_KG, enumerate(displaced_m, 1)
    ):
        k = LENGTHS_CM[length_cm] * (STIFFNESS[0] * gain + STIFFNESS[1])
        d = LENGTHS_CM[length_cm] * (damping[0] * damping_gain + damping[1])
        time_s = np.arange(0.0, LONGEST_S, 1.0 / RATE_HZ)
        time_s = time_s[chance.random(time_s.size) >= dropped]
        decay = d / (2.0 * mass_kg)
        turning = np.sqrt(complex(k / mass_kg - decay**2))
        envelope_m = start_m * np.exp(-decay * time_s)
        cosine, sine = np.cos(turning * time_s), np.sin(turning * time_s) / turning
        x_m = mass_kg * STANDARD_GRAVITY_M_S2 / k + (envelope_m * (cosine + decay * sine)).real
        v_m_s = -(envelope_m * sine).real * k / mass_kg
        x_m = x_m + chance.normal(0.0, position_sd_m, time_s.size)
        v_m_s = v_m_s + chance.normal(0.0, velocity_sd_m_s, time_s.size)
        name = f"{length_cm}cm_{gain:g}_{mass_kg:g}kg_{trial}.csv"
        condition = Condition(length_cm / 100.0, gain, damping_gain)
        found.append(Trial(mass_kg, time_s, x_m, v_m_s, name, condition))
    return found


def _campaign(name: str, kind: str, tables: str, files: Mapping[str, str], truth: Mapping[str, float]) -> CampaignFiles:
    """Return a campaign of files; `tables` are those of labbook.toml that the study needs."""
    text = _TITLE + STUDY_TOML.format(name=name, kind=kind, voltage_v=15.4, jumps=25)
    records = [Record(name, written.encode()) for name, written in files.items()]
    return CampaignFiles(configuration=text + tables, records=records, truth=truth)


def flask_campaign(seed: int) -> CampaignFiles:
    """Draw flasks of grains, poured and compacted."""
    truth = {"loose": LOOSE, "compacted": COMPACTED, "difference": COMPACTED - LOOSE}
    tables = f"[studies.compaction]\ngrain_mm = {GRAIN_MM:g}\n"
    return _campaign("grains in flasks", "bed", tables, {"flasks.csv": flasks(_chance(seed))}, truth)


def walk_campaign(seed: int) -> CampaignFiles:
    """Draw walks of two robots."""
    truth = {"thin": THIN, "wide": WIDE, "wide / thin": WIDE / THIN}
    return _campaign("two robots in the field", "field", "", {"walks.csv": walks(_chance(seed))}, truth)


def oscillation_campaign(seed: int) -> CampaignFiles:
    """Draw trials of a leg's gains at three neutral lengths, and the log of each."""
    sheet, files, truth = ["file,gain,damping_gain,mass_kg,neutral_cm"], {}, {}
    for one in oscillations(_chance(seed), lengths_cm=tuple(LENGTHS_CM), displaced_m=DISPLACED_M):
        of = one.condition
        sheet.append(f"{one.file},{of.gain:g},{of.damping_gain:g},{one.mass_kg:g},{100.0 * (of.neutral_m or 0.0):g}")
        rows = np.column_stack([1e3 * one.time_s, 1e3 * one.displacement_m, one.velocity_m_s])
        log = ["time_ms,position_mm,velocity (m/s)", *(f"{t:.3f},{x:.3f},{v:.4f}" for t, x, v in rows.tolist())]
        files[one.file] = "\n".join(log) + "\n"
    files["trials.csv"] = "\n".join(sheet) + "\n"
    for length_cm, factor in LENGTHS_CM.items():
        for what, unit, line in (("stiffness", "N/m", STIFFNESS), ("damping", "kg/s", DAMPING)):
            truth[f"{what} per gain, {length_cm} cm ({unit})"] = factor * line[0]
            for gain in (0.0, *(pair[what == "damping"] for pair in GAINS)):
                truth[f"{what} at gain {gain:g}, {length_cm} cm ({unit})"] = factor * (line[0] * gain + line[1])
    tables = '[profiles.study_log]\nfiles = "*kg_*.csv"\nformat = "study_log"\n'
    return _campaign("a leg's gains", "emulator", tables, files, truth)


def _chance(seed: int) -> Generator:
    return np.random.default_rng(np.random.SeedSequence([seed, 6]))
