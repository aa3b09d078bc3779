"""What moves with a foot in the ground: its own mass, that of the grains it takes along, and that of a platform."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once

Row = NDArray[np.float64]


@made_once
def make_moved_mass(composition: Composition) -> Function:
    """Compose `(work, depth_m)`: the mass that an intruding foot moves, kg."""
    foot = composition.position["foot_mass"]
    has_mass, mass = composition.has("added_mass_kg"), composition.slot("added_mass_kg")
    heavy, platform_kg = composition.has("platform_mass_kg"), composition.slot("platform_mass_kg")

    @inner
    def moved_mass_kg(work: Row, depth_m: float) -> float:
        moved_kg = work[foot]
        if has_mass:
            moved_kg += mass(work, depth_m)
        if heavy:
            moved_kg += platform_kg(work)
        return moved_kg

    return moved_mass_kg
