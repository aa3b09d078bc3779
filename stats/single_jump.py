"""Single jumps out of quiet standing on a force plate: heights by impulse and by flight time, peak force, push-off.

Onset and take-off are found by published rules, which differ by centimetres of height: `ONSETS` and `TAKE_OFFS` have
them by name. The weight is the mean force of the second of standing before the movement and the plate's zero that of
the flight, so that neither the body's mass nor the plate's offset has to be known.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.reasons import Reason
from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import Undefined
from stats.force_plate import LONGEST_FLIGHT_S, SHORTEST_S
from stats.scatter import Floats, Value

QUIET_S = 1.0
"""How long the standing before a jump is weighed (Owen et al. 2014)."""
QUIET_SPEED_M_S = 0.05
"""Standing is quiet where the speed of the body, from its force, scatters by less: 14 mm of a jump of 0.4 m."""
BACK_S = 0.03
"""So long before its force leaves the scatter of standing a body began to move (Owen et al. 2014)."""
_SDS = 5.0
"""Standard deviations that no sample of quiet standing, or of the flight, is off (Owen et al. 2014; McMahon 2018)."""
_INSIDE_S = 0.1
"""A body stands, and does not pass its weight in moving, where the force stays so long within that scatter."""
_LOADED_SHARE = 0.15
"""Of the largest force: the plate is loaded above it, before the weight is known."""
_EMPTY_SHARE = 0.25
"""Of the weight: the plate may be empty below it; in an unweighting it is not, and the body moves downward."""
_EDGE_SHARE = 0.25
"""Of a flight, at either end, where its force is not read: the plate may ring (Sams)."""
_BLOCKS = 10
"""Parts of the second of standing, and of the flight, whose means say how well the force is known."""
_FEWEST = 2 * _BLOCKS
"""Samples that a flight has at least."""


@dataclass(frozen=True, slots=True)
class Standing:
    """Quiet standing in the samples `start` to `stop` (half-open): mean and standard deviation of the force."""

    start: int
    stop: int
    weight_n: float
    sd_n: float


def weigh(force_n: Floats, start: int, stop: int) -> Standing:
    """Weigh a body that stands from one sample of a force of shape (n,) to another."""
    return Standing(start, stop, float(force_n[start:stop].mean()), float(force_n[start:stop].std()))


def _first(found: NDArray[np.bool_], start: int) -> int | None:
    return start + int(np.argmax(found)) if found.any() else None


def _last(found: NDArray[np.bool_]) -> int | None:
    return found.size - 1 - int(np.argmax(found[::-1])) if found.any() else None


def _five_sds(force_n: Floats, standing: Standing, peak: int, rate_hz: float) -> int | None:
    off_n = np.abs(force_n[standing.stop : peak + 1] - standing.weight_n)
    found = _first(off_n > _SDS * standing.sd_n, standing.stop)
    return None if found is None else max(found - round(BACK_S * rate_hz), 0)


def _back_to_weight(force_n: Floats, standing: Standing, peak: int, _rate_hz: float) -> int | None:
    deepest = int(np.argmin(force_n[: peak + 1]))
    within = _last(force_n[: deepest + 1] >= standing.weight_n - _SDS * standing.sd_n)
    return None if within is None or within == deepest else _last(force_n[: within + 1] >= standing.weight_n)


ONSETS: Mapping[str, Callable[[Floats, Standing, int, float], int | None]] = {
    "5sd_back_30ms": _five_sds,
    "5sd_back_to_weight": _back_to_weight,
    "10_percent": lambda force_n, standing, peak, _rate_hz: _first(
        force_n[standing.stop : peak + 1] < 0.9 * standing.weight_n, standing.stop
    ),
}
"""Onset of the movement, by name: of force (n,), standing, sample of the largest force before take-off and rate in Hz
the sample at which the movement begins, None where the force does not change as the rule says.

