"""A bed of grains for a foot to jump on: poured, settled, cut level, settled again, and kept in the cache.

Grains begin on a lattice with random sizes and velocities, fall, and come to rest by their friction and damping. Those
above the level are then taken away, so that the surface is flat and known.
"""

from __future__ import annotations

import hashlib
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np

from data_schema.errors import UsageError, unknown_name
from data_schema.file_cache import FileCache
from simulator.grains.contact import Material
from simulator.grains.stepping import KINETIC, NEVER, Grains, Whole, advance, grains_at
from simulator.parameter import GRAVITY_M_S2

GRAVITY = np.array([0.0, 0.0, -GRAVITY_M_S2])
SPREAD = 0.1
"""Diameters are drawn evenly from this share below to this share above the one given: equal spheres form crystals."""
STEP_SHARE = 0.15
"""A time step as a share of the time that a Rayleigh wave takes round the smallest grain."""
MOST_GRAINS = 200_000
_PACKING = 0.62
"""Share of the volume that more grains never fill as they settle with friction: enough are poured."""
_AT_REST = 1e-4
"""Mean kinetic energy of a grain at rest, as a share of its weight times its diameter."""
_STRETCH_S, _MOST_STRETCHES = 0.05, 40
_RANDOM_M_S = 0.1


@dataclass(frozen=True, slots=True)
class BedAsked:
    """A bed that is wanted: its material, mean diameter and density of grains, width and depth, and the draw's seed."""

    material: Material = field(default_factory=Material)
    diameter_m: float = 0.01
    density_kg_m3: float = 1000.0
    width_m: float = 0.2
    depth_m: float = 0.16
    seed: int = 0

    @property
    def step_s(self) -> float:
        """The time step."""
        smallest_m = 0.5 * self.diameter_m * (1.0 - SPREAD)
        return STEP_SHARE * self.material.rayleigh_time_s(smallest_m, self.density_kg_m3)

    @property
    def name(self) -> str:
        """Name of its file in the cache."""
        return hashlib.sha256(repr(self).encode()).hexdigest()


PROPERTIES = {
    "young_modulus": ("young_modulus_pa", "Pa", 1e5, 1e9),
    "poisson_ratio": ("poisson_ratio", "", 0.0, 0.49),
    "restitution": ("restitution", "", 0.05, 0.99),
    "friction": ("friction", "", 0.0, 2.0),
    "rolling_friction": ("rolling_friction", "", 0.0, 1.0),
    "width": ("width_m", "m", 0.01, 2.0),
    "depth": ("depth_m", "m", 0.01, 2.0),
}
"""What may be set of grains and bed: field of `Material` or `BedAsked`, unit, range. None of them has a source."""


def bed_by_words(words: Sequence[str]) -> BedAsked:
    """Return the bed that words such as `friction=0.4` ask for, in SI units.

    Raises `UnknownName` for a name that none of `PROPERTIES` has, `UsageError` for a value outside its range.
    """
    of_material: dict[str, float] = {}
    of_bed: dict[str, float] = {}
    for word in words:
        name, _, text = (part.strip() for part in word.partition("="))
        if name not in PROPERTIES:
            raise unknown_name("property of grains", name, PROPERTIES)
        key, unit, low, high = PROPERTIES[name]
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise UsageError(f"--grain {word}: give {name} as a number from {low:g} to {high:g} {unit}".rstrip() + ".")
        (of_material if key in Material.__annotations__ else of_bed)[key] = value
    bed = BedAsked(material=Material(**of_material))
    return replace(bed, width_m=of_bed.get("width_m", bed.width_m), depth_m=of_bed.get("depth_m", bed.depth_m))


