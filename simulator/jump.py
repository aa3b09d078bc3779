"""Simulate a scene: from a `Scene` to what its jumps do and cost.

Its sampled motion comes from the dense output of the accepted steps.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError
from simulator.compiled import Row
from simulator.effects.registry import ENERGIES
from simulator.kernel.build import Kernel
from simulator.kernel.composition import Composition
from simulator.kernel.interpreter import kernel_for_few, lost_time_s
from simulator.kernel.layout import LEG_WORK, MECHANICAL, MODES, OUTCOMES, V_BODY, V_FOOT, X_BODY, X_FOOT
from simulator.kernel.limits import (
    FIXED_STEP_S,
    FLIP_TICK,
    JUMPS_WANTED,
    LIMITS,
    MOST_STEPS,
    REPEATS,
    STOP_AFTER,
    STOP_AFTER_TOUCHDOWN,
    TOLERANCE,
    TOLERANCE_SHARE,
)
from simulator.kernel.rows import COLUMNS, COST_PARTS, COUNTERS
from simulator.result import JumpResult, ModeChange, SceneResult
from simulator.scene import Scene

if TYPE_CHECKING:
    import xarray


FINEST_ACCURACY, COARSEST_ACCURACY = 1e-13, 0.1
ILL_CONDITIONED_BELOW = 10.0
SMALL_COST = 0.1
"""Cost, as a share of the energy turned over, below which it is a difference of larger numbers, and known as they are:
its own relative error is then no longer within the goal."""
ROUNDING = 1e-15
"""Relative error of a step from rounding alone; grown to half the goal, it makes a jump ill-conditioned."""
MOST_STEPS_A_JUMP = 2_000_000
MOST_REPEATS = 5
_SURE = ("min_leg_length_m", "max_leg_length_m", "min_body_height_m", "capped_time_s", "energy_at_play_J")
_COUNTS = ("outcome", "decision_tick", "steps", "rhs_evaluations", "repeats", "mode_changes")
_NUMBERS = [name for name in COLUMNS if name in JumpResult.__annotations__ and name not in _COUNTS]
_ROOM_FOR_CHANGES = 4096
_RECORDED_STEPS = 100_000


def simulate(
    scene: Scene, accuracy: float = 1e-6, trajectory: bool = False, *, most_steps: int = MOST_STEPS_A_JUMP
) -> SceneResult:
    """Simulate all jumps of a scene.

    Parameters
    ----------
    scene : from `load_scene`, changed by `Scene.changed` or `changed_by_words`
    accuracy : relative error wanted in depth, lift-off time, apex height and cost, 1e-13 to 0.1
    trajectory : whether the result holds the sampled motion, as an `xarray.Dataset`
    most_steps : a jump of more steps ends in `step_limit`

    Returns
    -------
    One `JumpResult` for each jump, in SI units. A set of effects that no kernel was compiled for yet is simulated in
    plain Python at first; after ten seconds of it a kernel is compiled, which takes as long again, and cached on disk.

    Raises
    ------
    UsageError for an accuracy outside these bounds.

    Examples
    --------
    >>> from simulator.scene_file import load_scene
    >>> found = simulate(load_scene("sim2"), accuracy=1e-6)
    >>> f"{found.jump.apex_height_m:.3f} m, {found.jump.cost_J:.1f} J"
    '0.303 m, 30.5 J'
    """
    limits = limits_for(accuracy)
    limits[JUMPS_WANTED], limits[MOST_STEPS] = scene.jumps, most_steps
    kernel = kernel_for_few(scene.effects)
    table = parameter_row(kernel, scene)[np.newaxis, :]
    started = time.perf_counter()
    rows, changes, trace = _run(kernel, table, limits, scene.jumps, trajectory)
    spent, compiling = time.perf_counter() - started, kernel.compile_time_s
    if kernel.interpreted and (now := kernel_for_few(scene.effects)).compile_time_s:  # it took too long otherwise
        spent, compiling = spent - now.compile_time_s - lost_time_s(kernel), now.compile_time_s
    jumps = tuple(_jump(scene, accuracy, row, changes[changes[:, 0] == place]) for place, row in enumerate(rows))
    jumps = tuple(_with_other_branch(scene, accuracy, kernel, table, limits, jump) for jump in jumps)
    return SceneResult(
        scene,
        accuracy,
        flag_after_ill_conditioned(jumps),
        compile_time_s=compiling,
        wall_time_s=spent,
        interpreted=kernel.interpreted,
        trajectory=trajectory_of(kernel.composition, trace) if trajectory else None,
    )


def flag_after_ill_conditioned(jumps: tuple[JumpResult, ...]) -> tuple[JumpResult, ...]:
    """Flag all jumps after an ill-conditioned one: they start from a state that is not better known."""
    flags = itertools.accumulate((jump.ill_conditioned for jump in jumps), max)
    return tuple(
        jump if jump.ill_conditioned == flag else replace(jump, ill_conditioned=flag)
        for jump, flag in zip(jumps, flags, strict=True)
    )


def limits_for(accuracy: float, stop_after: int = STOP_AFTER_TOUCHDOWN, fixed_step_s: float = 0.0) -> Row:
    """Return what the kernel is asked for at this accuracy, for one jump; a fixed step serves to measure orders."""
    if not FINEST_ACCURACY <= accuracy <= COARSEST_ACCURACY:
        raise UsageError(
            f"an accuracy of {accuracy:g} cannot be had: give one from {FINEST_ACCURACY:g} to {COARSEST_ACCURACY:g}, "
            "the relative error wanted."
        )
    limits = np.zeros(LIMITS)
    limits[TOLERANCE] = accuracy * TOLERANCE_SHARE
    limits[STOP_AFTER], limits[JUMPS_WANTED], limits[REPEATS] = stop_after, 1, MOST_REPEATS
    limits[MOST_STEPS], limits[FLIP_TICK], limits[FIXED_STEP_S] = MOST_STEPS_A_JUMP, -1, fixed_step_s
    return limits


def parameter_row(kernel: Kernel, scene: Scene) -> Row:
    """Return the scene's parameters in the order that the kernel reads, shape (declared parameters,)."""
    return np.array([scene[parameter.name] for parameter in kernel.composition.parameters])


