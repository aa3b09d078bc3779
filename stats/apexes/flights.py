"""Free flights of a log: from lift-off to landing or catch, each with the parabola through its raw samples.

A parabola holds until the robot lands or a hand catches it. A catch adds an acceleration from some moment c on, so that
the height gains a (t - c)^2 / 2. For growing right ends of the window the size of that term is tested for several c at
once, beside a quadratic whose curvature is known roughly (gravity); the first end with a significant term closes the
window at its most likely c.

The parabola is a robust quadratic through raw samples, fitted in many windows at once: bisquare (Tukey) weights with a
scale from the median absolute residual, iterated from least squares; the standard error is Huber's for M-estimates. A
quadratic has no smoothing bias, and a spike or a dropout moves it by nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.apexes.cleaning import Bools, Floats
from stats.apexes.jumps import Hop, Log
from stats.scatter import Value

_TUNING = 4.685
"""Bisquare constant for 95 % efficiency on normal noise (Holland and Welsch 1977)."""
_ITERATIONS = 12
_SCALE_FLOOR_M = 1e-9
"""Noise-free samples have no scale; a nanometre is below every sensor."""
MINIMUM_SAMPLES = 5
_SAME = 1e-9
"""Part by which strengths of two pushes differ that are the same but for rounding."""


@dataclass(frozen=True, slots=True)
class Windows:
    """Samples of k windows side by side, padded to one width: arrays of shape (k, width) unless noted otherwise."""

    tau: Floats
    """Time from each window's origin, in units of `scale_s`."""
    rise_m: Floats
    """Height above each window's reference; 0 in the padding."""
    valid: Bools
    """False in the padding."""
    origin_s: Floats
    """Shape (k,)."""
    reference_m: Floats
    """Shape (k,)."""
    scale_s: float


@dataclass(frozen=True, slots=True)
class Quadratics:
    """Weighted least-squares quadratics of k windows in (1, tau, tau^2)."""

    coefficients: Floats
    """Shape (k, 3); zeros where the window has too few samples."""
    inverse: Floats
    """Inverse of the normal matrix, shape (k, 3, 3)."""
    solved: Bools
    """Shape (k,)."""

    def at(self, tau: Floats) -> Floats:
        """Return the heights at `tau`, shape (k, width)."""
        c = self.coefficients[:, :, np.newaxis]
        return c[:, 0] + tau * (c[:, 1] + tau * c[:, 2])


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


def gather(
    time_s: Floats, height_m: Floats, origin_s: Floats, left_s: Floats, right_s: Floats, scale_s: float
) -> Windows:
    """Cut k windows (`left_s` to `right_s`, both included, shape (k,)) out of valid samples, shape (n,)."""
    first = np.searchsorted(time_s, left_s, side="left")
    last = np.searchsorted(time_s, right_s, side="right")
    width = max(1, int(np.max(last - first, initial=0)))
    at = first[:, np.newaxis] + np.arange(width)
    valid = at < last[:, np.newaxis]
    at = np.minimum(at, time_s.size - 1)
    reference = height_m[np.clip(np.searchsorted(time_s, origin_s), 0, time_s.size - 1)]
    tau = np.where(valid, (time_s[at] - origin_s[:, np.newaxis]) / scale_s, 0.0)
    rise = np.where(valid, height_m[at] - reference[:, np.newaxis], 0.0)
    return Windows(tau, rise, valid, origin_s, reference, scale_s)


def least_squares(windows: Windows, weights: Floats) -> Quadratics:
    """Fit all windows with weights of shape (k, width), 0 in the padding."""
    solved = np.count_nonzero(weights, axis=1) >= MINIMUM_SAMPLES
    powers = [weights]
    for _ in range(4):
        powers.append(powers[-1] * windows.tau)
    sums = np.stack([power.sum(axis=1) for power in powers], axis=1)
    normal = sums[:, [[0, 1, 2], [1, 2, 3], [2, 3, 4]]]
    right = np.stack([(power * windows.rise_m).sum(axis=1) for power in powers[:3]], axis=1)
    normal[~solved], right[~solved] = np.eye(3), 0.0
    inverse = np.linalg.inv(normal)
    return Quadratics(np.einsum("kij,kj->ki", inverse, right), inverse, solved)


def bisquare_weights(residuals: Floats, valid: Bools, scale: Floats) -> Floats:
    """Return Tukey's weights for residuals of shape (k, width) and scales of shape (k,)."""
    u = residuals / (_TUNING * scale[:, np.newaxis])
    return np.where(valid & (np.abs(u) < 1.0), (1.0 - u * u) ** 2, 0.0)


