"""The orders in which dates and clock times are written."""

from __future__ import annotations

DATE_FORMATS = ("y-m-d", "d.m.y", "d/m/y", "m/d/y")
"""Orders of year, month and day; the signs between them may be any of `-`, `.` and `/`."""

CLOCK_FORMATS = ("h:m:s", "h:m", "m:s")
"""What the parts of a clock time are; the last one may have decimals."""
