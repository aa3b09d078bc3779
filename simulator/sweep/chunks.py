"""A chunk of a sweep: so many scenes simulated side by side or one after the other, by a thread or another machine.

The chunks depend on the sweep alone, never on who computes them, and no scene on its neighbours: the same bits come out
whatever the number of cores and the order.

Also what a sweep gives for each jump: names, units, meanings and how they are stored.
"""

from __future__ import annotations

import functools
import os
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError
from simulator.compiled import Row
from simulator.error_bars import JUDGED, NOT_OUTPUTS, finer_accuracies
from simulator.jump import ILL_CONDITIONED_BELOW, derived, limits_for, rounding_share
from simulator.kernel.build import Kernel, is_cached, kernel_for, why_no_lanes
from simulator.kernel.cache import fingerprint
from simulator.kernel.composition import compose
from simulator.kernel.interpreter import kernel_for_few
from simulator.kernel.layout import OUTCOMES
from simulator.kernel.limits import JUMPS_WANTED
from simulator.kernel.rows import COLUMNS, KERNEL_OUTPUTS, Output
from simulator.scene import Scene
from simulator.sweep.design import Design

Block = Row
FEWEST_IN_LANES, FEWEST_TO_COMPILE = 10_000, 500_000
"""Jumps of a sweep from which on it is in lanes where they are on disk, and for which they are compiled."""

NOT_MADE = "not_made"
"""Outcome of the jumps of a scene after its last: the robot did not come down again."""
REFUSED = "refused"
"""Outcome of all jumps of a scene that cannot be simulated, since its values do not fit together."""
NEVER_ROSE = "never_rose"
"""Flag of a touchdown that is no jump."""
REFUSED_FLAG, NOT_MADE_FLAG = -2, -1


OUTCOME_FLAGS = ((REFUSED_FLAG, REFUSED), (NOT_MADE_FLAG, NOT_MADE), *enumerate(OUTCOMES))
_YES_OR_NO = ((NOT_MADE_FLAG, NOT_MADE), (0, "no"), (1, "yes"))


def _yes_or_no(name: str, meaning: str, comment: str) -> Output:
    return Output(name, "1", meaning, "i1", comment, _YES_OR_NO)


OUTPUTS = (
    replace(KERNEL_OUTPUTS[0], flags=OUTCOME_FLAGS),
    *KERNEL_OUTPUTS[1:],
    Output("passive_J", "J", "passive draw of the electronics", comment="from touchdown to the jump's end"),
    Output("cost_J", "J", "cost of the jump", comment="heat, mechanical, drag and passive draw"),
    _yes_or_no("ill_conditioned", "whether the jump is ill-conditioned", "it hangs on a decision or on rounding"),
    _yes_or_no(
        "under_surface", "whether the body gets under the surface", "of the grains, which act on the foot alone"
    ),
    _yes_or_no("open_book", "whether the energy book stays open", "it does not close within the accuracy"),
    _yes_or_no("never_rose", "whether the lifted foot never rose above its print", "it is no jump then"),
)
"""In the order of a chunk's columns: those of the kernel first, then what is computed from them."""

ERRORS = tuple(
    Output(
        *(f"{output.name}_error", output.unit, f"error of {output.name}"),
        comment="estimated; the least that it may be where ill_conditioned; NaN: none",
    )
    for output in OUTPUTS
    if output.kind == "f8" and output.name not in NOT_OUTPUTS
)
"""What a sweep with error bars gives beside them: columns after those of the outputs."""
SAMPLED_ERROR = Output(
    *("error_over_accuracy", "1", "error over the accuracy asked for"),
    comment="largest relative error of depth, lift-off time, apex height and cost, estimated in a sample of the "
    "scenes; NaN in the others, infinite where the jump ends otherwise",
)
"""What a sweep gives whose error bars are those of a sample: a column after those of the outputs."""
NOT_MADE_ROW = np.array([np.nan if output.kind == "f8" else float(NOT_MADE_FLAG) for output in (*OUTPUTS, *ERRORS)])
PLACE = {output.name: place for place, output in enumerate(OUTPUTS)}
_WITH_ERROR = [PLACE[error.name.removesuffix("_error")] for error in ERRORS]
_JUDGED = [_WITH_ERROR.index(PLACE[name]) for name in JUDGED]
_building = threading.Lock()