def _run(kernel: Kernel, table: Row, limits: Row, jumps: int, record: bool) -> tuple[Row, Row, Row]:
    """Run one scene; room for mode changes and steps is made until they fit."""
    rows = np.zeros((1, jumps, len(COLUMNS)))
    counts = np.zeros(1, np.int64)
    room, steps = 16 * jumps + _ROOM_FOR_CHANGES, _RECORDED_STEPS if record else 0
    while True:
        changes = np.full((room, 4), -1.0)
        trace = np.zeros((steps, 4 + 4 * kernel.composition.state_size))
        kernel.batch(table, limits, rows, counts, changes, trace)
        full, recorded = changes[-1, 0] >= 0.0, record and trace[-1, 1] > 0.0
        if not (full or recorded):
            return rows[0, : counts[0]], changes[changes[:, 0] >= 0.0], trace[trace[:, 1] > 0.0]
        room, steps = 8 * room if full else room, 8 * steps if recorded else steps


def _jump(scene: Scene, accuracy: float, row: Row, changes: Row) -> JumpResult:
    found = dict(zip(COLUMNS, row.tolist(), strict=True))
    values: dict[str, Any] = {
        name: found[name] if name in _SURE or math.isfinite(found[name]) else None for name in _NUMBERS
    }
    tick, passive_w = found["decision_tick"], scene["passive_power"] if "passive_draw" in scene.effects else 0.0
    return JumpResult(
        **values,
        **{name: value.item() for name, value in derived(found, scene.effects, passive_w, accuracy).items()},
        outcome=OUTCOMES[int(found["outcome"])],
        decision_tick=int(tick) if tick >= 0 else None,
        counters={name: int(found[name]) for name in COUNTERS},
        mode_changes=tuple(
            ModeChange(time_s, MODES[int(before)], MODES[int(after)]) for _, time_s, before, after in changes.tolist()
        ),
        steps=int(found["steps"]),
        rhs_evaluations=int(found["rhs_evaluations"]),
        repeats=int(found["repeats"]),
    )


def cost_span(effects: Collection[str]) -> str:
    """Return over what the cost of a jump is summed: the stance, or the whole jump."""
    return "jump" if "cost_of_whole_jump" in effects else "stance"


