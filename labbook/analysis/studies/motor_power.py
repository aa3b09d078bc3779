"""What motors draw to exert a force at the foot: heat, electromechanical drag and mechanical power (thesis Eq. 3.5).

The same as the effects `motor_heat` and `drag` integrate, from a force and a leg length that were measured. As in
thesis 3.2.2 no stall torque bounds the force.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simulator.kinematics import lever_m

_Floats = NDArray[np.float64]
MOTOR_PARAMETERS = ("torque_constant", "motor_resistance", "velocity_constant")
"""Of a scene, as `Drive` calls them too."""


@dataclass(frozen=True, slots=True)
class Drive:
    """A symmetric five-bar leg and its two motors: links in m, N m / A, Ohm, V s / rad."""

    upper_link: float
    lower_link: float
    torque_constant: float
    motor_resistance: float
    velocity_constant: float

    @property
    def reach_m(self) -> tuple[float, float]:
        """Shortest and longest length of the leg; at both the force has no lever."""
        return abs(self.lower_link - self.upper_link), self.lower_link + self.upper_link

    def levers_m(self, length_m: ArrayLike) -> _Floats:
        """Return the joint's lever arm at each leg length, shape (n,)."""
        lengths = np.asarray(length_m, dtype=np.float64)
        levers = (lever_m(self.upper_link, self.lower_link, length) for length in lengths.tolist())
        return np.fromiter(levers, np.float64, lengths.size)

    def heat_w(self, force_n: _Floats, levers_m: _Floats) -> _Floats:
        """Return the heat in the windings of both motors, R I^2 / 2 for the current I of both together."""
        current_a = force_n * levers_m / self.torque_constant
        return np.asarray(0.5 * self.motor_resistance * current_a**2)

    def drag_w(self, speed_m_s: _Floats, levers_m: _Floats) -> _Floats:
        """Return the electromechanical drag at the leg's speed, extension positive."""
        factor = self.torque_constant * self.velocity_constant / self.motor_resistance
        return np.asarray(factor * (speed_m_s / levers_m) ** 2)
