"""The error of each output of a jump, estimated by simulating it again to a hundredth of the accuracy asked for.

The difference is the bound, and the finer values are the result: a coarser second run, or a margin of the controller's
decisions, does not see a jump that ends in another way. What the margins, the growth of errors and the number of steps
say are the reasons for a large one. Where the finer simulation hangs on a close decision, still finer ones are made.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import fields, replace

from simulator.jump import (
    FINEST_ACCURACY,
    close_decision,
    flag_after_ill_conditioned,
    open_book,
    rounding_share,
    simulate,
)
from simulator.result import JumpResult, SceneResult
from simulator.scene import Scene

FINER = 100.0
"""How much finer the second simulation is: with 10 a scene that was 24 % off went unnoticed."""
JUDGED = ("max_depth_m", "liftoff_time_s", "apex_height_m", "cost_J")
"""The outputs that the accuracy is a goal for."""
NOT_OUTPUTS = ("decision_margin", "error_growth", "energy_residual_J", "energy_at_play_J")
"""Numbers about a simulation, which have no error."""


def finer_accuracy(accuracy: float) -> float:
    """Return the accuracy of the second simulation; it is that of the first where there is nothing finer."""
    return max(accuracy / FINER, FINEST_ACCURACY)


def finer_accuracies(accuracy: float) -> tuple[float, ...]:
    """Return the accuracies, each a hundred times finer, down to 1e-13, at which a jump is simulated until it does not
    hang on a decision; none where there is nothing finer.
    """
    finer = finer_accuracy(accuracy)
    return (finer, *finer_accuracies(finer)) if finer < accuracy else ()


def simulate_finer(scene: Scene, accuracy: float, trajectory: bool = False) -> SceneResult:
    """Simulate a scene a hundred times finer than `accuracy`, and so on while that hangs on a decision.

    The result's `accuracy` is the one that was taken, never finer than 1e-13.
    """
    finer = finer_accuracy(accuracy)
    found = simulate(scene, finer, trajectory)
    if finer > FINEST_ACCURACY and any(map(close_decision, found.jumps)):
        return simulate_finer(scene, finer, trajectory)
    return found


def simulate_with_errors(scene: Scene, accuracy: float = 1e-6, trajectory: bool = False) -> SceneResult:
    """Simulate all jumps of a scene with an estimated error for each output.

    Parameters
    ----------
    scene : from `load_scene`, changed by `Scene.changed` or `changed_by_words`
    accuracy : relative error wanted in depth, lift-off time, apex height and cost, 1e-13 to 0.1
    trajectory : whether the result holds the sampled motion

    Returns
    -------
    The jumps simulated to a hundredth of `accuracy` (`simulate_finer`). Of each, `errors` has by output the absolute
    difference to the simulation to `accuracy`, in the output's unit. It is `ill_conditioned` where that of
    depth, lift-off time, apex height or cost is above the accuracy, or where it ends otherwise: `coarser` is then the
    jump to `accuracy`; so is every jump after such a one. Its errors are the least that they may be: simulations that
    do not settle are samples, and the difference of two is a half or a third of how far others lie. A jump that only
    the finer simulation makes has no errors. At an accuracy of 1e-13 there is nothing finer, and no error.

    Raises
    ------
    UsageError for an accuracy outside these bounds.

    Examples
    --------
    >>> from simulator.scene_file import load_scene
    >>> jump = simulate_with_errors(load_scene("sim2"), accuracy=1e-6).jump
    >>> jump.errors["apex_height_m"] < 1e-6 * jump.apex_height_m, jump.ill_conditioned
    (True, False)
    """
    if finer_accuracy(accuracy) >= accuracy:
        return simulate(scene, accuracy, trajectory)
    coarse, fine = simulate(scene, accuracy), simulate_finer(scene, accuracy, trajectory)
    pairs = itertools.zip_longest(fine.jumps, coarse.jumps[: len(fine.jumps)])
    jumps = tuple(_with_errors(jump, other, accuracy) for jump, other in pairs)
    return replace(
        fine,
        accuracy=accuracy,
        finer_accuracy=fine.accuracy,
        jumps=flag_after_ill_conditioned(jumps),
        compile_time_s=coarse.compile_time_s or fine.compile_time_s,
        interpreted=coarse.interpreted,
        wall_time_s=coarse.wall_time_s + fine.wall_time_s,
    )


def _with_errors(jump: JumpResult, coarse: JumpResult | None, accuracy: float) -> JumpResult:
    if coarse is None:
        return replace(jump, errors={}, ill_conditioned=True)
    errors = differences(jump, coarse)
    otherwise = coarse.outcome != jump.outcome
    return replace(
        jump,
        errors=errors,
        ill_conditioned=otherwise or largest_share(jump, errors) > accuracy,
        coarser=coarse if otherwise else None,
        open_book=bool(open_book(jump.energy_residual_J, jump.energy_at_play_J, accuracy)),
    )


def largest_share(jump: JumpResult, errors: Mapping[str, float]) -> float:
    """Return the largest relative error of depth, lift-off time, apex height and cost; a number that is 0 has none.

    It is infinite where only one of both simulations has a number.
    """
    values = {name: getattr(jump, name) for name in JUDGED}
    shares = [errors.get(name, math.inf) / abs(value) for name, value in values.items() if value]
    return max(shares, default=0.0)


def differences(jump: JumpResult, other: JumpResult) -> Mapping[str, float]:
    """Return by how much each output of two simulations of a jump differs, in its unit, where both have it.

    Rounding, as far as the sampled control lets it grow, is the least difference: both may take the same steps.
    """
    rounding = float(rounding_share(jump.error_growth))
    found: dict[str, float] = {}
    for one in fields(jump):
        value, beside = getattr(jump, one.name), getattr(other, one.name)
        if isinstance(value, float) and isinstance(beside, float) and one.name not in NOT_OUTPUTS:
            found[one.name] = max(abs(value - beside), rounding * abs(value))
    return found
