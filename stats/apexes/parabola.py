"""Robust quadratic through raw samples, many windows at once: height, time, standard error and curvature of an apex.

Bisquare (Tukey) weights with a scale from the median absolute residual, iterated from least squares; the standard
error is Huber's for M-estimates. A quadratic has no smoothing bias, and a spike or a dropout moves it by nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stats.apexes.cleaning import Bools, Floats

_TUNING = 4.685
"""Bisquare constant for 95 % efficiency on normal noise (Holland and Welsch 1977)."""
_ITERATIONS = 12
_SCALE_FLOOR_M = 1e-9
"""Noise-free samples have no scale; a nanometre is below every sensor."""
MINIMUM_SAMPLES = 5


@dataclass(frozen=True, slots=True)
class Windows:
    """Samples of k windows side by side, padded to one width: arrays of shape (k, width) unless said otherwise."""

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
class Parabolas:
    """Apexes of k windows; every array has shape (k,). Only where `defined` do the numbers mean anything."""

    defined: Bools
    """At least five samples and a highest point (not a lowest one)."""
    apex_s: Floats
    apex_height_m: Floats
    apex_height_se_m: Floats
    curvature_m_s2: Floats
    """Downward acceleration."""
    curvature_se_m_s2: Floats
    residual_sd_m: Floats
    """Robust standard deviation of the samples about the parabola."""
    samples_before: NDArray[np.int64]
    """Samples with weight before the apex."""
    samples_after: NDArray[np.int64]


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


def fit_parabolas(time_s: Floats, height_m: Floats, around_s: Floats, left_s: Floats, right_s: Floats) -> Parabolas:
    """Fit one parabola to each window of raw valid samples and return its highest point.

    `time_s` and `height_m` have shape (n,), seconds increasing and metres; windows have shape (k,) and run from
    `left_s` to `right_s` around `around_s`. Source: robust quadratic, statistics of apex estimation: bias below
    0.02 mm and RMSE 0.15 mm for a 0.11 s window at 1 kHz with 1 mm of noise.
    """
    k = around_s.size
    if k == 0 or time_s.size == 0:
        zeros, none = np.zeros(k), np.zeros(k, dtype=np.int64)
        return Parabolas(none > 0, zeros, zeros, zeros, zeros, zeros, zeros, none, none)
    scale_s = max(float(np.max(np.maximum(around_s - left_s, right_s - around_s))), np.finfo(np.float64).tiny)
    windows = gather(time_s, height_m, around_s, left_s, right_s, scale_s)
    fit = least_squares(windows, windows.valid.astype(np.float64))
    residuals = windows.rise_m - fit.at(windows.tau)
    for _ in range(_ITERATIONS):
        weights = bisquare_weights(residuals, windows.valid, robust_scale(residuals, windows.valid))
        fit = least_squares(windows, weights)
        residuals = windows.rise_m - fit.at(windows.tau)
    scale = robust_scale(residuals, windows.valid)
    covariance = _covariance(windows, residuals, scale)

    constant, linear, square = fit.coefficients.T
    defined = fit.solved & (square < 0.0)
    safe = np.where(defined, square, -1.0)
    tau_apex = -linear / (2.0 * safe)
    gradient = np.stack([np.ones(k), tau_apex, tau_apex * tau_apex], axis=1)
    used = bisquare_weights(residuals, windows.valid, scale) > 0.0
    before = windows.tau < tau_apex[:, np.newaxis]
    return Parabolas(
        defined=defined,
        apex_s=around_s + scale_s * tau_apex,
        apex_height_m=windows.reference_m + constant + 0.5 * linear * tau_apex,
        apex_height_se_m=np.sqrt(np.einsum("ki,kij,kj->k", gradient, covariance, gradient)),
        curvature_m_s2=-2.0 * square / scale_s**2,
        curvature_se_m_s2=2.0 * np.sqrt(covariance[:, 2, 2]) / scale_s**2,
        residual_sd_m=scale,
        samples_before=np.count_nonzero(used & before, axis=1),
        samples_after=np.count_nonzero(used & ~before, axis=1),
    )


def _covariance(windows: Windows, residuals: Floats, scale: Floats) -> Floats:
    """Return Huber's covariance of the coefficients: scale^2 [sum psi^2 / (n - 3)] / [mean psi']^2 (X'X)^-1."""
    n = windows.valid.sum(axis=1)
    u = residuals / (_TUNING * scale[:, np.newaxis])
    inside = windows.valid & (np.abs(u) < 1.0)
    psi = np.where(inside, residuals * (1.0 - u * u) ** 2, 0.0)
    slope = np.where(inside, (1.0 - u * u) * (1.0 - 5.0 * u * u), 0.0).sum(axis=1) / np.maximum(n, 1)
    variance = (psi * psi).sum(axis=1) / np.maximum(n - 3, 1) / np.maximum(slope, 0.1) ** 2
    unweighted = least_squares(windows, windows.valid.astype(np.float64)).inverse
    covariance: Floats = variance[:, np.newaxis, np.newaxis] * unweighted
    return covariance
