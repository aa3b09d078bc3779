"""A parameter of a scene: its name, unit, meaning and range; and the parameters that every scene has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Part = Literal["robot", "leg", "controller", "ground", "drive", "start"]
"""The parts of a scene; each is a table of its file."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number of a scene, in SI units. `low` and `high` are the legal box, both ends included.

    `assumed` is the value taken where an effect that reads it is switched on in a scene that gives none, and `why`
    it was chosen.
    """

    name: str
    part: Part
    unit: str
    meaning: str
    low: float
    high: float
    assumed: float | None = None
    why: str = ""

    @property
    def unit_text(self) -> str:
        """What stands behind a number of it: " kg", nothing where it has no unit."""
        return "" if self.unit == "1" else f" {self.unit}"


GRAVITY_M_S2 = 9.81
"""Acceleration of gravity in every scene; the published numbers were computed with it."""
HARD_GROUND_INSETS_M = (1e-3, 1e-4)
"""On rigid and emulated ground the leg counts as folded or straight this much before it is, in flight too: the cost
counts there, and the joint's speed has a pole at both lengths."""

BASICS = (
    Parameter("body_mass", "robot", "kg", "mass of the body", 0.01, 100.0),
    Parameter("foot_mass", "robot", "kg", "mass of the foot", 1e-6, 20.0),
    Parameter("rest_length", "robot", "m", "length at which the leg's spring exerts nothing", 0.02, 2.0),
    Parameter("upper_link", "robot", "m", "links' length l1 at the motors; linear leg: half its stroke", 0.01, 1.0),
    Parameter("lower_link", "robot", "m", "links' length l2 at the foot; linear leg: its middle length", 0.01, 2.0),
    Parameter("k_compression", "leg", "N/m", "stiffness of the leg in compression", 1.0, 1e6),
    Parameter("k_extension", "leg", "N/m", "stiffness of the leg in extension", 1.0, 1e6),
    Parameter("initial_velocity", "start", "m/s", "velocity of body and foot at the start, down negative", -5.0, 0.0),
    Parameter("initial_height", "start", "m", "height of the foot above the surface at the start", 0.0, 2.0),
)
