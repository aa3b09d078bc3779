"""The file of a sweep, NetCDF or Zarr: what it holds, and its writing a block at a time.

No times stand in it, so that equal sweeps are equal files.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError
from simulator.effects.registry import EFFECTS
from simulator.scene_file import write_scene
from simulator.sweep.chunks import simulator_here
from simulator.sweep.compute import optional
from simulator.sweep.outputs import OUTPUTS, REFUSED, Output
from simulator.sweep.sweep import JUMP, Sweep

Identity = Mapping[str, str | float]
Attributes = dict[str, str | float | int | NDArray[np.int8]]
Slices = tuple[slice, ...]
FORMAT = 2
"""Version of how sweeps are stored."""
IDENTITY = "sweep"
"""Attribute with what identifies the sweep, as JSON."""
BLOCK = 65_536
"""Most numbers in a block."""
_NAMED = 3
_FOLLOWING = ("swept values", "text of the scene", "outputs", "chunk")
"""What says nothing to a person, and differs for itself only where nothing readable does."""


def identity_of(sweep: Sweep) -> dict[str, str | float]:
    """Return all that a sweep's numbers depend on, readable; equal for equal commands and simulators."""
    scene, design = sweep.scene, sweep.design
    swept = {
        f"sweep of {axis.name}": (
            f"{len(axis.values)} values from {axis.coordinates.min():.9g} to {axis.coordinates.max():.9g}"
        )
        for axis in design.axes
    }
    return {
        "scene": scene.name,
        "effects": ", ".join(name for name in EFFECTS if name in scene.effects),
        "jumps": scene.jumps,
        **{name: value.value for name, value in scene.values.items()},
        "accuracy": sweep.accuracy,
        "sampling": design.description,
        **swept,
        "swept values": design.content_hash()[:20],
        "text of the scene": hashlib.sha256(write_scene(scene).encode()).hexdigest()[:20],
        "chunk": sweep.chunks.rows_each,
        "outputs": hashlib.sha256(" ".join(output.name for output in OUTPUTS).encode()).hexdigest()[:20],
        "simulator": simulator_here(),
        "labbook": sweep.labbook,
        "format": FORMAT,
    }


def differences(there: Identity, now: Identity) -> str:
    """Return in words what differs, the first few things; empty where nothing does."""
    names = [name for name in dict.fromkeys((*now, *there)) if there.get(name) != now.get(name)]
    readable = [name for name in names if name not in _FOLLOWING]
    said = [f"{name} ({_shown(there.get(name))} there, {_shown(now.get(name))} now)" for name in readable[:_NAMED]]
    return " and ".join(said or names)


def _shown(value: str | float | None) -> str:
    if value is None:
        return "none"
    return f"{value:.9g}" if isinstance(value, float) else str(value)


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
    variables: tuple[Variable, ...]
    attributes: Attributes = field(default_factory=dict)


def layout_of(sweep: Sweep, identity: Identity) -> Layout:
    """Return what the file of a sweep holds."""
    dims, coordinates = tuple(sweep.dims), tuple(_coordinates(sweep))
    beside = " ".join(coordinate.name for coordinate in coordinates if coordinate.name not in dims)
    shared: Attributes = {"coordinates": beside} if beside else {}
    outputs = (Variable(output.name, output.kind, dims, {**_about(output), **shared}) for output in OUTPUTS)
    return Layout(sweep.dims, (*coordinates, *outputs), _attributes(sweep, identity))


def _coordinates(sweep: Sweep) -> Iterator[Variable]:
    for axis in sweep.design.axes:
        dims = (sweep.design.dim_of(axis),)
        about: Attributes = {"units": axis.quantity.unit, "long_name": axis.quantity.meaning}
        yield Variable(axis.name, "f8", dims, about, axis.coordinates)
        if axis.parameter != axis.name:
            about = {"units": "1", "long_name": f"{axis.parameter} that {axis.name} stands for, SI"}
            yield Variable(axis.parameter, "f8", dims, about, axis.values)
    if JUMP in sweep.dims:
        numbers = np.arange(1, sweep.scene.jumps + 1)
        yield Variable(JUMP, "i4", (JUMP,), {"units": "1", "long_name": "number of the jump, from 1"}, numbers)


def _about(output: Output) -> Attributes:
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


