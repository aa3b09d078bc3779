"""The files that a sweep can be written to, by the end of their names."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from data_schema.errors import UsageError
from simulator.sweep import netcdf, zarr_folder
from simulator.sweep.layout import Layout
from simulator.sweep.optional import optional
from simulator.sweep.writer import Writer


@dataclass(frozen=True, slots=True)
class Format:
    """A file format: what writes it, what reads a file's attributes, and the library that both need."""

    suffix: str
    library: str
    writer: Callable[[Path, Layout], Writer]
    attributes: Callable[[Path], dict[str, Any]]


FORMATS = {
    found.suffix: found
    for found in (
        Format(netcdf.SUFFIX, "netCDF4", netcdf.NetcdfWriter, netcdf.netcdf_attributes),
        Format(zarr_folder.SUFFIX, "zarr", zarr_folder.ZarrWriter, zarr_folder.zarr_attributes),
    )
}


def format_of(out: Path) -> Format:
    """Return the format that a file's name asks for; raises `UsageError` for other names and absent libraries."""
    if out.suffix not in FORMATS:
        raise UsageError(f"--out {out} does not say which format: end it in {' or '.join(FORMATS)}.")
    found = FORMATS[out.suffix]
    optional(found.library, f"a {found.suffix} file")
    return found
