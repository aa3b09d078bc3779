"""Free flights of a log: from lift-off to landing or catch, each with the parabola through its raw samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from data_schema.vocabulary import Undefined
from stats.apexes.cleaning import CleanSignal
from stats.apexes.flight_window import FlightWindowParameters, window_ends
from stats.apexes.parabola import fit_parabolas
from stats.apexes.stance import Hop


@dataclass(frozen=True, slots=True)
class Flight:
    """The parabola through one flight."""

    apex_s: float
    height_m: float
    height_se_m: float
    curvature_m_s2: float
    """Downward acceleration."""
    curvature_se_m_s2: float
    before: int
    """Samples with weight before the apex."""
    after: int
    left_s: float
    """First moment of the window that was fitted."""
    right_s: float
    """Its last: the catch, the landing, or the longest reach."""


def fit_flights(
    signal: CleanSignal,
    hops: list[Hop],
    liftoffs: list[float | Undefined],
    rest_length_m: float,
    gravity_m_s2: float,
    window: FlightWindowParameters,
) -> list[Flight | Undefined]:
    """Return one flight per hop, all fitted at once; `Undefined` where a hop has no maximum or too few samples.

    A window begins at lift-off or, where that is not known yet, when the body rises through the rest length: the
    foot cannot touch the ground above it. It ends where the body falls through it, or at the catch.
    """
    flying = [(row, hop.apex) for row, hop in enumerate(hops) if isinstance(hop.apex, int)]
    time_s = signal.time_s
    coarse_s = time_s[[apex for _, apex in flying]]
    left_s, limit_s = coarse_s - window.half_window_s, coarse_s + window.half_window_s
    for at, (row, apex) in enumerate(flying):
        liftoff_s = liftoffs[row]
        begin_s = float(time_s[hops[row].end]) if isinstance(liftoff_s, Undefined) else liftoff_s
        left_s[at] = max(left_s[at], begin_s)
        below = np.flatnonzero(signal.coarse_m[apex : np.searchsorted(time_s, limit_s[at])] < rest_length_m)
        if below.size:
            limit_s[at] = time_s[apex + below[0] - 1]
    right_s = window_ends(time_s, signal.height_m, coarse_s, left_s, limit_s, signal.noise_sd_m, gravity_m_s2, window)
    fits = fit_parabolas(time_s, signal.height_m, coarse_s, left_s, right_s)
    few = Undefined("too few valid samples around the highest point after this stance, or it is no maximum")
    flights: dict[int, Flight | Undefined] = {}
    for at, (row, _) in enumerate(flying):
        flights[row] = few
        if fits.defined[at]:
            flights[row] = Flight(
                apex_s=float(fits.apex_s[at]),
                height_m=float(fits.apex_height_m[at]),
                height_se_m=float(fits.apex_height_se_m[at]),
                curvature_m_s2=float(fits.curvature_m_s2[at]),
                curvature_se_m_s2=float(fits.curvature_se_m_s2[at]),
                before=int(fits.samples_before[at]),
                after=int(fits.samples_after[at]),
                left_s=float(left_s[at]),
                right_s=float(right_s[at]),
            )
    return [hop.apex if isinstance(hop.apex, Undefined) else flights[row] for row, hop in enumerate(hops)]


def departures(
    signal: CleanSignal,
    hops: list[Hop],
    flights: list[Flight],
    gravity_m_s2: float,
    window: FlightWindowParameters,
) -> list[float | Undefined]:
    """Return the lift-offs of a log without leg length: where, backward in time, the body leaves its parabola.

    The same search as for a catch, in reversed time. The leg's force fades to nothing at lift-off, so the body
    leaves its parabola slowly and this is some 0.01 s late.
    """
    begin_s = signal.time_s[[hop.begin for hop in hops]]
    found_s = -window_ends(
        -signal.time_s[::-1],
        signal.height_m[::-1],
        np.array([-flight.apex_s for flight in flights]),
        np.array([-flight.right_s for flight in flights]),
        -begin_s,
        signal.noise_sd_m,
        gravity_m_s2,
        window,
    )
    never = Undefined("the body left its parabola nowhere between touchdown and apex")
    return [at if at > begin else never for at, begin in zip(found_s.tolist(), begin_s.tolist(), strict=True)]