def block_shape(shape: Sequence[int]) -> tuple[int, ...]:
    """Return the shape of the blocks: whole in the last dimensions, a part of one, 1 in those before."""
    for place in range(len(shape)):
        rest = math.prod(shape[place + 1 :])
        if rest <= BLOCK:
            return (*[1] * place, min(shape[place], BLOCK // rest), *shape[place + 1 :])
    return ()


def blocks(shape: Sequence[int]) -> Iterator[tuple[Slices, int, int]]:
    """Yield the blocks of an array, rectangles that are also in one piece in its row-major order.

    Each as slices, and as its first number and the one after its last in that order.
    """
    each = block_shape(shape)
    starts = [range(0, length, step) for length, step in zip(shape, each, strict=True)]
    first = 0
    for corner in itertools.product(*starts):
        slices = tuple(
            slice(begin, min(begin + step, length)) for begin, step, length in zip(corner, each, shape, strict=True)
        )
        after = first + math.prod(part.stop - part.start for part in slices)
        yield slices, first, after
        first = after


class SweepFile(ABC):
    """A sweep's file in one of the formats, being written."""

    library: ClassVar[str]
    """What reads and writes the format."""
    variables: dict[str, Any]
    """What blocks are assigned to, by name."""

    @abstractmethod
    def __init__(self, path: Path, layout: Layout) -> None: ...

    def put(self, name: str, slices: Slices, values: NDArray[Any]) -> None:
        """Write a block of a variable."""
        self.variables[name][slices] = values

    @abstractmethod
    def finish(self, attributes: Attributes) -> None:
        """Add the last attributes and close the file, on disk for good."""

    @staticmethod
    @abstractmethod
    def attributes(path: Path) -> dict[str, Any]:
        """Return the attributes of a file; empty where it is none of this format."""


class Netcdf(SweepFile):
    """A NetCDF-4 file, every variable in one piece."""

    library = "netCDF4"

    def __init__(self, path: Path, layout: Layout) -> None:
        self._path = path
        self._file = optional(self.library, "a .nc file").Dataset(path, "w", format="NETCDF4", clobber=True)
        self._file.set_fill_off()
        for name, length in layout.dims.items():
            self._file.createDimension(name, length)
        self.variables = {}
        for variable in layout.variables:
            made = self._file.createVariable(variable.name, variable.kind, variable.dims, contiguous=True)
            made.set_auto_maskandscale(False)
            made.setncatts(variable.attributes)
            self.variables[variable.name] = made
        self._file.setncatts(layout.attributes)
        for variable in layout.variables:
            if variable.values is not None:
                self.variables[variable.name][:] = variable.values

    def finish(self, attributes: Attributes) -> None:
        """Add the last attributes and close the file."""
        self._file.setncatts(attributes)
        self._file.close()
        sync(self._path)

    @staticmethod
    def attributes(path: Path) -> dict[str, Any]:
        """Return the attributes of a NetCDF file; empty where it is none."""
        try:
            with optional("netCDF4", "a .nc file").Dataset(path) as file:
                return {name: file.getncattr(name) for name in file.ncattrs()}
        except OSError:
            return {}


class Zarr(SweepFile):
    """A Zarr folder (format 2, which all readers know), compressed; the blocks of the writing are its chunks."""

    library = "zarr"

    def __init__(self, path: Path, layout: Layout) -> None:
        self._path, self._zarr = path, optional(self.library, "a .zarr folder")
        self._group = self._zarr.create_group(path, zarr_format=2, attributes=_plain(layout.attributes))
        self.variables = {}
        for variable in layout.variables:
            shape = tuple(layout.dims[name] for name in variable.dims)
            dims = {"_ARRAY_DIMENSIONS": list(variable.dims)}  # where xarray keeps their names
            self.variables[variable.name] = self._group.create_array(
                variable.name,
                shape=shape,
                chunks=block_shape(shape),
                dtype=variable.kind,
                fill_value=None,
                attributes=_plain({**variable.attributes}) | dims,
            )
            if variable.values is not None:
                self.variables[variable.name][:] = variable.values

    def finish(self, attributes: Attributes) -> None:
        """Add the last attributes, gather all metadata in one file, and put everything on disk for good."""
        self._group.attrs.update(_plain(attributes))
        self._zarr.consolidate_metadata(self._path, zarr_format=2)
        for entry in (*self._path.rglob("*"), self._path):
            sync(entry)

    @staticmethod
    def attributes(path: Path) -> dict[str, Any]:
        """Return the attributes of a Zarr folder; empty where it is none."""
        try:
            return dict(optional("zarr", "a .zarr folder").open_group(path, mode="r").attrs)
        except (FileNotFoundError, ValueError):
            return {}


FORMATS: dict[str, type[SweepFile]] = {".nc": Netcdf, ".zarr": Zarr}
"""By the end of a file's name."""


def format_of(out: Path) -> type[SweepFile]:
    """Return the format that a file's name asks for; raises `UsageError` for other names and absent libraries."""
    if out.suffix not in FORMATS:
        raise UsageError(f"--out {out} does not say which format: end it in {' or '.join(FORMATS)}.")
    optional(FORMATS[out.suffix].library, f"a {out.suffix} file")
    return FORMATS[out.suffix]


def sync(path: Path) -> None:
    """Make a file's content, or the names in a folder, survive a power cut."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _plain(attributes: Attributes) -> dict[str, Any]:
    return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in attributes.items()}
