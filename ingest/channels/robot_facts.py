"""Forces and heights against what is known of the robots: their weight and the reach of their legs.

Over whole hops the mean vertical force is the weight, whatever the hops are like. A factor of a unit (kN for N), or
columns exchanged, are far beyond what a robot weighed badly explains.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from data_schema.units import STANDARD_GRAVITY_M_S2
from ingest.channels.columns import ColumnPlan, fitting_units, in_unit, unit_flags
from ingest.channels.names import channel_kind, plate_of
from ingest.channels.plate_load import Load, find_load
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import BoolArray, Declarations, FloatArray, RobotFacts

WEIGHT_AGREES = 0.2
WEIGHT_REFUSED = 2.0
"""A mean force that is so many times more or less than the weight is of another unit, or of no robot known."""
LEAST_MOTION_M = 1e-3
LEAST_MOTION_LEGS = 0.05
"""Hops of less are no reason to take a unit for the right one."""
LEAST_HEIGHT_LEGS, MOST_HEIGHT_LEGS = 0.2, 3.0
"""A body that never comes higher, while it hops, or comes higher than this may be measured in another unit."""

_FEWEST_HOPS = 3
_MOST_ROWS = 1 << 20
"""Hops are looked for in the beginning of a long recording."""
_LOW, _HIGH = 0.3, 0.6
_ABOVE_NOISE = 8.0


def check_robot(
    plans: Sequence[ColumnPlan],
    stored: Mapping[int, FloatArray],
    loads: Mapping[int, Load],
    usable: BoolArray,
    declared: Declarations,
    findings: FindingCollector,
) -> None:
    """Refuse forces and heights that no known robot can have.

    Says nothing where no robot is known or no hops are seen.

    `stored` holds the columns by position, shape (n_rows,), `loads` those on plates by their numbers; `usable`, shape
    (n_rows,), excludes rejected rows.
    """
    if not declared.robots or declared.no_robot_check:
        return
    looked_at_rows = usable[:_MOST_ROWS]
    looked_at = {
        plan.position: stored[plan.position][:_MOST_ROWS][looked_at_rows]
        for plan in plans
        if channel_kind(plan.channel) in ("force_x", "force_y", "force_z", "body_height")
    }
    _check_forces(plans, looked_at, loads, declared.robots, findings)
    for plan in plans:
        if plan.channel == "body_height":
            _check_height(looked_at[plan.position], plan, declared.robots, findings)


def _check_forces(
    plans: Sequence[ColumnPlan],
    stored: Mapping[int, FloatArray],
    loads: Mapping[int, Load],
    robots: Sequence[RobotFacts],
    findings: FindingCollector,
) -> None:
    """Compare the vertical force that any plate, or all together, carry over hops with the weights."""
    vertical = [plan for plan in plans if channel_kind(plan.channel) == "force_z"]
    if not vertical:
        return
    of_plates = {plan.position: loads.get(plate_of(plan.channel)) for plan in vertical}
    each = [load.of(stored[position]) for position, load in of_plates.items() if load is not None]
    candidates = [*each, np.sum(each, axis=0)] if len(each) > 1 else each
    carried = [force for force in map(_carried_n, candidates) if force is not None]
    weights = [robot.mass_kg * STANDARD_GRAVITY_M_S2 for robot in robots]
    if _relative_difference(carried, weights) <= WEIGHT_AGREES:
        return
    known = " or ".join(f"{robot.mass_kg:g} kg" for robot in robots)
    name = vertical[0].source_name
    remedy = "; correct the mass in [robots] of labbook.toml, or say `--no-robot-check` if it is another robot's."
    for plan in plans:
        if channel_kind(plan.channel) in ("force_x", "force_y"):
            load = find_load(stored[plan.position])
            sideways = None if load is None else _carried_n(load.of(stored[plan.position]))
            if sideways is not None and _relative_difference([sideways], weights) <= WEIGHT_AGREES:
                y_up = '`--axes "y up"` if y is up, or, ' if channel_kind(plan.channel) == "force_y" else ""
                exchange = f"`{_channel_flag(plan, vertical[0])} {_channel_flag(vertical[0], plan)}`"
                findings.add(
                    FILE,
                    "force_axes_swapped",
                    f"Column {plan.source_name!r} carries {sideways:.3g} N over hops, the weight of a robot of "
                    f"{known}, and {name!r}, the vertical force, does not: say "
                    f"{y_up}if these two alone are exchanged, {exchange}{remedy}",
                    column=name,
                )
                return
    if not carried:
        return
    nearest = min(carried, key=lambda force: _relative_difference([force], weights))
    found = f"Over hops column {name!r} carries a mean of {nearest:.3g} N, and a robot of {known} weighs "
    found += " or ".join(f"{weight:.3g} N" for weight in weights)
    if all(1 / WEIGHT_REFUSED <= nearest / weight <= WEIGHT_REFUSED for weight in weights):
        findings.add(NOTE, "force_weight_differs", f"{found}: was the robot weighed, the plate tared?", column=name)
    else:
        low, high = min(weights) / WEIGHT_REFUSED, max(weights) * WEIGHT_REFUSED
        units = fitting_units(vertical[0], nearest, low, high)
        advice = f"is the unit right? Say {unit_flags(vertical[0], units)}" if units else "is it the vertical force"
        advice += "" if units else ', and the plate tared? Say which column is, `--column "NAME=force_z:UNIT"`'
        findings.add(FILE, "force_weight_implausible", f"{found}: {advice}{remedy}", column=name)


def _channel_flag(plan: ColumnPlan, other: ColumnPlan) -> str:
    """Return the flag that has a column read as what another one was."""
    unit = f":{plan.source_unit}" if plan.source_unit else ""
    return f'--column "{plan.flag}={other.declared_channel}{unit}"'


def _relative_difference(forces: Sequence[float], weights: Sequence[float]) -> float:
    return min((abs(force / weight - 1) for force in forces for weight in weights), default=np.inf)


def _check_height(
    height_m: FloatArray, plan: ColumnPlan, robots: Sequence[RobotFacts], findings: FindingCollector
) -> None:
    finite = height_m[np.isfinite(height_m)]
    if not finite.size:
        return
    low, high = np.percentile(finite, (1.0, 99.0))
    reach = max(robot.reach_m for robot in robots)
    too_little = high - low < LEAST_MOTION_M or 0 < low < high < LEAST_HEIGHT_LEGS * reach
    too_much = high < 0 or max(-low, high) > MOST_HEIGHT_LEGS * reach
    if not (too_little or too_much):
        return
    hops = _hops(finite) is not None
    if not (hops or too_much):
        return
    if not hops and high - low < LEAST_MOTION_M:
        advice = "it does not move: did the sensor come loose? Leave the file out"
    elif high < 0:
        advice = f"is its sign turned round? Say `sign = {-plan.sign}` of it in a [profiles.NAME] table of labbook.toml"
    else:
        advice = _unit_advice(plan, low, high, reach)
    findings.add(
        FILE,
        "height_implausible",
        f"Column {plan.source_name!r} is read as heights of {low:.3g} to {high:.3g} m, and the longest leg in [robots] "
        f"reaches {reach:.3g} m: {advice}, or `--no-robot-check` if it is as it should be.",
        column=plan.source_name,
    )


def _unit_advice(plan: ColumnPlan, low: float, high: float, reach: float) -> str:
    """Return a question and the flags for the units in which heights and motion would be those of a robot."""
    fitting = fitting_units(plan, high, LEAST_HEIGHT_LEGS * reach, MOST_HEIGHT_LEGS * reach)
    units = [unit for unit in fitting if in_unit(plan, high - low, unit) >= LEAST_MOTION_LEGS * reach]
    if not units:
        return f'are its unit and the column right? Say `--column "NAME={plan.channel}:UNIT" --override-units`'
    return f"is its unit another? Say {unit_flags(plan, units)}"


def _carried_n(load_n: FloatArray) -> float | None:
    """Return the mean load over whole hops; None where no hops are seen."""
    load_n = load_n[np.isfinite(load_n)]
    hops = _hops(load_n)
    return None if hops is None else float(load_n[hops].mean())


def _hops(values: FloatArray) -> slice | None:
    """Return the samples from the first to the last rise of values that go up and down; None where they do not.

    The levels between which they go are far apart for the noise, which is the usual step from sample to sample.
    """
    if len(values) < 100:
        return None
    low, high = (float(level) for level in np.percentile(values, (2.0, 98.0)))
    noise = float(np.median(np.abs(np.diff(values))))
    if high - low <= _ABOVE_NOISE * noise or high == low:
        return None
    above, below = values > low + _HIGH * (high - low), values < low + _LOW * (high - low)
    clear = np.flatnonzero(above | below)
    rises = clear[1:][above[clear][1:] & below[clear][:-1]]
    return slice(rises[0], rises[-1]) if len(rises) > _FEWEST_HOPS else None
