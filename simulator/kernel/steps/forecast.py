"""How many steps a foot that stiff dampers hold back will take: a look ahead by long steps of low accuracy.

A foot far lighter than its dampers are stiff sinks at the speed at which forces balance. Steps of the kernel are then
no longer than what is stable; where that is a billionth of the jump, the steps allowed come to no end of it. A step of
Rosenbrock's is stable at any length, and follows such a foot well enough to count.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.control.controller import make_wants_switch
from simulator.kernel.events.guards import make_guards
from simulator.kernel.layout import (
    ACTIVE_DAMPING,
    BETWEEN,
    CAP_KINK,
    COMPRESSION,
    COST_KINK,
    DAMPING,
    EXTENSION,
    GUARDS_BETWEEN,
    INTRUDING,
    K2,
    K3,
    LENGTH_UNIT,
    MODE,
    NOW,
    PHASE,
    SAMPLED_SPEED,
    SPEED_UNIT,
    STIFFNESS,
    TICK,
    TIME,
    TRIAL,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.limits import LONGEST_STANCE_S
from simulator.kernel.mechanics.leg import make_set_gains
from simulator.kernel.mechanics.motion import make_rates
from simulator.kernel.steps.step_limits import STABLE_SHARE

Row = NDArray[np.float64]
MOST_LOOKS = 500
"""Steps ahead after which no more are counted."""
CHANGE = 0.1
"""Largest relative change of the foot's speed in a step ahead; of the body's, together with that of a fall by the rest
length."""
NUDGE = 1e-3
"""Relative change of the foot's speed by which its damping is found."""


def make_forecast(composition: Composition) -> Function:
    """Compose `(work, enough)`: how many steps it takes at least to what may end them, counted up to `enough`."""
    rates_inlined, guards = make_rates(composition, creeping=False), make_guards(composition)
    wants_switch, set_gains, count = make_wants_switch(composition), make_set_gains(composition), composition.guards
    sampled, rate = composition.on("sampled_control"), composition.position.get("control_rate", -1)
    bends = [one.place for one in composition.effect_guards if one.happens is None]
    kinks = tuple(guard in (CAP_KINK, COST_KINK, *bends) for guard in range(count))
    first, end = composition.integrals_end, composition.integrals_end + len(composition.effect_states)
    held, per_fall = composition.on("held_force"), composition.position["inverse_fall_speed"]

    @inner
    def rates(t: float, work: Row, stage: int) -> None:
        rates_inlined(INTRUDING, t, work, BETWEEN, stage)

    @inner
    def settling_rate(t: float, work: Row) -> float:
        """Find the rate at which the foot's speed settles at `BETWEEN`, 1/s, and the rates of the state, at `K2`."""
        speed_m_s = work[BETWEEN + V_FOOT]
        work[BETWEEN + V_FOOT] = speed_m_s * (1.0 + NUDGE)
        rates(t, work, K3)
        faster_m_s2 = work[K3 + V_FOOT]
        work[BETWEEN + V_FOOT] = speed_m_s * (1.0 - NUDGE)
        rates(t, work, K3)
        work[BETWEEN + V_FOOT] = speed_m_s
        rates(t, work, K2)
        return (work[K3 + V_FOOT] - faster_m_s2) / (2.0 * NUDGE * speed_m_s)

    @inner
    def steady(h: float, settling: float, work: Row) -> bool:
        """Take a step, whose end is at `TRIAL`; whether no speed changes much in it."""
        for x, v, stiff, aside_m_s in ((X_BODY, V_BODY, 0.0, 1.0 / work[per_fall]), (X_FOOT, V_FOOT, settling, 0.0)):
            before = work[BETWEEN + v]
            after = before + h * work[K2 + v] / (1.0 + h * stiff)
            if not abs(after - before) <= CHANGE * (abs(before) + aside_m_s):
                return False
            work[TRIAL + v], work[TRIAL + x] = after, work[BETWEEN + x] + 0.5 * h * (before + after)
        return work[TRIAL + X_FOOT] >= 2.0 * work[BETWEEN + X_FOOT]

    @inner
    def uneventful(t: float, work: Row) -> bool:
        """Whether nothing has happened at `TRIAL` that forces do not show by themselves."""
        guards(t, work, TRIAL, GUARDS_BETWEEN)
        happened = 0
        for guard in range(count):
            happened += 1 if work[GUARDS_BETWEEN + guard] > 0.0 and not kinks[guard] else 0
        return happened == 0

    @inner
    def decides(work: Row) -> bool:
        """Do at `TRIAL` what the controller does at a tick; whether that is known."""
        if held:
            return False
        extending = work[PHASE] == EXTENSION
        if wants_switch(work, work[PHASE], TRIAL, work[LENGTH_UNIT], work[SPEED_UNIT]) > 0.0:
            extending = not extending
        work[PHASE] = EXTENSION if extending else COMPRESSION
        set_gains(work, extending, work[TRIAL + V_FOOT])
        return True

    @inner
    def counted(work: Row, enough: float) -> float:
        for place in (X_BODY, V_BODY, X_FOOT, V_FOOT):
            work[BETWEEN + place] = work[NOW + place]
        for place in range(first, end):  # states of effects are held
            work[BETWEEN + place] = work[TRIAL + place] = work[NOW + place]
        started, t, tick, steps = work[TIME], work[TIME], work[TICK], 0.0
        settling = settling_rate(t, work)
        h = 1.0 / settling
        for _ in range(MOST_LOOKS):
            if not settling > 0.0 or steps >= enough or t >= LONGEST_STANCE_S:
                break
            end_s = tick / work[rate] if sampled else LONGEST_STANCE_S
            to_end = t + h >= end_s
            if to_end:
                h = end_s - t
            calm = steady(h, settling, work)
            if not (calm and uneventful(t + h, work)):
                if calm and h < CHANGE * (t - started):
                    break
                h *= 0.5
                continue
            t = end_s if to_end else t + h
            if sampled and to_end:
                tick += 1.0
                if not decides(work):
                    break
            for place in (X_BODY, V_BODY, X_FOOT, V_FOOT):
                work[BETWEEN + place] = work[TRIAL + place]
            before = settling
            settling = settling_rate(t, work)
            steps += h * min(before, settling) / STABLE_SHARE
            h *= 2.0
        return steps

    @inner
    def forecast(work: Row, enough: float) -> float:
        if work[MODE] != INTRUDING or not work[NOW + V_FOOT] < 0.0:
            return 0.0
        phase, stiffness, damping = work[PHASE], work[STIFFNESS], work[DAMPING]
        active_damping, sample = work[ACTIVE_DAMPING], work[SAMPLED_SPEED]
        steps = counted(work, enough)
        work[PHASE], work[STIFFNESS], work[DAMPING] = phase, stiffness, damping
        work[ACTIVE_DAMPING], work[SAMPLED_SPEED] = active_damping, sample
        return steps

    return forecast
