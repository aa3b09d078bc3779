"""Heights of the body while a person holds it: lowering with wobble, catching, lifting back to the clamp.

Closed forms on arrays of seconds since each motion began; each starts and ends at rest, save the catch, which
begins at the speed of the fall.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Wobble:
    """An unsteady hand: two sines that die away towards the end of a motion."""

    amplitude_m: float
    frequency_hz: float
    phase_rad: float

    def height_m(self, time_s: FloatArray, duration_s: float) -> FloatArray:
        """Deviation from the intended height; zero, and at rest, at both ends."""
        share = np.clip(time_s / duration_s, 0, 1)
        # Squared at the end, so that the robot is still when it is let go.
        envelope = 6.75 * share * (1 - share) ** 2 * self.amplitude_m
        angle = 2 * np.pi * self.frequency_hz * time_s + self.phase_rad
        return envelope * np.minimum(share * 8, 1) * (np.sin(angle) + 0.4 * np.sin(2.3 * angle))


def carry_m(time_s: FloatArray, duration_s: float, start_m: float, end_m: float) -> FloatArray:
    """Move between two heights with the least jerk, as a hand does (Flash and Hogan 1985)."""
    share = np.clip(time_s / duration_s, 0, 1)
    return start_m + (end_m - start_m) * share**3 * (10 - 15 * share + 6 * share**2)


def carry_duration_s(distance_m: float, acceleration_m_s2: float) -> float:
    """Time of a move over `distance_m` whose acceleration nowhere exceeds `acceleration_m_s2`, see `carry_m`."""
    return math.sqrt(10 / math.sqrt(3) * distance_m / acceleration_m_s2)


def catch_duration_s(speed_m_s: float, distance_m: float) -> float:
    """Time in which a fall at `speed_m_s` is stopped within `distance_m`, see `catch_m`."""
    return 3 * distance_m / speed_m_s


def catch_m(time_s: FloatArray, start_m: float, speed_m_s: float, distance_m: float) -> FloatArray:
    """Stop a fall: the speed dies quadratically and the body comes to rest `distance_m` lower."""
    left = np.clip(1 - time_s / catch_duration_s(speed_m_s, distance_m), 0, 1)
    return start_m - distance_m * (1 - left**3)
