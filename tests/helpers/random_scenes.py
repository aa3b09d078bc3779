"""Scenes drawn at random over the whole legal box, what they make, and what is wrong with it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import LabbookError
from simulator.declared import parameters_read
from simulator.effects.registry import BOOKED, EFFECTS
from simulator.jump import ILL_CONDITIONED_BELOW, ROUNDING, parameter_row
from simulator.kernel.build import kernel_for
from simulator.kernel.layout import OUTCOMES
from simulator.kernel.rows import COLUMN, COLUMNS
from simulator.parameter import Parameter
from simulator.scene import Scene
from simulator.scene_file import load_scene, shipped_scenes
from tests.helpers.kernels import batch_rows

Row = NDArray[np.float64]
Flags = NDArray[np.bool_]

JUMPS = 3
FEW_STEPS = 200_000
"""Work enough for any one jump; the shipped scenes take 50 to 11 000 steps."""
DECADES = 50.0
"""A parameter whose box spans more than this factor is drawn uniformly in its logarithm."""
SMALLEST_SHARE = 1e-4
"""Of a box that starts at 0, the smallest part of its end that is drawn beside 0 itself."""
AT_AN_END = 0.05

NEEDED_BY_GROUND = {
    "hydrostatic_stiffness": ("hydrostatic_stiffness",),
    "rigid_ground": ("rigid_ground", "touchdown_impact"),
    "emulated_ground": ("emulated_ground", "touchdown_impact", "latched_switching"),
}
ON_GROUND = {"hydrostatic_stiffness": "sim2", "rigid_ground": "force_plate", "emulated_ground": "emulator"}
"""The shipped scene that a drawn effect set takes its values from, by its ground."""
GROUNDS_IN_TURN = ("hydrostatic_stiffness", "hydrostatic_stiffness", "rigid_ground", "emulated_ground")
PASSES = 2
"""Over the effects wished for: what one needs may come later in the order."""

BOOK = ("leg_work_J", *(energy.column for energy in BOOKED))
AT_LIFT_OFF = tuple(name for name in COLUMNS if name.startswith("liftoff_"))
AT_TOUCHDOWN = tuple(name for name in COLUMNS if name.startswith("next_touchdown_"))
AT_APEX = ("apex_height_m", "apex_foot_height_m", "apex_time_s")
ALWAYS = tuple(
    name for name in COLUMNS if name not in (*AT_LIFT_OFF, *AT_TOUCHDOWN, *AT_APEX, "outcome", "decision_margin")
)
"""Columns with a number whatever the outcome; the margin is infinite where nothing was decided, but not NaN."""


@dataclass(frozen=True, slots=True)
class Made:
    """Legal scenes of one effect set and what they make, shape (scenes, jumps, columns); NaN where no jump was made."""

    base: Scene
    scenes: tuple[Scene, ...] = field(repr=False)
    refusals: tuple[str, ...] = field(repr=False)
    table: Row = field(repr=False)
    rows: Row = field(repr=False)

    def column(self, name: str) -> Row:
        """A column, shape (scenes, jumps)."""
        found: Row = self.rows[:, :, COLUMN[name]]
        return found

    @property
    def made(self) -> Flags:
        """Which jumps were made, shape (scenes, jumps)."""
        return np.isfinite(self.column("outcome"))

    def ended(self, outcome: str) -> Flags:
        """Which jumps ended so, shape (scenes, jumps)."""
        return np.asarray(self.column("outcome") == OUTCOMES.index(outcome))

    def told(self, wrong: Flags, most: int = 3) -> str:
        """How many scenes are wrong, and what the simplest of them change in the base; nothing where none is."""
        if not wrong.any():
            return ""
        changes = sorted((changed(self.base, self.scenes[place]) for place in np.flatnonzero(wrong)), key=len)
        return f"{wrong.sum()} of {len(wrong)} scenes, such as {changes[:most]}"


def changed(base: Scene, scene: Scene) -> dict[str, float]:
    """Values in which a scene differs from its base."""
    return {name: scene[name] for name in scene.read if scene[name] != base[name]}


def draw(parameter: Parameter, random: np.random.Generator) -> float:
    """Draw a value from a parameter's whole box, now and then exactly at one of its ends."""
    low, high = parameter.low, parameter.high
    if random.random() < AT_AN_END:
        return float(random.choice((low, high)))
    if low > 0.0 and high > DECADES * low:
        value = math.exp(random.uniform(math.log(low), math.log(high)))
    elif low == 0.0 and high >= DECADES:
        value = high * SMALLEST_SHARE ** random.random()
    else:
        value = random.uniform(low, high)
    return float(min(max(value, low), high))


def drawn(base: Scene, count: int, random: np.random.Generator) -> tuple[tuple[Scene, ...], tuple[str, ...]]:
    """Draw legal scenes beside a base, and the sentences that refused others.

    In each scene a share of the parameters, itself drawn, leaves the base's value: with all of them drawn hardly a
    robot would jump; so there are near scenes and far ones.
    """
    parameters = parameters_read(base.effects).values()
    scenes: list[Scene] = []
    refusals: list[str] = []
    while len(scenes) < count:
        share = random.random()
        values = {parameter.name: draw(parameter, random) for parameter in parameters if random.random() < share}
        try:
            scenes.append(base.changed(values))
        except LabbookError as refusal:
            refusals.append(str(refusal))
    return tuple(scenes), tuple(refusals)


