"""What every file format of a sweep can do: take blocks of variables one after the other, then close."""

from __future__ import annotations

from typing import Any, Protocol

from numpy.typing import NDArray

from simulator.sweep.layout import Attributes

Slices = tuple[slice, ...]
Values = NDArray[Any]


class Writer(Protocol):
    """A file being written."""

    def put(self, name: str, slices: Slices, values: Values) -> None:
        """Write a block of a variable."""
        ...

    def finish(self, attributes: Attributes) -> None:
        """Add the last attributes and close the file, on disk for good."""
        ...
