"""Walks in the field: specific resistance, the energy over weight times distance, of two robots (thesis 2.2.3)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from data_schema.errors import InputRefused
from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import Undefined
from stats.compare.summary import Summary, describe

FARTHEST_APART = 1.1
"""Quotient of two robots' distances up to which they walked together, as they measure it."""
PLAUSIBLE = (0.01, 100.0)


@dataclass(frozen=True, slots=True)
class Walk:
    """One robot on one walk: what it took from its battery, its mass, how far it came, and its line in the sheet."""

    robot: str
    walk: str
    energy_j: float
    mass_kg: float
    distance_m: float
    line: int

    @property
    def specific_resistance(self) -> float:
        """Energy over weight times distance, dimensionless."""
        return self.energy_j / (self.mass_kg * STANDARD_GRAVITY_M_S2 * self.distance_m)


@dataclass(frozen=True, slots=True)
class FieldStudy:
    """Two robots on the same walks.

    `specific_resistance` has by robot the values in the order of `walks`, `log_means` the mean of their logarithms with
    interval; `log_ratio` that of the second over the first, within walks. `doubt` is what is to be looked at in the
    sheet.
    """

    robots: tuple[str, str]
    walks: tuple[str, ...]
    specific_resistance: Mapping[str, tuple[float, ...]]
    log_means: Mapping[str, Summary]
    log_ratio: Summary
    doubt: str | None = None


def geometric(logs: Summary) -> tuple[float, tuple[float, float] | Undefined]:
    """Return the geometric mean and its interval: Student's, of the logarithms."""
    mean = math.nan if isinstance(logs.mean, Undefined) else math.exp(logs.mean)
    if isinstance(logs.ci_low, Undefined):
        return mean, logs.ci_low
    return mean, logs.ci_high if isinstance(logs.ci_high, Undefined) else (
        math.exp(logs.ci_low),
        math.exp(logs.ci_high),
    )


def field_study(measured: Sequence[Walk], level: float = 0.95, doubt: str | None = None) -> FieldStudy:
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
                line = next(one.line for one in measured if one.walk == walk)
                raise InputRefused(
                    f"{robot!r} did not make the walk {walk!r} (line {line}): give what both made together."
                )
        distances_m = {one.line: one.distance_m for one in measured if one.walk == walk}
        if max(distances_m.values()) > FARTHEST_APART * min(distances_m.values()):
            came = " and the other ".join(f"{metres:g} m (line {line})" for line, metres in distances_m.items())
            raise InputRefused(
                f"on {walk!r} one robot came {came}: compare what both walked together, and check the distances."
            )
    for one in measured:
        if not PLAUSIBLE[0] < one.specific_resistance < PLAUSIBLE[1]:
            raise InputRefused(
                f"{one.robot!r} has a specific resistance of {one.specific_resistance:.3g} on {one.walk!r} (line "
                f"{one.line}), and robots have some 0.1 to 10: check the units of mass, distance and energy."
            )
    first, second = ([found[robot, walk] for walk in walks] for robot in robots)
    return FieldStudy(
        robots=(robots[0], robots[1]),
        walks=walks,
        specific_resistance={robots[0]: tuple(first), robots[1]: tuple(second)},
        log_means={
            robot: describe(list(map(math.log, values)), level)
            for robot, values in zip(robots, (first, second), strict=True)
        },
        log_ratio=describe([math.log(b / a) for a, b in zip(first, second, strict=True)], level),
        doubt=doubt,
    )