@dataclass(frozen=True, slots=True, eq=False)
class Recipe:
    """All that is needed to simulate rows of a sweep, small enough to send with every chunk.

    `base`: the scene's parameters in the kernel's order; `places`: where among them the swept ones stand;
    `passive_place`: where the passive power does. `finer`: limits of the finer simulations that error bars take one
    after the other, none without them; `sampled`: only some scenes have them. `simulator`: which version of it is
    meant. `why_scalar`: why a chunk's scenes are simulated one after the other, None where they are side by side in
    lanes, which changes no bit.
    """

    effects: tuple[str, ...]
    jumps: int
    base: Row
    places: tuple[int, ...]
    passive_place: int | None
    limits: Row
    finer: tuple[Row, ...]
    sampled: bool
    accuracy: float
    simulator: str
    why_scalar: str | None


@functools.cache
def simulator_here() -> str:
    """Return the fingerprint of the simulator that this process has loaded."""
    return fingerprint()


def recipe_for(scene: Scene, design: Design, accuracy: float, *, error_bars: float = 0.0) -> Recipe:
    """Return the recipe of a sweep, `error_bars` for this share of its scenes.

    Raises `UsageError` for an accuracy that cannot be had.
    """
    limits, *others = [limits_for(each) for each in (accuracy, *finer_accuracies(accuracy))]
    for each in (limits, *others):
        each[JUMPS_WANTED] = scene.jumps
    names = [parameter.name for parameter in compose(scene.effects).parameters]
    return Recipe(
        effects=tuple(sorted(scene.effects)),
        jumps=scene.jumps,
        base=np.array([scene[name] for name in names]),
        places=tuple(names.index(swept.parameter) for swept in design.axes),
        passive_place=names.index("passive_power") if "passive_draw" in scene.effects else None,
        limits=limits,
        finer=tuple(others) if error_bars else (),
        sampled=error_bars < 1.0,
        accuracy=accuracy,
        simulator=simulator_here(),
        why_scalar=why_scalar(scene, design),
    )


def why_scalar(scene: Scene, design: Design) -> str | None:
    """Return why a sweep's scenes are simulated one after the other, None where they are side by side in lanes.

    To compile the lanes takes as long as they save in about a million jumps.
    """
    if why := why_no_lanes(scene.effects):
        return why
    jumps = design.row_count * scene.jumps
    if jumps < FEWEST_IN_LANES:
        return f"lanes take {FEWEST_IN_LANES} jumps or more"
    if jumps < FEWEST_TO_COMPILE and not is_cached(scene.effects, lanes=True):
        return f"lanes are compiled from {FEWEST_TO_COMPILE} jumps on, or by `labbook sim warm --lanes`"
    return None


def recipe_of_rows(scene: Scene, accuracy: float) -> Recipe:
    """Return the recipe of scenes that differ in any parameter, whose rows are those of `parameter_row`."""
    recipe = recipe_for(scene, Design(()), accuracy)
    return replace(recipe, places=tuple(range(recipe.base.size)))


def kernel_of(recipe: Recipe) -> Kernel:
    """Return the kernel of a sweep, compiled by the first thread that asks."""
    with _building:
        return kernel_for(recipe.effects, lanes=recipe.why_scalar is None)


def check_simulator(recipe: Recipe, version: str) -> None:
    """Raise `UsageError` where a worker has another simulator than the recipe was made with."""
    if recipe.simulator != version:
        raise UsageError(
            f"a worker has another version of the simulator ({version}, not {recipe.simulator}): give it the same "
            "labbook, Python and numba."
        )


def simulate_rows(recipe: Recipe, values: Block, barred: NDArray[np.bool_] | None = None) -> Block:
    """Simulate a scene for each row of swept values, shape (rows, axes); return shape (rows, jumps, outputs).

    A recipe with error bars gives the errors after the outputs, and the numbers of the finer simulation, as
    `simulator.error_bars` shows them. One with those of a sample gives after the outputs, which stay as they are,
    `SAMPLED_ERROR` for the rows that `barred` names, shape (rows,), and flags them by it too. Raises `UsageError` where
    this process has another simulator than the recipe was made with.
    """
    check_simulator(recipe, simulator_here())
    table = np.tile(recipe.base, (len(values), 1))
    table[:, recipe.places] = values
    block = _simulated(recipe, recipe.limits, table)
    if not recipe.finer:
        return block
    if not recipe.sampled:
        fine = _finer(recipe, table)
        errors, over, _ = _compared(recipe.accuracy, block, fine)
        _flag(fine, over > 1.0)
        return np.concatenate([fine, errors], axis=2)
    sample = np.full((*block.shape[:2], 1), np.nan)
    if barred is not None and barred.any():
        some = block[barred]
        _, over, made = _compared(recipe.accuracy, some, _finer(recipe, table[barred]))
        _flag(some, (over > 1.0) | (some[:, :, PLACE["ill_conditioned"]] > 0.0))
        block[barred], sample[barred, :, 0] = some, np.where(made, over, np.nan)
    return np.concatenate([block, sample], axis=2)


