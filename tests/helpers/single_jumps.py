"""Simulated jumps out of quiet standing: a smooth motion of the centre of mass, whose force on a plate is Newton's."""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import PchipInterpolator

from data_schema.units import STANDARD_GRAVITY_M_S2 as G

COUNTERMOVEMENT = (
    (0.0, 0.06, 0.12, 0.22, 0.30, 0.40, 0.48, 0.60, 0.72, 0.82, 0.90, 0.925),
    (1.0, 0.985, 0.9, 0.55, 0.42, 0.8, 1.5, 2.1, 2.3, 1.9, 0.5, 0.0),
)
"""Times in s and forces in weights, through which the force of the push-off runs smoothly."""
DEEP = (COUNTERMOVEMENT[0], (1.0, 0.985, 0.9, 0.2, 0.05, 0.5, 1.75, 2.4, 2.6, 2.2, 0.5, 0.0))
SQUAT = ((0.0, 0.05, 0.1, 0.2, 0.3, 0.38, 0.44, 0.47), (1.0, 1.02, 1.15, 1.6, 2.0, 1.9, 0.6, 0.0))
_SWAY_HZ = np.array([0.25, 0.6, 1.1, 2.2, 3.3, 5.1])
_SWAY_SHARES = np.array([0.15, 0.3, 1.0, 0.7, 0.4, 0.2])
LANDING_S = 0.25


class SimulatedJump:
    """Standing, one jump, standing again; `time_s` and `force_n` are the record, all else is the truth.

    The body sways in standing: a force of `sway_n` at the beat of the heart, and its overtones. A plate adds white
    noise, an offset, a drift and steps of its converter.
    """

    def __init__(
        self,
        seed: int,
        *,
        mass_kg: float = 60.0,
        rate_hz: float = 1200.0,
        noise_n: float = 1.0,
        sway_n: float = 2.0,
        drift_n_s: float = 0.0,
        offset_n: float = 0.0,
        step_n: float = 0.0,
        shape: tuple[tuple[float, ...], tuple[float, ...]] = COUNTERMOVEMENT,
        slower: float = 1.0,
        quiet_s: float = 2.0,
        after_s: float = 1.5,
    ) -> None:
        random = np.random.default_rng(seed)
        self.weight_n = mass_kg * G
        self.onset_s = quiet_s + random.uniform(0.0, 0.01)
        at_s = np.array(shape[0]) * slower * random.uniform(0.9, 1.1)
        weights = np.array(shape[1])
        weights[weights > 1.2] *= random.uniform(0.95, 1.05)
        push_n = PchipInterpolator(at_s, self.weight_n * weights)
        self.push_off_s = float(at_s[-1])
        self.take_off_s = self.onset_s + self.push_off_s
        hz, phase = _SWAY_HZ * random.uniform(0.9, 1.1, 6), random.uniform(0.0, 2.0 * math.pi, 6)
        size_n = sway_n * _SWAY_SHARES * random.normal(1.0, 0.3, 6)
        gained = float(push_n.integrate(0.0, self.push_off_s)) / mass_kg - G * self.push_off_s
        swayed = np.sum(size_n / (2.0 * math.pi * hz) * np.sin(2.0 * math.pi * hz * self.take_off_s + phase)) / mass_kg
        self.speed_m_s = gained + float(swayed)
        self.height_m = self.speed_m_s**2 / (2.0 * G)
        self.landing_s = self.take_off_s + 2.0 * self.speed_m_s / G
        self.time_s = np.arange(0.0, self.landing_s + after_s, 1.0 / rate_hz)
        sway = np.cos(2.0 * math.pi * np.multiply.outer(self.time_s, hz) + phase) @ size_n
        since_s, landed_s = self.time_s - self.onset_s, self.time_s - self.landing_s
        pushing = np.where(since_s < 0.0, self.weight_n, push_n(np.clip(since_s, 0.0, self.push_off_s)))
        braking = mass_kg * self.speed_m_s * math.pi / (2.0 * LANDING_S)
        stopping = self.weight_n + braking * np.sin(math.pi * np.clip(landed_s / LANDING_S, 0.0, 1.0))
        self.true_n = np.where(
            self.time_s < self.take_off_s,
            pushing + sway,
            np.where(landed_s < 0.0, 0.0, np.minimum(landed_s / 0.01, 1.0) * (stopping + sway)),
        )
        self.peak_n = float(self.true_n[self.time_s < self.take_off_s].max())
        plate_n = random.normal(0.0, noise_n, self.time_s.size) + offset_n + drift_n_s * self.time_s
        self.force_n = self.true_n + plate_n
        if step_n:
            self.force_n = step_n * np.round(self.force_n / step_n)