def robust_scale(residuals: Floats, valid: Bools) -> Floats:
    """Return 1.4826 times the median absolute residual, corrected for three fitted coefficients; shape (k,)."""
    n = valid.sum(axis=1)
    correction = np.sqrt(n / np.maximum(n - 3, 1))
    scale: Floats = np.maximum(1.4826 * correction * row_median(np.abs(residuals), valid), _SCALE_FLOOR_M)
    return scale


def row_median(values: Floats, valid: Bools) -> Floats:
    """Return the median of the valid entries of each row, shape (k,); 0 for a row without any."""
    n = valid.sum(axis=1)
    ordered = np.sort(np.where(valid, values, np.inf), axis=1)
    rows = np.arange(len(ordered))
    low, high = np.maximum(n - 1, 0) // 2, np.minimum(n // 2, ordered.shape[1] - 1)
    median: Floats = np.where(n > 0, 0.5 * (ordered[rows, low] + ordered[rows, high]), 0.0)
    return median


def fit_parabolas(
    time_s: Floats, height_m: Floats, around_s: Floats, left_s: Floats, right_s: Floats
) -> list[Flight | None]:
    """Fit one parabola to each window of raw valid samples, None where it has fewer than five or no highest point.

    `time_s` and `height_m` have shape (n,), seconds increasing and metres; windows have shape (k,) and run from
    `left_s` to `right_s` around `around_s`. Source: robust quadratic, statistics of apex estimation: bias below
    0.02 mm and RMSE 0.15 mm for a 0.11 s window at 1 kHz with 1 mm of noise.
    """
    k = around_s.size
    if k == 0 or time_s.size == 0:
        return [None] * k
    scale_s = max(float(np.max(np.maximum(around_s - left_s, right_s - around_s))), np.finfo(np.float64).tiny)
    windows = gather(time_s, height_m, around_s, left_s, right_s, scale_s)
    unweighted = fit = least_squares(windows, windows.valid.astype(np.float64))
    residuals = windows.rise_m - fit.at(windows.tau)
    for _ in range(_ITERATIONS):
        weights = bisquare_weights(residuals, windows.valid, robust_scale(residuals, windows.valid))
        fit = least_squares(windows, weights)
        residuals = windows.rise_m - fit.at(windows.tau)
    scale = robust_scale(residuals, windows.valid)
    covariance = _covariance(windows, residuals, scale, unweighted.inverse)

    constant, linear, square = fit.coefficients.T
    defined = fit.solved & (square < 0.0)
    safe = np.where(defined, square, -1.0)
    tau_apex = -linear / (2.0 * safe)
    gradient = np.stack([np.ones(k), tau_apex, tau_apex * tau_apex], axis=1)
    used = bisquare_weights(residuals, windows.valid, scale) > 0.0
    before = windows.tau < tau_apex[:, np.newaxis]
    columns = (
        defined,
        around_s + scale_s * tau_apex,
        windows.reference_m + constant + 0.5 * linear * tau_apex,
        np.sqrt(np.einsum("ki,kij,kj->k", gradient, covariance, gradient)),
        -2.0 * square / scale_s**2,
        2.0 * np.sqrt(covariance[:, 2, 2]) / scale_s**2,
        np.count_nonzero(used & before, axis=1),
        np.count_nonzero(used & ~before, axis=1),
        left_s,
        right_s,
    )
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return [Flight(*numbers) if is_flight else None for is_flight, *numbers in rows]


def _covariance(windows: Windows, residuals: Floats, scale: Floats, inverse: Floats) -> Floats:
    """Return Huber's covariance: scale^2 [sum psi^2 / (n - 3)] / [mean psi']^2 times `inverse`, (X'X)^-1."""
    n = windows.valid.sum(axis=1)
    u = residuals / (_TUNING * scale[:, np.newaxis])
    inside = windows.valid & (np.abs(u) < 1.0)
    psi = np.where(inside, residuals * (1.0 - u * u) ** 2, 0.0)
    slope = np.where(inside, (1.0 - u * u) * (1.0 - 5.0 * u * u), 0.0).sum(axis=1) / np.maximum(n, 1)
    variance = (psi * psi).sum(axis=1) / np.maximum(n - 3, 1) / np.maximum(slope, 0.1) ** 2
    covariance: Floats = variance[:, np.newaxis, np.newaxis] * inverse
    return covariance


@dataclass(frozen=True, slots=True)
class FlightWindowParameters:
    """Which samples around an apex the parabola is fitted to."""

    half_window_s: float = 0.08
    """Longest reach to either side, inside the flight: 0.16 s of the 0.35 s of a 0.15 m hop."""
    look_ahead_s: float = 0.03
    """A catch is looked for this much beyond the window: it takes that long to differ from noise."""
    step_s: float = 0.004
    """Spacing of the moments at which a catch may begin."""
    reach_s: float = 0.04
    """A catch is tested on at most this much motion after it; the hand's later motion is no parabola."""
    catch_z: float = 3.5
    """The catch must be this many standard errors strong."""
    gravity_share_sd: float = 0.05
    """How well gravity is known beforehand, as a share: rail friction and the sensor's string change it."""
    resolution_m: float = 0.0003
    """Least standard deviation of a sample in these tests: a 10-bit sensor over 1 m, or friction in a true flight."""


