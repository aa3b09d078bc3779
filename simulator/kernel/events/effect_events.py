"""Events of effects: their guards, and what happens there, also where another event falls on the same instant."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inlined, inner
from simulator.effects.effect import MODES, Function
from simulator.kernel.composition import Composition
from simulator.kernel.effect_functions import EffectGuard
from simulator.kernel.layout import ARMED, GUARDS_BEFORE, MODE, NOW, OF_EFFECTS

Row = NDArray[np.float64]


def _in_modes(one: EffectGuard) -> tuple[bool, ...]:
    return tuple(mode in one.guard.modes for mode in MODES)


def make_effect_guards(composition: Composition) -> Function:
    """Compose `(mode, work, row, place)`: the guards that effects declare, each in its modes."""
    filled = inlined(lambda mode, work, row, place: None)
    for one in composition.effect_guards:
        filled = _with_guard(filled, one)
    return filled


def _with_guard(before: Function, one: EffectGuard) -> Function:
    value, guard, acts = one.value, one.place, _in_modes(one)

    @inlined
    def filled(mode: float, work: Row, row: int, place: int) -> None:
        before(mode, work, row, place)
        if acts[int(mode)]:
            work[place + guard] = value(work, row)

    return filled


def make_due(composition: Composition) -> Function:
    """Compose `(work)`: the event of an effect that is due as a step starts, -1 for none.

    It is one that was not positive before, and became so as another event ended the step. Guards of the start are known
    (`GUARDS_BEFORE`); those that are not positive are armed.
    """
    due = inner(lambda work: -1)
    for one in composition.effect_guards:
        if one.happens is not None:
            due = _with_due(due, one)
    return due


def _with_due(before: Function, one: EffectGuard) -> Function:
    guard, armed, acts = one.place, ARMED + one.place - OF_EFFECTS, _in_modes(one)

    @inner
    def due(work: Row) -> int:
        found = before(work)
        if acts[int(work[MODE])]:
            if work[GUARDS_BEFORE + guard] <= 0.0:
                work[armed] = 1
            elif work[armed] == 1 and found < 0:
                found = guard
        return found

    return due


def make_effects_happen(composition: Composition) -> Function:
    """Compose `(event, work)`: what effects do at this event, their own or another that ends their mode as well."""
    happen = inner(lambda event, work: None)
    for one in composition.effect_guards:
        if one.happens is not None:
            happen = _with_happening(happen, one, one.happens)
    return happen


def _with_happening(before: Function, one: EffectGuard, act: Function) -> Function:
    guard, armed, acts, value = one.place, ARMED + one.place - OF_EFFECTS, _in_modes(one), one.value

    @inner
    def happen(event: int, work: Row) -> None:
        before(event, work)
        if event == guard or (work[armed] == 1 and acts[int(work[MODE])] and value(work, NOW) > 0.0):
            work[armed] = 0
            act(work, NOW)

    return happen
