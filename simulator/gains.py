"""From the robot's gains to physical units (thesis 5.1.1, fits of the characterisation 4.2.6)."""

from __future__ import annotations

STIFFNESS_PER_GAIN_N_M = 2.56
STIFFNESS_AT_ZERO_GAIN_N_M = 67.36
DAMPING_PER_GAIN = 3.32
DAMPING_AT_ZERO_GAIN = 19.67
"""kg/s in the fit; the numbers serve active damping too, then in kg/m (thesis 5.1.1)."""


def stiffness_n_m(gain: float) -> float:
    """Return the leg's stiffness under an extension gain, N/m (thesis 5.1.1).

    >>> f"{stiffness_n_m(400.0):.2f}"
    '1091.36'
    """
    return STIFFNESS_PER_GAIN_N_M * gain + STIFFNESS_AT_ZERO_GAIN_N_M


def active_damping_kg_m(gain: float) -> float:
    """Return the active damping of a damping gain on the emulator, kg/m (thesis ch. 4).

    Without the fit's offset, which there is the emulator's friction.
    """
    return DAMPING_PER_GAIN * gain


def fitted_active_damping_kg_m(gain: float) -> float:
    """Return the active damping of a damping gain on grains, kg/m (thesis ch. 5): with the fit's offset, 0 for gain 0.

    >>> fitted_active_damping_kg_m(0.0), f"{fitted_active_damping_kg_m(150.0):.2f}"
    (0.0, '517.67')
    """
    return DAMPING_PER_GAIN * gain + DAMPING_AT_ZERO_GAIN if gain != 0.0 else 0.0
