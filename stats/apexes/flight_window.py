"""How far a parabola holds after an apex: the hand that catches the robot ends the flight before it lands.

A catch adds an acceleration from some moment c on, so that the height gains a (t - c)^2 / 2. For growing right ends
of the window the size of that term is tested for several c at once, beside a quadratic whose curvature is known
roughly (gravity); the first end with a significant term closes the window at its most likely c.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stats.apexes.cleaning import Floats
from stats.apexes.parabola import Windows, gather, least_squares, robust_scale


@dataclass(frozen=True, slots=True)
class FlightWindowParameters:
    """Which samples around an apex the parabola is fitted to."""

    half_window_s: float = 0.08
    """Longest reach to either side, inside the flight: 0.16 s of the 0.35 s of a 0.15 m hop."""
    look_ahead_s: float = 0.03
    """A catch is looked for this much beyond the window: it takes that long to be told from noise."""
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
    reach = round(parameters.reach_s / parameters.step_s)
    ends = (limit_s - apex_s) / scale_s
    open_still = np.ones(apex_s.size, dtype=np.bool_)
    last = float(np.max(windows.tau, initial=0.0))
    for right in range(4, int(last / step) + 2, 2):
        begins = step * np.arange(max(2, right - reach), right - 1, 2, dtype=np.float64)
        z = _catch_z(windows, windows.valid & (windows.tau <= right * step), begins, sd, gravity_m_s2, parameters)
        strongest = np.argmax(z, axis=1)
        caught = open_still & (z[np.arange(apex_s.size), strongest] > parameters.catch_z)
        ends[caught] = np.minimum(ends[caught], begins[strongest[caught]])
        open_still &= ~caught
        if not open_still.any():
            break
    result: Floats = apex_s + ends * scale_s
    return result


def _noise(windows: Windows, noise_sd_m: float, parameters: FlightWindowParameters) -> float:
    """Return one noise level for all flights of a log: they share a sensor, and one window knows it badly."""
    rising = windows.valid & (windows.tau <= 0.0)
    fit = least_squares(windows, rising.astype(np.float64))
    scales = robust_scale(windows.rise_m - fit.at(windows.tau), rising)[fit.solved]
    return max(noise_sd_m, parameters.resolution_m, float(np.median(scales)) if scales.size else 0.0)


def _catch_z(
    windows: Windows,
    used: np.ndarray[tuple[int, ...], np.dtype[np.bool_]],
    begins: Floats,
    sd: float,
    gravity_m_s2: float,
    parameters: FlightWindowParameters,
) -> Floats:
    """Return the strength of an upward push from each of `begins` on, in standard errors, shape (k, n_begins).

    The quadratic is taken out of the push's own column (Frisch and Waugh), the prior on curvature counting as one
    more observation.
    """
    tau, rise = windows.tau, windows.rise_m * used
    columns = np.stack([used, tau * used, tau * tau * used], axis=1).astype(np.float64)
    normal = np.einsum("kiw,kjw->kij", columns, columns)
    right = np.einsum("kiw,kw->ki", columns, rise)
    curvature = 0.5 * gravity_m_s2 * parameters.half_window_s**2
    prior = (sd / (parameters.gravity_share_sd * curvature)) ** 2
    normal[:, 2, 2] += prior
    right[:, 2] -= prior * curvature
    # With fewer than two samples offset and slope are free: a hint of a ridge keeps them finite, and nothing else.
    normal[:, [0, 1], [0, 1]] += 1e-9
    inverse = np.linalg.inv(normal)
    push = np.maximum(tau[:, np.newaxis, :] - begins[:, np.newaxis], 0.0) ** 2 * used[:, np.newaxis, :]
    shadow = np.einsum("kcw,kiw->kci", push, columns)
    explained = np.einsum("kci,kij,kj->kc", shadow, inverse, right)
    own = np.einsum("kcw,kcw->kc", push, push)
    left_over = own - np.einsum("kci,kij,kcj->kc", shadow, inverse, shadow)
    strength = np.einsum("kcw,kw->kc", push, rise) - explained
    known = left_over > 1e-9 * own
    z: Floats = np.where(known, strength / (sd * np.sqrt(np.where(known, left_over, 1.0))), 0.0)
    return z
