"""Jumps and apexes of a height log: the detectors by name, and the one function that runs them.

A detector proposes; which jumps count is the protocol's and a person's decision. Two are known: "published", the
thesis's rule (4.3.3), and "robust", which states a standard error for every apex and has no smoothing bias.

The thesis had a person look at every jump; here the rule is confined to the flight that follows a stance, so that
hand motion on the clamp is not counted. Which jumps are then left out (the first two, those with a dropped packet)
is the protocol's business. Nothing is masked: a spike or a dropout inside the average moves it, as it did there.

The robust one takes after each stance a flight that curves like gravity, measured by a robust parabola.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused, unknown_name
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.apexes.cleaning import Floats, check_log, clean_signal, gaps_in_time, sampling_interval
from stats.apexes.flights import Flight, FlightWindowParameters, departures, fit_flights
from stats.apexes.jumps import (
    FLAGS,
    ZERO_DOUBTFUL,
    Hop,
    Jump,
    Jumps,
    Log,
    StanceParameters,
    find_hops,
    flight_around,
    jump_out_of,
    jump_without_apex,
    liftoff_from_leg,
)
from stats.apexes.standing import height_zero_m
from stats.checks import as_number


@dataclass(frozen=True, slots=True)
class PublishedParameters:
    """Parameters of the published detector."""

    window_samples: int = 10
    """Moving average, samples (thesis 4.3.3)."""
    stance: StanceParameters = field(default_factory=StanceParameters)
    """Where a maximum may be an apex: our addition, in place of the person who looked."""

    def __post_init__(self) -> None:
        if self.window_samples < 1:
            raise InputRefused(f"a moving average of {self.window_samples} samples: give 1 or more (thesis: 10).")

    @property
    def smoothed_samples(self) -> int:
        """Samples that are averaged before an apex is read off."""
        return self.window_samples


def published_jumps(log: Log, parameters: PublishedParameters) -> tuple[Jump, ...]:
    """Return the jumps of a log.

    The apex is the highest value of the moving average in the flight after a stance, its time the mean time of the
    samples averaged. The rule has no standard error and fits no curvature.
    """
    signal, hops, width = log.signal, find_hops(log), parameters.window_samples
    no_error, no_curvature = Undefined(Reason.RULE_WITHOUT_ERROR), Undefined(Reason.RULE_WITHOUT_CURVATURE)
    jumps = []
    for number, hop in enumerate(hops, start=1):
        if isinstance(hop.apex, Undefined):
            jumps.append(jump_without_apex(number, log, hop, hop.apex))
            continue
        end_s = float(signal.time_s[min(hop.fallen, signal.time_s.size - 1)])
        first, last = np.searchsorted(log.time_s, [signal.time_s[hop.end], end_s]).tolist()
        # Averages whose middle lies in the flight: half a window more on either side.
        first = max(first - width // 2, 0)
        smooth = _moving_average(log.height_m[first : last + 1 + width // 2], width)
        if not np.isfinite(smooth).any():
            jumps.append(jump_without_apex(number, log, hop, Undefined(Reason.TOO_FEW_IN_A_ROW, needed=width)))
            continue
        highest = int(np.argmax(np.where(np.isfinite(smooth), smooth, -np.inf)))
        apex_s = float(np.mean(log.time_s[first + highest : first + highest + width]))
        following = hops[number] if number < len(hops) else None
        liftoff_s = liftoff_from_leg(log, hop)
        if isinstance(liftoff_s, Undefined):
            liftoff_s = float(signal.time_s[hop.end])
        apex = apex_s, float(smooth[highest]), no_error
        jumps.append(jump_out_of(number, log, hop, following, liftoff_s, apex, end_s, width, no_curvature))
    return tuple(jumps)


def smoothing_bias_m(window_samples: int, interval_s: float, gravity_m_s2: float) -> float:
    """Return by how much a moving average lowers an apex on average: g (w / fs)^2 / 24.

    Exact for an apex that falls anywhere between two samples with equal probability: the average lowers an apex on
    a sample by g (w^2 - 1) / (24 fs^2), and the sampling grid adds g / (24 fs^2).
    """
    return gravity_m_s2 * (window_samples * interval_s) ** 2 / 24.0


def _moving_average(values: Floats, width: int) -> Floats:
    """Return the averages of `width` samples in a row, shape (n - width + 1,); empty when there are fewer."""
    if values.size < width:
        return np.empty(0)
    finite = np.where(np.isfinite(values), values, np.nan)
    return np.convolve(finite, np.full(width, 1.0 / width), mode="valid")


@dataclass(frozen=True, slots=True)
class RobustParameters:
    """Parameters of the robust detector."""

    stance: StanceParameters = field(default_factory=StanceParameters)
    window: FlightWindowParameters = field(default_factory=FlightWindowParameters)
    curvature_tolerance: float = 0.25
    """An apex curves within this share of gravity, plus three standard errors; hand motion does not."""
    curvature_flag: float = 0.1
    """A curvature further from gravity than this share, plus three standard errors, is flagged."""
    samples_per_side_min: int = 3
    """Fewest samples on either side of the apex."""
    samples_per_side_few: int = 6
    """Fewer than this on a side is flagged."""
    catch_early_s: float = 0.03
    """A window that ends sooner after the apex is flagged."""

    @property
    def smoothed_samples(self) -> int:
        """None: the parabola goes through raw samples."""
        return 0


def robust_jumps(log: Log, parameters: RobustParameters) -> tuple[Jump, ...]:
    """Return the jumps of a log.

    Dropouts and spikes are left out, stances found on a running median, and a parabola fitted to raw samples from
    lift-off to where the body leaves it, at most `half_window_s` to either side.
    """
    return _flown(log, find_hops(log), parameters)


def _flown(log: Log, hops: list[Hop], parameters: RobustParameters) -> tuple[Jump, ...]:
    """Return the jumps of stances in their order, each with the flight about its maximum."""
    liftoffs = [liftoff_from_leg(log, hop) for hop in hops]
    fitted = fit_flights(log, hops, liftoffs, parameters.window)
    flights = [flight if isinstance(flight, Undefined) else _checked(flight, parameters) for flight in fitted]

    unseen = {
        row: flight
        for row, flight in enumerate(flights)
        if isinstance(flight, Flight) and isinstance(liftoffs[row], Undefined)
    }
    if unseen:
        found = departures(log, [hops[row] for row in unseen], list(unseen.values()), parameters.window)
        for row, liftoff_s in zip(unseen, found, strict=True):
            in_gap = hops[row].end == hops[row].begin + 1
            liftoffs[row] = Undefined(Reason.FLIGHT_ENDS_UNKNOWN) if in_gap else liftoff_s

    jumps, few = [], parameters.samples_per_side_few
    for row, (hop, flight) in enumerate(zip(hops, flights, strict=True)):
        if isinstance(flight, Undefined):
            jumps.append(jump_without_apex(row + 1, log, hop, flight))
            continue
        flags = {
            "few_samples_before": flight.before < few,
            "few_samples_after": flight.after < few,
            "caught_early": flight.right_s - flight.apex_s < parameters.catch_early_s,
            "curvature_off": _off_gravity(flight, parameters.curvature_flag, parameters),
        }
        following = hops[row + 1] if row + 1 < len(hops) else None
        apex, used = (flight.apex_s, flight.height_m, flight.height_se_m), flight.before + flight.after
        raised = tuple(flag for flag, is_raised in flags.items() if is_raised)
        about = liftoffs[row], apex, flight.right_s, used, flight.curvature_m_s2, raised
        jumps.append(jump_out_of(row + 1, log, hop, following, *about))
    return tuple(jumps)


def _checked(flight: Flight, parameters: RobustParameters) -> Flight | Undefined:
    """Return the flight, or why it is not one: it does not curve like gravity, or too few samples on a side."""
    if _off_gravity(flight, parameters.curvature_tolerance, parameters):
        return Undefined(Reason.NO_FREE_FLIGHT, curvature_m_s2=flight.curvature_m_s2)
    for count, side in ((flight.before, "before"), (flight.after, "after")):
        if count < parameters.samples_per_side_min:
            needed = parameters.samples_per_side_min
            return Undefined(Reason.TOO_FEW_BESIDE_APEX, count=count, side=side, needed=needed)
    return flight


def _off_gravity(flight: Flight, share: float, parameters: RobustParameters) -> bool:
    gravity = parameters.stance.gravity_m_s2
    return abs(flight.curvature_m_s2 - gravity) > share * gravity + 3.0 * flight.curvature_se_m_s2


__all__ = [
    "DETECTORS",
    "FLAGS",
    "Detector",
    "Jump",
    "Jumps",
    "PublishedParameters",
    "RobustParameters",
    "find_jumps",
    "jump_at",
]

Parameters = PublishedParameters | RobustParameters
"""Frozen dataclasses of plain numbers, nested; `dataclasses.asdict` makes them JSON."""


@dataclass(frozen=True, slots=True)
class Detector:
    """One way to find jumps; its version changes whenever its results may."""

    name: str
    version: int
    function: Callable[..., tuple[Jump, ...]]
    """(log, parameters) -> jumps."""
    parameters: Parameters
    """The defaults."""


DETECTORS: dict[str, Detector] = {
    detector.name: detector
    for detector in (
        Detector("published", 6, published_jumps, PublishedParameters()),
        Detector("robust", 7, robust_jumps, RobustParameters()),
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
    time, height, leg, missing = _arrays(time_s, body_height_m, leg_length_m, gaps)
    found: tuple[Jump, ...] = ()
    zero_m = 0.0

    def lowered_by(by_m: float, parameters: Parameters) -> Log:
        return _log(time, height - by_m, leg, missing, rest_length_m, parameters)

    if time.size:
        found = chosen.function(lowered_by(0.0, settings), settings)
        zero_m = height_zero_m(time, height, leg, rest_length_m, settings.stance.stance_depth_m)
    if zero_m:
        robust = RobustParameters()
        for _pass in range(2):  # the first finds flights from where the body stands, which is below its rest length
            lowered = robust_jumps(lowered_by(zero_m, robust), robust)
            zero_m = _zero_of_liftoffs(time, height, lowered, rest_length_m) or zero_m
        lowered = chosen.function(lowered_by(zero_m, settings), settings)
        if _flights(lowered) > _flights(found):
            found = tuple(_raised(jump, zero_m) for jump in lowered)
    return Jumps(
        detector=chosen.name,
        version=chosen.version,
        parameters=settings,
        smoothing_bias_m=smoothing_bias_m(
            settings.smoothed_samples, sampling_interval(time), settings.stance.gravity_m_s2
        ),
        zero_m=zero_m,
        jumps=found,
    )


def _arrays(
    time_s: ArrayLike, body_height_m: ArrayLike, leg_length_m: ArrayLike | None, gaps: ArrayLike | None
) -> tuple[Floats, Floats, Floats | None, Floats]:
    """Return the arrays of a log, checked, and its gaps as `find_jumps` has them."""
    time, height = np.asarray(time_s, np.float64), np.asarray(body_height_m, np.float64)
    leg: Floats | None = None if leg_length_m is None else np.asarray(leg_length_m, np.float64)
    missing = np.empty((0, 2)) if gaps is None else np.asarray(gaps, np.float64).reshape(-1, 2)
    check_log(time, height, leg, missing)
    return time, height, leg, gaps_in_time(time) if gaps is None else missing


def _log(
    time_s: Floats,
    height_m: Floats,
    leg_m: Floats | None,
    gaps: Floats,
    rest_length_m: float,
    parameters: Parameters,
) -> Log:
    stance = parameters.stance
    signal = clean_signal(time_s, height_m, leg_m, gaps, stance.cleaning)
    return Log(time_s, height_m, gaps, signal, rest_length_m, stance)


def jump_at(
    time_s: ArrayLike,
    body_height_m: ArrayLike,
    at_s: float,
    *,
    rest_length_m: float,
    leg_length_m: ArrayLike | None = None,
    gaps: ArrayLike | None = None,
) -> Jump | Undefined:
    """Return the jump that a person sees at a time: the flight about it, with the parabola of the robust detector.

    The arguments but `at_s`, in seconds on the log's own time axis, are those of `find_jumps`. The apex is the highest
    point of the parabola that is fitted about that time; it is undefined, as for the detector, where the body is not in
    flight there, where too few samples lie on a side of it, and where it does not curve like gravity. The jump has
    the number 1. Raises `InputRefused` as `find_jumps` does, and for a time that is not finite.
    """
    at_s = as_number("the time of the apex", at_s)
    found = find_jumps(time_s, body_height_m, rest_length_m=rest_length_m, leg_length_m=leg_length_m, gaps=gaps)
    time, height, leg, missing = _arrays(time_s, body_height_m, leg_length_m, gaps)
    parameters = RobustParameters()
    raised_m = found.zero_m if any(ZERO_DOUBTFUL in jump.flags for jump in found.jumps) else 0.0
    log = _log(time, height - raised_m, leg, missing, rest_length_m, parameters)
    around = flight_around(log, at_s)
    if isinstance(around, Undefined):
        return around
    hop, following = around
    jump = _flown(log, [hop, *([] if following is None else [following])], parameters)[0]
    if isinstance(jump.apex_height_m, Undefined):
        return jump.apex_height_m
    apex_s, liftoff_s = jump.apex_s, jump.liftoff_s
    longest_s2 = 2.0 * jump.apex_height_m / parameters.stance.gravity_m_s2  # of a free rise from the ground, squared
    if isinstance(apex_s, float) and isinstance(liftoff_s, float) and (apex_s - liftoff_s) ** 2 > longest_s2:
        unknown = Undefined(Reason.FLIGHT_ENDS_UNKNOWN)  # it was held between lift-off and the time
        jump = replace(jump, liftoff_s=unknown, flight_time_s=unknown)
    return _raised(jump, raised_m) if raised_m else jump


def _flights(jumps: tuple[Jump, ...]) -> int:
    return sum(not isinstance(jump.apex_height_m, Undefined) for jump in jumps)


def _zero_of_liftoffs(time_s: Floats, body_height_m: Floats, jumps: tuple[Jump, ...], rest_length_m: float) -> float:
    """Return the height at which the body usually leaves the ground, over the leg's rest length; 0 where unknown."""
    liftoffs_s = [jump.liftoff_s for jump in jumps if isinstance(jump.liftoff_s, float)]
    known = np.isfinite(body_height_m)
    if not liftoffs_s:
        return 0.0
    return float(np.median(np.interp(liftoffs_s, time_s[known], body_height_m[known]))) - rest_length_m


def _raised(jump: Jump, by_m: float) -> Jump:
    """Return a jump found in heights that were lowered, with its height as it was measured."""
    if isinstance(jump.apex_height_m, Undefined):
        return jump
    return replace(jump, apex_height_m=jump.apex_height_m + by_m, flags=(*jump.flags, ZERO_DOUBTFUL))
