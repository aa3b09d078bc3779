"""What the file of a sweep holds, whatever its format: dimensions, coordinates, variables and attributes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from simulator.effects.registry import EFFECTS
from simulator.scene_file import write_scene
from simulator.sweep.axis import Quantity
from simulator.sweep.identity import Identity
from simulator.sweep.outputs import OUTPUTS, REFUSED, Output
from simulator.sweep.sweep import JUMP, Sweep

IDENTITY = "sweep"
"""Attribute with what identifies the sweep, as JSON."""
Attributes = dict[str, str | float | int | NDArray[np.int8]]


@dataclass(frozen=True, slots=True, eq=False)
class Variable:
    """A variable of the file; `values` of a coordinate are known beforehand."""

    name: str
    kind: str
    dims: tuple[str, ...]
    attributes: Attributes
    values: NDArray[np.float64] | NDArray[np.int64] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """A file's content but for the numbers that are simulated."""

    dims: Mapping[str, int]
    coordinates: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    attributes: Attributes = field(default_factory=dict)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return tuple(self.dims.values())


def layout_of(sweep: Sweep, identity: Identity) -> Layout:
    """Return what the file of a sweep holds."""
    dims, coordinates = tuple(sweep.dims), _coordinates(sweep)
    beside = " ".join(coordinate.name for coordinate in coordinates if coordinate.name not in dims)
    shared: Attributes = {"coordinates": beside} if beside else {}
    return Layout(
        dims=sweep.dims,
        coordinates=tuple(coordinates),
        outputs=tuple(
            Variable(output.name, output.kind, dims, {**_output_attributes(output), **shared}) for output in OUTPUTS
        ),
        attributes=_attributes(sweep, identity),
    )


def _coordinates(sweep: Sweep) -> list[Variable]:
    found = []
    for axis in sweep.design.axes:
        dims = (sweep.design.dim_of(axis),)
        found.append(Variable(axis.name, "f8", dims, _quantity_attributes(axis.quantity), axis.coordinates))
        if axis.parameter != axis.name:
            attributes: Attributes = {"units": "1", "long_name": f"{axis.parameter} that {axis.name} stands for, SI"}
            found.append(Variable(axis.parameter, "f8", dims, attributes, axis.values))
    if JUMP in sweep.dims:
        numbers = np.arange(1, sweep.scene.jumps + 1)
        found.append(Variable(JUMP, "i4", (JUMP,), {"units": "1", "long_name": "number of the jump, from 1"}, numbers))
    return found


def _quantity_attributes(quantity: Quantity) -> Attributes:
    return {"units": quantity.unit, "long_name": quantity.meaning}


def _output_attributes(output: Output) -> Attributes:
    attributes: Attributes = {"units": output.unit, "long_name": output.meaning}
    if output.flags:
        attributes["flag_values"] = np.array([value for value, _ in output.flags], np.int8)
        attributes["flag_meanings"] = " ".join(meaning for _, meaning in output.flags)
    return attributes


def _attributes(sweep: Sweep, identity: Identity) -> Attributes:
    scene = sweep.scene
    swept = ", ".join(axis.name for axis in sweep.design.axes)
    return {
        "title": f"{scene.title}: sweep of {swept}",
        "scene": scene.name,
        "scene_toml": write_scene(scene),
        "comment": f"The scene holds what was not swept; {swept} stand in the coordinates. Numbers are in SI units.",
        "effects": " ".join(name for name in EFFECTS if name in scene.effects),
        "accuracy": sweep.accuracy,
        "sampling": sweep.design.description,
        "assumed": json.dumps({name: scene.values[name].why for name in sweep.assumed}, ensure_ascii=False),
        "set_by_user": json.dumps({name: scene[name] for name in scene.set_by_user}),
        **({REFUSED: sweep.refused} if sweep.refused else {}),
        "simulator_fingerprint": identity["simulator"],
        "labbook_version": sweep.labbook,
        IDENTITY: json.dumps(dict(identity), ensure_ascii=False),
    }
