"""The file of a sweep, NetCDF or Zarr: what it holds, and its writing, one output after the other.

No times stand in it, so that equal sweeps are equal files.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError
from simulator.effects.registry import EFFECTS
from simulator.scene_file import write_scene
from simulator.sweep.compute import optional
from simulator.sweep.identity import Identity
from simulator.sweep.outputs import REFUSED, Output
from simulator.sweep.parts import Parts, sync
from simulator.sweep.sweep import JUMP, Sweep

Attributes = dict[str, str | float | int | NDArray[np.int8]]
IDENTITY = "sweep"
"""Attribute with what identifies the sweep, as JSON."""
BLOCK = 65_536
"""Most numbers in a block."""


@dataclass(frozen=True, slots=True, eq=False)
class Variable:
    """A variable of the file; its values are read when they are written, so that those of one are in memory."""

    name: str
    dims: tuple[str, ...]
    attributes: Attributes
    values: Callable[[], NDArray[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Content:
    """All that a file holds."""

    dims: Mapping[str, int]
    variables: tuple[Variable, ...]
    attributes: Attributes


def content_of(sweep: Sweep, identity: Identity, parts: Parts, counts: Mapping[str, str | int]) -> Content:
    """Return what the file of a sweep holds, whose chunks are all done; `counts` are further attributes."""
    dims, coordinates = tuple(sweep.dims), tuple(_coordinates(sweep))
    beside = " ".join(coordinate.name for coordinate in coordinates if coordinate.name not in dims)
    shared: Attributes = {"coordinates": beside} if beside else {}
    outputs = (
        Variable(output.name, dims, {**_about(output), **shared}, partial(_numbers, sweep, parts, place))
        for place, output in enumerate(sweep.outputs)
    )
    return Content(sweep.dims, (*coordinates, *outputs), {**_attributes(sweep, identity), **counts})


def _numbers(sweep: Sweep, parts: Parts, place: int) -> NDArray[Any]:
    return parts.column(place).astype(sweep.outputs[place].kind).reshape(tuple(sweep.dims.values()))


def _coordinates(sweep: Sweep) -> Iterator[Variable]:
    for axis in sweep.design.axes:
        dims = (sweep.design.dim_of(axis),)
        about: Attributes = {"units": axis.quantity.unit, "long_name": axis.quantity.meaning}
        yield Variable(axis.name, dims, about, partial(np.asarray, axis.coordinates))
        if axis.parameter != axis.name:
            about = {"units": "1", "long_name": f"{axis.parameter} that {axis.name} stands for, SI"}
            yield Variable(axis.parameter, dims, about, partial(np.asarray, axis.values))
    if JUMP in sweep.dims:
        about = {"units": "1", "long_name": "number of the jump, from 1"}
        yield Variable(JUMP, (JUMP,), about, partial(np.arange, 1, sweep.scene.jumps + 1, dtype=np.int32))


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
        **({"error_bars": sweep.error_bars} if sweep.error_bars else {}),
        "sampling": sweep.design.description,
        "assumed": json.dumps({name: scene.values[name].why for name in sweep.assumed}, ensure_ascii=False),
        "set_by_user": json.dumps({name: scene[name] for name in scene.set_by_user}),
        **({REFUSED: sweep.refused} if sweep.refused else {}),
        "simulator_fingerprint": identity["simulator"],
        "labbook_version": sweep.labbook,
        IDENTITY: json.dumps(dict(identity), ensure_ascii=False),
    }


def block_shape(shape: Sequence[int]) -> tuple[int, ...]:
    """Return the shape of a Zarr folder's blocks: whole in the last dimensions, a part of one, 1 in those before."""
    for place in range(len(shape)):
        rest = math.prod(shape[place + 1 :])
        if rest <= BLOCK:
            return (*[1] * place, min(shape[place], BLOCK // rest), *shape[place + 1 :])
    return ()


def _write_netcdf(content: Content, path: Path) -> None:
    """Write a NetCDF-4 file, every variable in one piece."""
    with optional("netCDF4", "a .nc file").Dataset(path, "w", format="NETCDF4", clobber=True) as file:
        file.set_fill_off()
        for name, length in content.dims.items():
            file.createDimension(name, length)
        for variable in content.variables:
            values = variable.values()
            made = file.createVariable(variable.name, values.dtype, variable.dims, contiguous=True)
            made.set_auto_maskandscale(False)
            made.setncatts(variable.attributes)
            made[:] = values
        file.setncatts(content.attributes)


def _netcdf_attributes(path: Path) -> dict[str, Any]:
    """Return the attributes of a NetCDF file; empty where it is none."""
    try:
        with optional("netCDF4", "a .nc file").Dataset(path) as file:
            return {name: file.getncattr(name) for name in file.ncattrs()}
    except OSError:
        return {}


def _write_zarr(content: Content, path: Path) -> None:
    """Write a Zarr folder (format 2, which all readers know), compressed, all metadata gathered in one file."""
    zarr = optional("zarr", "a .zarr folder")
    group = zarr.create_group(path, zarr_format=2, attributes=_plain(content.attributes))
    for variable in content.variables:
        values = variable.values()
        group.create_array(
            variable.name,
            data=values,
            chunks=block_shape(values.shape),
            fill_value=None,
            attributes=_plain(variable.attributes) | {"_ARRAY_DIMENSIONS": list(variable.dims)},  # as xarray has it
        )
    zarr.consolidate_metadata(path, zarr_format=2)


def _zarr_attributes(path: Path) -> dict[str, Any]:
    """Return the attributes of a Zarr folder; empty where it is none."""
    try:
        return dict(optional("zarr", "a .zarr folder").open_group(path, mode="r").attrs)
    except (FileNotFoundError, ValueError):
        return {}


@dataclass(frozen=True, slots=True)
class Format:
    """A format of a sweep's file: the library that knows it, what writes a file and what gives one's attributes."""

    library: str
    write_content: Callable[[Content, Path], None]
    attributes: Callable[[Path], dict[str, Any]]

    def write(self, content: Content, path: Path) -> None:
        """Write a file, on disk for good."""
        self.write_content(content, path)
        for entry in (*path.rglob("*"), path):
            sync(entry)


FORMATS = {
    ".nc": Format("netCDF4", _write_netcdf, _netcdf_attributes),
    ".zarr": Format("zarr", _write_zarr, _zarr_attributes),
}
"""By the end of a file's name."""


def format_of(out: Path) -> Format:
    """Return the format that a file's name asks for; raises `UsageError` for other names and absent libraries."""
    if out.suffix not in FORMATS:
        raise UsageError(f"--out {out} does not say which format: end it in {' or '.join(FORMATS)}.")
    found = FORMATS[out.suffix]
    optional(found.library, f"a {out.suffix} file")
    return found


def _plain(attributes: Attributes) -> dict[str, Any]:
    return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in attributes.items()}
