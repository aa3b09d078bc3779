"""What a detector says about a log: one `Jump` a stance, in order, and how it was found.

A stance without a flight (a misfire) is a jump without an apex, so that jumps can be counted against jumps made.

A stance begins when the body sinks below the leg's rest length and ends when it rises above it again; the clamp, the
lowering by hand and the catch all happen above (thesis 5.1.3). The first maximum after a stance is where an apex is
looked for, if it comes soon, or is so high that only free flight gets there in that time. A drop that ends without a
lift-off is a stance too.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.apexes.cleaning import Bools, CleaningParameters, CleanSignal, Floats
from stats.force_plate import crossing_s
from stats.scatter import Value


@dataclass(frozen=True, slots=True)
class Jump:
    """One stance and, where there was one, the flight that followed it.

    Times are in seconds on the log's own time axis. A number that does not exist is `Undefined` with the reason;
    the height and its reason exclude each other.
    """

    number: int
    """1 for the first stance of the log."""
    touchdown_s: Value
    """The foot met the ground: the foot's height, or without a leg length the body's over the rest length, is 0."""
    liftoff_s: Value
    """The leg reached its flight length again or, without a leg length, the body began to fly a parabola."""
    apex_s: Value
    """When the body was highest."""
    apex_height_m: Value
    """Height of the body at the apex, above the undisturbed ground."""
    apex_height_se_m: Value
    """Standard error of that height from the scatter of the samples."""
    flight_time_s: Value
    """Lift-off to landing; flagged where the landing had to be read off the parabola."""
    samples_used: int
    """Samples that the apex is fitted to; 0 without an apex."""
    curvature_m_s2: Value
    """Downward acceleration fitted around the apex: a self-check, near the gravity that acts on the robot."""
    gap_touched: bool
    """Whether samples are missing from shortly before lift-off to shortly after landing, or to the catch."""
    flags: tuple[str, ...]
    """What a person should know about this jump; the words are `stats.apexes.jumps.FLAGS`."""

    @property
    def undefined_reason(self) -> str | None:
        """Why there is no apex height, or None where there is one."""
        return self.apex_height_m.reason if isinstance(self.apex_height_m, Undefined) else None

    @property
    def misfired(self) -> bool:
        """Whether no flight followed the stance; where samples are missing, that is not known."""
        return isinstance(self.apex_height_m, Undefined) and self.apex_height_m.code in _NO_FLIGHT


_NO_FLIGHT = (Reason.NO_FALL, Reason.NO_FREE_FLIGHT)
ZERO_DOUBTFUL = "zero_doubtful"
"""The flag of jumps that are found only where heights count from a higher level."""
FLAGS: dict[str, str] = {
    "landing_extrapolated": "the landing was not seen (caught by hand); read off the parabola",
    "few_samples_before": "few valid samples between lift-off and apex",
    "few_samples_after": "few valid samples between apex and landing or catch",
    "caught_early": "the body left the parabola soon after the apex; the samples from there on are not used",
    "curvature_off": "the fitted acceleration is more than a tenth away from gravity",
    ZERO_DOUBTFUL: "the body stands higher than the leg is long: found from that level, its height as measured",
    "moved": "a person put the apex at this time",
    "added": "a person added this jump, which the detector has not",
}
"""Flags a jump can carry, and what they mean; the last two come from verdicts."""
HEIGHT_DOUBTFUL = frozenset({"few_samples_before", "few_samples_after", "caught_early", "curvature_off"})
"""Flags for which a person should look whether the apex height of one jump is right."""


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
    zero_m: float
    """By how much the heights seem to lie too high, judged by where the body stands; 0 where they do not."""
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


def defined(values: Iterable[Value]) -> NDArray[np.float64]:
    """Return the values that exist, in order, as an array of shape (n_defined,)."""
    return np.array([value for value in values if not isinstance(value, Undefined)], np.float64)


_SPEED_SAMPLES = 8
"""So many samples on either side of a gap show the speed there."""


@dataclass(frozen=True, slots=True)
class StanceParameters:
    """How stances and the first maximum after them are recognised."""

    cleaning: CleaningParameters = field(default_factory=CleaningParameters)
    stance_depth_m: float = 0.03
    """A body this far below the rest length is in stance (the legs of both thesis robots give at least 0.05 m)."""
    rise_max_s: float = 0.35
    """A maximum this soon after the body passed the rest length may be an apex, whatever the rise."""
    free_rise_share: float = 0.6
    """A later one may be where the body has risen by at least this share of what is fallen freely in that time: a hand
    lifts more slowly. Free flights have some 0.85 of it, as they are seen only when the body has fallen a little."""
    fall_min_m: float = 0.002
    """A maximum counts once the body has fallen this far from it, and four standard deviations of the noise."""
    smoothing_s: float = 0.015
    """Window of the average in which the first maximum is looked for."""
    leg_tolerance_m: float = 0.001
    """The leg has its flight length again when it is this close to it (about 1 ms before it is)."""
    gap_margin_s: float = 0.02
    """Samples missing this close to lift-off or landing count too: those moments are read off the samples around."""
    gap_least_s: float = 0.02
    """In a longer gap between samples a stance can lie: before it the body falls, and after it it rises."""
    gap_speed_m_s: float = 0.3
    """It falls and rises faster than this (a flight of 5 mm ends with it), and than the noise of some samples."""
    gravity_m_s2: float = 9.80665
    """Acceleration expected in flight (standard gravity, CGPM 1901)."""


@dataclass(frozen=True, slots=True)
class Log:
    """A log as it was recorded, its gaps (rows of start and length, s), its valid samples, how stances are found."""

    time_s: Floats
    height_m: Floats
    gaps: Floats
    signal: CleanSignal
    rest_length_m: float
    stance: StanceParameters


@dataclass(frozen=True, slots=True)
class Hop:
    """One stance and where its apex may be; indices count the valid samples of a `CleanSignal`."""

    begin: int
    """First sample in stance."""
    end: int
    """First sample above the rest length again; n_valid when the log ends before."""
    next_begin: int
    """First sample of the next stance; n_valid when there is none."""
    apex: int | Undefined
    """Sample nearest to the first maximum after the stance."""
    fallen: int
    """First sample by which the body has fallen from that maximum; where the search ended without one."""
    touchdown_s: Value


def find_hops(log: Log) -> list[Hop]:
    """Return the stances of a log in order of time, each with the first maximum after it."""
    signal = log.signal
    below = signal.coarse_m < log.rest_length_m - log.stance.stance_depth_m
    above = signal.coarse_m > log.rest_length_m
    unseen = _stances_in_gaps(signal, log.stance)
    starts = np.union1d(_rising_edges(below), unseen)
    rises = np.union1d(_rising_edges(above), unseen[above[unseen + 1]] + 1)
    from_first = bool(below.size) and bool(below[0])
    if from_first:
        starts = np.append(0, starts)
    if starts.size == 0:
        return []
    # Of all dips before one rise the first begins the stance.
    which = np.searchsorted(rises, starts)
    _, first = np.unique(which, return_index=True)
    starts = starts[first]
    n = signal.time_s.size
    ends = np.append(rises, n)[which[first]]
    following = np.append(starts[1:], n)
    hops = []
    previous_end = 0
    for begin, end, next_begin in zip(starts.tolist(), ends.tolist(), following.tolist(), strict=True):
        apex, fallen = _first_maximum(signal, end, next_begin, log.stance)
        hops.append(Hop(begin, end, next_begin, apex, fallen, _touchdown(log, previous_end, begin)))
        previous_end = end
    # A body that lies low at first is in stance if a flight follows, and else at rest.
    return hops[1:] if from_first and isinstance(hops[0].apex, Undefined) else hops


def flight_around(log: Log, at_s: float) -> tuple[Hop, Hop | None] | Undefined:
    """Return the stance before the flight that a time lies in, with the sample there for its maximum, and the next one.

    The flight is what lies about that time between two samples of the body below the rest length, however shallow the
    stances there: `find_hops` may have missed them.
    """
    signal = log.signal
    if not (signal.time_s.size and signal.time_s[0] <= at_s <= signal.time_s[-1]):
        return Undefined(Reason.TIME_NOT_IN_LOG)
    apex = int(np.argmin(np.abs(signal.time_s - at_s)))
    below = signal.coarse_m < log.rest_length_m
    if below[apex]:
        return Undefined(Reason.NOT_IN_FLIGHT)
    n, hops = signal.time_s.size, find_hops(log)
    before, after = np.flatnonzero(below[:apex]), np.flatnonzero(below[apex:])
    end = int(before[-1]) + 1 if before.size else 0
    landed = apex + int(after[0]) if after.size else n
    found = next((hop for hop in reversed(hops) if hop.end <= apex), None)
    following = next((hop for hop in hops if hop.begin >= landed), None)
    log_begins = Undefined(Reason.LOG_BEGINS_IN_STANCE)
    if found is not None and signal.time_s[end] - signal.time_s[found.end] <= log.stance.smoothing_s:
        begin, touchdown = found.begin, found.touchdown_s  # the body passes the rest length more than once in noise
    else:
        risen = 0 if found is None else found.end
        begin = risen + int(np.argmin(signal.coarse_m[risen:end])) if end > risen else risen
        touchdown = _touchdown(log, risen, begin) if end > risen else log_begins
    return Hop(begin, end, landed, apex, landed, touchdown), following


def _stances_in_gaps(signal: CleanSignal, parameters: StanceParameters) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return the samples before gaps in which a stance lies: a body in free flight gains no upward speed."""
    n = signal.time_s.size
    before = np.flatnonzero(np.diff(signal.time_s) > parameters.gap_least_s)
    before = before[(before >= _SPEED_SAMPLES - 1) & (before + _SPEED_SAMPLES < n)]
    first, last = before - _SPEED_SAMPLES + 1, before + _SPEED_SAMPLES
    falls = _speed(signal, first, before) < -parameters.gap_speed_m_s
    rises = _speed(signal, before + 1, last) > parameters.gap_speed_m_s
    found: np.ndarray[tuple[int], np.dtype[np.int64]] = before[falls & rises]
    return found


