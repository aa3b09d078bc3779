"""Dense output: the quintic through position, velocity and acceleration at both ends of a step.

A mechanical system gives all six for nothing; the position is then of order 6 inside the step and the velocity of order
5, as accurate as the steps themselves, whatever method took them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    K1,
    K7,
    NOW,
    QUINTICS,
    TRIAL,
    X_BODY,
    X_FOOT,
)

Row = NDArray[np.float64]


@inner
def _fit(h: float, work: Row, x: int, at: int) -> None:
    """Coefficients in powers of the share of the step, at the place `at`, of the height that is the state `x`."""
    v0, a0, v1, a1 = work[K1 + x] * h, work[K1 + x + 1] * h * h, work[K7 + x] * h, work[K7 + x + 1] * h * h
    d = work[TRIAL + x] - work[NOW + x] - v0 - 0.5 * a0
    e = v1 - v0 - a0
    f = a1 - a0
    work[at] = work[NOW + x]
    work[at + 1] = v0
    work[at + 2] = 0.5 * a0
    work[at + 3] = 10.0 * d - 4.0 * e + 0.5 * f
    work[at + 4] = -15.0 * d + 7.0 * e - f
    work[at + 5] = 6.0 * d - 3.0 * e + 0.5 * f


@inner
def _evaluate(h: float, s: float, work: Row, at: int, place: int) -> None:
    c1, c2, c3, c4, c5 = work[at + 1], work[at + 2], work[at + 3], work[at + 4], work[at + 5]
    work[place] = work[at] + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))))
    work[place + 1] = (c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))) / h


@inner
def interpolate(h: float, s: float, work: Row, row: int) -> None:
    """Write heights and speeds of body and foot at a share `s` of the step at the place `row`."""
    _evaluate(h, s, work, QUINTICS, row + X_BODY)
    _evaluate(h, s, work, QUINTICS + 6, row + X_FOOT)


@made_once
def make_interpolate(composition: Composition) -> Function:
    """Compose `(h, s, work, row)`, which also writes the states of effects, and those of a platform that can slide."""
    if composition.platform < 0 and not composition.effect_states:
        return interpolate
    platform, slides = composition.platform, composition.platform >= 0
    first, end = composition.integrals_end, composition.integrals_end + len(composition.effect_states)

    @inner
    def interpolate_all(h: float, s: float, work: Row, row: int) -> None:
        interpolate(h, s, work, row)
        for i in range(first, end):  # the cubic of state and rate at both ends
            rise, r0, r1 = work[TRIAL + i] - work[NOW + i], h * work[K1 + i], h * work[K7 + i]
            bend, turn = 3.0 * rise - 2.0 * r0 - r1, r0 + r1 - 2.0 * rise
            work[row + i] = work[NOW + i] + s * (r0 + s * (bend + s * turn))
        if slides:
            _evaluate(h, s, work, QUINTICS + 12, row + platform)

    return interpolate_all


def make_fit_quintics(composition: Composition) -> Function:
    """Compose `(h, work)`: fit the dense output to states and rates at both ends.

    Velocities are taken from the rates: a foot that creeps has one there only.
    """
    platform, slides = composition.platform, composition.platform >= 0

    @inner
    def fit_quintics(h: float, work: Row) -> None:
        _fit(h, work, X_BODY, QUINTICS)
        _fit(h, work, X_FOOT, QUINTICS + 6)
        if slides:
            _fit(h, work, platform, QUINTICS + 12)

    return fit_quintics
