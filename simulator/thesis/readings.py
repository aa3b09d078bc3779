"""Set 1 of the thesis by other readings: what its text leaves open, and what that changes.

Neither gains of the leg nor a radius of the foot are published for set 1, and Eq. 3.5 does not say of how many motors
it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from simulator.scene import Scene
from simulator.thesis.claims import OF_SET_1, Finding, chapter_3_claims, judge_claim
from simulator.thesis.figures import ThesisFigures

SPEEDS_M_S = np.array([0.5, 0.75, 1.0, 1.25, 1.5, 1.75])
UNPUBLISHED: Mapping[str, float] = {
    "k_compression": 120.0,
    "k_extension": 650.0,
    "b_compression": 2.0,
    "b_extension": 10.0,
    "foot_radius": 0.02,
}
"""Gains of the leg, and a foot, that come near to what is published of set 1: found among random ones."""


@dataclass(frozen=True, slots=True)
class Reading:
    """A reading of set 1, and what its claims give over `SPEEDS_M_S`; `of_unpublished`: by other gains and foot."""

    name: str
    findings: tuple[Finding, ...]
    of_unpublished: bool = False


def set_1_readings(figures: ThesisFigures) -> tuple[Reading, ...]:
    """Simulate set 1 as it is shipped and by each other reading."""
    scene = figures.set_1
    resistance, velocity = scene["motor_resistance"], scene["velocity_constant"]
    other = ", ".join(f"{name} {value:g}" for name, value in UNPUBLISHED.items())
    readings: Mapping[str, Mapping[str, float]] = {
        "as shipped: heat of two motors that share the current, drag of one": {},
        "drag of two motors": {"velocity_constant": 2.0 * velocity},
        "heat R I^2 of the whole current, as Eq. 3.5 reads, drag of one": {
            "motor_resistance": 2.0 * resistance,
            "velocity_constant": 2.0 * velocity,
        },
        f"another leg and foot ({other})": UNPUBLISHED,
    }
    return tuple(
        Reading(name, _findings(figures, scene.changed(values)), values is UNPUBLISHED)
        for name, values in readings.items()
    )


def met_by_others(readings: tuple[Reading, ...]) -> frozenset[str]:
    """Return the ids of claims about set 1 that another leg and foot meet at every speed."""
    return frozenset(
        finding.claim.id
        for reading in readings
        if reading.of_unpublished
        for finding in reading.findings
        if finding.agrees
    )


def _findings(figures: ThesisFigures, scene: Scene) -> tuple[Finding, ...]:
    jumps = figures.of_both(scene, {"initial_velocity": -SPEEDS_M_S})
    claims = {claim.id: claim for claim in chapter_3_claims()}
    return tuple(judge_claim(claims[name], measure(jumps)) for name, measure in OF_SET_1.items())
