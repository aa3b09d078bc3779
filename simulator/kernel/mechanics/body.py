"""The body under the leg's force, its weight, and what forces the effects add; one of these may hold it at rest."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inner
from simulator.effects.effect import MODES, BodyForce, Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import V_BODY

Row = NDArray[np.float64]


def _in_its_modes(force: BodyForce, newtons: Function) -> Function:
    """Compose `(mode, work, row)`: an effect's force, N, 0 in other modes than its own."""
    acts, always = tuple(mode in force.modes for mode in MODES), set(force.modes) == set(MODES)

    @inner
    def in_its_modes(mode: float, work: Row, row: int) -> float:
        if always or acts[int(mode)]:
            return newtons(work, row)
        return 0.0

    return in_its_modes


def _sum(composition: Composition, *, friction: bool) -> Any:
    """Compose `(mode, work, row)`: the effects' forces on the body, N, without that of `friction`; None without any."""
    found: Function | None = None
    for force, newtons in composition.body_forces:
        if friction or not force.holds:
            one = _in_its_modes(force, newtons)
            found = one if found is None else _both(found, one)
    return found


def _both(first: Function, second: Function) -> Function:
    return inner(lambda mode, work, row: first(mode, work, row) + second(mode, work, row))


@made_once
def make_body_acceleration(composition: Composition) -> Function:
    """Compose `(mode, work, row, applied_n)`: the acceleration upward, m/s²; 0 while the body is held."""
    per_body, force_n = composition.position["inverse_body_mass"], _sum(composition, friction=True)
    holds, held, forced = composition.has("body_held"), composition.slot("body_held"), force_n is not None

    @inner
    def acceleration_m_s2(mode: float, work: Row, row: int, applied_n: float) -> float:
        if holds and held(work):
            return 0.0
        a_b = -applied_n * work[per_body] - GRAVITY_M_S2
        if forced:
            a_b += force_n(mode, work, row) * work[per_body]
        return a_b

    return acceleration_m_s2


@made_once
def make_drive(composition: Composition) -> Function:
    """Compose `(mode, work, row, applied_n)`: the force on a body at rest but for the one that may hold it, N."""
    body, force_n = composition.position["body_mass"], _sum(composition, friction=False)
    forced = force_n is not None

    @inner
    def drive_n(mode: float, work: Row, row: int, applied_n: float) -> float:
        drive = -applied_n - work[body] * GRAVITY_M_S2
        if forced:
            drive += force_n(mode, work, row)
        return drive

    return drive_n


def make_force_losses(composition: Composition) -> Function:
    """Compose `(mode, work, row, stage)`: the rates of what each effect's force takes from the body, W."""
    losses = inner(lambda mode, work, row, stage: None)
    for force, newtons in composition.body_forces:
        losses = _also(losses, _in_its_modes(force, newtons), composition.integrals[force.loss.name])
    return losses


def _also(before: Function, force_n: Function, place: int) -> Function:
    @inner
    def losses(mode: float, work: Row, row: int, stage: int) -> None:
        before(mode, work, row, stage)
        work[stage + place] = -force_n(mode, work, row) * work[row + V_BODY]

    return losses
