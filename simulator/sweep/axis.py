"""What is swept: a quantity, the values it takes, and the parameter that the simulator reads."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError, unknown_name
from simulator.changes import WORDS
from simulator.declared import all_parameters

Row = NDArray[np.float64]

GAINS = {
    "gain": "extension gain of the leg's controller",
    "damping_gain": "active-damping gain of the leg's controller",
}
"""Words that stand for one parameter each, in other units: `simulator.changes` has their conversion."""


NOT_SWEPT = {
    "flight": "switches effects and cannot be swept: give it with --set, in a sweep of its own for each of soft, held "
    "and massless.",
    "drop_height": "depends on the leg's rest length and cannot be swept: give it with --set, or sweep initial_height, "
    "the foot's height at the start.",
    "jumps": "is a dimension of every result and cannot be swept: give it with --set, and the result holds all jumps "
    "up to that number.",
}
"""Words that stand for no parameter, why that is and what to do instead."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """Something that can be swept; `to_parameter` turns a value of it into one of the parameter read."""

    name: str
    unit: str
    meaning: str
    parameter: str
    to_parameter: Callable[[float], float] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """A quantity with its values, and those of its parameter; both of shape (values,)."""

    quantity: Quantity
    coordinates: Row
    values: Row

    @property
    def name(self) -> str:
        """Name of the quantity."""
        return self.quantity.name

    @property
    def parameter(self) -> str:
        """Name of the parameter that the simulator reads."""
        return self.quantity.parameter


def quantity(name: str, effects: Collection[str]) -> Quantity:
    """Return what a word after --over names, in a scene with these effects; raises `UsageError` for other words."""
    known = all_parameters()
    if name in known:
        return Quantity(name, known[name].unit, known[name].meaning, name)
    if name in GAINS:
        on = frozenset(effects)
        (parameter,) = WORDS[name]("1", on).values

        def to_parameter(number: float) -> float:
            return WORDS[name](repr(float(number)), on).values[parameter]

        return Quantity(name, "1", GAINS[name], parameter, to_parameter)
    if name in NOT_SWEPT:
        raise UsageError(f"{name} {NOT_SWEPT[name]}")
    raise unknown_name("parameter", name, (*known, *GAINS))


def axis(swept: Quantity, coordinates: Row) -> Axis:
    """Return the axis of a quantity at these values."""
    coordinates = np.asarray(coordinates, dtype=np.float64)
    if swept.to_parameter is None:
        return Axis(swept, coordinates, coordinates)
    return Axis(swept, coordinates, np.array([swept.to_parameter(number) for number in coordinates.tolist()]))
