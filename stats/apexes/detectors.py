"""Jumps and apexes of a height log: the detectors by name, and the one function that runs them.

A detector proposes; which jumps count is the protocol's and a person's decision. Two are known: "published", the
thesis's rule (4.3.3), and "robust", which states a standard error for every apex and has no smoothing bias.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused, unknown_name
from stats.apexes.cleaning import Floats, check_log, gaps_in_time, sampling_interval
from stats.apexes.jumps import FLAGS, Jump, Jumps
from stats.apexes.published import PublishedParameters, published_jumps, smoothing_bias_m
from stats.apexes.robust import RobustParameters, robust_jumps
from stats.checks import as_number

__all__ = [
    "DETECTORS",
    "FLAGS",
    "Detector",
    "Jump",
    "Jumps",
    "PublishedParameters",
    "RobustParameters",
    "find_jumps",
]

Parameters = PublishedParameters | RobustParameters
"""Frozen dataclasses of plain numbers, nested; `dataclasses.asdict` makes them JSON."""


@dataclass(frozen=True, slots=True)
class Detector:
    """One way to find jumps; its version changes whenever its results may."""

    name: str
    version: int
    function: Callable[..., tuple[Jump, ...]]
    """(time_s, body_height_m, leg_length_m or None, gaps, rest_length_m, parameters) -> jumps."""
    parameters: Parameters
    """The defaults."""


DETECTORS: dict[str, Detector] = {
    detector.name: detector
    for detector in (
        Detector("published", 3, published_jumps, PublishedParameters()),
        Detector("robust", 3, robust_jumps, RobustParameters()),
    )
}
"""All detectors by name."""


def find_jumps(
    time_s: ArrayLike,
    body_height_m: ArrayLike,
    *,
    rest_length_m: float,
    leg_length_m: ArrayLike | None = None,
    gaps: ArrayLike | None = None,
    detector: str = "robust",
    parameters: Parameters | None = None,
) -> Jumps:
    """Return the jumps of one log, one for each stance.

    `time_s`, `body_height_m` (above the undisturbed ground) and the optional `leg_length_m` have shape (n,); a
    height may be NaN where nothing was measured. `gaps` has shape (n_gaps, 2), rows (start_s, length_s); without
    it, steps in time of more than 1.5 intervals are the gaps. `rest_length_m` is the leg's neutral length.
    Raises `UnknownName` for another detector, `InputRefused` for arrays that do not fit together, time that does not
    increase, or parameters of the other detector.
    """
    chosen = DETECTORS.get(detector)
    if chosen is None:
        raise unknown_name("detector", detector, DETECTORS)
    settings = chosen.parameters if parameters is None else parameters
    if type(settings) is not type(chosen.parameters):
        raise InputRefused(
            f"the detector {detector!r} was given {type(settings).__name__}: "
            f"give {type(chosen.parameters).__name__} or leave them out."
        )
    rest_length_m = as_number("the rest length", rest_length_m, above=0.0)
    time, height = np.asarray(time_s, dtype=np.float64), np.asarray(body_height_m, dtype=np.float64)
    leg: Floats | None = None if leg_length_m is None else np.asarray(leg_length_m, dtype=np.float64)
    missing = np.empty((0, 2)) if gaps is None else np.asarray(gaps, dtype=np.float64).reshape(-1, 2)
    check_log(time, height, leg, missing)
    if gaps is None:
        missing = gaps_in_time(time)
    found: tuple[Jump, ...] = ()
    if time.size:
        found = chosen.function(time, height, leg, missing, rest_length_m, settings)
    return Jumps(
        detector=chosen.name,
        version=chosen.version,
        parameters=settings,
        smoothing_bias_m=smoothing_bias_m(
            settings.smoothed_samples, sampling_interval(time), settings.stance.gravity_m_s2
        ),
        jumps=found,
    )
