"""Measures whether `accuracy` is kept over random scenes, and writes that table of `docs/accuracy.md` anew.

python benchmarks/goal_document.py
"""

from __future__ import annotations

import datetime
import sys
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.document import table_text
from benchmarks.section import Table
from simulator.jump import ill_conditioned, limits_for, parameter_row
from simulator.kernel.build import Kernel, kernel_for
from simulator.kernel.layout import OUTCOMES
from simulator.kernel.rows import COLUMN, COLUMNS
from simulator.scene_file import load_scene

DOCUMENT = Path(__file__).resolve().parent.parent / "docs" / "accuracy.md"
FIRST, LAST = "<!-- measured: is the goal kept -->", "<!-- end of is the goal kept -->"
GOALS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10)
FINEST = 1e-12
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


@dataclass(frozen=True, slots=True)
class Kept:
    """Jumps at one goal: how many are flagged, which part of the others keeps the goal, their errors over the goal (the
    middle and the largest), and how many of them end otherwise than at the finest accuracy.
    """

    goal: float
    flagged: int
    judged: int
    share: float
    median: float
    worst: float
    otherwise: int


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


def kept(kernel: Kernel, table: Row) -> tuple[int, list[Kept]]:
    """How many of the scenes jump at the finest accuracy, and what they keep of each goal."""
    finest = _simulated(kernel, table, FINEST)
    jumps = finest[:, 0] == TOUCHDOWN
    found = []
    for goal in GOALS:
        rows = _simulated(kernel, table, goal)
        flags = ill_conditioned(rows[:, COLUMN["decision_margin"]], rows[:, COLUMN["error_growth"]], goal)
        judged = jumps & ~np.asarray(flags)
        ended = rows[judged, 0] == TOUCHDOWN
        both = rows[judged][ended], finest[judged][ended]
        errors = np.max(np.abs(_outputs(both[0]) / _outputs(both[1]) - 1.0), axis=0) / goal
        found.append(
            Kept(
                goal,
                flagged=int(np.sum(jumps)) - int(np.sum(judged)),
                judged=int(np.sum(judged)),
                share=float(np.sum(errors <= 1.0)) / int(np.sum(judged)),
                median=float(np.median(errors)),
                worst=float(np.max(errors)),
                otherwise=int(np.sum(~ended)),
            )
        )
    return int(np.sum(jumps)), found


def _simulated(kernel: Kernel, table: Row, accuracy: float) -> Row:
    rows, none = np.zeros((len(table), 1, len(COLUMNS))), np.zeros((0, 4))
    kernel.batch(table, limits_for(accuracy), rows, np.zeros(len(table), np.int64), none, none)
    return np.asarray(rows[:, 0])


def _outputs(rows: Row) -> Row:
    cost = sum(rows[:, COLUMN[f"stance_{part}_J"]] for part in ("heat", "mechanical", "drag"))
    return np.stack([*(rows[:, COLUMN[name]] for name in OUTPUTS), cost])


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
        rows = [
            (
                f"{row.goal:g}", f"{100 * row.share:.2f} %", f"{row.median:.2g}", f"{row.worst:.3g}", str(row.flagged),
                str(row.otherwise),
            )
            for row in found
        ]  # fmt: skip
        heads = ("goal", "kept", "median error over goal", "largest", "jumps flagged", "end otherwise")
        yield table_text(Table(heads, tuple(rows), ""))


def main() -> None:
    """Put the tables between the two lines of the document."""
    text = DOCUMENT.read_text(encoding="utf-8")
    if text.count(FIRST) != 1 or text.count(LAST) != 1:
        sys.exit(f"{DOCUMENT} has no place for the results: put the lines {FIRST} and {LAST} into it.")
    before, after = text.split(FIRST)[0], text.split(LAST)[1]
    DOCUMENT.write_text("\n".join([before + FIRST, "", *lines(), LAST]) + after, encoding="utf-8")


if __name__ == "__main__":
    main()
