"""A sweep as a Zarr folder (format 2, which all readers know), compressed; the blocks of the writing are its chunks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from simulator.sweep.blocks import block_shape
from simulator.sweep.disk import sync
from simulator.sweep.layout import Attributes, Layout, Variable
from simulator.sweep.optional import optional
from simulator.sweep.writer import Slices, Values

SUFFIX = ".zarr"
_WHAT_FOR = "a .zarr folder"
_DIMS = "_ARRAY_DIMENSIONS"
"""Attribute in which xarray keeps the names of an array's dimensions."""


class ZarrWriter:
    """Writes a folder block by block."""

    def __init__(self, path: Path, layout: Layout) -> None:
        self._zarr = optional("zarr", _WHAT_FOR)
        self._path = path
        self._group = self._zarr.create_group(path, zarr_format=2, attributes=_plain(layout.attributes))
        self._arrays = {variable.name: self._array(variable, layout) for variable in layout.outputs}
        for variable in layout.coordinates:
            self._array(variable, layout)[:] = variable.values

    def _array(self, variable: Variable, layout: Layout) -> Any:
        shape = tuple(layout.dims[name] for name in variable.dims)
        return self._group.create_array(
            variable.name,
            shape=shape,
            chunks=block_shape(shape),
            dtype=variable.kind,
            fill_value=None,
            attributes=_plain({**variable.attributes, _DIMS: list(variable.dims)}),
        )

    def put(self, name: str, slices: Slices, values: Values) -> None:
        """Write a block of a variable."""
        self._arrays[name][slices] = values

    def finish(self, attributes: Attributes) -> None:
        """Add the last attributes, gather all metadata in one file, and put everything on disk for good."""
        self._group.attrs.update(_plain(attributes))
        self._zarr.consolidate_metadata(self._path, zarr_format=2)
        for entry in (*self._path.rglob("*"), self._path):
            sync(entry)


def zarr_attributes(path: Path) -> dict[str, Any]:
    """Return the attributes of a Zarr folder; empty where it is none."""
    library = optional("zarr", _WHAT_FOR)
    try:
        return dict(library.open_group(path, mode="r").attrs)
    except (FileNotFoundError, ValueError):
        return {}


def _plain(attributes: dict[str, Any]) -> dict[str, Any]:
    return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in attributes.items()}
