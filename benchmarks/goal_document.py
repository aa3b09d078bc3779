"""Measures whether `accuracy` is kept over random scenes and what error bars find, and writes these tables of
`docs/accuracy.md` anew.

python benchmarks/goal_document.py                     all tables
python benchmarks/goal_document.py "error bars"        those of one section
"""

from __future__ import annotations

import datetime
import itertools
import sys
import textwrap
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.document import replace_between, table_text
from benchmarks.section import Table
from data_schema.errors import UsageError
from simulator.changes import changed_by_words
from simulator.declared import GROUNDS
from simulator.effects.registry import EFFECTS
from simulator.error_bars import finer_accuracies
from simulator.jump import (
    FINEST_ACCURACY,
    ILL_CONDITIONED_BELOW,
    MOST_STEPS_A_JUMP,
    cost_span,
    derived,
    limits_for,
    parameter_row,
    rounding_share,
)
from simulator.kernel.build import Kernel, kernel_for
from simulator.kernel.layout import OUTCOMES, STEP_LIMIT
from simulator.kernel.limits import MOST_STEPS
from simulator.kernel.rows import COLUMN, COLUMNS, COST_PARTS
from simulator.parameter import Parameter
from simulator.scene_file import load_scene

DOCUMENT = Path(__file__).resolve().parent.parent / "docs" / "accuracy.md"
GOALS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10)
FINEST = 1e-12
FEW_STEPS = 200_000
"""Work enough for the reference of any jump that a robot makes."""
WIDE, SMALLEST_SHARE = 50.0, 1e-4
"""A wider range is drawn evenly in the logarithm, from this share of its end where it starts at 0."""
SEED = 7
SCENES = 5000
RANGES = {
    "k_compression": (100.0, 400.0),
    "k_extension": (300.0, 2000.0),
    "b_compression": (2.0, 40.0),
    "b_extension": (0.2, 40.0),
    "b_ad": (0.0, 600.0),
    "foot_radius": (0.012, 0.06),
    "kg_scale": (0.2, 20.0),
    "bg_scale": (0.2, 5.0),
    "body_mass": (0.5, 3.0),
    "foot_mass": (0.03, 0.5),
}
"""What is drawn, evenly between two values, in every scene."""
STARTS = {
    "sim2": {"initial_velocity": (-2.0, -0.2)},
    "bed": {"initial_velocity": (-0.5, 0.0), "initial_height": (0.02, 0.2)},
    "sim1": {"initial_velocity": (-2.0, -0.2)},
}
OUTPUTS = ("max_depth_m", "liftoff_time_s", "apex_height_m")
TOUCHDOWN = OUTCOMES.index("touchdown")

Row = NDArray[np.float64]
Flags = NDArray[np.bool_]


def drawn(name: str) -> tuple[Kernel, Row]:
    """The kernel of a scene, and the parameters of random scenes round it, shape (scenes, parameters)."""
    scene = load_scene(name)
    kernel = kernel_for(scene.effects)
    names = [parameter.name for parameter in kernel.composition.parameters]
    table = np.repeat(parameter_row(kernel, scene)[np.newaxis], SCENES, axis=0)
    random = np.random.default_rng(SEED)
    for parameter, (low, high) in (STARTS[name] | RANGES).items():
        table[:, names.index(parameter)] = random.uniform(low, high, SCENES)
    return kernel, table


def kept(kernel: Kernel, table: Row) -> tuple[int, list[tuple[str, ...]]]:
    """How many of the scenes jump at the finest accuracy, and for each goal a row of `KEPT`."""
    finest = _simulated(kernel, table, FINEST)
    jumps, found = finest[:, 0] == TOUCHDOWN, list[tuple[str, ...]]()
    for goal in GOALS:
        rows = _simulated(kernel, table, goal)
        judged = jumps & ~_flags(kernel, rows, goal)
        ended = rows[judged, 0] == TOUCHDOWN
        both = rows[judged][ended], finest[judged][ended]
        errors = np.max(np.abs(_outputs(both[0]) / _outputs(both[1]) - 1.0), axis=0) / goal
        share, flagged, otherwise = _part(errors <= 1.0, judged), np.sum(jumps & ~judged), np.sum(~ended)
        cells = (share, f"{np.median(errors):.2g}", f"{np.max(errors):.3g}", f"{flagged}", f"{otherwise}")
        found.append((f"{goal:g}", *cells))
    return int(np.sum(jumps)), found


