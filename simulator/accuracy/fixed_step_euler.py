"""The fixed-step scheme of the thesis, for comparison only: explicit Euler through a whole jump (thesis 3.2).

At every step the ground either acts or does not: it does where the foot has just gone deeper than ever before and still
moves down. There is no jammed mode: a resting foot flips in and out of contact from step to step, Zeno-like (thesis
3.2, footnote 1). The controller looks at the first step more than a period after its last look, so that its clock is
up to a step late at each tick; the foot lifts off where the leg's force exceeds the weight of foot and grains, and
meets no ground before the apex (3.1.3). The forces are those of the kernel: what is compared is the scheme alone.
"""

from __future__ import annotations

import functools
import math

import numba
import numpy as np

from data_schema.errors import UsageError
from simulator.compiled import Function, Row, inner
from simulator.effects.registry import EFFECTS
from simulator.kernel.cache import cached_entry
from simulator.kernel.composition import Composition, compose
from simulator.kernel.control.controller import make_switch, make_tick, make_wants_switch
from simulator.kernel.events.contact import make_lift_off
from simulator.kernel.layout import (
    APEX,
    ASLEEP,
    DEEPEST,
    FLIGHT,
    INTRUDING,
    K1,
    LEG_FOLDED,
    LEG_STRAIGHT,
    LENGTH_UNIT,
    LIFTOFF_REACHED,
    MARGIN,
    MODE,
    NO_LIFTOFF,
    NOW,
    PARAMETERS,
    PHASE,
    SPEED_UNIT,
    TIME,
    TIMEOUT,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.limits import LONGEST_FLIGHT_S, LONGEST_STANCE_S
from simulator.kernel.mechanics.leg import make_forces
from simulator.kernel.mechanics.motion import make_rates
from simulator.kernel.report import make_note_cost, make_note_liftoff
from simulator.kernel.rows import COLUMN, COLUMNS
from simulator.kernel.start import make_begin
from simulator.parameter import GRAVITY_M_S2
from simulator.scene import Scene

THESIS_STEP_S = 1e-6


def why_not(scene: Scene) -> str | None:
    """Say why the scheme does not cover a scene, or None where it does."""
    if "hydrostatic_stiffness" not in scene.effects:
        return "the thesis's scheme knows granular ground only"
    pushing = [effect for effect in EFFECTS.values() if effect.name in scene.effects and effect.body_force]
    return f"the thesis's scheme does not know {pushing[0].name}: {pushing[0].meaning}" if pushing else None


def fixed_step_euler_run(scene: Scene) -> tuple[Function, Row, Row]:
    """Return the compiled scheme `(work, step_s, to_liftoff, row)`, its row to work in, and a row for its results.

    So it can be called many times, for a jump from touchdown to the apex or for its stance only. The second row is one
    of the kernel's (`simulator.kernel.layout`): not a number where something was not reached, and the number of mode
    changes is how often the ground has begun to act, at a resting foot again and again. The forces are evaluated once
    a step. Raises `UsageError` where the scheme does not cover the scene.
    """
    reason = why_not(scene)
    if reason is not None:
        raise UsageError(f"scene {scene.name} cannot be computed so, because {reason}: simulate it instead.")
    composition, run = _compiled(scene.effects)
    work = np.zeros(composition.row_size)
    for place, parameter in enumerate(composition.parameters):
        work[PARAMETERS + place] = scene[parameter.name]
    return run, work, np.zeros(len(COLUMNS))


@functools.lru_cache(maxsize=16)
def _compiled(effects: frozenset[str]) -> tuple[Composition, Function]:
    composition = compose(effects)
    row = numba.float64[::1]
    types = (row, numba.float64, numba.boolean, row)
    return composition, cached_entry(_make_run(composition), types, "fixed-step Euler", composition.effects)


def _make_touchdown(composition: Composition) -> Function:
    """Put the robot at touchdown, the fall before it in closed form: `(work)`."""
    begin, at = make_begin(composition), composition.position
    rest, height, velocity = at["rest_length"], at["initial_height"], at["initial_velocity"]

    @inner
    def touch_down(work: Row) -> None:
        begin(work)
        speed_m_s = math.sqrt(work[velocity] * work[velocity] + 2.0 * GRAVITY_M_S2 * work[height])
        work[NOW + X_BODY], work[NOW + V_BODY] = work[rest], -speed_m_s
        work[NOW + X_FOOT], work[NOW + V_FOOT] = 0.0, -speed_m_s
        work[MODE], work[MARGIN] = INTRUDING, np.inf
        work[LENGTH_UNIT], work[SPEED_UNIT] = 1.0, 1.0

    return touch_down


def _make_look(composition: Composition) -> Function:
    """Let the controller look at t: `(t, looked_s, work)` returns when it last did."""
    wants_switch, switch = make_wants_switch(composition), make_switch(composition)
    tick = make_tick(composition, wants_switch, switch)
    if composition.on("sampled_control"):
        period_s = composition.slots["control_period_s"]

        @inner
        def look_at_ticks(t: float, looked_s: float, work: Row) -> float:
            if t > 0.0 and t - looked_s <= period_s(work):
                return looked_s
            tick(work, False)
            return t

        return look_at_ticks

    @inner
    def look_always(t: float, looked_s: float, work: Row) -> float:  # noqa: ARG001
        if wants_switch(work, work[PHASE], NOW, 1.0, 1.0) > 0.0:
            switch(work)
        return t

    return look_always


def _make_run(composition: Composition) -> Function:
    size = composition.state_size
    prepare, rates_of, forces = composition.prepare, make_rates(composition), make_forces(composition)
    touch_down, lift_off, look = _make_touchdown(composition), make_lift_off(composition), _make_look(composition)
    note_liftoff, note_stance = make_note_liftoff(composition), make_note_cost(composition, "stance")
    has_mass, added_kg = composition.optional("added_mass_kg")
    foot, upper, lower = (composition.position[name] for name in ("foot_mass", "upper_link", "lower_link"))
    outcome_at, lift, apex, depth, steps_at, flips_at = (
        COLUMN[name] for name in ("outcome", "liftoff_time_s", "apex_height_m", "max_depth_m", "steps", "mode_changes")
    )

    def run(work: Row, step_s: float, to_liftoff: bool, row: Row) -> None:
        prepare(work)
        touch_down(work)
        row[:] = np.nan
        pressing, looked_s, deepest_m = True, 0.0, 0.0
        steps, flips, outcome = 0, 0, -1
        while outcome < 0:
            t = steps * step_s
            if work[MODE] == FLIGHT:
                if work[NOW + V_BODY] <= 0.0:
                    row[apex], outcome = work[NOW + X_BODY], APEX
                elif t - row[lift] >= LONGEST_FLIGHT_S:
                    outcome = TIMEOUT
            else:
                looked_s = look(t, looked_s, work) if work[ASLEEP] == 0 else looked_s
                length_m = work[NOW + X_BODY] - work[NOW + X_FOOT]
                moved_kg = work[foot]
                if has_mass and pressing:
                    moved_kg += added_kg(work, -work[NOW + X_FOOT])
                if forces(work, NOW)[1] > moved_kg * GRAVITY_M_S2:
                    pressing, work[DEEPEST], work[TIME] = False, -deepest_m, t
                    lift_off(work)
                    if work[MODE] == FLIGHT:
                        note_liftoff(work, row)
                    if to_liftoff and work[MODE] == FLIGHT:
                        outcome = LIFTOFF_REACHED
                elif length_m < work[lower] - work[upper]:
                    outcome = LEG_FOLDED
                elif length_m > work[lower] + work[upper]:
                    outcome = LEG_STRAIGHT
                elif t >= LONGEST_STANCE_S:
                    outcome = NO_LIFTOFF
            rates_of(INTRUDING if pressing else FLIGHT, t, work, NOW, K1)
            for i in range(size):
                work[NOW + i] += step_s * work[K1 + i]
            steps += 1
            if work[MODE] != FLIGHT:
                pressed = pressing
                pressing = -work[NOW + X_FOOT] > deepest_m and work[NOW + V_FOOT] < 0.0
                if pressing and not pressed:
                    flips += 1
                deepest_m = max(deepest_m, -work[NOW + X_FOOT])
        if np.isnan(row[lift]):
            note_stance(work, row)
        row[outcome_at], row[depth], row[steps_at], row[flips_at] = outcome, deepest_m, steps, flips

    return run
