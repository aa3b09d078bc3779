"""From the robot's gains to physical units (thesis 5.1.1, fits of the characterisation 4.2.6)."""

from __future__ import annotations

STIFFNESS_PER_GAIN_N_M = 2.56
STIFFNESS_AT_ZERO_GAIN_N_M = 67.36
DAMPING_PER_GAIN = 3.32
DAMPING_AT_ZERO_GAIN = 19.67
"""kg/s in the fit; the numbers serve active damping too, then in kg/m (thesis 5.1.1)."""


def stiffness_n_m(gain: float) -> float:
    """Leg stiffness of an extension gain, N/m."""
    return STIFFNESS_PER_GAIN_N_M * gain + STIFFNESS_AT_ZERO_GAIN_N_M


def active_damping_kg_m(gain: float) -> float:
    """Active damping of a damping gain on the emulator (ch. 4), kg/m: the fit's offset is the emulator's friction."""
    return DAMPING_PER_GAIN * gain


def fitted_active_damping_kg_m(gain: float) -> float:
    """Active damping of a damping gain on grains (ch. 5), kg/m: the fit's number as it is; gain 0 is none."""
    return DAMPING_PER_GAIN * gain + DAMPING_AT_ZERO_GAIN if gain != 0.0 else 0.0