def _flags(kernel: Kernel, rows: Row, goal: float) -> Flags:
    """Which jumps are flagged without error bars."""
    columns = {name: rows[:, place] for name, place in COLUMN.items()}
    return np.asarray(derived(columns, kernel.composition.effects, 0.0, goal)["ill_conditioned"])


def _part(some: Flags, every: Flags) -> str:
    return f"{100 * int(np.sum(some)) / max(int(np.sum(every)), 1):.2f} %"


KEPT = ("goal", "kept", "median error over goal", "largest", "jumps flagged", "end otherwise")
"""Of the jumps that are not flagged: which part keeps the goal, and errors over the goal."""


def _simulated(kernel: Kernel, table: Row, accuracy: float, most_steps: float = MOST_STEPS_A_JUMP) -> Row:
    rows, none, limits = np.zeros((len(table), 1, len(COLUMNS))), np.zeros((0, 4)), limits_for(accuracy)
    limits[MOST_STEPS] = most_steps
    kernel.batch(table, limits, rows, np.zeros(len(table), np.int64), none, none)
    return np.asarray(rows[:, 0])


def _outputs(rows: Row, span: str = "stance") -> Row:
    cost = sum(rows[:, COLUMN[f"{span}_{part}_J"]] for part in COST_PARTS)
    return np.stack([*(rows[:, COLUMN[name]] for name in OUTPUTS), cost])


BARRED = (
    "goal",
    "misses above ten goals caught",
    "flagged",
    "false alarms",
    "others keep the goal",
    "reference uncertain",
)
"""What error bars find: misses, flags, and flags of jumps that keep the goal; jumps whose reference itself is not known
to the goal (at 1e-12 it is farther off than that) are counted apart.
"""


def legal(name: str) -> tuple[Kernel, Row]:
    """The kernel of a scene, and random scenes of its whole legal box: wide ranges evenly in the logarithm."""
    scene, random = load_scene(name), np.random.default_rng(SEED)
    kernel = kernel_for(scene.effects)
    rows: list[Row] = []
    while len(rows) < SCENES:
        values = {parameter.name: _within(parameter, random) for parameter in kernel.composition.parameters}
        try:
            rows.append(parameter_row(kernel, scene.changed(values)))
        except UsageError:  # values that do not fit together
            continue
    return kernel, np.array(rows)


def soft() -> tuple[Kernel, Row]:
    """The realistic box of `sim2`, with the gains of flight those of compression."""
    names = [parameter.name for parameter in kernel_for(load_scene("sim2").effects).composition.parameters]
    kernel, table = kernel_for(load_scene("sim2").effects - {"held_gains_in_flight"}), drawn("sim2")[1]
    return kernel, table[:, [names.index(parameter.name) for parameter in kernel.composition.parameters]]


def has_error_bars(kernel: Kernel, table: Row) -> list[tuple[str, ...]]:
    """What error bars find of random scenes: for each goal a row of `BARRED`."""
    finest = _simulated(kernel, table, FINEST_ACCURACY, FEW_STEPS)
    known = finest[:, 0] != STEP_LIMIT
    table, finest, found = table[known], finest[known], list[tuple[str, ...]]()
    simulated = {FINEST: _simulated(kernel, table, FINEST)}
    doubt = _apart(simulated[FINEST], finest)
    for goal in GOALS:
        first, *others = finer_accuracies(goal)
        for accuracy in {goal, first} - simulated.keys():
            simulated[accuracy] = _simulated(kernel, table, accuracy)
        coarse, fine = simulated[goal], simulated[first].copy()
        for finer in others:
            close = fine[:, COLUMN["decision_margin"]] < ILL_CONDITIONED_BELOW
            fine[close] = _simulated(kernel, table[close], finer)
        rounding = rounding_share(fine[:, COLUMN["error_growth"]])
        certain = doubt <= goal
        flags = certain & (np.maximum(_apart(coarse, fine), rounding) > goal)
        off, keeps = _apart(coarse, finest), _apart(fine, finest) <= goal
        missed, others_kept = certain & (off > 10.0 * goal), certain & ~flags
        cells = (
            f"{np.sum(missed & flags)} of {np.sum(missed)}",
            _part(flags, certain),
            _part(flags & (off <= goal), certain),
            _part(others_kept & keeps, others_kept),
            f"{np.sum(~certain)} of {len(certain)}",
        )
        found.append((f"{goal:g}", *cells))
    return found


