"""A parameter of a scene: its name, unit, meaning and the values the simulator accepts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Part = Literal["robot", "leg", "controller", "ground", "drive", "start"]
"""The parts of a scene; each is a table of its file."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number of a scene, in SI units. `low` and `high` are the legal box, both ends included.

    `assumed` is the value taken where a scene that reads it gives none, and `why` it was chosen.
    """

    name: str
    part: Part
    unit: str
    meaning: str
    low: float
    high: float
    assumed: float | None = None
    why: str = ""