def window_ends(
    time_s: Floats,
    height_m: Floats,
    apex_s: Floats,
    left_s: Floats,
    limit_s: Floats,
    noise_sd_m: float,
    gravity_m_s2: float,
    parameters: FlightWindowParameters,
) -> Floats:
    """Return where the window of each flight ends, shape (k,): at `limit_s`, or where a catch begins.

    `time_s`, `height_m`: valid samples, shape (n,), seconds and metres; `left_s` the windows' beginnings, `limit_s`
    their latest ends, `apex_s` the coarse apexes; a catch may begin two steps after them.
    """
    scale_s = parameters.half_window_s
    windows = gather(time_s, height_m, apex_s, left_s, limit_s + parameters.look_ahead_s, scale_s)
    sd = _noise(windows, noise_sd_m, parameters)
    step = parameters.step_s / scale_s
    moments = step * np.arange(0, int(np.max(windows.tau, initial=0.0) / step) + 2, 2, dtype=np.float64)
    z = _catch_z(windows, moments, sd, gravity_m_s2, parameters)
    caught = np.any(z > parameters.catch_z, axis=2)
    rows = np.flatnonzero(caught.any(axis=1))
    right = np.argmax(caught[rows], axis=1)
    ends = (limit_s - apex_s) / scale_s
    # With one sample since a gap, pushes from anywhere in the gap are as strong: rounding must not choose among them.
    strongest = z[rows, right] >= (1.0 - _SAME) * z[rows, right].max(axis=1, keepdims=True)
    ends[rows] = np.minimum(ends[rows], moments[right - z.shape[2] + np.argmax(strongest[:, ::-1], axis=1)])
    return apex_s + ends * scale_s


def _noise(windows: Windows, noise_sd_m: float, parameters: FlightWindowParameters) -> float:
    """Return one noise level for all flights of a log: they share a sensor, and one window knows it badly."""
    rising = windows.valid & (windows.tau <= 0.0)
    fit = least_squares(windows, rising.astype(np.float64))
    scales = robust_scale(windows.rise_m - fit.at(windows.tau), rising)[fit.solved]
    return max(noise_sd_m, parameters.resolution_m, float(np.median(scales)) if scales.size else 0.0)