CHOICES = (
    ("", "active_damping", "active_damping", "scaled_active_damping"),
    ("", "constant_force_cap", "torque_cap", "voltage_cap"),
    ("", "held_gains_in_flight", "massless_leg_in_flight"),
)
"""Effects of which one at most is on, "" for none; of all others but those of hard ground each is on or off."""
SETS, SCENES_OF_A_SET = 18, 600
GOALS_OF_SETS = (1e-4, 1e-6, 1e-8)
CASES = {
    "held force that lets errors grow": (
        "+held_force",
        "k_compression=228.82629 k_extension=1933.44639 b_compression=15.2393 "
        "b_extension=12.91257 foot_radius=0.02047 kg_scale=1.02813 bg_scale=1.15292 body_mass=2.37046 "
        "foot_mass=0.10245 initial_velocity=-0.71576 b_ad=541.4215",
    ),
    "controller without a clock that chatters": (
        "-sampled_control",
        "k_compression=121.227631 k_extension=1850.346804 "
        "b_compression=3.015164 b_extension=3.19522 body_mass=1.99361 foot_mass=0.222445 foot_radius=0.013872 "
        "kg_scale=0.958647 bg_scale=1.325107 initial_velocity=-0.49661 b_ad=224.844888",
    ),
}
"""Scenes of `sim2` whose numbers were wrong by far and not flagged."""


def random_sets() -> Iterator[tuple[Kernel, Row]]:
    """Kernels of random sets of effects on grains, each with random scenes of the realistic box."""
    random, sim2 = np.random.default_rng(SEED), load_scene("sim2")
    chosen = {*GROUNDS, "platform_mass", "touchdown_impact", *itertools.chain(*CHOICES)}
    free, found = [name for name in EFFECTS if name not in chosen], 0
    while found < SETS:
        on = {"hydrostatic_stiffness", *(name for name in free if random.random() < 0.5)}
        on |= {str(random.choice(names)) for names in CHOICES} - {""}
        try:
            scene = sim2.changed(effects_on=on, effects_off=sim2.effects - on)
        except UsageError:  # effects that do not fit together
            continue
        kernel = kernel_for(scene.effects)
        names = [parameter.name for parameter in kernel.composition.parameters]
        table = np.repeat(parameter_row(kernel, scene)[np.newaxis], SCENES_OF_A_SET, axis=0)
        for parameter, (low, high) in (STARTS["sim2"] | RANGES | {"ad_share": (0.0, 1.0)}).items():
            if parameter in names:
                table[:, names.index(parameter)] = random.uniform(low, high, SCENES_OF_A_SET)
        found += 1
        yield kernel, table


WITHOUT_BARS = ("goal", "jumps", "flagged", "others", "keep ten goals", "keep the goal", "largest error over goal")
"""Of jumps whose reference is known to the goal."""


def without_bars() -> Iterator[str]:
    """What flags without error bars find over random sets of effects, and of two scenes, as Markdown."""
    counts = {goal: list[tuple[Flags, Row]]() for goal in GOALS_OF_SETS}
    for number, (kernel, table) in enumerate(random_sets(), 1):
        print(f"== effects, set {number} of {SETS}: {', '.join(kernel.composition.effects)}", flush=True)
        finest = _simulated(kernel, table, FINEST_ACCURACY, FEW_STEPS)
        jumps = finest[:, 0] == TOUCHDOWN
        table, finest = table[jumps], finest[jumps]
        span = cost_span(kernel.composition.effects)
        doubt = _apart(_simulated(kernel, table, FINEST), finest, span)
        for goal, found in counts.items():
            rows, known = _simulated(kernel, table, goal), doubt <= goal
            off = _apart(rows, finest, span)[known] / goal
            found.append((_flags(kernel, rows, goal)[known], off))
            if (missed := ~found[-1][0] & (off > 10.0)).any():
                print(f"   {goal:g}: {np.sum(missed)} of {len(off)} unflagged, {np.max(off[missed]):.3g} goals off")
    yield textwrap.fill(
        f"Measured on {datetime.datetime.now(datetime.UTC).date()}: {SETS} random sets of effects on grains, each with "
        f"{SCENES_OF_A_SET} random scenes of the box above. Reference: the same jump at {FINEST_ACCURACY:g}; those "
        f"that at {FINEST:g} differ from it by more than the goal are left out.",
        120,
        break_on_hyphens=False,
    )
    lines = list[tuple[str, ...]]()
    for goal, found in counts.items():
        flags, off = (np.concatenate(part) for part in zip(*found, strict=True))
        rest = off[~flags]
        every = np.ones(len(rest), np.bool_)
        kept = _part(rest <= 10.0, every), _part(rest <= 1.0, every)
        lines.append((f"{goal:g}", f"{len(off)}", f"{np.sum(flags)}", f"{len(rest)}", *kept, f"{np.max(rest):.3g}"))
    yield f"\n{table_text(Table(WITHOUT_BARS, tuple(lines), ''))}"
    for name, (effects, words) in CASES.items():
        scene = changed_by_words(load_scene("sim2"), words.split(), effects)
        kernel = kernel_for(scene.effects)
        flagged = [
            f"{goal:g}"
            for goal in GOALS
            if _flags(kernel, _simulated(kernel, parameter_row(kernel, scene)[np.newaxis], goal), goal)[0]
        ]
        yield f"\nA {name} is flagged at {', '.join(flagged) or 'no goal'}."


