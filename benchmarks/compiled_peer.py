"""The stance of a scene integrated by CyRK's compiled methods: the forces are labbook's, no step passes through Python.

CyRK finds no events in compiled code, so that it is told each of them, and when: what a user of it would have to find.
Only what changes between two of these times is integrated.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numba
import numpy as np
from CyRK import nbsolve2_ivp
from numba import types
from numpy.typing import NDArray

from simulator.accuracy.hybrid import system_for
from simulator.accuracy.methods import Found, Method
from simulator.accuracy.outputs import outputs_of
from simulator.accuracy.peers import peer_run, typical_sizes
from simulator.compiled import compiled
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.events.guards import make_guards
from simulator.kernel.events.standstill import GOES_ON
from simulator.kernel.layout import (
    EVALUATIONS,
    GUARDS_AFTER,
    K1,
    LIFTOFF_REACHED,
    MODE,
    NOW,
    PARAMETERS,
    STRIDE,
    TICK,
    TIME,
    TRIAL,
    X_FOOT,
)
from simulator.kernel.limits import STOP_AFTER_LIFTOFF
from simulator.kernel.mechanics.motion import make_rates
from simulator.kernel.rows import COLUMNS
from simulator.kernel.steps.stride import UNEVENTFUL
from simulator.scene import Scene

Row = NDArray[np.float64]
LOCATED_BY, LOCATED_TO = "DOP853", 1e-12
"""Method of solve_ivp and its relative tolerance by which the times are found beforehand."""
_PROBE_S, _PAST_S = 1e-9, 1e-15
_pointer_to: Any = types.CPointer
_numbers = _pointer_to(types.float64)


def methods(like: Method, *, every_tick: bool = False) -> list[Method]:
    """Return CyRK's methods with the settings of another one; with `every_tick` they start anew at each tick, too."""
    ticking = ", tick by tick" if every_tick else ""
    return [
        replace(like, name=f"CyRK {name}, told all events{ticking}", prepare=partial(_Attempt, name, every_tick))
        for name in ("RK45", "Tsit5", "Vern7", "DOP853", "Vern8", "LSODA")
    ]


class _Attempt:
    """A stance by one method at one relative tolerance; raises `ValueError` for a scene that begins with a fall."""

    def __init__(self, method: str, every_tick: bool, scene: Scene, rtol: float, stop_after: int) -> None:
        if stop_after != STOP_AFTER_LIFTOFF:
            raise ValueError("only a stance is integrated: stop after lift-off.")
        system = system_for(scene.effects)
        parameters = np.array([scene[parameter.name] for parameter in system.composition.parameters])
        times, events = _told(scene.effects, tuple(parameters), every_tick)
        self._scene, self._work, self._row = scene, np.zeros(system.composition.row_size), np.zeros(len(COLUMNS))
        self._work[PARAMETERS : PARAMETERS + len(parameters)] = parameters
        system.begin(self._work)
        if self._work[NOW + X_FOOT] > 0.0:
            raise ValueError(f"scene {scene.name} begins with a fall.")
        tolerances = np.array([rtol]), rtol * typical_sizes(self._work, system)
        self.run: Callable[[], None] = partial(
            _stance(scene.effects), parameters, self._work, self._row, times, events, method, *tolerances
        )

    def found(self) -> Found:
        """Return what the last run gave."""
        return Found(outputs_of(self._scene, self._row), int(self._work[EVALUATIONS]))


@functools.lru_cache(maxsize=4)
def _told(effects: frozenset[str], parameters: tuple[float, ...], every_tick: bool) -> tuple[Row, NDArray[np.int64]]:
    """When the integrator has to stop, s, and for which event: none at a tick, of which there are those that count."""
    system = system_for(effects)
    rate, told = system.composition.position["control_rate"], list[tuple[float, int]]()

    def follow(event: int, work: Row, row: Row, stop_after: float) -> int:
        if event != UNEVENTFUL or work[TIME] == work[TICK] / work[rate]:
            told.append((float(work[TIME]), event))
        return int(system.follow(event, work, row, stop_after))

    watched = replace(system, follow=follow)
    peer_run(watched, np.array(parameters), LOCATED_BY, LOCATED_TO, 1, STOP_AFTER_LIFTOFF, every_tick=every_tick)
    return np.array([time_s for time_s, _ in told]), np.array([event for _, event in told])


