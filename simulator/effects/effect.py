"""What an effect is: one piece of physics, declared as data, and the compiled functions it gives the kernel."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from simulator.parameter import Parameter

Function = Callable[..., Any]
"""A function of numbers and arrays that numba can compile (see `simulator.compiled`)."""


ParameterIndex = Callable[[str], int]
"""Where a parameter, declared or derived, of an effect that is on stands in the row that a kernel works in."""


def no_functions(at: ParameterIndex) -> dict[str, Function]:
    """Give the kernel nothing: the effect is a choice that another part reads."""
    return {}


@dataclass(frozen=True, slots=True)
class Effect:
    """One piece of physics.

    `needs`: alternatives, each a tuple of effects of which at least one must be on. `excludes`: effects that cannot be
    on together with it, each with the sentence that says why and what to change. `publishes`: outputs it computes,
    which read 0 while it is off. `derived`: names of numbers that `functions(at)["prepare"]` computes once a jump from
    the parameters. `functions` fills slots of the kernel: `Composition.slots` by name.
    """

    name: str
    meaning: str
    source: str
    parameters: tuple[Parameter, ...] = ()
    needs: tuple[tuple[str, ...], ...] = ()
    excludes: dict[str, str] = field(default_factory=dict)
    publishes: tuple[str, ...] = ()
    derived: tuple[str, ...] = ()
    functions: Callable[[ParameterIndex], dict[str, Function]] = no_functions
