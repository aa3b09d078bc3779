"""The robust detector: after each stance a flight that curves like gravity, measured by a robust parabola."""

from __future__ import annotations

from dataclasses import dataclass, field

from data_schema.vocabulary import Undefined
from stats.apexes.cleaning import CleanSignal, Floats, clean_signal
from stats.apexes.flights import Flight, FlightWindowParameters, departures, fit_flights
from stats.apexes.jumps import Jump
from stats.apexes.stance import (
    Hop,
    StanceParameters,
    find_hops,
    gap_in_flight,
    jump_without_apex,
    landing,
    liftoff_from_leg,
)


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


def robust_jumps(
    time_s: Floats,
    body_height_m: Floats,
    leg_length_m: Floats | None,
    gaps: Floats,
    rest_length_m: float,
    parameters: RobustParameters,
) -> tuple[Jump, ...]:
    """Return the jumps of a log; arrays of shape (n,) in seconds and metres, gaps (n_gaps, 2): start and length.

    Dropouts and spikes are left out, stances found on a running median, and a parabola fitted to raw samples from
    lift-off to where the body leaves it, at most `half_window_s` to either side.
    """
    stance, window = parameters.stance, parameters.window
    signal = clean_signal(time_s, body_height_m, leg_length_m, gaps, stance.cleaning)
    hops = find_hops(signal, rest_length_m, stance)
    liftoffs = [liftoff_from_leg(signal, hop, rest_length_m, stance) for hop in hops]
    fitted = fit_flights(signal, hops, liftoffs, rest_length_m, stance.gravity_m_s2, window)
    flights = [flight if isinstance(flight, Undefined) else _checked(flight, parameters) for flight in fitted]

    unseen = {
        row: flight
        for row, flight in enumerate(flights)
        if isinstance(flight, Flight) and isinstance(liftoffs[row], Undefined)
    }
    if unseen:
        found = departures(signal, [hops[row] for row in unseen], list(unseen.values()), stance.gravity_m_s2, window)
        for row, liftoff_s in zip(unseen, found, strict=True):
            liftoffs[row] = liftoff_s

    jumps = []
    for row, (hop, flight) in enumerate(zip(hops, flights, strict=True)):
        if isinstance(flight, Undefined):
            jumps.append(jump_without_apex(row + 1, hop, flight.reason, signal, gaps, stance))
        else:
            following = hops[row + 1] if row + 1 < len(hops) else None
            jumps.append(_jump(row + 1, hop, following, liftoffs[row], flight, signal, gaps, rest_length_m, parameters))
    return tuple(jumps)


def _checked(flight: Flight, parameters: RobustParameters) -> Flight | Undefined:
    """Return the flight, or why it is not one: it does not curve like gravity, or too few samples on a side."""
    if _off_gravity(flight, parameters.curvature_tolerance, parameters):
        return Undefined(
            f"the highest point after this stance curves at {flight.curvature_m_s2:.1f} m/s^2, which is not gravity: "
            "no free flight"
        )
    for count, side in ((flight.before, "before"), (flight.after, "after")):
        if count < parameters.samples_per_side_min:
            needed = parameters.samples_per_side_min
            return Undefined(f"there are {count} valid samples {side} the apex and at least {needed} are needed")
    return flight


def _off_gravity(flight: Flight, share: float, parameters: RobustParameters) -> bool:
    gravity = parameters.stance.gravity_m_s2
    return abs(flight.curvature_m_s2 - gravity) > share * gravity + 3.0 * flight.curvature_se_m_s2


def _jump(
    number: int,
    hop: Hop,
    following: Hop | None,
    liftoff_s: float | Undefined,
    flight: Flight,
    signal: CleanSignal,
    gaps: Floats,
    rest_length_m: float,
    parameters: RobustParameters,
) -> Jump:
    landing_s, extrapolated = landing(
        flight.apex_s, flight.height_m, flight.curvature_m_s2, following, rest_length_m, parameters.stance
    )
    few = parameters.samples_per_side_few
    flags = {
        "landing_extrapolated": extrapolated,
        "few_samples_before": flight.before < few,
        "few_samples_after": flight.after < few,
        "caught_early": flight.right_s - flight.apex_s < parameters.catch_early_s,
        "curvature_off": _off_gravity(flight, parameters.curvature_flag, parameters),
    }
    flight_time_s: float | Undefined = Undefined("lift-off or landing is not known")
    if isinstance(landing_s, float) and isinstance(liftoff_s, float):
        flight_time_s = landing_s - liftoff_s
    end_s = flight.right_s
    if isinstance(landing_s, float) and not extrapolated:
        end_s = landing_s + parameters.stance.gap_margin_s
    return Jump(
        number=number,
        touchdown_s=hop.touchdown_s,
        liftoff_s=liftoff_s,
        apex_s=flight.apex_s,
        apex_height_m=flight.height_m,
        apex_height_se_m=flight.height_se_m,
        flight_time_s=flight_time_s,
        samples_used=flight.before + flight.after,
        curvature_m_s2=flight.curvature_m_s2,
        gap_touched=gap_in_flight(gaps, signal, hop, liftoff_s, end_s, parameters.stance),
        flags=tuple(flag for flag, raised in flags.items() if raised),
    )
