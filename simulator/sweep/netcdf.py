"""A sweep as a NetCDF-4 file: every variable in one piece, no times in it, so that equal sweeps are equal files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from simulator.sweep.disk import sync
from simulator.sweep.layout import Attributes, Layout
from simulator.sweep.optional import optional
from simulator.sweep.writer import Slices, Values

SUFFIX = ".nc"
_WHAT_FOR = "a .nc file"


class NetcdfWriter:
    """Writes a file block by block."""

    def __init__(self, path: Path, layout: Layout) -> None:
        self._file = optional("netCDF4", _WHAT_FOR).Dataset(path, "w", format="NETCDF4", clobber=True)
        self._path = path
        self._file.set_fill_off()
        for name, length in layout.dims.items():
            self._file.createDimension(name, length)
        self._variables: dict[str, Any] = {}
        for variable in (*layout.coordinates, *layout.outputs):
            made = self._file.createVariable(variable.name, variable.kind, variable.dims, contiguous=True)
            made.set_auto_maskandscale(False)
            made.setncatts(variable.attributes)
            self._variables[variable.name] = made
        self._file.setncatts(layout.attributes)
        for variable in layout.coordinates:
            self._variables[variable.name][:] = variable.values

    def put(self, name: str, slices: Slices, values: Values) -> None:
        """Write a block of a variable."""
        self._variables[name][slices] = values

    def finish(self, attributes: Attributes) -> None:
        """Add the last attributes and close the file, on disk for good."""
        self._file.setncatts(attributes)
        self._file.close()
        sync(self._path)


def netcdf_attributes(path: Path) -> dict[str, Any]:
    """Return the attributes of a NetCDF file; empty where it is none."""
    library = optional("netCDF4", _WHAT_FOR)
    try:
        with library.Dataset(path) as file:
            return {name: file.getncattr(name) for name in file.ncattrs()}
    except OSError:
        return {}
