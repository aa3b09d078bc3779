"""Draws legs and feet for set 1 of the thesis, which publishes none, and counts those that meet what it says.

python benchmarks/unpublished_gains.py          1024 of them, in half a minute
"""

from __future__ import annotations

import numpy as np
from scipy.stats import qmc

from simulator.thesis.claims import OF_SET_1, chapter_3_claims, judge_claim
from simulator.thesis.figures import Pair, ThesisFigures, jumps_over
from simulator.thesis.readings import SPEEDS_M_S

RANGES = {
    "k_compression": (100.0, 300.0),
    "k_extension": (600.0, 700.0),
    "b_compression": (0.5, 10.0),
    "b_extension": (0.5, 15.0),
    "foot_radius": (0.015, 0.03),
}
ASKED = ("sim1.saving", "sim1.mech_ratio", "sim1.apex")
DRAWS, ACCURACY = 1024, 1e-4


def main() -> None:
    """Print how many meet each claim at every speed, how many all, and the first few of these."""
    scene, drawn = ThesisFigures().set_1, qmc.Sobol(len(RANGES), seed=0).random(DRAWS)
    low, high = np.array(list(RANGES.values())).T
    columns = dict(zip(RANGES, (low + (high - low) * drawn).T[:, :, np.newaxis], strict=True))
    grid = {**columns, "initial_velocity": -SPEEDS_M_S[np.newaxis]}
    jumps = Pair(
        ce=jumps_over(scene, {**grid, "b_ad": 0.0}, ACCURACY),
        ad=jumps_over(scene, {**grid, "b_ad": columns["k_extension"]}, ACCURACY),
    )
    claims = {claim.id: claim for claim in chapter_3_claims()}
    every = np.ones(DRAWS, np.bool_)
    for name in ASKED:
        values = OF_SET_1[name](jumps)
        met = np.array([np.isfinite(row).any() and judge_claim(claims[name], row).agrees for row in values])
        every &= met
        print(f"{name}: {met.sum()} of {DRAWS}")
    print(f"all three: {every.sum()}")
    for number in np.flatnonzero(every)[:5]:
        print(", ".join(f"{name} {column[number, 0]:.4g}" for name, column in columns.items()))


if __name__ == "__main__":
    main()
