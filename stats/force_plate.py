"""Contacts of a hopping robot in the vertical force of a plate: their times, peaks and impulses, and what follows.

The plate's zero is taken from the flights, where nothing stands on it, and followed as it drifts. Weight and take-off
speeds follow from the forces alone, by impulse and momentum (Linthorne 2001, Am. J. Phys. 69, 1198), so that neither
the robot's mass nor the heights of its body have to be known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.reasons import Reason
from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import Undefined
from stats.compare.summary import describe
from stats.scatter import Floats, Value

SHORTEST_S = 0.02
"""A shorter contact is a knock on the plate, a shorter flight a contact's own vibration."""
LONGEST_FLIGHT_S = 1.2
"""After a longer one the robot was off the plate: such a flight would be 1.8 m high."""
FEWEST_CYCLES = 3
"""Fewer do not determine the weight: over one cycle the speed at its ends counts for as much."""
_FIRST_THRESHOLD = 0.15
"""Share of the largest force that separates loaded from empty before the noise is known."""
_NOISE_SDS = 6.0
"""Standard deviations of noise that no sample of the empty plate passes in an hour at 1 kHz."""
_LEAST_SHARE = 0.01
"""Of the largest force: the least threshold, for records with almost no noise."""
_EDGE_SHARE = 0.25
"""Of a flight, at either end, where the plate's zero is not read: below the threshold the force may still fade."""
_SMOOTHED_S = 0.007
"""The force is averaged over so long where it rises slowly, so that its beginning is not lost in the noise."""
_STEP_SHARE = 0.2
"""Of that time: a force that doubles within it has set in as a step."""
_LONGEST_ONSET_S = 0.03
"""The longest time over which the force's first rise is extended back to zero."""


@dataclass(frozen=True, slots=True)
class Contact:
    """A contact that begins and ends within the record.

    `start_s` and `end_s` are touchdown and take-off by the record's clock, `peak_n` the largest sample of the force,
    `impulse_n_s` its integral, and `moment_n_s2` the integral of the force times the time left until take-off, all
    above the plate's zero. `flight_s` is the time until the next touchdown, None where the next contact is not known.
    """

    start_s: float
    end_s: float
    peak_n: float
    impulse_n_s: float
    moment_n_s2: float
    flight_s: float | None = None

    @property
    def duration_s(self) -> float:
        """Time from touchdown to take-off."""
        return self.end_s - self.start_s


@dataclass(frozen=True, slots=True)
class PlateJumps:
    """Jump heights of the centre of mass above take-off, and the weight they were computed with."""

    heights_m: tuple[float, ...]
    mean_m: float
    se_m: Value
    weight_n: float