def _within(parameter: Parameter, random: np.random.Generator) -> float:
    low, high = parameter.low, parameter.high
    if low > 0.0 and high / low > WIDE:
        return float(np.exp(random.uniform(np.log(low), np.log(high))))
    if low == 0.0 and high > WIDE:
        return float(np.exp(random.uniform(np.log(SMALLEST_SHARE * high), np.log(high))))
    return float(random.uniform(low, high))


def _apart(one: Row, other: Row, span: str = "stance") -> Row:
    """The largest relative difference of each jump's outputs; infinite where they end otherwise."""
    values, beside = _outputs(one, span), _outputs(other, span)
    with np.errstate(invalid="ignore", divide="ignore"):
        apart = np.abs(values / beside - 1.0)
    apart[np.isnan(values) & np.isnan(beside) | (values == beside)] = 0.0
    apart[np.isnan(apart)] = np.inf
    return np.where(one[:, 0] == other[:, 0], np.max(apart, axis=0), np.inf)


BOXES: Mapping[str, Callable[[], tuple[Kernel, Row]]] = {
    "sim2, legal box": lambda: legal("sim2"),
    "bed, legal box": lambda: legal("bed"),
    "soft, realistic": soft,
    "sim1, legal box": lambda: legal("sim1"),
}


def bars() -> Iterator[str]:
    """What error bars find, a table a box, as Markdown."""
    yield textwrap.fill(
        f"Measured on {datetime.datetime.now(datetime.UTC).date()} with {SCENES} random jumps each: over the whole "
        f"legal box of `sim2`, `bed` and `sim1`, and over the box above with soft gains in flight. Reference: the same "
        f"jump at {FINEST_ACCURACY:g}; jumps of which that takes more than {FEW_STEPS} steps are left out, and "
        f"so are those that at {FINEST:g} differ from it by more than the goal, whose reference is uncertain.",
        120,
        break_on_hyphens=False,
    )
    for name, draw in BOXES.items():
        print(f"== error bars, {name}", flush=True)
        yield f"\n**{name}**\n"
        yield table_text(Table(BARRED, tuple(has_error_bars(*draw())), ""))


def lines() -> Iterator[str]:
    """What was drawn, a table a scene, as Markdown."""
    ranges = ", ".join(f"`{name}` {low:g} to {high:g}" for name, (low, high) in RANGES.items())
    yield textwrap.fill(
        f"Measured on {datetime.datetime.now(datetime.UTC).date()}: {SCENES} random scenes round each of "
        f"{', '.join(f'`{name}`' for name in STARTS)}, drawn evenly: {ranges}; touchdown at 0.2 to 2 m/s, `bed` from "
        f"20 to 200 mm at up to 0.5 m/s. Reference: the same scene at {FINEST:g}.",
        120,
        break_on_hyphens=False,
    )
    for name in STARTS:
        print(f"== {name}", flush=True)
        jumps, found = kept(*drawn(name))
        yield f"\n**{name}**: {jumps} of {SCENES} jump; in the others the leg folds, or nothing lifts off.\n"
        yield table_text(Table(KEPT, tuple(found), ""))


def main() -> None:
    """Put the tables, or with an argument those of that section, between their two lines of the document."""
    for name, made in SECTIONS.items():
        if sys.argv[1:] and name not in sys.argv[1:]:
            continue
        replace_between(DOCUMENT, f"<!-- measured: {name} -->", f"<!-- end of {name} -->", made())


SECTIONS = {"is the goal kept": lines, "random effects": without_bars, "error bars": bars}
"""Sections of the document by the names between whose lines they stand."""


if __name__ == "__main__":
    main()