@functools.lru_cache(maxsize=4)
def _stance(effects: frozenset[str]) -> Function:
    """Compile `(parameters, work, row, times, events, method, rtols, atols)`: the stance, piece by piece."""
    system = system_for(effects)
    size, rate = system.composition.state_size, system.composition.position["control_rate"]
    begin, touch_down, control, follow, finish = (
        system.begin, system.touch_down, system.control, system.follow, system.finish,
    )  # fmt: skip
    rates, land = _rates(system.composition).address, _land(system.composition)

    @compiled
    def stance(
        parameters: Row, work: Row, row: Row, times: Row, events: Row, method: str, rtols: Row, atols: Row
    ) -> None:
        work[:], row[:] = 0.0, np.nan
        work[PARAMETERS : PARAMETERS + len(parameters)] = parameters
        begin(work)
        touch_down(work, row)
        address = np.array([work.ctypes.data], dtype=np.int64).view(np.float64)
        for place in range(len(times)):
            while work[TICK] / work[rate] < work[TIME]:
                work[TICK] += 1
            control(work, row)
            start_s = work[TIME]
            found = nbsolve2_ivp(
                rates, (start_s, times[place]), work[NOW : NOW + size], method, args=address, rtols=rtols, atols=atols
            )
            states = found.y
            work[TRIAL : TRIAL + size] = states[:size, states.shape[1] - 1]
            found.free()
            work[TIME] = times[place]
            if events[place] >= 0:
                land(work, events[place])
            work[STRIDE] = work[TIME] - start_s
            if follow(events[place], work, row, float(STOP_AFTER_LIFTOFF)) != GOES_ON:
                break
        finish(LIFTOFF_REACHED, work, row)

    return stance


def _rates(composition: Composition) -> Any:
    """Compile the rates as CyRK calls them: `(rates, time, state, address of the working row)`."""
    rates_of, size = make_rates(composition), composition.state_size

    def rates(found: Row, time_s: float, state: Row, address: Any) -> None:
        work = address[0]
        for i in range(size):
            work[TRIAL + i] = state[i]
        work[EVALUATIONS] += 1.0
        rates_of(int(work[MODE]), time_s, work, TRIAL, K1)
        for i in range(size):
            found[i] = work[K1 + i]

    signature = types.void(_numbers, types.float64, _numbers, _pointer_to(_numbers))
    return numba.cfunc(signature, error_model="numpy")(rates)


def _land(composition: Composition) -> Function:
    """Compile `(work, guard)`: move the state at `TRIAL` and the time, by one step of Newton's, just past an event.

    The told time is that of the exact motion. This one meets the event some 1e-7 s earlier or later.
    """
    fill_guards, rates_of, size = make_guards(composition), make_rates(composition), composition.state_size

    @compiled
    def land(work: Row, guard: int) -> None:
        fill_guards(work[TIME], work, TRIAL, GUARDS_AFTER)
        before = work[GUARDS_AFTER + guard]
        rates_of(int(work[MODE]), work[TIME], work, TRIAL, K1)
        work[TRIAL : TRIAL + size] += _PROBE_S * work[K1 : K1 + size]
        fill_guards(work[TIME] + _PROBE_S, work, TRIAL, GUARDS_AFTER)
        slope = (work[GUARDS_AFTER + guard] - before) / _PROBE_S
        work[TIME] -= before / slope
        move_s, past_s = -before / slope - _PROBE_S, _PAST_S
        for _ in range(30):
            work[TRIAL : TRIAL + size] += move_s * work[K1 : K1 + size]
            fill_guards(work[TIME], work, TRIAL, GUARDS_AFTER)
            if work[GUARDS_AFTER + guard] > 0.0:
                break
            work[TIME] += past_s
            move_s, past_s = past_s, 2.0 * past_s

    return land