MOST_IN_A_PART = 4096
"""Rows that a core simulates without a look at whether it is to go on: a Ctrl-C waits for the parts under way."""


def simulate_on_all_cores(recipe: Recipe, values: Block) -> Block:
    """Return what `simulate_rows` does, the rows in parts: compiled code does not hold Python's lock."""
    parts = np.array_split(values, max(cores(), -(-len(values) // MOST_IN_A_PART)))
    with ThreadPoolExecutor(cores()) as pool:
        return np.concatenate(list(pool.map(lambda part: simulate_rows(recipe, part), parts)))


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _compared(accuracy: float, coarse: Block, fine: Block) -> tuple[Block, Block, NDArray[np.bool_]]:
    """Return the errors of the outputs, the largest of those that the accuracy is a goal for over it, and which jumps
    either simulation has, as `simulator.error_bars` has them of a jump.
    """
    found, beside = fine[:, :, _WITH_ERROR], coarse[:, :, _WITH_ERROR]
    rounding = rounding_share(fine[:, :, PLACE["error_growth"]])
    errors = np.maximum(np.abs(found - beside), rounding[:, :, np.newaxis] * np.abs(found))
    judged = np.abs(found[:, :, _JUDGED])
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(judged > 0.0, errors[:, :, _JUDGED] / judged / accuracy, 0.0)
    shares[np.isnan(shares)] = np.inf
    ends, before = fine[:, :, PLACE["outcome"]], coarse[:, :, PLACE["outcome"]]
    over = np.where(ends == before, shares.max(axis=2), np.inf)
    return errors, over, (ends != NOT_MADE_FLAG) | (before != NOT_MADE_FLAG)


def _flag(block: Block, above: NDArray[np.bool_]) -> None:
    """Flag jumps, shape (rows, jumps), and those that follow them."""
    flags = np.logical_or.accumulate(above, axis=1)
    not_made = block[:, :, PLACE["outcome"]] == NOT_MADE_FLAG
    block[:, :, PLACE["ill_conditioned"]] = np.where(not_made, NOT_MADE_FLAG, flags)


def _finer(recipe: Recipe, table: Block) -> Block:
    """Simulate finer, and finer still where that hangs on a decision, as `simulator.error_bars.simulate_finer` does."""
    first, *others = recipe.finer
    found = _simulated(recipe, first, table)
    for finer in others:
        close = (found[:, :, PLACE["decision_margin"]] < ILL_CONDITIONED_BELOW).any(axis=1)
        if not close.any():
            break
        found[close] = _simulated(recipe, finer, table[close])
    return found


def _simulated(recipe: Recipe, limits: Row, table: Block) -> Block:
    found = np.full((len(table), recipe.jumps, len(COLUMNS)), np.nan)
    counts = np.zeros(len(table), np.int64)
    kernel = kernel_for_few(recipe.effects) if len(table) == 1 else kernel_of(recipe)
    kernel.batch(table, limits, found, counts, np.zeros((0, 4)), np.zeros((0, 4)))
    return _outputs(recipe, found, counts, None if recipe.passive_place is None else table[:, recipe.passive_place])


def _outputs(recipe: Recipe, found: Block, counts: NDArray[np.int64], passive_w: Row | None) -> Block:
    """Add what is computed from the kernel's columns, as `simulator.jump` does; mark the jumps that were not made."""
    columns = dict(zip(COLUMNS, np.moveaxis(found, -1, 0), strict=True))
    passive = 0.0 if passive_w is None else passive_w[:, np.newaxis]
    block = np.empty((*found.shape[:2], len(OUTPUTS)))
    block[:, :, : len(COLUMNS)] = found
    for name, values in derived(columns, recipe.effects, passive, recipe.accuracy).items():
        block[:, :, PLACE[name]] = values
    flags = block[:, :, PLACE["ill_conditioned"]] > 0.0
    block[:, :, PLACE["ill_conditioned"]] = np.logical_or.accumulate(flags, axis=1)
    block[np.arange(recipe.jumps)[np.newaxis, :] >= counts[:, np.newaxis]] = NOT_MADE_ROW[: len(OUTPUTS)]
    return block


FLAGS = ("ill_conditioned", "under_surface", "open_book", NEVER_ROSE)
"""What may be remarked of a jump: a sweep counts the jumps."""
