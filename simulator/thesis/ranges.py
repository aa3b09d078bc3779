"""What the figures of ch. 3 vary, and over which ranges.

The text says what is varied but gives no range, so the ranges are assumed: round the nominal values, and for figure
3.13 those of the experiments that it predicts. A claim can hold over one range and fail over a wider one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

DEEPEST_M = 0.08
"""Depth to which the ground's functions are drawn (figures 3.2, 3.6): a little deeper than the feet of set 1 get."""
FASTEST_M_S = 1.2
"""Downward speed of the foot to which the power surface is drawn (figure 3.6)."""
SAMPLE_SPEEDS_M_S = (0.2, 0.6, 1.0)
"""Downward speeds at touchdown of the sample jumps of figure 3.6: the text's own, and two slower ones. From 1.15 m/s on
the guard against short legs ends the compression early."""
TOUCHDOWN_SPEEDS_M_S: FloatArray = np.linspace(0.2, 2.0, 37)
"""Downward speeds at touchdown (figures 3.8, 3.9): drops from 2 mm to 20 cm."""

_HALF_TO_TWICE: FloatArray = np.geomspace(0.5, 2.0, 17)
SIGMAS_N_M3: FloatArray = 1.2e5 * _HALF_TO_TWICE
DRAG_SCALES: FloatArray = 17.2 * _HALF_TO_TWICE
"""`sigma` and `b_g`, half to twice those of poppy seeds (figures 3.11, 3.12)."""

FOOT_RADII_M = (0.03, 0.038, 0.051)
"""The foot published with the simulations, and both of the experiments they accompany (thesis 5.1.1; figure 3.13)."""
EXTENSION_GAINS = (300.0, 400.0)
"""The experiments' soft and stiff gain (thesis 5.1.1)."""
GROUND_FACTORS = (0.5, 1.0, 2.0)
"""Factors on the ground's stiffness and, crossed with them, on its drag."""
ACTIVE_DAMPINGS_KG_M: FloatArray = np.linspace(0.0, 500.0, 26)
"""Coefficients of active damping; from about 600 kg/m on its 1 kHz sampling lifts the foot off a compressed leg."""
