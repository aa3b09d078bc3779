"""The calibration of a sensor: the straight line from its raw numbers to what it measures, and how far that errs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from data_schema.errors import InputRefused


@dataclass(frozen=True, slots=True)
class Calibration:
    """The line `value = scale * raw + offset`.

    `errors` are independent standard errors of the value, each a line in the raw number: (slope, intercept); they have
    `df` degrees of freedom, None where a person states them. `source` says how the line was found. It holds for logs
    from the local date `first_day` to `last_day`; None: without a bound.
    """

    scale: float = 1.0
    offset: float = 0.0
    errors: tuple[tuple[float, float], ...] = ()
    df: int | None = None
    source: str | None = None
    first_day: str | None = None
    last_day: str | None = None

    @property
    def period(self) -> str:
        """The days on which it holds, in words."""
        first, last = self.first_day, self.last_day
        return " ".join([*([f"from {first}"] if first else []), *([f"until {last}"] if last else [])]) or "always"

    def holds_on(self, day: str) -> bool:
        """Return whether it holds on a local date."""
        return (self.first_day or day) <= day <= (self.last_day or day)

    def sentence(self, column: str, channel: str, unit: str | None) -> str:
        """Return the line in words, its values in `unit`."""
        of = f" {unit}" if unit and unit != "1" else ""
        level = math.hypot(*(intercept for slope, intercept in self.errors if not slope))
        slope = math.hypot(*(slope for slope, _ in self.errors))
        shift = f"{'-' if self.offset < 0 else '+'} {abs(self.offset):.6g}{of}"
        ses = [*([f"{level:.2g}{of}"] if level else []), *([f"{slope:.2g}{of} of the slope"] if slope else [])]
        errors = f"standard error {' and '.join(ses)}" if ses else "without a standard error"
        source = self.source or "no source given: assumed"
        slope_part = column if self.scale == 1.0 else f"{self.scale:.6g}{of} x {column}"
        return f"{channel} = {slope_part} {shift} ({errors}; {source})"


def line_through(raw: Sequence[float], value: Sequence[float], value_se: float | None = None) -> Calibration:
    """Fit a line by least squares to what a sensor showed at known values.

    `raw` and `value` have shape (n,), n >= 2. `value_se` is the standard error of each known value; without it the
    scatter about the line is taken where there are three points or more, and two points have no standard error.
    Raises `InputRefused` for fewer points, other lengths, and raw numbers that are all equal.
    """
    n = len(raw)
    if n != len(value) or n < 2:
        raise InputRefused(f"there are {n} raw and {len(value)} known values: give two points or more.")
    raw_mean, value_mean = math.fsum(raw) / n, math.fsum(value) / n
    spread = math.fsum((one - raw_mean) ** 2 for one in raw)
    if not spread > 0:
        raise InputRefused(f"the raw values are all {raw[0]:g}: give points at different values.")
    scale = math.fsum((one - raw_mean) * (known - value_mean) for one, known in zip(raw, value, strict=True)) / spread
    if not scale:
        raise InputRefused(f"the known values are all {value[0]:g}: give points at different values.")
    offset = value_mean - scale * raw_mean
    df = None
    if value_se is None and n > 2:
        df = n - 2
        left = (known - scale * one - offset for one, known in zip(raw, value, strict=True))
        value_se = math.sqrt(math.fsum(each**2 for each in left) / df)
    if not value_se:
        return Calibration(scale, offset)
    slope_se = value_se / math.sqrt(spread)
    return Calibration(scale, offset, ((0.0, value_se / math.sqrt(n)), (slope_se, -slope_se * raw_mean)), df)