def _speed(signal: CleanSignal, first: np.ndarray, last: np.ndarray) -> Floats:
    """Return the mean speed between samples, m/s."""
    rise_m, passed_s = signal.coarse_m[last] - signal.coarse_m[first], signal.time_s[last] - signal.time_s[first]
    return np.asarray(rise_m / passed_s, np.float64)


def liftoff_from_leg(log: Log, hop: Hop) -> Value:
    """Return when the leg, extending, reached the length it then flew with (at most the rest length)."""
    signal = log.signal
    if signal.leg_m is None:
        return Undefined(Reason.NO_LEG_LENGTH)
    if isinstance(hop.apex, Undefined):
        return hop.apex
    stance_to_apex = signal.leg_m[hop.begin : hop.apex + 1]
    in_flight = signal.leg_m[hop.end : hop.apex + 1]
    if not np.isfinite(stance_to_apex).any() or not np.isfinite(in_flight).any():
        return Undefined(Reason.LEG_LENGTH_MISSING)
    level = min(log.rest_length_m, float(np.nanmedian(in_flight))) - log.stance.leg_tolerance_m
    shortest = hop.begin + int(np.nanargmin(stance_to_apex))
    extended = np.flatnonzero(signal.leg_m[shortest : hop.apex + 1] >= level)
    if extended.size == 0 or extended[0] == 0:
        return Undefined(Reason.LEG_NOT_RETURNED)
    after = shortest + int(extended[0])
    return crossing_s(signal.time_s[after - 1 :], signal.leg_m[after - 1 : after + 1] - level, 0.0, 1)


