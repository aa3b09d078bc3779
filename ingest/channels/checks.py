"""Checks of whole channels: values out of range, constant or held sensors, saturation, missing values.

A value no such sensor can give rejects its whole row: it is the mark of a misframed packet, in which other channels
look healthy by chance (seen in logs of the UCT hopping leg: 2.2e35 m beside plausible angles).

Forces and heights are held against what is known of the robots, their weight and the reach of their legs. Over whole
hops the mean vertical force is the weight, whatever the hops are like. A factor of a unit (kN for N), or columns
exchanged, are far beyond what a robot weighed badly explains.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from hashlib import sha256

import numpy as np

from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import CHANNELS, GapKind
from ingest.channels.columns import ColumnPlan, fitting_units, in_unit, unit_flags
from ingest.channels.forces import MOST_N, Load, find_load
from ingest.channels.names import channel_kind, is_cop, is_of_plate, plate_of
from ingest.model import (
    FILE,
    NOTE,
    ROW,
    BoolArray,
    ChannelData,
    Declarations,
    FindingCollector,
    FloatArray,
    Gap,
    IntArray,
    RobotFacts,
)
from ingest.spool import release, row_blocks
from ingest.tables.table import Block

LIMITS_BY_CHANNEL: Mapping[str, tuple[float, float]] = {
    "body_height": (-2.0, 20.0),
    "foot_height": (-2.0, 20.0),
    "platform_height": (-2.0, 20.0),
    "leg_length": (-0.5, 5.0),
    "leg_velocity": (-200.0, 200.0),
    "body_velocity": (-100.0, 100.0),
    "cop_x": (-1e3, 1e3),
    "cop_y": (-1e3, 1e3),
    "cop_z": (-1e3, 1e3),
}
"""What a leg of tens of centimetres can show, in stored units; generous by a factor of ten and more."""

LIMITS_BY_UNIT: Mapping[str | None, tuple[float, float]] = {
    "m": (-1e3, 1e3),
    "m/s": (-1e3, 1e3),
    "N": (-MOST_N, MOST_N),
    "N*m": (-1e5, 1e5),
    "V": (-1e3, 1e3),
    "A": (-1e4, 1e4),
    "mAh": (-1e6, 1e6),
    "degC": (-273.15, 1e3),
    "deg": (-1e6, 1e6),
    "rad": (-1e6, 1e6),
}
_ANYTHING = (-np.inf, np.inf)
"""Of what is unknown, or has no unit, nothing is impossible: stamps in nanoseconds and identifiers exceed 1e18."""
_WHOLE = 2.0**53
_FEWEST_HELD_ROWS = 3

CHANCE_HELD = 0.01
"""A stretch of repeats of which chance gives more than this in a file is no held packet."""


def out_of_range(
    values: Mapping[int, FloatArray],
    plans: Sequence[ColumnPlan],
    loads: Mapping[int, Load],
    block: Block,
    findings: FindingCollector,
) -> BoolArray:
    """Return which rows, shape (n_rows,), hold a value that the channel cannot have.

    The centre of pressure of an unloaded plate can have any, and rejects no row; `loads` are by plate. Integers of
    which digits are lost are noted.
    """
    forces = {plate_of(plan.channel): plan.position for plan in plans if channel_kind(plan.channel) == "force_z"}
    bad_rows = np.zeros(block.n_rows, dtype=np.bool_)
    for plan in plans:
        kind = channel_kind(plan.channel) or plan.channel
        low, high = LIMITS_BY_CHANNEL.get(kind) or LIMITS_BY_UNIT.get(plan.unit, _ANYTHING)
        stored = values[plan.position]
        bad = np.zeros(block.n_rows, dtype=np.bool_)
        for piece in row_blocks(stored):
            bad[piece] = _outside(stored[piece], low, high)
        if (low, high) == _ANYTHING and np.fmax.reduce(stored) > _WHOLE:
            message = "Integers beyond 2^53 are kept to 16 digits; the others are in the raw copy only."
            findings.add(NOTE, "digits_rounded", message, column=plan.source_name)
        if is_cop(plan.channel):
            load = loads.get(plate_of(plan.channel))
            bad &= False if load is None else load.is_on(values[forces[plate_of(plan.channel)]])
        if bad.any():
            rows = np.flatnonzero(bad)
            unit = f" {plan.unit}" if plan.unit else ""
            most = 2 * len(rows) > len(bad)
            fitting = fitting_units(plan, float(np.nanmedian(stored)), low, high) if most else ()
            advice = f" If the unit is another, say {unit_flags(plan, fitting)}." if fitting else ""
            findings.add(
                ROW,
                "out_of_range",
                f"{plan.channel} lies outside {low:g} to {high:g}{unit}: a damaged row or a wrong unit; the whole row "
                f"is left out.{advice}",
                column=plan.source_name,
                lines=block.lines[rows],
                value=f"{stored[rows[0]]:g}",
            )
            bad_rows |= bad
    return bad_rows


def _outside(values: FloatArray, low: float, high: float) -> BoolArray:
    if np.fmin.reduce(values, initial=np.inf) >= low and np.fmax.reduce(values, initial=-np.inf) <= high:
        return np.zeros(len(values), dtype=np.bool_)
    return (values < low) | (values > high)


_DISCHARGING = re.compile(
    rb"(?i)dis[ _-]?ch|d[ _-]?chg|entlad|d(?:e|\xc3?\xa9|\xe9)charg|descarg|\xe6\x94\xbe\xe7\x94\xb5|\xb7\xc5\xb5\xe7"
    rb"|^\W*(?:c[cv][ _-]?)?(?:dsc|dis|dch|d)\W*$"
)
"""Words for discharging in the exports of makers, in Chinese in UTF-8 and GBK; the short ones stand alone in a cell."""
_OF_STEPS = re.compile("(?i)step|mode|stat[eu]|phase|type|schritt|modus|zustand|[eé]tape|[eé]tat|paso|estado")
SIGNED_BY_DIRECTION = ("current", "charge")
"""Channels that are positive while charging and negative while discharging."""


def refuse_unsigned(
    values: Mapping[int, FloatArray],
    plans: Sequence[ColumnPlan],
    texts: Mapping[str, Sequence[bytes]],
    usable: BoolArray,
    findings: FindingCollector,
) -> None:
    """Refuse currents and charges of no declared sign that are positive in rows whose step, as `CC_DChg`, discharges.

    `texts` are columns of text, a cell a row, by name; `usable`, shape (n_rows,), excludes rejected rows. A column
    holds steps where its name says so, or where every row has one and not all discharge: remarks are none.
    """
    for name, text in texts.items():
        says_so = {cell: _DISCHARGING.search(cell) is not None for cell in set(text)}
        example = next((cell for cell in says_so if says_so[cell]), None)
        if not (_OF_STEPS.search(name) or (all(says_so) and not all(says_so.values()))):
            continue
        rows = usable & np.fromiter((says_so[cell] for cell in text), np.bool_, len(usable))
        for plan in plans:
            if example is None or plan.channel not in SIGNED_BY_DIRECTION or plan.declared_sign is not None:
                continue
            stored = values[plan.position]
            if 2 * np.count_nonzero(stored[rows] > 0) <= np.count_nonzero(stored[rows]):
                continue
            unsigned = not (stored[usable] < 0).any()
            own = f"own.{plan.channel}_{'magnitude' if unsigned else 'discharging'}"
            turn = "" if unsigned else ", or `sign = -1` if all is turned round,"
            findings.add(
                FILE,
                "current_unsigned",
                f"Column {plan.source_name!r} is positive where the file says {example.decode(errors='replace')!r}, "
                f"and {plan.channel} is negative while discharging: say `sign = 1` of it if it is right{turn} "
                "in a [profiles.NAME] table of labbook.toml, or keep it as a quantity of your own, "
                f'`--column "{plan.flag}={own}:{plan.source_unit or plan.unit}"`.',
                column=plan.source_name,
            )


def note_missing(
    values: Mapping[int, FloatArray], plans: Sequence[ColumnPlan], block: Block, findings: FindingCollector
) -> None:
    """Report cells without a value, which stay in the signal as NaN."""
    for plan in plans:
        stored = values[plan.position]
        missing = np.isnan(stored)
        release(stored)
        if missing.any():
            rows = np.flatnonzero(missing)
            message = "Cells are blank or not-a-number: the samples stay, without this value."
            findings.add(NOTE, "value_missing", message, column=plan.source_name, lines=block.lines[rows])


def note_still_channels(channels: Sequence[ChannelData], findings: FindingCollector) -> None:
    """Report channels that never change, repeat most of their values, or stick at an end of their range."""
    for channel in channels:
        values = channel.values
        if len(values) < 10 or _is_setting(channel):
            continue
        repeats = values[1:] == values[:-1]
        same = np.count_nonzero(repeats)
        held = (
            np.count_nonzero(repeats & (values[1:] != 0)) if is_of_plate(channel.name) else same
        )  # many programs write zeros while nothing is on it
        if same == len(values) - 1:
            message = f"The channel is {values[0]:g} throughout: a setting, or a sensor that was off."
            findings.add(NOTE, "channel_constant", message, column=channel.source_name)
        elif held > 0.5 * len(values) and len(np.unique(values[1:][values[1:] != values[:-1]])) > 20:
            message = (
                f"{100 * held / len(values):.0f} % of the values repeat the one before: "
                "the sensor is slower than the log or holds its value; a repeat is no sign of rest."
            )
            findings.add(NOTE, "channel_held", message, column=channel.source_name)
        else:
            _note_flat_tops(channel, findings)
        release(values)


def _is_setting(channel: ChannelData) -> bool:
    """Gains, states and counters stand still by nature."""
    kind = channel_kind(channel.name)
    return kind is not None and CHANNELS[kind].unit == "1"


def _note_flat_tops(channel: ChannelData, findings: FindingCollector) -> None:
    """Report a noisy channel that stays exactly at its highest or lowest value: clipped at full scale."""
    values = channel.values
    for edge in (np.fmax.reduce(values), np.fmin.reduce(values)):
        at_edge = values == edge
        first, stop = _runs(at_edge)
        longest = int((stop - first).max(initial=0))
        if longest >= 5 and edge != 0 and len(np.unique(values[:: 1 + len(values) // 2000])) > 100:
            message = (
                f"{longest} samples in a row are exactly {edge:g}, the extreme of the channel: clipped at full scale?"
            )
            findings.add(NOTE, "channel_clipped", message, column=channel.source_name, count=int(at_edge.sum()))


def held_rows(time_s: FloatArray, channels: Sequence[ChannelData]) -> tuple[Gap, ...]:
    """Return stretches in which every channel repeats its value though one of them otherwise always changes.

    That is a logger which writes its last packet again when none arrives. Coarse steps and little noise repeat by
    chance too: a stretch counts only if its like is expected less than `CHANCE_HELD` times in the file, given how often
    each channel repeats at this value. `time_s` has shape (n,).
    """
    if len(time_s) < 10:
        return ()
    witnesses = _different([(channel.values, _repeats(channel.values)) for channel in channels])
    if not witnesses or min(np.count_nonzero(repeat) for _, repeat in witnesses) > 0.1 * len(time_s):
        return ()
    held = np.logical_and.reduce([repeat for _, repeat in witnesses])
    first, stop = _runs(held)
    long = stop - first >= _FEWEST_HELD_ROWS
    first, stop = first[long], stop[long]
    if not first.size:
        return ()
    chance = np.prod([_repeat_rates(*witness, first, stop - first) for witness in witnesses], axis=0)
    beyond_chance = len(time_s) * chance ** (stop - first) < CHANCE_HELD
    gaps = []
    for start, end in zip(first[beyond_chance].tolist(), stop[beyond_chance].tolist(), strict=True):
        # Rows start+1 .. end repeat row start.
        after = min(end + 1, len(time_s) - 1)
        length = float(time_s[after] - time_s[start])
        gaps.append(Gap(float(time_s[start]), length, end - start, end - start, GapKind.HELD))
    return tuple(gaps)


def _different(witnesses: Sequence[tuple[FloatArray, BoolArray]]) -> list[tuple[FloatArray, BoolArray]]:
    """Return the channels without those that repeat at the same rows: one sensor in two columns is one witness."""
    return list({sha256(repeat.data).digest(): (values, repeat) for values, repeat in witnesses}.values())


def _repeat_rates(values: FloatArray, repeat: BoolArray, first: IntArray, length: IntArray) -> FloatArray:
    """Return how often a channel repeats at the value of each stretch, or in the whole file if that is more.

    Shape (n_stretches,). The stretch itself, `length` rows from `first` on, is left out. At rest, and where a motion
    turns, a coarse sensor repeats more often than on the way.
    """
    reach = 1.5 * _step(values)
    order = np.argsort(values[:-1])
    ordered, repeated = values[:-1][order], np.concatenate([[0], np.cumsum(repeat[order])])
    below = np.searchsorted(ordered, values[first] - reach, "right")
    upto = np.searchsorted(ordered, values[first] + reach, "left")
    overall = np.count_nonzero(repeat) / len(repeat)
    rows, repeats = upto - below - length, repeated[upto] - repeated[below] - length
    return np.asarray(np.maximum(overall, (repeats + overall) / (rows + 1.0)), dtype=np.float64)


def _step(values: FloatArray) -> float:
    """Return the usual distance of neighbouring values, 0 where there is but one."""
    steps = np.diff(np.unique(values[np.isfinite(values)]))
    return float(np.median(steps)) if steps.size else 0.0


def _runs(mask: BoolArray) -> tuple[IntArray, IntArray]:
    """Return where the runs of true values begin, and where they have ended."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return edges[::2], edges[1::2]


def _repeats(values: FloatArray) -> BoolArray:
    """Return which values, from the second on, equal the one before."""
    same: BoolArray = values[1:] == values[:-1]
    release(values)
    return same


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