def find_contacts(time_s: ArrayLike, force_n: ArrayLike) -> tuple[Contact, ...] | Undefined:
    """Find the contacts between flights in a record of vertical force.

    Parameters
    ----------
    time_s : (n,) times of the samples, rising
    force_n : (n,) ground reaction on the robot, upward positive; NaN where a sample is missing

    Returns
    -------
    The contacts in order; one that touches an end of the record or has a missing sample is left out. Undefined where
    the plate is never empty for long enough, or nothing presses on it.
    """
    time, force = np.asarray(time_s, np.float64), np.asarray(force_n, np.float64)
    zeroed = _zeroed(time, force)
    if isinstance(zeroed, Undefined):
        return zeroed
    known, step_s, least = np.isfinite(force), zeroed.step_s, zeroed.least
    above, threshold_n = zeroed.above_n, zeroed.threshold_n
    found: list[Contact | None] = []
    for before, after in pairwise(_ranges(above < threshold_n, least)):
        if after[0] - before[1] < least:
            continue
        around = slice(sum(before) // 2, sum(after) // 2)
        whole = known[around].all() and np.diff(time[around]).max() < 1.5 * step_s
        found.append(_contact(time[around], above[around], threshold_n) if whole else None)
    return tuple(
        replace(contact, flight_s=after.start_s - contact.end_s)
        if after is not None and after.start_s - contact.end_s <= LONGEST_FLIGHT_S
        else contact
        for contact, after in zip(found, [*found[1:], None], strict=True)
        if contact is not None
    )


def force_above_zero(time_s: ArrayLike, force_n: ArrayLike) -> Floats | Undefined:
    """Return the force above the plate's zero, which is read in the flights and followed as it drifts, shape (n,).

    Parameters and reasons are those of `find_contacts`.
    """
    zeroed = _zeroed(np.asarray(time_s, np.float64), np.asarray(force_n, np.float64))
    return zeroed if isinstance(zeroed, Undefined) else zeroed.above_n


def jump_heights(contacts: Sequence[Contact]) -> PlateJumps | Undefined:
    """Return the height of each jump by impulse and momentum.

    The body leaves the plate at one height above it each time: over a cycle from take-off to take-off, of length T, it
    then rises by nothing, and the speed at the first of them is g (T / 2 - M / (W T)), with M the moment of the force
    between them about the second. Nothing is assumed of the leg at touchdown, as the time of flight does.

    Parameters
    ----------
    contacts : as `find_contacts` returns them

    Returns
    -------
    PlateJumps; its standard error holds the scatter of the jumps and the weight's error. Undefined with fewer than
    three cycles that follow each other.
    """
    cycles = [
        (after.end_s - contact.end_s, after) for contact, after in pairwise(contacts) if contact.flight_s is not None
    ]
    if len(cycles) < FEWEST_CYCLES:
        return Undefined(Reason.TOO_FEW_JUMPS_IN_A_ROW, needed=FEWEST_CYCLES)
    in_all_s = math.fsum(length_s for length_s, _ in cycles)
    weight_n = math.fsum(after.impulse_n_s for _, after in cycles) / in_all_s

    def heights(weight: float) -> list[float]:
        speeds = [
            STANDARD_GRAVITY_M_S2 * (length_s / 2 - after.moment_n_s2 / (weight * length_s))
            for length_s, after in cycles
        ]
        return [speed**2 / (2 * STANDARD_GRAVITY_M_S2) for speed in speeds]

    found = heights(weight_n)
    about = describe(found)
    assert isinstance(about.mean, float)  # noqa: S101 - three heights have a mean
    se = about.se
    if isinstance(se, float) and isinstance(about.sd, float):
        speed_sd_m_s = about.sd * math.sqrt(STANDARD_GRAVITY_M_S2 / (2 * about.mean))
        part = math.sqrt(2) * speed_sd_m_s / (STANDARD_GRAVITY_M_S2 * in_all_s)  # its ends' speeds are not the same
        se = math.hypot(se, math.fsum(heights(weight_n * (1 + part))) / len(found) - about.mean)
    return PlateJumps(tuple(found), about.mean, se, weight_n)


def _contact(time: Floats, above: Floats, threshold_n: float) -> Contact:
    """Measure a contact in the samples from the middle of the flight before it to the middle of that after it."""
    start_s, end_s = _onset_s(time, above, threshold_n), -_onset_s(-time[::-1], above[::-1], threshold_n)
    impulse_n_s, moment_n_s2 = (float(np.trapezoid(load, time)) for load in (above, above * (end_s - time)))
    return Contact(start_s, end_s, float(above.max()), impulse_n_s, moment_n_s2)


@dataclass(frozen=True, slots=True, eq=False)
class _Zeroed:
    """The force above the plate's zero, what of it is a load, a sample's length, and the shortest contact's samples."""

    above_n: Floats
    threshold_n: float
    step_s: float
    least: int


def _zeroed(time: Floats, force: Floats) -> _Zeroed | Undefined:
    from scipy.ndimage import uniform_filter1d

    known = np.isfinite(force)
    if np.count_nonzero(known) < 2:
        return Undefined(Reason.NO_TWO_SAMPLES)
    step_s = float(np.median(np.diff(time)))
    least = max(round(SHORTEST_S / step_s), 2)
    smooth = uniform_filter1d(np.where(known, force, np.median(force[known])), least)
    low, high = float(smooth.min()), float(smooth.max())
    zero, noise_n = _zero(time, force, _ranges(force < low + _FIRST_THRESHOLD * (high - low), least))
    if zero is None:
        return Undefined(Reason.PLATE_NEVER_EMPTY, shortest_ms=SHORTEST_S * 1e3)
    threshold_n = max(_NOISE_SDS * noise_n, _LEAST_SHARE * (high - low))
    if high - low < 2.0 * threshold_n:
        return Undefined(Reason.PLATE_UNTOUCHED, noise_n=noise_n)
    return _Zeroed(force - zero, threshold_n, step_s, least)


def _ranges(empty: NDArray[np.bool_], least: int) -> list[tuple[int, int]]:
    """Return the half-open ranges of at least so many samples in which the plate is empty."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], empty, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2) if b - a >= least]


def _zero(time: Floats, force: Floats, flights: Sequence[tuple[int, int]]) -> tuple[Floats | None, float]:
    """Return the plate's zero at each sample, straight between the flights' means, and the noise about it."""
    if not flights:
        return None, 0.0
    edges = [round(_EDGE_SHARE * (end - begin)) for begin, end in flights]
    inner = [slice(begin + edge, end - edge) for (begin, end), edge in zip(flights, edges, strict=True)]
    middles = [float(time[part].mean()) for part in inner]
    zero = np.interp(time, middles, [float(force[part].mean()) for part in inner])
    squares = sum(float(np.sum((force[part] - force[part].mean()) ** 2)) for part in inner)
    return zero, math.sqrt(squares / sum(part.stop - part.start - 1 for part in inner))


def _onset_s(time: Floats, above: Floats, threshold_n: float) -> float:
    """Return when the force began to rise.

    The line through the points at which its moving average passes a low threshold and the double of that is extended
    to zero. A step, which the average makes a ramp, began in the ramp's middle.
    """
    from scipy.ndimage import uniform_filter1d

    window = max(round(_SMOOTHED_S / (time[1] - time[0])), 1)
    smooth, low_n = uniform_filter1d(above, window), threshold_n / math.sqrt(window)
    once, twice = (_first_rise_s(time, smooth, level) for level in (low_n, 2.0 * low_n))
    began = once - min(twice - once, _LONGEST_ONSET_S)
    return began + 0.5 * _SMOOTHED_S if twice - once < _STEP_SHARE * _SMOOTHED_S else began


def _first_rise_s(time: Floats, values: Floats, level: float) -> float:
    """Return when the values first pass a level."""
    at = int(np.argmax(values > level))
    return crossing_s(time, values, level, at) if at else float(time[0])


def crossing_s(time: Floats, values: Floats, level: float, at: int) -> float:
    """Return when values pass a level between a sample and the one before it, on a straight line."""
    part = (level - values[at - 1]) / (values[at] - values[at - 1])
    return float(time[at - 1] + part * (time[at] - time[at - 1]))