def _rising_edges(mask: Bools) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    return np.flatnonzero(mask[1:] & ~mask[:-1]) + 1


def _first_maximum(
    signal: CleanSignal, end: int, next_begin: int, parameters: StanceParameters
) -> tuple[int | Undefined, int]:
    """Return the sample of the first maximum after `end` and that by which the body has fallen from it."""
    n = signal.time_s.size
    if end >= n:
        return Undefined(Reason.LOG_ENDS_IN_STANCE), n
    stop = int(np.searchsorted(signal.time_s, signal.time_s[end] + parameters.rise_max_s, side="right"))
    stop, last = min(stop, next_begin), next_begin
    width = max(1, round(parameters.smoothing_s / signal.interval_s))
    earliest = int(np.searchsorted(signal.time_s, signal.time_s[end] - parameters.smoothing_s))  # after any gap
    begin = max(end - width // 2, earliest)
    window = signal.coarse_m[begin : min(last + width, n)]
    if window.size < width:
        return Undefined(Reason.LOG_ENDS_AFTER_STANCE), stop
    smooth = np.convolve(window, np.full(width, 1.0 / width), mode="valid")[: last - begin]
    fall = max(parameters.fall_min_m, 4.0 * signal.noise_sd_m / width**0.5)
    fallen = np.flatnonzero(smooth < np.maximum.accumulate(smooth) - fall)
    none = Undefined(Reason.NO_FALL), stop
    if fallen.size == 0:
        return none
    centre = begin + width // 2
    highest, seen = int(np.argmax(smooth[: fallen[0]])), centre + int(fallen[0])
    rise_m = float(smooth[highest] - signal.coarse_m[end])
    free_fall_m = parameters.gravity_m_s2 * float(signal.time_s[seen] - signal.time_s[end]) ** 2 / 2.0
    if fallen[0] >= stop - begin and rise_m < parameters.free_rise_share * free_fall_m:
        return none
    return centre + highest, seen


def _touchdown(log: Log, earliest: int, begin: int) -> Value:
    """Return when the foot's height fell through 0; without a leg length the body's height over the rest length."""
    signal = log.signal
    height = signal.coarse_m[earliest : begin + 1] - log.rest_length_m
    if signal.leg_m is not None:
        foot = signal.coarse_m[earliest : begin + 1] - signal.leg_m[earliest : begin + 1]
        if np.isfinite(foot).all():
            height = foot
    down = np.flatnonzero((height[:-1] > 0.0) & (height[1:] <= 0.0))
    if down.size == 0:
        return Undefined(Reason.LOG_BEGINS_IN_STANCE)
    return crossing_s(signal.time_s[earliest:], height, 0.0, int(down[-1]) + 1)


def jump_out_of(
    number: int,
    log: Log,
    hop: Hop,
    following: Hop | None,
    liftoff_s: Value,
    apex: tuple[float, float, Value],
    end_s: float,
    samples_used: int,
    curvature_m_s2: Value,
    flags: tuple[str, ...] = (),
) -> Jump:
    """Return the jump of a stance and a flight whose apex (time, height and its standard error) was measured.

    The flight ended, where that is seen, when the next stance begins, if that is within the time a flight can take; a
    robot that was caught by hand would have landed when the parabola falls through the rest length, which is flagged.
    `end_s` is when else the samples end that height and flight time need.
    """
    (apex_s, height_m, _se), stance = apex, log.stance
    fall_m_s2 = stance.gravity_m_s2 if isinstance(curvature_m_s2, Undefined) else curvature_m_s2
    seen_s = None if following is None else following.touchdown_s
    fall_s = math.sqrt(2.0 * max(height_m - log.rest_length_m, 0.0) / fall_m_s2)
    longest_s = max(stance.rise_max_s, fall_s / math.sqrt(stance.free_rise_share))
    landing_s: float | None = None
    extrapolated = not (isinstance(seen_s, float) and seen_s - apex_s <= longest_s)
    if isinstance(seen_s, float) and not extrapolated:
        landing_s, end_s = seen_s, seen_s + stance.gap_margin_s
    elif height_m > log.rest_length_m:
        landing_s = apex_s + fall_s
    flight_time_s: Value = Undefined(Reason.FLIGHT_ENDS_UNKNOWN)
    if landing_s is not None and not isinstance(liftoff_s, Undefined):
        flight_time_s = landing_s - liftoff_s
    return Jump(
        number,
        hop.touchdown_s,
        liftoff_s,
        *apex,
        flight_time_s,
        samples_used,
        curvature_m_s2,
        _gap_in_flight(log, hop, liftoff_s, end_s),
        (*(("landing_extrapolated",) if extrapolated else ()), *flags),
    )


def jump_without_apex(number: int, log: Log, hop: Hop, why: Undefined) -> Jump:
    """Return the row of a stance that no flight was found after; missing samples are named beside the reason."""
    end_s = float(log.signal.time_s[min(hop.fallen, log.signal.time_s.size - 1)])
    gap_touched = _gap_in_flight(log, hop, why, end_s)
    none = Undefined(Reason.SAMPLES_MISSING_HERE, reason=why.reason) if gap_touched else why
    return Jump(number, hop.touchdown_s, none, none, none, none, none, 0, none, gap_touched, ())


def _gap_in_flight(log: Log, hop: Hop, liftoff_s: Value, end_s: float) -> bool:
    """Say whether samples are missing that height and flight time need: from shortly before lift-off to `end_s`.

    Where the lift-off is not known, the body's rise through the rest length stands for it. A gap while the leg stood on
    the ground moves neither.
    """
    rose_s = float(log.signal.time_s[min(hop.end, log.signal.time_s.size - 1)])
    begin_s = (rose_s if isinstance(liftoff_s, Undefined) else liftoff_s) - log.stance.gap_margin_s
    return bool(np.any((log.gaps[:, 0] < end_s) & (log.gaps[:, 0] + log.gaps[:, 1] > begin_s)))
