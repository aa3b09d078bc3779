"""Writing a jump's output row: at lift-off, at the apex, and at the end."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.effects.registry import BOOKED, COSTS
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    BOTTOMED,
    CANCELLED,
    CAPPED,
    DEPTH,
    EVALUATIONS,
    EVENTS,
    GUARD_SWITCHES,
    IMPACT,
    INTRUDING,
    LEG_WORK,
    LONGEST,
    LOWEST,
    MARGIN,
    MARGIN_TICK,
    MECHANICAL,
    MODE,
    NOW,
    RELEASE_MISSED,
    SHORTEST,
    SLIDES,
    START_ENERGY,
    STEPS,
    TIME,
    TOUCHED_BEFORE_HOLD,
    TOUCHED_DURING_RESET,
    UNRESISTED,
    V_BODY,
    V_FOOT,
    WORST_GROWTH,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.rows import COLUMN
from simulator.parameter import GRAVITY_M_S2

Row = NDArray[np.float64]


@made_once
def make_energy(composition: Composition) -> Function:
    """Kinetic and potential energy, J: `(mode, work)`; grains and a platform with mass count while they
    move."""
    body, foot = composition.position["body_mass"], composition.position["foot_mass"]
    has_mass, mass = composition.has("added_mass_kg"), composition.slot("added_mass_kg")
    slides, platform, platform_kg = (
        composition.platform >= 0,
        composition.platform,
        composition.slot("platform_mass_kg"),
    )

    @inner
    def energy(mode: int, work: Row) -> float:
        moved_kg, sliding_j = work[foot], 0.0
        if slides and work[SLIDES] == 1:
            sliding_j = 0.5 * platform_kg(work) * work[NOW + platform + 1] * work[NOW + platform + 1]
        elif slides and mode == INTRUDING:
            moved_kg += platform_kg(work)
        if has_mass and mode == INTRUDING:
            moved_kg += mass(work, -work[NOW + X_FOOT])
        return (
            work[body] * (0.5 * work[NOW + V_BODY] * work[NOW + V_BODY] + GRAVITY_M_S2 * work[NOW + X_BODY])
            + 0.5 * moved_kg * work[NOW + V_FOOT] * work[NOW + V_FOOT]
            + work[foot] * GRAVITY_M_S2 * work[NOW + X_FOOT]
            + sliding_j
        )

    return energy


def make_booked(composition: Composition) -> Function:
    """Energy gained since touchdown according to what events and integrals say, J: `(work)`."""
    booked = inner(lambda work: work[NOW + LEG_WORK] - work[IMPACT])
    for energy in BOOKED:
        if energy.name in composition.integrals:
            booked = _with_entry(booked, composition.integrals[energy.name], float(energy.sign))
    return booked


def _with_entry(before: Function, integral: int, sign: float) -> Function:
    return inner(lambda work: before(work) + sign * work[NOW + integral])


def make_note_energies(composition: Composition) -> Function:
    """Write the energies of the book, 0 for those of effects that are off: `(work, row)`.

    Returns the sum of their sizes and of that of the leg's work, J.
    """
    note = inner(lambda work, row: abs(work[NOW + LEG_WORK]))
    for energy in BOOKED:
        if energy.sudden:
            place = int(IMPACT)
        elif energy.name in composition.integrals:
            place = int(NOW) + composition.integrals[energy.name]
        else:
            place = -1
        note = _with_column(note, COLUMN[energy.column], place)
    return note


def _with_column(before: Function, column: int, place: int) -> Function:
    @inner
    def note(work: Row, row: Row) -> float:
        turned_over_j = before(work, row)
        row[column] = work[place] if place >= 0 else 0.0
        return turned_over_j + abs(row[column])

    return note


def make_note_cost(composition: Composition, span: str) -> Function:
    """Write the cost so far, of the stance or of the jump: `(work, row)`."""
    note = _with_part(inner(lambda work, row: None), COLUMN[f"{span}_mechanical_J"], MECHANICAL)
    for energy in COSTS:
        note = _with_part(note, COLUMN[f"{span}_{energy.name}_J"], composition.integrals.get(energy.name, -1))
    return note


def _with_part(before: Function, column: int, integral: int) -> Function:
    @inner
    def note_cost(work: Row, row: Row) -> None:
        before(work, row)
        row[column] = work[NOW + integral] if integral >= 0 else 0.0

    return note_cost


@made_once
def make_note_liftoff(composition: Composition) -> Function:
    """Write the state at lift-off; a later lift-off before the apex overwrites it: `(work, row)`."""
    note_cost = make_note_cost(composition, "stance")
    time, height, body, foot, apex = (
        COLUMN["liftoff_time_s"],
        COLUMN["liftoff_body_height_m"],
        COLUMN["liftoff_body_velocity_m_s"],
        COLUMN["liftoff_foot_velocity_m_s"],
        COLUMN["apex_height_m"],
    )

    @inner
    def note_liftoff(work: Row, row: Row) -> None:
        row[time], row[height], row[body], row[foot] = (
            work[TIME],
            work[NOW + X_BODY],
            work[NOW + V_BODY],
            work[NOW + V_FOOT],
        )
        row[apex] = np.nan
        note_cost(work, row)

    return note_liftoff


def make_finish(composition: Composition) -> Function:
    """Write the rest of the row: `(outcome, work, row)`.

    The energy at play is the size of every sum of the book, and a thousandth of what body and foot have at touchdown,
    from where a leg folded to nothing would lie: where next to nothing is turned over, rounding is not an error.
    """
    note_stance, note_jump = make_note_cost(composition, "stance"), make_note_cost(composition, "jump")
    at = COLUMN
    o, lift, work_at, residual_at = (
        at["outcome"],
        at["liftoff_time_s"],
        at["leg_work_J"],
        at["energy_residual_J"],
    )
    margin, tick, growth, shortest, longest, lowest, capped, at_play = (
        at["decision_margin"],
        at["decision_tick"],
        at["error_growth"],
        at["min_leg_length_m"],
        at["max_leg_length_m"],
        at["min_body_height_m"],
        at["capped_time_s"],
        at["energy_at_play_J"],
    )
    energy, booked, note_energies = make_energy(composition), make_booked(composition), make_note_energies(composition)
    steps, evaluations, counters, changes, duration, depth, sunk = (
        at["steps"],
        at["rhs_evaluations"],
        at["bottomed"],
        at["mode_changes"],
        at["jump_time_s"],
        at["max_depth_m"],
        at["unresisted_sink_m"],
    )

    @inner
    def finish(outcome: int, work: Row, row: Row) -> None:
        row[o] = outcome
        if np.isnan(row[lift]):
            note_stance(work, row)
        note_jump(work, row)
        row[duration] = work[TIME]
        row[depth], row[sunk] = work[DEPTH], work[UNRESISTED]
        row[work_at] = work[NOW + LEG_WORK]
        row[at_play] = 1e-3 * work[START_ENERGY] + note_energies(work, row)
        row[residual_at] = energy(work[MODE], work) - work[START_ENERGY] - booked(work)
        row[margin], row[tick], row[growth] = work[MARGIN], work[MARGIN_TICK], math.exp(work[WORST_GROWTH])
        row[shortest], row[longest], row[capped] = work[SHORTEST], work[LONGEST], work[CAPPED]
        row[lowest] = min(work[LOWEST], work[NOW + X_BODY])
        row[steps], row[evaluations] = work[STEPS], work[EVALUATIONS]
        row[counters] = work[BOTTOMED]
        row[counters + 1] = work[TOUCHED_DURING_RESET]
        row[counters + 2] = work[TOUCHED_BEFORE_HOLD]
        row[counters + 3] = work[RELEASE_MISSED]
        row[counters + 4] = work[GUARD_SWITCHES]
        row[counters + 5] = work[CANCELLED]
        row[changes] = work[EVENTS]

    return finish
