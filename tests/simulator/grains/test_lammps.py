"""The same foot in the same bed through LAMMPS, where it is installed: an independent program with the same law."""

from __future__ import annotations

import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from simulator.compiled import Row
from simulator.grains.bed import GRAVITY, BedAsked, settled
from simulator.grains.contact import (
    FRICTION,
    ROLLING_DAMPING,
    ROLLING_FRICTION,
    ROLLING_STIFFNESS,
    SHEAR,
    SHEAR_DAMPING,
    STIFFNESS,
)
from simulator.grains.stepping import KINETIC, FootPath, Grains, advance, grains_at
from simulator.parameter import GRAVITY_M_S2

ASKED = BedAsked(diameter_m=0.01, width_m=0.12, depth_m=0.08)
FOOT_RADIUS_M, SWING_M, PERIOD_S = 0.02, 0.012, 0.08
EVERY = 50

INPUT = """
units si
atom_style sphere
boundary p p f
newton off
comm_modify vel yes
read_data bed.data
neighbor 0.002 bin
neigh_modify delay 0
timestep {step}
pair_style granular
pair_coeff * * {law}
fix move all nve/sphere
fix weight all gravity {gravity} vector 0 0 -1
fix floor all wall/gran granular {law} zplane 0.0 NULL
variable dive equal -{swing}*(1-cos(2*PI*step*dt/{period}))
region foot cylinder z {middle} {middle} {radius} {surface} 1.0 side out move NULL NULL v_dive
fix foot all wall/gran/region granular {law} region foot
compute turning all erotate/sphere
thermo {every}
thermo_style custom step ke c_turning
thermo_modify norm no format float %.12g
run {steps}
"""


def bed_data(grains: Grains) -> str:
    """The bed as LAMMPS reads it."""
    density = float(grains.mass_kg[0] / (4.0 / 3.0 * math.pi * grains.radius_m[0] ** 3))
    atoms = "\n".join(
        f"{number} 1 {2.0 * radius_m:.17g} {density:.17g} {x:.17g} {y:.17g} {z:.17g}"
        for number, (radius_m, (x, y, z)) in enumerate(zip(grains.radius_m, grains.x, strict=True), 1)
    )
    width = f"0 {ASKED.width_m}"
    box = f"{width} xlo xhi\n{width} ylo yhi\n0 1.5 zlo zhi"
    return f"bed\n\n{len(grains.x)} atoms\n1 atom types\n\n{box}\n\nAtoms\n\n{atoms}\n"


def by_lammps(program: str, folder: Path, grains: Grains, surface_m: float, steps: int) -> Row:
    """The grains' kinetic energy every so many steps, from the first on."""
    law = ASKED.material.law(float(grains.radius_m.mean()), float(grains.mass_kg.mean()))
    words = (
        f"hertz {law[STIFFNESS]:.17g} {ASKED.material.restitution} "
        f"tangential mindlin {law[SHEAR]:.17g} {law[SHEAR_DAMPING]:.17g} {law[FRICTION]} "
        f"rolling sds {law[ROLLING_STIFFNESS]:.17g} {law[ROLLING_DAMPING]:.17g} {law[ROLLING_FRICTION]} "
        "damping coeff_restitution"
    )
    text = INPUT.format(
        step=ASKED.step_s,
        law=words,
        gravity=GRAVITY_M_S2,
        swing=SWING_M,
        period=PERIOD_S,
        middle=0.5 * ASKED.width_m,
        radius=FOOT_RADIUS_M,
        surface=surface_m,
        every=EVERY,
        steps=steps,
    )
    (folder / "bed.data").write_text(bed_data(grains), encoding="utf-8")
    (folder / "foot.in").write_text(text, encoding="utf-8")
    done = subprocess.run([program, "-in", "foot.in"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    rows = done.stdout.split("c_turning", 1)[1].split("\n", 1)[1].split("Loop time")[0]
    energies = np.array([line.split() for line in rows.strip().splitlines()], dtype=np.float64)
    return np.asarray(energies[1:, 1] + energies[1:, 2])


@pytest.mark.soak
def test_the_same_foot_through_lammps(tmp_path: Path) -> None:
    program = shutil.which("lmp")
    if program is None or subprocess.run([program, "-h"], capture_output=True, check=False).returncode != 0:
        pytest.skip("no LAMMPS that runs (`lmp`) is on the path")
    bed = settled(ASKED).grains
    grains = grains_at(bed.x, bed.radius_m, ASKED.density_kg_m3, GRAVITY)  # LAMMPS knows none of its springs
    surface_m = float((bed.x[:, 2] + bed.radius_m).max())
    steps = round(PERIOD_S / ASKED.step_s)
    turned = 2.0 * math.pi * ASKED.step_s / PERIOD_S * np.arange(steps + 1)
    foot = FootPath(
        FOOT_RADIUS_M,
        surface_m - SWING_M * (1.0 - np.cos(turned)),
        -SWING_M * 2.0 * math.pi / PERIOD_S * np.sin(turned),
    )
    _, record = advance(
        grains, ASKED.material, ASKED.width_m, ASKED.step_s, steps, gravity=GRAVITY, foot=foot, every=EVERY
    )
    ours_j = record[:, KINETIC]
    theirs_j = by_lammps(program, tmp_path, grains, surface_m, steps)[: len(ours_j)]
    apart = np.abs(ours_j - theirs_j) / theirs_j.max()
    assert len(theirs_j) > 20
    # Where friction slips, LAMMPS stretches its spring by what the dashpot has too much, and motions part.
    assert apart.max() < 0.06
    assert ours_j.mean() == pytest.approx(theirs_j.mean(), rel=0.05)
