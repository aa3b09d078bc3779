"""Walks in the field: specific resistance, the energy over weight times distance, of two robots (thesis 2.2.3)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from data_schema.errors import InputRefused
from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import Undefined
from stats.compare.summary import Summary, describe


@dataclass(frozen=True, slots=True)
class Walk:
    """One robot on one walk: what it took from its battery, its mass, and how far it came."""

    robot: str
    walk: str
    energy_j: float
    mass_kg: float
    distance_m: float

    @property
    def specific_resistance(self) -> float:
        """Energy over weight times distance, dimensionless."""
        return self.energy_j / (self.mass_kg * STANDARD_GRAVITY_M_S2 * self.distance_m)


@dataclass(frozen=True, slots=True)
class FieldStudy:
    """Two robots on the same walks.

    `specific_resistance` has by robot the values in the order of `walks`, `means` their mean with interval.
    `log_ratio` is the mean of the logarithm of the second over the first, within walks.
    """

    robots: tuple[str, str]
    walks: tuple[str, ...]
    specific_resistance: Mapping[str, tuple[float, ...]]
    means: Mapping[str, Summary]
    log_ratio: Summary

    @property
    def ratio(self) -> float:
        """Geometric mean of second over first."""
        mean = self.log_ratio.mean
        return math.nan if isinstance(mean, Undefined) else math.exp(mean)

    @property
    def ratio_ci(self) -> tuple[float, float] | Undefined:
        """Its interval: Student's, of the logarithms."""
        low, high = self.log_ratio.ci_low, self.log_ratio.ci_high
        if isinstance(low, Undefined):
            return low
        return high if isinstance(high, Undefined) else (math.exp(low), math.exp(high))


def field_study(measured: Sequence[Walk], level: float = 0.95) -> FieldStudy:
    """Compare two robots that walked together, walk by walk: ground and pace are the same for both.

    Ratios are compared, as a harder ground asks more of both in proportion. Raises `InputRefused` for other than two
    robots, and for walks that both did not make exactly once.
    """
    robots = tuple(dict.fromkeys(one.robot for one in measured))
    walks = tuple(dict.fromkeys(one.walk for one in measured))
    if len(robots) != 2:
        raise InputRefused(f"the walks are of {', '.join(map(repr, robots))}: compare two robots.")
    found = {(one.robot, one.walk): one.specific_resistance for one in measured}
    if len(found) < len(measured):
        raise InputRefused("a robot made a walk twice: give each walk a name of its own.")
    for walk in walks:
        for robot in robots:
            if (robot, walk) not in found:
                raise InputRefused(f"{robot!r} did not make the walk {walk!r}: give what both made together.")
    first, second = ([found[robot, walk] for walk in walks] for robot in robots)
    return FieldStudy(
        robots=(robots[0], robots[1]),
        walks=walks,
        specific_resistance={robots[0]: tuple(first), robots[1]: tuple(second)},
        means={robots[0]: describe(first, level), robots[1]: describe(second, level)},
        log_ratio=describe([math.log(b / a) for a, b in zip(first, second, strict=True)], level),
    )
