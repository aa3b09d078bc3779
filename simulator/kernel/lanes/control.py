"""The controller's ticks in several lanes, at the start of a step and within it."""

from __future__ import annotations

import math
from typing import Any

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.control.decisions import LARGEST_GROWTH, make_growth_factor
from simulator.kernel.layout import (
    ACTIVE_DAMPING,
    BETWEEN,
    DECIDED,
    GROWTH,
    LENGTH_UNIT,
    MARGIN,
    MARGIN_TICK,
    NOW,
    PHASE,
    SAMPLED_SPEED,
    SATURATED,
    SPEED_UNIT,
    STALE,
    TICK,
    TIME,
    V_FOOT,
    WORST_GROWTH,
)
from simulator.kernel.mechanics.margins import make_forces
from simulator.kernel.steps.dense_output import make_interpolate
from simulator.kernel.working_row import choose, lanes_in

Lanes = Any
"""A number of every lane, or whether something holds in each (`simulator.kernel.lanes.numbers`)."""
Row = Any
"""The working rows of all lanes, place by place."""


def make_grow(composition: Composition) -> Function:
    """Compose `(which, work)`: follow how much a small error of the foot's speed grows, as the scalar kernel does."""
    if not composition.has("active_damping_kg_m") or not composition.has("quadratic_drag_kg_m"):
        return inner(lambda which, work: None)
    growth_factor = make_growth_factor(composition)

    @inner
    def grow(which: Lanes, work: Row) -> None:
        if lanes_in(which) == 0:
            return
        factor = growth_factor(work)
        if lanes_in(which & ((factor > 1.0) | (work[GROWTH] > 0.0))) == 0:
            return
        grown = max(0.0, work[GROWTH] + math.log(max(factor, 1e-3)))
        work[GROWTH] = choose(which, grown, work[GROWTH])
        work[WORST_GROWTH] = choose(which, max(work[WORST_GROWTH], min(grown, LARGEST_GROWTH)), work[WORST_GROWTH])

    return grow


def make_tick(composition: Composition, wants_switch: Function) -> Function:
    """Compose `(active, work)`: the tick that is due, where it changes no phase and brings no force to its cap.

    Returns in which lanes it does.
    """
    rate, active_damping = composition.position["control_rate"], composition.has("active_damping_kg_m")
    capped, forces = composition.has("cap_n"), make_forces(composition)
    grow = make_grow(composition)

    @inner
    def tick(active: Lanes, work: Row) -> Lanes:
        number, time_s = work[TICK], work[TIME]
        due = active & (number / work[rate] <= time_s)
        if lanes_in(due) == 0:
            return due
        wanted = wants_switch(work, work[PHASE], NOW, work[LENGTH_UNIT], work[SPEED_UNIT])
        leaves = due & ((wanted > 0.0) | (number + 1.0 == work[DECIDED]) | ((number + 1.0) / work[rate] <= time_s))
        sampled = due & ~due
        if active_damping:
            sampled = due & (work[ACTIVE_DAMPING] > 0.0)
            before = work[SAMPLED_SPEED]
            work[SAMPLED_SPEED] = choose(sampled, max(0.0, -work[NOW + V_FOOT]), before)
            if capped:
                commanded_n, _, most_n = forces(work, NOW)
                sign = choose(abs(commanded_n) <= most_n, 0.0, choose(commanded_n > 0.0, 1.0, -1.0))
                leaves |= sampled & (sign != work[SATURATED])
            work[SAMPLED_SPEED] = choose(leaves, before, work[SAMPLED_SPEED])
            grow(sampled & ~leaves, work)
        near = due & ~leaves & (abs(wanted) < work[MARGIN]) & (number > 0.0)
        work[MARGIN], work[MARGIN_TICK] = (
            choose(near, abs(wanted), work[MARGIN]),
            choose(near, number, work[MARGIN_TICK]),
        )
        work[TICK] = choose(due & ~leaves, number + 1.0, number)
        work[STALE] = choose(sampled & ~leaves, 1.0, work[STALE])
        return leaves

    return tick


def make_ticks_within(composition: Composition, wants_switch: Function) -> Function:
    """Compose `(h, until, considered, work)`: look at the ticks inside a step, with their margins.

    Returns in which lanes the phase changes at one; in the others the ticks are passed.
    """
    rate, interpolate = composition.position["control_rate"], make_interpolate(composition)

    @inner
    def ticks_within(h: Lanes, until: Lanes, considered: Lanes, work: Row) -> tuple[Lanes, Lanes, Lanes, Lanes]:
        number, margin, margin_tick, leaves = work[TICK], work[MARGIN], work[MARGIN_TICK], considered & ~considered
        while True:
            tick_s = number / work[rate]
            inside = considered & ~leaves & (tick_s < until)
            if lanes_in(inside) == 0:
                return leaves, number, margin, margin_tick
            interpolate(h, (tick_s - work[TIME]) / h, work, BETWEEN)
            wanted = wants_switch(work, work[PHASE], BETWEEN, work[LENGTH_UNIT], work[SPEED_UNIT])
            leaves |= inside & (wanted > 0.0)
            near = inside & (abs(wanted) < margin)
            margin, margin_tick = choose(near, abs(wanted), margin), choose(near, number, margin_tick)
            number = choose(inside, number + 1.0, number)

    return ticks_within
