"""What a simulated jump looks like over time, as the trajectory's figure and the animation draw it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ModeSpan:
    """A stretch of time in one contact mode, s; `name` is what the mode is called on this ground."""

    start_s: float
    end_s: float
    mode: str
    name: str


@dataclass(frozen=True, slots=True)
class LegDrawing:
    """Sizes that the animation draws the robot with: links of the five-bar leg from hip to knee and knee to foot, m."""

    upper_link_m: float
    lower_link_m: float
    foot_radius_m: float


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """A simulated motion; arrays of shape (n_samples,), heights above the undisturbed surface, in order of time.

    `leg_force_n` is the force that pushes body and foot apart. `ground_height_m` is where the ground under the foot
    is: pressed down by the foot, or led back up. `marks` are named instants, such as lift-off.
    """

    title: str
    time_s: FloatArray
    body_height_m: FloatArray
    foot_height_m: FloatArray
    leg_force_n: FloatArray
    ground_height_m: FloatArray
    leg: LegDrawing
    spans: tuple[ModeSpan, ...] = ()
    marks: tuple[tuple[str, float], ...] = ()
