"""All parameters that scenes can have, and which effects read each."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping

from simulator.effects.registry import EFFECTS
from simulator.parameter import BASICS, Parameter

GROUNDS = ("hydrostatic_stiffness", "rigid_ground", "emulated_ground")
"""The effects that are a ground; every scene has exactly one."""


@functools.cache
def all_parameters() -> Mapping[str, Parameter]:
    """Return every parameter by name: those of every scene first, then the effects' in the registry's order.

    Raises `ValueError` where an effect declares the name of another parameter.
    """
    found = {parameter.name: parameter for parameter in BASICS}
    for effect in EFFECTS.values():
        for parameter in effect.parameters:
            if found.setdefault(parameter.name, parameter) != parameter:
                raise ValueError(
                    f"{effect.name} declares {parameter.name}, which there is already: choose another name"
                )
    return found


def parameters_read(effects: Iterable[str]) -> dict[str, Parameter]:
    """Return the parameters, by name, that a scene with these effects reads."""
    on = frozenset(effects)
    read = {parameter.name for parameter in BASICS}
    read |= {parameter.name for name in on for parameter in EFFECTS[name].parameters}
    return {name: parameter for name, parameter in all_parameters().items() if name in read}


def readers(name: str) -> tuple[str, ...]:
    """Return the effects that read a parameter; none for a parameter of every scene."""
    return tuple(effect.name for effect in EFFECTS.values() if name in {item.name for item in effect.parameters})