@dataclass(frozen=True, slots=True, eq=False)
class Bed:
    """A settled bed, its surface at `asked.depth_m` above its floor."""

    asked: BedAsked
    grains: Grains

    @property
    def solid_fraction(self) -> float:
        """Share of the volume that the grains fill in the middle half of the depth."""
        asked, z, radius_m = self.asked, self.grains.x[:, 2], self.grains.radius_m
        low, high = 0.25 * asked.depth_m, 0.75 * asked.depth_m

        def below(level_m: float) -> float:
            cap_m = np.clip(level_m - z + radius_m, 0.0, 2.0 * radius_m)
            return float((math.pi * cap_m**2 * (radius_m - cap_m / 3.0)).sum())

        return (below(high) - below(low)) / ((high - low) * asked.width_m**2)


def settled(asked: BedAsked, stop: Whole = NEVER) -> Bed:
    """Return the bed, from the cache where it is there; half a minute to minutes of one core otherwise.

    Raises `UsageError` where grains are too large for the box, or too many, and `CancelledError` as `advance` does.
    """
    if (data := BEDS.read(asked.name)) is not None:
        with np.load(io.BytesIO(data)) as stored:
            return Bed(asked, Grains(**{one.name: stored[one.name] for one in fields(Grains)}))
    grains = _at_rest(asked, _levelled(asked, _at_rest(asked, _poured(asked), stop)), stop)
    stream = io.BytesIO()
    np.savez_compressed(stream, **{one.name: getattr(grains, one.name) for one in fields(Grains)})
    BEDS.write(asked.name, stream.getvalue())
    BEDS.forget_unused()
    return Bed(asked, grains)


BEDS = FileCache(
    "beds",
    ("simulator/grains/bed.py", "simulator/grains/contact.py", "simulator/grains/stepping.py"),
    ("numpy", "numba"),
)


def _poured(asked: BedAsked) -> Grains:
    size_m = asked.diameter_m * (1.0 + SPREAD) * 1.02
    across = int(asked.width_m / size_m)
    volume_m3 = _PACKING * asked.width_m**2 * (asked.depth_m + 1.5 * asked.diameter_m)
    n = math.ceil(volume_m3 / (math.pi / 6.0 * asked.diameter_m**3))
    if across < 4 or asked.depth_m < 4.0 * asked.diameter_m:
        raise UsageError(
            f"grains of {asked.diameter_m:g} m are too large for a box of {asked.width_m:g} m and {asked.depth_m:g} m "
            "depth: give smaller ones, or a box of at least five diameters."
        )
    if n > MOST_GRAINS:
        raise UsageError(
            f"{n} grains of {asked.diameter_m:g} m fill the box, and no more than {MOST_GRAINS} are simulated: give "
            "larger ones or a smaller box."
        )
    random = np.random.default_rng(asked.seed)
    number = np.arange(n)
    place = np.stack([number % across, number // across % across, number // across**2], axis=1) + 0.5
    x = place * np.array([asked.width_m / across, asked.width_m / across, size_m])
    radius_m = 0.5 * asked.diameter_m * random.uniform(1.0 - SPREAD, 1.0 + SPREAD, n)
    return grains_at(x, radius_m, asked.density_kg_m3, GRAVITY, random.uniform(-_RANDOM_M_S, _RANDOM_M_S, (n, 3)))


def _levelled(asked: BedAsked, grains: Grains) -> Grains:
    """Take away what stands above the level, and number the rest along the box, neighbours near each other."""
    under = np.flatnonzero(grains.x[:, 2] + grains.radius_m <= asked.depth_m)
    cell = (grains.x[under] // (2.0 * asked.diameter_m)).astype(int)
    order = under[np.lexsort((cell[:, 2], cell[:, 1], cell[:, 0]))]
    return grains_at(grains.x[order], grains.radius_m[order], asked.density_kg_m3, GRAVITY)


def _at_rest(asked: BedAsked, grains: Grains, stop: Whole) -> Grains:
    steps = round(_STRETCH_S / asked.step_s)
    rest_j = _AT_REST * float((grains.mass_kg * grains.radius_m).sum()) * 2.0 * GRAVITY_M_S2
    for _ in range(_MOST_STRETCHES):
        grains, record = advance(
            grains, asked.material, asked.width_m, asked.step_s, steps, gravity=GRAVITY, every=steps, stop=stop
        )
        if record[-1, KINETIC] < rest_j:
            break
    return grains