- `5sd_back_30ms`: 30 ms before the force is 5 SD of standing off the weight, to either side (Owen et al. 2014).
- `5sd_back_to_weight`: the last sample not below the weight before the force is 5 SD below it (Merrigan et al. 2022).
- `10_percent`: the force is 10 % below the weight (Meylan et al. 2011).
"""

TAKE_OFFS: Mapping[str, Callable[[float, Floats], float]] = {
    "flight_5sd": lambda _weight_n, flight_n: float(flight_n.mean() + _SDS * flight_n.std()),
    "10n": lambda _weight_n, _flight_n: 10.0,
    "50n": lambda _weight_n, _flight_n: 50.0,
    "20_percent": lambda weight_n, _flight_n: 0.2 * weight_n,
}
"""Take-off, by name: of the weight in N and the force in the middle of the flight (n,) the threshold in N at or below
which the body has left the plate, after the largest force.

- `flight_5sd`: the mean of the flight and 5 SD of it (McMahon et al. 2018; its middle half: Sams).
- `10n`: 10 N (Hirsch). `50n`: 50 N (Zoffoli). `20_percent`: of the weight (Bilalovski).
"""

ONSET, TAKE_OFF = "5sd_back_30ms", "flight_5sd"
"""The rules that are used where none is named."""


def take_off_sample(force_n: Floats, peak: int, threshold_n: float) -> int | None:
    """Return the first sample from the largest force on that is not above a threshold."""
    return _first(force_n[peak:] <= threshold_n, peak)


def speed_m_s(force_n: Floats, standing: Standing, onset: int, take_off: int, rate_hz: float) -> float:
    """Return the speed of the body at the last sample before take-off, from the impulse since the onset."""
    net_n = force_n[onset:take_off] - standing.weight_n
    return float(np.trapezoid(net_n, dx=1.0 / rate_hz)) / standing.weight_n * STANDARD_GRAVITY_M_S2


@dataclass(frozen=True, slots=True, eq=False)
class FoundJump:
    """A jump out of quiet standing as it lies in a record, before onset and take-off are decided.

    `time_s` and `force_n` (above the plate's zero), both of shape (n,), go from the second of standing to where the
    flight has ended; `peak` is the sample of the largest force before the flight, and about `left` to `landed` the
    plate is empty. `landed` is None where the body does not come back to the plate, or a sample until then is missing.
    """

    time_s: Floats
    force_n: Floats
    standing: Standing
    peak: int
    left: int
    landed: int | None

    @property
    def rate_hz(self) -> float:
        """Samples a second."""
        return (self.time_s.size - 1) / float(self.time_s[-1] - self.time_s[0])

    @property
    def flight(self) -> slice:
        """The middle of the flight."""
        return _middle(self.left, self.time_s.size if self.landed is None else self.landed)


def _middle(start: int, stop: int) -> slice:
    edge = int(_EDGE_SHARE * (stop - start))
    return slice(start + edge, stop - edge)


@dataclass(frozen=True, slots=True)
class SingleJump:
    """A jump by one rule of onset and one of take-off; each number has its standard error.

    `height_m` is the rise of the centre of mass after take-off by impulse and momentum, `flight_height_m` that by the
    time of flight, which takes the posture at landing for that at take-off; `push_off_s` goes from onset to take-off.
    """

    onset_s: float
    take_off_s: float
    weight_n: float
    weight_se_n: float
    height_m: float
    height_se_m: float
    flight_height_m: Value
    flight_height_se_m: Value
    peak_n: float
    peak_se_n: float
    push_off_s: float
    push_off_se_s: float


def find_jumps(time_s: ArrayLike, force_n: ArrayLike) -> tuple[FoundJump, ...] | Undefined:
    """Find the jumps out of quiet standing in a record of vertical force.

    Parameters
    ----------
    time_s : (n,) times of the samples, rising and evenly spaced but for gaps
    force_n : (n,) ground reaction on the body, upward positive, the plate's zero anywhere; NaN where one is missing

    Returns
    -------
    The jumps in order. Undefined where nothing leaves the plate upward, or where fewer than half of the flights begin
    from a second of quiet standing, in which no sample is missing until the flight.
    """
    from scipy.ndimage import uniform_filter1d

    time, force = np.asarray(time_s, np.float64), np.asarray(force_n, np.float64)
    known = np.isfinite(force)
    if np.count_nonzero(known) < 2:
        return Undefined(Reason.NO_TWO_SAMPLES)
    step_s = float(np.median(np.diff(time)))
    least = max(round(SHORTEST_S / step_s), _FEWEST)
    filled = np.interp(np.arange(force.size), np.flatnonzero(known), force[known])
    smooth = uniform_filter1d(filled, least)
    low, high = float(smooth.min()), float(smooth.max())
    loaded = smooth >= low + _LOADED_SHARE * (high - low)
    empty = np.pad(smooth < low + _EMPTY_SHARE * (float(np.median(smooth[loaded])) - low), 1)
    broken = np.flatnonzero(~known | (np.diff(time, prepend=time[0] - step_s) > 1.5 * step_s))
    found: list[FoundJump] = []
    flights = landed = 0
    for left, end in np.flatnonzero(empty[1:] != empty[:-1]).reshape(-1, 2).tolist():
        if left == 0 or end - left < least:
            landed = end if left == 0 else landed
            continue
        before = int(np.searchsorted(broken, left))
        start = max(landed, int(broken[before - 1])) if before else landed
        stop = int(broken[before]) if before < broken.size else force.size
        second = _standing(force[:left], start, step_s, low)
        if second is not None and min(end, stop) - left >= least:
            part = slice(second[0], min(end + least, stop))
            above_n = force[part] - float(force[_middle(left, min(end, stop))].mean())
            standing = weigh(above_n, 0, second[1] - second[0])
            gone = left - part.start
            if speed_m_s(above_n, standing, standing.stop, gone, 1.0 / step_s) <= 0.0:
                landed = end if end - left >= standing.stop else landed
                continue  # an unweighting, or a step off the plate
            peak = standing.stop + int(np.argmax(above_n[standing.stop : gone]))
            is_whole = end + least <= stop or end < stop == force.size
            back = is_whole and time[end] - time[left] <= LONGEST_FLIGHT_S
            found.append(FoundJump(time[part], above_n, standing, peak, gone, end - part.start if back else None))
        flights, landed = flights + 1, end
    if not flights:
        return Undefined(Reason.NO_TAKE_OFF)
    if 2 * len(found) < flights:
        return Undefined(Reason.NO_QUIET_STANDING, found=len(found), n=flights, quiet_s=QUIET_S)
    return tuple(found)


def _standing(force_n: Floats, start: int, step_s: float, zero_n: float) -> tuple[int, int] | None:
    """Return the samples of the second of standing before the last movement of a force (n,), None if it is not quiet.

    The quietest second says how the force scatters; the movement begins where the force was last within that scatter.
    """
    n = round(QUIET_S / step_s)
    if force_n.size - start < n:
        return None
    own = force_n[start:] - force_n[start:].mean()
    sum_n, square_n2 = (np.concatenate([[0.0], np.cumsum(own**power)]) for power in (1, 2))
    variance = (square_n2[n:] - square_n2[:-n]) / n - ((sum_n[n:] - sum_n[:-n]) / n) ** 2
    begin = start + int(np.argmin(variance))
    quietest = weigh(force_n, begin, begin + n)
    off = np.abs(force_n[begin:] - quietest.weight_n) > _SDS * quietest.sd_n
    outside = np.concatenate([[0], np.flatnonzero(off), [off.size]])
    long = np.flatnonzero(np.diff(outside) > _INSIDE_S / step_s)
    if not long.size:
        return None
    moved = begin + int(outside[long[-1] + 1])
    stop = max(moved - round(BACK_S / step_s), start + n)
    second = force_n[stop - n : stop]
    weight_n = float(second.mean()) - zero_n
    quiet = weight_n > 0.0 and _speeds_m_s(second, weight_n, step_s).std() <= QUIET_SPEED_M_S
    return (stop - n, stop) if quiet else None


def _speeds_m_s(force_n: Floats, weight_n: float, step_s: float) -> Floats:
    """Return the speed of a body that stands, from its force, up to a constant."""
    return np.cumsum(force_n - force_n.mean()) * (step_s * STANDARD_GRAVITY_M_S2 / weight_n)


def measure_jump(jump: FoundJump, onset: str = ONSET, take_off: str = TAKE_OFF) -> SingleJump | Undefined:
    """Measure a jump by a rule of `ONSETS` and one of `TAKE_OFFS`.

    A height's standard error has in it how the force of standing scatters from tenth to tenth of a second, how the
    plate may have drifted since (by the slopes in standing and in flight), the speed with which the body sways, the
    impulse before the onset, the time from the last sample on the plate to where the force has surely ended, and the
    steps of the converter where noise does not even them out.

    Returns
    -------
    Undefined where the force does not change as the rule of onset says, or the threshold of take-off is not below the
    weight.
    """
    force_n, standing, peak = jump.force_n, jump.standing, jump.peak
    weight_n, rate_hz, flight_n = standing.weight_n, jump.rate_hz, force_n[jump.flight]
    threshold_n = TAKE_OFFS[take_off](weight_n, flight_n)
    if threshold_n >= weight_n:
        return Undefined(Reason.THRESHOLD_ABOVE_WEIGHT, threshold_n=threshold_n, weight_n=weight_n)
    begin = ONSETS[onset](force_n, standing, peak, rate_hz)
    off = take_off_sample(force_n, peak, threshold_n)
    if begin is None:
        return Undefined(Reason.NO_ONSET, rule=onset)
    if off is None or (speed := speed_m_s(force_n, standing, begin, off, rate_hz)) <= 0.0:
        return Undefined(Reason.NO_TAKE_OFF)
    push_off_s = (off - begin) / rate_hz
    second_n = force_n[standing.start : standing.stop]
    step_n = float(np.diff(np.unique(force_n.round(6))).min())  # of the converter; next to nothing where there is none
    scatter_n, *slope = _blocks(second_n, rate_hz)
    zero_rounding_n = _rounding_se_n(flight_n, step_n)
    weight_se_n = math.hypot(scatter_n, _rounding_se_n(second_n, step_n), zero_rounding_n)
    drift_n_s = _drift_n_s(slope, _blocks(flight_n, rate_hz)[1:])
    weighed = (standing.start + standing.stop) / 2.0
    to_push_off_s, to_flight_s = (
        (middle - weighed) / rate_hz for middle in ((begin + off) / 2.0, (jump.flight.start + jump.flight.stop) / 2.0)
    )
    first = _smooth_start(force_n, standing, peak)
    gone_s = _fade_s(force_n[peak:], flight_n, off - 1 - peak, rate_hz) / math.sqrt(3.0)
    speed_se = math.hypot(
        (speed + STANDARD_GRAVITY_M_S2 * push_off_s) * weight_se_n / weight_n,
        (speed * to_flight_s + STANDARD_GRAVITY_M_S2 * push_off_s * to_push_off_s) * drift_n_s / weight_n,
        float(_speeds_m_s(second_n, weight_n, 1.0 / rate_hz).std()),
        speed_m_s(force_n, standing, min(first, begin), begin + 1, rate_hz),
        STANDARD_GRAVITY_M_S2 * gone_s,
    )
    noise_n = float(flight_n.std())
    peak_n = float(force_n[peak])
    near = np.count_nonzero(force_n[begin:off] >= peak_n - 3.0 * noise_n)
    flight_height_m, flight_height_se_m = _flight_height(jump, threshold_n, off, gone_s)
    return SingleJump(
        onset_s=float(jump.time_s[begin]),
        take_off_s=float(jump.time_s[off]),
        weight_n=weight_n,
        weight_se_n=math.hypot(weight_se_n, to_flight_s * drift_n_s),
        height_m=speed**2 / (2.0 * STANDARD_GRAVITY_M_S2),
        height_se_m=speed * speed_se / STANDARD_GRAVITY_M_S2,
        flight_height_m=flight_height_m,
        flight_height_se_m=flight_height_se_m,
        peak_n=peak_n,
        peak_se_n=math.hypot(
            noise_n * math.sqrt(1.0 + 2.0 * math.log(near)), _rounding_se_n(force_n[peak], step_n), zero_rounding_n
        ),
        push_off_s=push_off_s,
        push_off_se_s=math.hypot((begin - first) / rate_hz, BACK_S, gone_s),
    )


def _rounding_se_n(force_n: Floats | np.float64, step_n: float) -> float:
    """Return the standard error that steps leave in a force's mean; scatter of half a step evens them out."""
    return step_n / math.sqrt(12.0) if force_n.std() < step_n / 2.0 else 0.0


def _blocks(force_n: Floats, rate_hz: float) -> tuple[float, float, float]:
    """Return the standard error of a force's mean from the means of its parts, its slope and the slope's error."""
    means = np.array([part.mean() for part in np.array_split(force_n, _BLOCKS)])
    at_s = (np.arange(_BLOCKS) - (_BLOCKS - 1) / 2.0) * force_n.size / _BLOCKS / rate_hz
    slope = float(at_s @ means / (at_s @ at_s))
    rest_n2 = float(np.sum((means - means.mean() - slope * at_s) ** 2)) / (_BLOCKS - 2)
    return math.sqrt(rest_n2 / _BLOCKS), slope, math.sqrt(rest_n2 / float(at_s @ at_s))


def _drift_n_s(*slopes: Sequence[float]) -> float:
    """Return how fast a plate may drift whose force has slopes that are known to standard errors."""
    weights = [1.0 / max(se, 1e-12) ** 2 for _slope, se in slopes]
    mean = math.fsum(w * slope for w, (slope, _se) in zip(weights, slopes, strict=True)) / math.fsum(weights)
    return math.hypot(mean, math.fsum(weights) ** -0.5)


def _smooth_start(force_n: Floats, standing: Standing, peak: int) -> int:
    """Return the sample at which a force begins to leave that of standing, as the square of time.

    The square that passes 5 SD and 10 SD where the force does begins 1 + sqrt(2) times the time between before that.
    """
    off_n = np.abs(force_n[standing.stop : peak + 1] - standing.weight_n)
    passed = [_first(off_n > sds * standing.sd_n, standing.stop) for sds in (_SDS, 2.0 * _SDS)]
    once, twice = (peak if sample is None else sample for sample in passed)
    return max(once - round((1.0 + math.sqrt(2.0)) * (twice - once)), 0)


def _fade_s(force_n: Floats, flight_n: Floats, sample: int, rate_hz: float) -> float:
    """Return the time from a sample to where a force that falls into the noise of a flight has surely ended.

    That is where the line from its passing 10 SD of the flight to its passing 5 SD reaches -2 SD.
    """

    def passes(level_n: float) -> float:
        below = int(np.argmax(force_n <= level_n))
        part = (level_n - force_n[below]) / (force_n[below - 1] - force_n[below]) if below else 0.0
        return below - float(part)

    once, twice = (passes(float(flight_n.mean() + sds * flight_n.std())) for sds in (_SDS, 2.0 * _SDS))
    return max(once + (once - twice) * (_SDS + 2.0) / _SDS - sample, 1.0) / rate_hz


def _flight_height(jump: FoundJump, threshold_n: float, off: int, gone_s: float) -> tuple[Value, Value]:
    """Return the height by the time of flight and its standard error; `gone_s` is that of the take-off."""
    if jump.landed is None:
        missing = Undefined(Reason.NO_LANDING)
        return missing, missing
    middle = jump.flight.start
    largest = middle + int(np.argmax(jump.force_n[middle:]))
    backward = jump.force_n[middle : largest + 1][::-1]  # from the landing into the flight
    down = take_off_sample(backward, 0, threshold_n)
    assert down is not None  # noqa: S101 - a flight is below the threshold that its take-off was
    flight_s = (largest + 1 - down - off) / jump.rate_hz
    down_s = _fade_s(backward, jump.force_n[jump.flight], down - 1, jump.rate_hz) / math.sqrt(3.0)
    return (
        STANDARD_GRAVITY_M_S2 * flight_s**2 / 8.0,
        STANDARD_GRAVITY_M_S2 * flight_s / 4.0 * (gone_s + down_s),  # both make the flight too long
    )