def derived(found: Mapping[str, Any], effects: Collection[str], passive_w: Any, accuracy: float) -> dict[str, Any]:
    """Return what is computed from the kernel's columns, by the outputs' names; numbers or arrays of one shape."""
    span, passive_j = cost_span(effects), passive_w * np.asarray(found["jump_time_s"])
    cost_j = sum(found[f"{span}_{part}_J"] for part in COST_PARTS) + passive_j
    return {
        "passive_J": passive_j,
        "cost_J": cost_j,
        "ill_conditioned": ill_conditioned(found["decision_margin"], found["error_growth"], accuracy)
        | small_cost(cost_j, found["energy_at_play_J"]),
        "under_surface": np.less(found["min_body_height_m"], 0.0) & ("hydrostatic_stiffness" in effects),
        "open_book": open_book(found["energy_residual_J"], found["energy_at_play_J"], accuracy),
        "never_rose": np.greater(found["unresisted_sink_m"], 0.0)
        & np.equal(found["apex_time_s"], found["next_touchdown_time_s"]),
    }


def ill_conditioned(decision_margin: Any, error_growth: Any, accuracy: float) -> Any:
    """Whether jumps hang on a decision, or on rounding that has grown; numbers or arrays of one shape."""
    return np.less(decision_margin, ILL_CONDITIONED_BELOW) | np.greater(error_growth * ROUNDING, 0.5 * accuracy)


def small_cost(cost_j: Any, energy_at_play_j: Any) -> Any:
    """Whether costs are small differences of what the energy book turns over; numbers or arrays of one shape."""
    return np.less(np.abs(cost_j), SMALL_COST * energy_at_play_j) & np.not_equal(cost_j, 0.0)


def rounding_share(error_growth: Any) -> Any:
    """Return the relative error that rounding grows to, at most 1; a number or an array of them."""
    return np.minimum(1.0, np.maximum(error_growth, 1.0) * ROUNDING)


def close_decision(jump: JumpResult) -> bool:
    """Whether the outcome hangs on a decision that lies under ten local errors from falling otherwise."""
    return jump.decision_margin is not None and jump.decision_margin < ILL_CONDITIONED_BELOW


def grown_rounding(jump: JumpResult, accuracy: float) -> float:
    """Return the relative error that rounding alone has grown to, at most 1; 0 where `accuracy` has room for it."""
    error = jump.error_growth * ROUNDING
    return min(error, 1.0) if error > 0.5 * accuracy else 0.0


def open_book(energy_residual_j: Any, energy_at_play_j: Any, accuracy: float) -> Any:
    """Whether energy books do not close within the accuracy; numbers or arrays of one shape."""
    return np.greater(np.abs(energy_residual_j), accuracy * energy_at_play_j)


def _with_other_branch(
    scene: Scene, accuracy: float, kernel: Kernel, table: Row, limits: Row, jump: JumpResult
) -> JumpResult:
    """Add the jump that the other outcome of the closest decision gives; only single jumps hang on one decision."""
    margin = jump.decision_margin
    if margin is None or margin >= ILL_CONDITIONED_BELOW or scene.jumps > 1 or jump.decision_tick is None:
        return jump
    turned = limits.copy()
    turned[FLIP_TICK] = jump.decision_tick
    rows, changes, _ = _run(kernel, table, turned, 1, False)
    return replace(jump, other_branch=_jump(scene, accuracy, rows[0], changes))


SAMPLE_EVERY_S = 5e-4
_MEMBERS = {
    "body_height": (X_BODY, "m", "height of the body above the undisturbed surface"),
    "body_velocity": (V_BODY, "m/s", "velocity of the body, up positive"),
    "foot_height": (X_FOOT, "m", "height of the foot above the undisturbed surface"),
    "foot_velocity": (V_FOOT, "m/s", "velocity of the foot, up positive"),
    "leg_work": (LEG_WORK, "J", "work of the leg's motors on body and foot since touchdown"),
    "mechanical_energy": (MECHANICAL, "J", "mechanical part of the cost since touchdown"),
}


