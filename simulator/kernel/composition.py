"""From the effects that are on to what a kernel is composed of: the row of parameters and the functions of its
slots.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simulator.basics import BASICS
from simulator.compiled import inner
from simulator.effects.effect import Effect, Function
from simulator.effects.registry import EFFECTS
from simulator.kernel.layout import (
    MECHANICAL,
    PARAMETERS,
)
from simulator.parameter import Parameter


@dataclass(frozen=True, slots=True)
class Composition:
    """What a kernel is built from. `position` holds the place of each parameter in the row, declared ones first."""

    effects: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    position: Mapping[str, int]
    slots: Mapping[str, Function]
    prepare: Function
    integrals: Mapping[str, int]
    """Place in the state of each integral that only some effects call for."""

    def has(self, slot: str) -> bool:
        """Whether an effect that is on fills this slot."""
        return slot in self.slots

    def slot(self, name: str) -> Any:
        """The function that fills a slot; None where no effect does, for code that `has` keeps from being compiled."""
        return self.slots.get(name)

    def on(self, effect: str) -> bool:
        """Whether this effect is on."""
        return effect in self.effects

    @property
    def row_size(self) -> int:
        """Length of the row that the kernel works in; parameters are the last of it."""
        return PARAMETERS + len(self.position)

    @property
    def state_size(self) -> int:
        """Number of states: motion and integrals."""
        return MECHANICAL + 1 + len(self.integrals)


_INTEGRALS = {
    "ground_loss": "resistance_n",
    "grain_energy": "added_mass_kg",
    "heat": "heat_w",
    "drag": "drag_w",
    "friction_loss": "rail_friction_n",
    "reset_work": "travel_m",
}
"""Integrals, each with the slot that calls for it."""


_INVERSES = {"body_mass": "inverse_body_mass", "foot_mass": "inverse_foot_mass"}
"""Derived in every scene: the equations of motion multiply, which takes a fifth of the time of a division."""


def _prepare_inverses(position: Mapping[str, int]) -> Function:
    body, foot = position["body_mass"], position["foot_mass"]
    inverse_body, inverse_foot = position["inverse_body_mass"], position["inverse_foot_mass"]

    @inner
    def prepare(work: NDArray[np.float64]) -> None:
        work[inverse_body] = 1.0 / work[body]
        work[inverse_foot] = 1.0 / work[foot]

    return prepare


def _after(first: Function, second: Function) -> Function:
    @inner
    def both(work: NDArray[np.float64]) -> None:
        first(work)
        second(work)

    return both


def compose(effects: Iterable[str]) -> Composition:
    """Compose what is called for; the order in which effects are named does not matter."""
    chosen: tuple[Effect, ...] = tuple(EFFECTS[name] for name in EFFECTS if name in set(effects))
    parameters = tuple(dict.fromkeys((*BASICS, *(parameter for effect in chosen for parameter in effect.parameters))))
    names = [parameter.name for parameter in parameters] + [*_INVERSES.values()]
    names += [name for effect in chosen for name in effect.derived]
    position = {name: PARAMETERS + place for place, name in enumerate(names)}
    slots: dict[str, Function] = {}
    prepare = _prepare_inverses(position)
    for effect in chosen:
        functions = dict(effect.functions(position.__getitem__))
        if "prepare" in functions:
            prepare = _after(prepare, functions.pop("prepare"))
        slots |= functions
    wanted = [name for name, slot in _INTEGRALS.items() if slot in slots]
    return Composition(
        effects=tuple(effect.name for effect in chosen),
        parameters=parameters,
        position=position,
        slots=slots,
        prepare=prepare,
        integrals={name: MECHANICAL + 1 + place for place, name in enumerate(wanted)},
    )
