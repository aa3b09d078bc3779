"""What a detector says about a log: one `Jump` a stance, in order, and how it was found.

A stance without a flight (a misfire) is a jump without an apex, so that jumps can be counted against jumps made.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.vocabulary import Undefined


@dataclass(frozen=True, slots=True)
class Jump:
    """One stance and, where there was one, the flight that followed it.

    Times are in seconds on the log's own time axis. A number that does not exist is `Undefined` with the reason;
    the height and its reason exclude each other.
    """

    number: int
    """1 for the first stance of the log."""
    touchdown_s: float | Undefined
    """The foot met the ground: the foot's height, or without a leg length the body's over the rest length, is 0."""
    liftoff_s: float | Undefined
    """The leg reached its flight length again or, without a leg length, the body began to fly a parabola."""
    apex_s: float | Undefined
    """When the body was highest."""
    apex_height_m: float | Undefined
    """Height of the body at the apex, above the undisturbed ground."""
    apex_height_se_m: float | Undefined
    """Standard error of that height from the scatter of the samples."""
    flight_time_s: float | Undefined
    """Lift-off to landing; flagged where the landing had to be read off the parabola."""
    samples_used: int
    """Samples that the apex rests on; 0 without an apex."""
    curvature_m_s2: float | Undefined
    """Downward acceleration fitted around the apex: a self-check, near the gravity that acts on the robot."""
    gap_touched: bool
    """Whether samples are missing from shortly before lift-off to shortly after landing, or to the catch."""
    flags: tuple[str, ...]
    """What a person should know about this jump; the words are `stats.apexes.jumps.FLAGS`."""

    @property
    def undefined_reason(self) -> str | None:
        """Why there is no apex height, or None where there is one."""
        return self.apex_height_m.reason if isinstance(self.apex_height_m, Undefined) else None


FLAGS: dict[str, str] = {
    "landing_extrapolated": "the landing was not seen (caught by hand); read off the parabola",
    "few_samples_before": "few valid samples between lift-off and apex",
    "few_samples_after": "few valid samples between apex and landing or catch",
    "caught_early": "the body left the parabola soon after the apex; the samples from there on are not used",
    "curvature_off": "the fitted acceleration is more than a tenth away from gravity",
}
"""Flags a jump can carry, and what they mean."""


@dataclass(frozen=True, slots=True)
class Jumps:
    """All jumps of one log as one detector found them."""

    detector: str
    """Name in `stats.apexes.detectors.DETECTORS`."""
    version: int
    """Version of that detector's algorithm."""
    parameters: object
    """The parameters used: the detector's own frozen dataclass of plain numbers."""
    smoothing_bias_m: float
    """By how much the heights lie too low on average because of smoothing; 0 where nothing is smoothed."""
    jumps: tuple[Jump, ...]
    """In order of time."""

    @property
    def with_apex(self) -> tuple[Jump, ...]:
        """The jumps that have an apex height."""
        return tuple(jump for jump in self.jumps if not isinstance(jump.apex_height_m, Undefined))

    @property
    def apex_heights_m(self) -> NDArray[np.float64]:
        """Apex heights of the jumps that have one, in order, metres."""
        return defined(jump.apex_height_m for jump in self.jumps)

    @property
    def apex_times_s(self) -> NDArray[np.float64]:
        """Apex times of the jumps that have one, in order, seconds."""
        return defined(jump.apex_s for jump in self.with_apex)


def defined(values: Iterable[float | Undefined]) -> NDArray[np.float64]:
    """Return the values that exist, in order, as an array of shape (n_defined,)."""
    return np.array([value for value in values if not isinstance(value, Undefined)], dtype=np.float64)
