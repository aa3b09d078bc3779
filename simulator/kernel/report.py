"""Writing a jump's output row: at lift-off, at the apex, and at the end."""

from __future__ import annotations

import math

import numpy as np

from simulator.compiled import Function, Row, inner
from simulator.effects.registry import BOOKED
from simulator.kernel.combined import in_turn, summed
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
from simulator.kernel.rows import COLUMN, COST_PARTS, COUNTERS
from simulator.parameter import GRAVITY_M_S2


@made_once
def make_energy(composition: Composition) -> Function:
    """Kinetic and potential energy, J: `(mode, work)`; grains and a platform with mass count while they
    move."""
    body, foot = composition.position["body_mass"], composition.position["foot_mass"]
    has_mass, mass = composition.optional("added_mass_kg")
    (slides, platform_kg), platform = composition.optional("platform_mass_kg"), composition.platform

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
    entries = [
        _entry(composition.integrals[energy.name], float(energy.sign))
        for energy in BOOKED
        if energy.name in composition.integrals
    ]
    return summed([inner(lambda work: work[NOW + LEG_WORK] - work[IMPACT]), *entries])


def _entry(integral: int, sign: float) -> Function:
    return inner(lambda work: sign * work[NOW + integral])


def make_note_energies(composition: Composition) -> Function:
    """Write the energies of the book, 0 for those of effects that are off: `(work, row)`.

    Returns the sum of their sizes and of that of the leg's work, J.
    """
    places = {name: int(NOW) + integral for name, integral in composition.integrals.items()}
    places |= {energy.name: int(IMPACT) for energy in BOOKED if energy.sudden}
    notes = [_column(COLUMN[energy.column], places.get(energy.name, -1)) for energy in BOOKED]
    return summed([inner(lambda work, row: abs(work[NOW + LEG_WORK])), *notes])


def _column(column: int, place: int) -> Function:
    """Compose `(work, row)`: write what stands at a place, 0 where there is none (-1), and return its size."""

    @inner
    def note(work: Row, row: Row) -> float:
        row[column] = work[place] if place >= 0 else 0.0
        return abs(row[column])

    return note


def make_note_cost(composition: Composition, span: str) -> Function:
    """Write the cost so far, of the stance or of the jump: `(work, row)`."""
    places = {name: int(NOW) + integral for name, integral in composition.integrals.items()}
    places["mechanical"] = int(NOW) + MECHANICAL
    return in_turn(_column(COLUMN[f"{span}_{part}_J"], places.get(part, -1)) for part in COST_PARTS)


@made_once
def make_note_liftoff(composition: Composition) -> Function:
    """Write the state at lift-off; a later lift-off before the apex overwrites it: `(work, row)`."""
    note_cost = make_note_cost(composition, "stance")
    time, height, body, foot, apex, apex_foot = (
        COLUMN["liftoff_time_s"],
        COLUMN["liftoff_body_height_m"],
        COLUMN["liftoff_body_velocity_m_s"],
        COLUMN["liftoff_foot_velocity_m_s"],
        COLUMN["apex_height_m"],
        COLUMN["apex_foot_height_m"],
    )

    @inner
    def note_liftoff(work: Row, row: Row) -> None:
        row[time], row[height], row[body], row[foot] = (
            work[TIME],
            work[NOW + X_BODY],
            work[NOW + V_BODY],
            work[NOW + V_FOOT],
        )
        row[apex] = row[apex_foot] = np.nan
        note_cost(work, row)

    return note_liftoff


_COUNTED = (BOTTOMED, TOUCHED_DURING_RESET, TOUCHED_BEFORE_HOLD, RELEASE_MISSED, GUARD_SWITCHES, CANCELLED)
_AT_THE_END = {
    "jump_time_s": TIME,
    "max_depth_m": DEPTH,
    "unresisted_sink_m": UNRESISTED,
    "leg_work_J": NOW + LEG_WORK,
    "decision_margin": MARGIN,
    "decision_tick": MARGIN_TICK,
    "min_leg_length_m": SHORTEST,
    "max_leg_length_m": LONGEST,
    "capped_time_s": CAPPED,
    "steps": STEPS,
    "rhs_evaluations": EVALUATIONS,
    "mode_changes": EVENTS,
    **dict(zip(COUNTERS, _COUNTED, strict=True)),
}
"""Columns that are written at the end of a jump, and where in the working row they stand."""


def make_finish(composition: Composition) -> Function:
    """Write the rest of the row: `(outcome, work, row)`.

    The energy at play is the size of every sum of the book, and a thousandth of what body and foot have at touchdown,
    from where a leg folded to nothing would lie: where next to nothing is turned over, rounding is not an error.
    """
    note_stance, note_jump = make_note_cost(composition, "stance"), make_note_cost(composition, "jump")
    energy, booked, note_energies = make_energy(composition), make_booked(composition), make_note_energies(composition)
    note_rest = in_turn(_column(COLUMN[name], int(place)) for name, place in _AT_THE_END.items())
    outcome_at, lift, residual, at_play, growth, lowest = (
        COLUMN[name]
        for name in (
            *("outcome", "liftoff_time_s", "energy_residual_J", "energy_at_play_J", "error_growth"),
            "min_body_height_m",
        )
    )

    @inner
    def finish(outcome: int, work: Row, row: Row) -> None:
        row[outcome_at] = outcome
        if np.isnan(row[lift]):
            note_stance(work, row)
        note_jump(work, row)
        note_rest(work, row)
        row[at_play] = 1e-3 * work[START_ENERGY] + note_energies(work, row)
        row[residual] = energy(work[MODE], work) - work[START_ENERGY] - booked(work)
        row[growth], row[lowest] = math.exp(work[WORST_GROWTH]), min(work[LOWEST], work[NOW + X_BODY])

    return finish