def trajectory_of(composition: Composition, trace: Row) -> xarray.Dataset:
    """Sample the motion every half millisecond and at both ends of every step.

    Both ends: at an event two samples share one time, and jumps in force and gains stay sharp. Between them position,
    velocity and acceleration follow the quintic of all three at a step's ends, integrals and states the cubic.

    `trace`, shape (steps, 4 + 4 states), holds the accepted steps: start (s), length (s), mode, jump, then state and
    rates at the start, state and rates at the end.
    """
    import xarray

    size = composition.state_size
    names = {**_MEMBERS}
    meanings = {energy.name: energy.meaning for energy in ENERGIES}
    for name, place in composition.integrals.items():
        names[name] = (place, "J", f"{meanings[name]} since touchdown")
    for one in composition.effect_states:
        names[one.state.name] = (one.place, one.state.unit, one.state.meaning)
    start, length = trace[:, 0], trace[:, 1]
    step, share = _samples(start, length)
    columns = {}
    for name, (place, unit, meaning) in names.items():
        columns[name] = (
            "time",
            _interpolated(trace[step], share, length[step], place, size),
            {"units": unit, "long_name": meaning},
        )
    dataset = xarray.Dataset(
        {
            **columns,
            **{
                f"{part}_acceleration": (
                    "time",
                    _acceleration(trace[step], share, length[step], place, size),
                    {"units": "m/s^2", "long_name": f"acceleration of the {part}, up positive"},
                )
                for part, place in (("body", X_BODY), ("foot", X_FOOT))
            },
            "mode": (
                "time",
                trace[step, 2].astype(np.int64),
                {"long_name": "contact mode", "flag_values": list(range(len(MODES))), "flag_meanings": " ".join(MODES)},
            ),
            "jump": ("time", trace[step, 3].astype(np.int64), {"long_name": "number of the jump, from 0"}),
        },
        coords={
            "time": ("time", start[step] + share * length[step], {"units": "s", "long_name": "time since the start"})
        },
    )
    dataset["leg_length"] = dataset["body_height"] - dataset["foot_height"]
    dataset["leg_length"].attrs = {"units": "m", "long_name": "length of the leg"}
    return dataset


def _samples(start: Row, length: Row) -> tuple[NDArray[np.int64], Row]:
    inside = np.maximum(np.ceil(length / SAMPLE_EVERY_S).astype(np.int64), 1)
    step = np.repeat(np.arange(len(start)), inside + 1)
    first = np.repeat(np.concatenate([[0], np.cumsum(inside + 1)[:-1]]), inside + 1)
    share = (np.arange(len(step)) - first) / np.repeat(inside, inside + 1)
    return step, share


def _interpolated(steps: Row, share: Row, length: Row, place: int, size: int) -> Row:
    y0, r0, y1, r1 = (steps[:, 4 + block * size + place] for block in range(4))
    if place in (X_BODY, X_FOOT, V_BODY, V_FOOT):
        x = place if place in (X_BODY, X_FOOT) else place - 1
        c = _quintic_of(steps, length, x, size)
        if place == x:
            return np.asarray(sum(c[power] * share**power for power in range(6)))
        return np.asarray(sum(power * c[power] * share ** (power - 1) for power in range(1, 6)) / length)
    d0, d1 = r0 * length, r1 * length
    difference = y1 - y0
    return np.asarray(y0 + share * (d0 + share * (3 * difference - 2 * d0 - d1 + share * (d0 + d1 - 2 * difference))))


def _acceleration(steps: Row, share: Row, length: Row, x: int, size: int) -> Row:
    c = _quintic_of(steps, length, x, size)
    return np.asarray(sum(power * (power - 1) * c[power] * share ** (power - 2) for power in range(2, 6)) / length**2)


def _quintic_of(steps: Row, length: Row, x: int, size: int) -> tuple[Row, ...]:
    """Coefficients, by powers of the share of a step, of the height at place `x`."""
    x0, v0, x1, v1 = (steps[:, 4 + block * size + x] for block in range(4))
    a0, a1 = (steps[:, 4 + block * size + x + 1] * length**2 for block in (1, 3))
    d, e, f = x1 - x0 - v0 * length - 0.5 * a0, (v1 - v0) * length - a0, a1 - a0
    return x0, v0 * length, 0.5 * a0, 10 * d - 4 * e + 0.5 * f, -15 * d + 7 * e - f, 6 * d - 3 * e + 0.5 * f