def drawn_effects(count: int, random: np.random.Generator) -> list[frozenset[str]]:
    """Draw effect sets from all that may be on together: each effect with an even chance, in a random order."""
    found: dict[frozenset[str], None] = {}
    grounds = itertools.cycle(GROUNDS_IN_TURN)
    while len(found) < count:
        on = set(NEEDED_BY_GROUND[next(grounds)])
        wished = [str(name) for name in random.permutation(sorted(EFFECTS)) if random.random() < 0.5]
        for name in wished * PASSES:
            met = all(set(needed) & on for needed in EFFECTS[name].needs)
            if met and not any(name in EFFECTS[other].excludes or other in EFFECTS[name].excludes for other in on):
                on.add(name)
        found.setdefault(frozenset(on))
    return list(found)


def bases(drawn_sets: int, seed: int) -> Iterator[Scene]:
    """The shipped scenes, then as many drawn effect sets, each with the values of the shipped scene on its ground."""
    for name in shipped_scenes():
        shipped = load_scene(name)
        yield shipped.changed(jumps=min(shipped.jumps, JUMPS))
    for effects in drawn_effects(drawn_sets, np.random.default_rng(seed)):
        shipped = load_scene(next(name for ground, name in ON_GROUND.items() if ground in effects))
        yield shipped.changed({}, effects, set(EFFECTS) - effects, jumps=min(shipped.jumps, JUMPS))


def run(base: Scene, table: Row, accuracy: float, most_steps: int = FEW_STEPS) -> Row:
    """Simulate a table of scenes with the base's effects in one call."""
    return batch_rows(kernel_for(base.effects).batch, table, accuracy, base.jumps, most_steps)[0]


def make(base: Scene, count: int, seed: int, accuracy: float) -> Made:
    """Draw scenes and simulate them."""
    scenes, refusals = drawn(base, count, np.random.default_rng(seed))
    kernel = kernel_for(base.effects)
    table = np.array([parameter_row(kernel, scene) for scene in scenes])
    return Made(base, scenes, refusals, table, run(base, table, accuracy))


def endless(made: Made) -> Flags:
    """Scenes that were given up for the work they took, shape (scenes,)."""
    return np.asarray(made.ended("step_limit").any(axis=1))


def energy_at_play_j(made: Made) -> Row:
    """What a jump's energy book turns over, J, shape (scenes, jumps).

    It is the energy of body and foot at the start, from where a leg folded to nothing would lie, and the size of every
    sum of the book: what the tolerances of a step are relative to, but for a part that none of the outputs sees.
    """
    kernel = kernel_for(made.base.effects)
    value = {parameter.name: made.table[:, place] for place, parameter in enumerate(kernel.composition.parameters)}
    kg = value["body_mass"] + value["foot_mass"]
    height_m = value["initial_height"] + value["rest_length"]
    start_j = kg * (0.5 * value["initial_velocity"] ** 2 + 9.81 * height_m)
    sums = np.abs(np.stack([made.column(name) for name in BOOK]))
    return np.asarray(start_j[:, np.newaxis] + sums.sum(axis=0))


def open_book(made: Made, accuracy: float) -> Flags:
    """Scenes of which a jump's energy book does not close within the accuracy, shape (scenes,)."""
    share = np.abs(made.column("energy_residual_J")) / made.column("energy_at_play_J")
    return np.asarray((made.made & ~(share <= accuracy)).any(axis=1))


def lacking(made: Made) -> Mapping[str, Flags]:
    """Scenes that lack a number which their outcome has, or have one that is not finite, by column."""
    finite = {name: np.isfinite(made.column(name)) for name in COLUMNS}
    left, landed = finite["liftoff_time_s"], made.ended("touchdown")
    rose = landed & (made.column("liftoff_body_velocity_m_s") > 0.0)
    wrong = {name: ~finite[name] for name in ALWAYS}
    wrong |= {name: (finite[name] != left) | (landed & ~finite[name]) for name in AT_LIFT_OFF}
    wrong |= {name: finite[name] != landed for name in AT_TOUCHDOWN}
    wrong |= {name: rose & ~finite[name] for name in AT_APEX}
    came_down = made.column("steps") > 0.0  # a jump that ended in the air has no step of its own
    wrong["touchdown_time_s"] = came_down & ~finite["touchdown_time_s"]
    wrong["decision_margin"] = np.isnan(made.column("decision_margin"))
    return {name: np.asarray((made.made & flags).any(axis=1)) for name, flags in wrong.items()}


def well_posed(made: Made, accuracy: float) -> Flags:
    """Scenes all of whose jumps came down again and are not flagged at this accuracy, shape (scenes,)."""
    flagged = made.column("decision_margin") < ILL_CONDITIONED_BELOW
    flagged |= made.column("error_growth") * ROUNDING > 0.5 * accuracy
    return np.asarray((made.ended("touchdown") & ~flagged).all(axis=1))
