"""A kernel ready to run for a set of effects, built once a process."""

from __future__ import annotations

import functools
import time
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numba

from simulator.compiled import Function
from simulator.effects.registry import EFFECTS
from simulator.kernel.batch import make_batch
from simulator.kernel.cache import compiling_alone, give_unique_symbols, keep_on_disk, on_disk
from simulator.kernel.composition import Composition, compose
from simulator.kernel.lanes.pool import make_batch_in_lanes

_SETTINGS: Any = numba.config
IN_LANES = frozenset(
    {
        "active_damping",
        "added_mass",
        "constant_force_cap",
        "contact_once_risen",
        "cost_of_commanded_force",
        "cost_of_whole_jump",
        "drag",
        "held_gains_in_flight",
        "hydrostatic_stiffness",
        "inertial_drag",
        "leg_damping",
        "motor_heat",
        "passive_draw",
        "sampled_control",
        "short_leg_guard",
        "torque_cap",
    }
)
"""Effects that a kernel in lanes may be composed of: their functions take no branch by a number of the state."""
IN_ALL_LANES = ("hydrostatic_stiffness", "sampled_control")
"""Those without which the modes or the controller's instants are others than its steps know. The guard of the first is
the only one of an effect that they look at, and they integrate no states of effects."""


@dataclass(frozen=True, slots=True)
class Kernel:
    """A kernel ready to run; `compile_time_s` is what this process spent to compile it or to load it from disk.

    It is `interpreted` where it runs in plain Python, with no time to compile.
    """

    composition: Composition
    batch: Function
    compile_time_s: float
    interpreted: bool = False


def kernel_for(effects: Iterable[str], *, lanes: bool = False) -> Kernel:
    """Return the kernel for these effects, composed of them and of no others.

    With `lanes` it simulates scenes side by side, to the same bits, where `why_no_lanes` is None.
    """
    return _kernel(frozenset(effects), lanes)


def why_no_lanes(effects: frozenset[str]) -> str | None:
    """Return why scenes with these effects are simulated one after the other; None where lanes can take them."""
    if _SETTINGS.DISABLE_JIT:
        return "nothing is compiled here"
    own = {name for name in effects - {IN_ALL_LANES[0]} if EFFECTS[name].guards or EFFECTS[name].states}
    if others := sorted(effects - IN_LANES | own):
        return f"{others[0]} has no lanes"
    lacking = [name for name in IN_ALL_LANES if name not in effects]
    return f"without {lacking[0]} there are no lanes" if lacking else None


@functools.lru_cache(maxsize=64)
def composed(effects: frozenset[str], lanes: bool = False) -> tuple[Composition, Any]:
    """Compose a kernel; its entry knows its place on disk, and is not compiled yet."""
    composition = compose(effects)
    batch = make_batch_in_lanes(composition) if lanes else make_batch(composition)
    if hasattr(batch, "compile"):  # with NUMBA_DISABLE_JIT=1 it is the plain function
        keep_on_disk(batch, _name(composition, lanes))
    return composition, batch


def _name(composition: Composition, lanes: bool) -> tuple[str, ...]:
    return ("in lanes", *composition.effects) if lanes else composition.effects


def is_cached(effects: frozenset[str], *, lanes: bool = False) -> bool:
    """Whether later processes need not compile a kernel: it is cached on disk, or nothing is ever compiled here."""
    batch = composed(effects, lanes)[1]
    return not hasattr(batch, "compile") or on_disk(batch)


def is_compiled(effects: frozenset[str], *, lanes: bool = False) -> bool:
    """Whether a kernel is there without compiling: it is cached, or this process has compiled it."""
    return is_cached(effects, lanes=lanes) or bool(composed(effects, lanes)[1].signatures)


@functools.lru_cache(maxsize=64)
def _kernel(effects: frozenset[str], lanes: bool) -> Kernel:
    composition, batch = composed(effects, lanes)
    started = time.perf_counter()
    if hasattr(batch, "compile"):
        name = _name(composition, lanes)
        give_unique_symbols(name)
        numbers = numba.float64
        with compiling_alone(name):
            batch.compile(
                (numbers[:, ::1], numbers[::1], numbers[:, :, ::1], numba.int64[::1], numbers[:, ::1], numbers[:, ::1])
            )
    return Kernel(composition, batch, time.perf_counter() - started, interpreted=not hasattr(batch, "compile"))