def _catch_z(
    windows: Windows, moments: Floats, sd: float, gravity_m_s2: float, parameters: FlightWindowParameters
) -> Floats:
    """Return the strength of upward pushes in standard errors, shape (k, n, n_back); 0 where none may begin.

    [:, right, back - 1] is of the samples up to `moments[right]` and a push from `moments[right - back]` on. The
    quadratic is taken out of the push's own column (Frisch and Waugh), the prior on curvature being one observation.
    """
    sums, rise_sums = (np.cumsum(found, axis=2) for found in _power_sums(windows, moments, np.zeros(moments.size)))
    curvature = 0.5 * gravity_m_s2 * parameters.half_window_s**2
    prior = (sd / (parameters.gravity_share_sd * curvature)) ** 2
    rise_sums[2] -= prior * curvature
    # With fewer than two samples offset and slope are free: a hint of a ridge keeps them finite, and nothing else.
    by_0, by_1, by_2 = sums[0] + 1e-9, sums[2] + 1e-9, sums[4] + prior
    # The normal matrix of each quadratic is made diagonal: its lower triangle, then what is left on the diagonal.
    low_10, low_20 = sums[1] / by_0, sums[2] / by_0
    by_1 = by_1 - low_10 * sums[1]
    low_21 = (sums[3] - low_20 * sums[1]) / by_1
    by_2 = by_2 - low_20 * sums[2] - low_21 * low_21 * by_1
    rise_1 = rise_sums[1] - low_10 * rise_sums[0]
    rise_2 = rise_sums[2] - low_20 * rise_sums[0] - low_21 * rise_1

    between, rise_between = _power_sums(windows, moments, np.concatenate([moments[:1], moments[:-1]]))
    push, pushed_rise = np.zeros_like(between), np.zeros_like(sums[0])
    z = np.zeros((*pushed_rise.shape, round(parameters.reach_s / parameters.step_s) // 2))
    for back in range(1, min(z.shape[2] + 1, moments.size - 1)):
        ends, begins = np.s_[:, back + 1 :], np.s_[:, 1 : moments.size - back]
        # Sums of powers of a time make those of a time whose origin is `early` before.
        early = moments[back - 1]
        later = np.array([[comb(to, of) * early ** max(to - of, 0) for of in range(5)] for to in range(5)])
        push[:, *begins] += np.tensordot(later, between[:, *ends], 1)
        pushed_rise[begins] += np.tensordot(later[2, :3], rise_between[:, *ends], 1)
        begin, (square, cube, own) = moments[begins[1]], push[2:, *begins]
        push_1 = cube + begin * square - low_10[ends] * square
        push_2 = own + begin * (2.0 * cube + begin * square) - low_20[ends] * square - low_21[ends] * push_1
        parts = (square / by_0[ends], push_1 / by_1[ends], push_2 / by_2[ends])
        left_over = own - parts[0] * square - parts[1] * push_1 - parts[2] * push_2
        explained = parts[0] * rise_sums[0][ends] + parts[1] * rise_1[ends] + parts[2] * rise_2[ends]
        known = left_over > 1e-9 * own
        strength = (pushed_rise[begins] - explained) / np.sqrt(np.where(known, left_over, 1.0))
        z[*ends, back - 1] = np.where(known, strength / sd, 0.0)
    return z


def _power_sums(windows: Windows, moments: Floats, origins: Floats) -> tuple[Floats, Floats]:
    """Sum powers of the time since an origin over samples, shape (5, k, n), and times the rise, shape (3, k, n).

    At [..., i] are the samples after `moments[i - 1]` up to `moments[i]`, of i = 0 all up to it, with `origins[i]`.
    """
    tau, rise_m = windows.tau[windows.valid], windows.rise_m[windows.valid]
    place = np.searchsorted(moments, tau)
    since = tau - origins[np.minimum(place, moments.size - 1)]
    shape = (len(windows.tau), moments.size + 1)
    place += np.nonzero(windows.valid)[0] * shape[1]
    powers, size = np.vander(since, 5, increasing=True).T, shape[0] * shape[1]
    weights = (*powers, *(powers[:3] * rise_m))
    sums = np.array([np.bincount(place, each, size) for each in weights], np.float64).reshape(8, *shape)[..., :-1]
    return sums[:5], sums[5:]


def fit_flights(
    log: Log, hops: list[Hop], liftoffs: list[Value], window: FlightWindowParameters
) -> list[Flight | Undefined]:
    """Return one flight per hop, all fitted at once; `Undefined` where a hop has no maximum or too few samples.

    A window begins at lift-off or, where that is not known yet, when the body rises through the rest length: the
    foot cannot touch the ground above it. It ends where the body falls through it, or at the catch.
    """
    flying = [(row, hop.apex) for row, hop in enumerate(hops) if isinstance(hop.apex, int)]
    signal, time_s = log.signal, log.signal.time_s
    coarse_s = time_s[[apex for _, apex in flying]]
    left_s, limit_s = coarse_s - window.half_window_s, coarse_s + window.half_window_s
    for at, (row, apex) in enumerate(flying):
        liftoff_s = liftoffs[row]
        begin_s = float(time_s[hops[row].end]) if isinstance(liftoff_s, Undefined) else liftoff_s
        left_s[at] = max(left_s[at], begin_s)
        below = np.flatnonzero(signal.coarse_m[apex : np.searchsorted(time_s, limit_s[at])] < log.rest_length_m)
        if below.size:
            limit_s[at] = time_s[apex + below[0] - 1]
    sds = signal.noise_sd_m, log.stance.gravity_m_s2
    right_s = window_ends(time_s, signal.height_m, coarse_s, left_s, limit_s, *sds, window)
    fits = fit_parabolas(time_s, signal.height_m, coarse_s, left_s, right_s)
    flights = {row: fit or Undefined(Reason.TOO_FEW_AROUND_APEX) for (row, _), fit in zip(flying, fits, strict=True)}
    return [hop.apex if isinstance(hop.apex, Undefined) else flights[row] for row, hop in enumerate(hops)]


def departures(log: Log, hops: list[Hop], flights: list[Flight], window: FlightWindowParameters) -> list[Value]:
    """Return the lift-offs of a log without leg length: where, backward in time, the body leaves its parabola.

    The same search as for a catch, in reversed time. The leg's force fades to nothing at lift-off, so the body
    leaves its parabola slowly and this is some 0.01 s late.
    """
    signal = log.signal
    begin_s = signal.time_s[[hop.begin for hop in hops]]
    found_s = -window_ends(
        -signal.time_s[::-1],
        signal.height_m[::-1],
        np.array([-flight.apex_s for flight in flights]),
        np.array([-flight.right_s for flight in flights]),
        -begin_s,
        signal.noise_sd_m,
        log.stance.gravity_m_s2,
        window,
    )
    never = Undefined(Reason.NEVER_LEFT_PARABOLA)
    return [at if at > begin else never for at, begin in zip(found_s.tolist(), begin_s.tolist(), strict=True)]
