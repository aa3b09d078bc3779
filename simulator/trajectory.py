"""The sampled motion of a simulation, from the dense output of its accepted steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import Row
from simulator.effects.registry import ENERGIES
from simulator.kernel.composition import Composition
from simulator.kernel.layout import LEG_WORK, MECHANICAL, MODES, V_BODY, V_FOOT, X_BODY, X_FOOT

if TYPE_CHECKING:
    import xarray

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
            "body_acceleration": (
                "time",
                _acceleration(trace[step], share, length[step], X_BODY, size),
                {"units": "m/s^2", "long_name": "acceleration of the body, up positive"},
            ),
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
