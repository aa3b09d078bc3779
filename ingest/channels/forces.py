"""Force plates: the sign and axes of what is stored, and whether forces, moments and centre of pressure agree.

Stored is the ground reaction on the robot with z up, whatever frame the maker writes. Plates report the force on
themselves, many with z down: these turn the frame by half a turn about x, a proper rotation, so that
`cop_x = -moment_y / force_z` and `cop_y = moment_x / force_z` hold in both.
"""

from __future__ import annotations

import dataclasses
import functools
import re
from collections.abc import Mapping, Sequence

import numpy as np

from data_schema.errors import unknown_name
from ingest.channels.checks import LOADED_N
from ingest.channels.columns import ColumnPlan
from ingest.channels.names import channel_kind, plate_of
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import BoolArray, FloatArray
from ingest.spool import by_blocks

Axes = Mapping[str, tuple[str, int]]
"""Each axis of the file, the axis it is stored as, its sign: proper rotations, so that moments turn as forces do."""

AXES: Mapping[str, Axes] = {
    "z up": {"x": ("x", 1), "y": ("y", 1), "z": ("z", 1)},
    "z down": {"x": ("x", 1), "y": ("y", -1), "z": ("z", -1)},
    "y up": {"x": ("x", 1), "y": ("z", 1), "z": ("y", -1)},
}
"""The frames of force data by the direction of their vertical axis; x stays where it is."""

_VECTOR = re.compile(r"(force|moment|free_moment|cop)_([xyz])((?:_\d+)?)")


def turn_axes(
    plans: Sequence[ColumnPlan], stored: dict[int, FloatArray], frame: str, reason: str
) -> tuple[ColumnPlan, ...]:
    """Return the plans with forces, moments and centres of pressure named by the stored axes.

    `frame` is a key of `AXES`. Components whose sign changes are turned round in `stored` (by position); `reason` is
    noted with every component that is renamed or turned round. Raises `UsageError` for a frame that is not known.
    """
    if frame not in AXES:
        raise unknown_name("frame of forces", frame, AXES)
    axes = AXES[frame]
    turned = []
    for plan in plans:
        vector = _VECTOR.fullmatch(plan.channel)
        axis, sign = axes[vector[2]] if vector else ("", 1)
        if vector is None or (axis == vector[2] and sign == 1):
            turned.append(plan)
            continue
        if sign == -1:
            stored[plan.position] = 0.0 - stored[plan.position]
        channel = f"{vector[1]}_{axis}{vector[3]}"
        turned.append(
            dataclasses.replace(plan, channel=channel, sign=plan.sign * sign, assumed=(*plan.assumed, reason))
        )
    return tuple(turned)


FARTHEST_COP_M = 2.0
COP_AGREES = 0.15
MOST_DRIFT_N = 5.0

_KINDS = tuple(f"{quantity}_{axis}" for quantity in ("force", "moment", "free_moment", "cop") for axis in "xyz")

Z_UP_REACTION: Mapping[str, int] = dict.fromkeys(_KINDS, 1)
"""What is stored already: the reaction on the robot with z up."""

ACTION: Mapping[str, int] = {kind: 1 if kind.startswith("cop") else -1 for kind in _KINDS}
"""From the force on a plate to the reaction on the robot, the axes as they are."""

Z_DOWN_ACTION: Mapping[str, int] = {kind: sign * AXES["z down"][kind[-1]][1] for kind, sign in ACTION.items()}
"""From the force on a plate with z down to the reaction on the robot with z up."""


def orient(
    plans: Sequence[ColumnPlan],
    stored: dict[int, FloatArray],
    axes: Mapping[str, int],
    maker: str,
    findings: FindingCollector,
) -> tuple[ColumnPlan, ...]:
    """Return the plans with their final signs, and apply these to `stored` (by position, signs declared applied).

    `axes` are the maker's signs. A plate whose load comes out negative records its forces with the opposite sign in the
    same frame, reaction for action or the other way round: all are turned round, which is noted.
    """
    oriented = list(plans)
    for plate in sorted({plate_of(plan.channel) for plan in plans if _is_plate(plan)}):
        members = [index for index, plan in enumerate(oriented) if _is_plate(plan) and plate_of(plan.channel) == plate]
        force = next((oriented[index] for index in members if channel_kind(oriented[index].channel) == "force_z"), None)
        signs = axes
        reason = f"axes: {maker}" if axes else ""
        if force is not None and _loaded_median(stored[force.position]) * axes.get("force_z", 1) < -LOADED_N:
            signs = {kind: sign * axes.get(kind, 1) for kind, sign in ACTION.items()}
            reason = f"sign: the load was negative, so the sign is the opposite of {maker or 'a reaction'}"
            message = "The load on the plate is negative: all its forces and moments are stored with the opposite sign."
            findings.add(NOTE, "force_sign_flipped", message, column=force.source_name)
        for index in members:
            plan = oriented[index]
            sign = signs.get(channel_kind(plan.channel) or "", 1)
            if sign == -1:
                stored[plan.position] = by_blocks(stored[plan.position], np.negative)
            assumed = (*plan.assumed, reason) if reason else plan.assumed
            oriented[index] = dataclasses.replace(plan, sign=plan.sign * sign, assumed=assumed)
    return tuple(oriented)


def note_assumed_signs(plans: Sequence[ColumnPlan], findings: FindingCollector) -> None:
    """Note the signs assumed of forces whose instrument neither the layout of the file nor a declaration fixes."""
    named = [plan.source_name for plan in plans if _is_plate(plan) and plan.sign == 1]
    if named:
        message = (
            "Nothing tells whose axes these are: stored as written, as the reaction on the robot with z up; if they "
            "are the force on the plate with z down, say `--instrument action_z_down`, or the maker's name."
        )
        findings.add(NOTE, "force_sign_assumed", message, count=len(named), value=", ".join(named))


def check_plates(
    plans: Sequence[ColumnPlan], stored: dict[int, FloatArray], findings: FindingCollector
) -> tuple[ColumnPlan, ...]:
    """Check every plate against itself. A centre of pressure of unstated unit takes the unit and sign that agree."""
    checked = list(plans)
    for plate in sorted({plate_of(plan.channel) for plan in plans if _is_plate(plan)}):
        index = {
            channel_kind(plan.channel): number
            for number, plan in enumerate(checked)
            if _is_plate(plan) and plate_of(plan.channel) == plate
        }
        values = {kind: stored[checked[number].position] for kind, number in index.items()}
        if "force_z" not in values:
            continue
        force_column = checked[index["force_z"]].source_name
        if _is_y_up(values, force_column, findings):
            continue
        _check_axes(values, force_column, findings)
        _check_drift(values["force_z"], force_column, findings)
        loaded = np.abs(values["force_z"]) > LOADED_N
        if np.count_nonzero(loaded) < 10:
            continue
        for cop, moment, sign in (("cop_x", "moment_y", -1.0), ("cop_y", "moment_x", 1.0)):
            if moment not in values:
                continue
            expected = sign * values[moment][loaded] / values["force_z"][loaded]
            if np.nanmedian(np.abs(expected)) > FARTHEST_COP_M:
                message = (
                    f"Moment over force puts the centre of pressure {np.nanmedian(np.abs(expected)):.3g} m away: N*mm?"
                )
                message += (
                    f' Declare the unit, for example `--column "{checked[index[moment]].source_name}={moment}:N*mm"`.'
                )
                findings.add(FILE, "moment_unit_implausible", message, column=checked[index[moment]].source_name)
            elif cop in values:
                number = index[cop]
                checked[number] = _fit_cop(checked[number], stored, loaded, expected, findings)
    return tuple(checked)


def _fit_cop(
    plan: ColumnPlan, stored: dict[int, FloatArray], loaded: BoolArray, expected: FloatArray, findings: FindingCollector
) -> ColumnPlan:
    far = np.abs(expected) > 0.005  # nearer to the middle a ratio has no meaning
    if np.count_nonzero(far) < 10:
        return plan
    ratio = float(np.nanmedian(stored[plan.position][loaded][far] / expected[far]))
    own_unit = any(sentence.startswith("unit ") for sentence in plan.assumed)
    for scale, sign in ((1.0, 1), (1.0, -1), (1e-3, 1), (1e-3, -1)):
        agrees = abs(ratio * scale * sign - 1) < COP_AGREES
        if agrees and (scale, sign) == (1.0, 1):
            return plan
        if agrees and own_unit:
            stored[plan.position] = by_blocks(stored[plan.position], functools.partial(np.multiply, scale * sign))
            unit = "mm" if scale == 1e-3 else "m"
            reason = f"unit {unit} and sign {sign:+d}: agree with moments over force"
            message = (
                f"The centre of pressure is stored as agrees with moments over force: unit {unit}, sign {sign:+d}."
            )
            findings.add(NOTE, "cop_fitted", message, column=plan.source_name)
            return dataclasses.replace(
                plan, source_unit=unit, scale=plan.scale * scale, sign=plan.sign * sign, assumed=(*plan.assumed, reason)
            )
    message = (
        "The centre of pressure of the file does not equal moments over force: filtered, or of another origin; kept."
    )
    findings.add(NOTE, "cop_disagrees", message, column=plan.source_name)
    return plan


def _is_plate(plan: ColumnPlan) -> bool:
    return channel_kind(plan.channel) in Z_DOWN_ACTION


def _loaded_median(force: FloatArray) -> float:
    """Return the median of the hundredth of samples with the largest force, at least ten: stance, if there was any."""
    force = force[np.isfinite(force)]
    count = min(len(force), max(10, len(force) // 100))
    if count == 0:
        return 0.0
    largest = np.argpartition(np.abs(force), len(force) - count)[len(force) - count :]
    return float(np.median(force[largest]))


def _check_axes(values: Mapping[str | None, FloatArray], column: str, findings: FindingCollector) -> None:
    vertical = abs(_loaded_median(values["force_z"]))
    for axis in ("force_x", "force_y"):
        sideways = abs(_loaded_median(values[axis])) if axis in values else 0.0
        if sideways > LOADED_N and sideways > 1.5 * vertical:
            message = f"{axis} carries more load than force_z: are the columns swapped?"
            findings.add(NOTE, "force_axes_suspect", message, column=column)


def _is_y_up(values: Mapping[str | None, FloatArray], column: str, findings: FindingCollector) -> bool:
    """Refuse a plate with its load along y and its points of application in the plane y = 0: there y points up."""
    if not {"force_y", "cop_y", "cop_z"} <= values.keys():
        return False
    in_plane = np.ptp(values["cop_y"]) == 0 and np.ptp(values["cop_z"]) > 0
    load, beside = abs(_loaded_median(values["force_y"])), abs(_loaded_median(values["force_z"]))
    if not in_plane or load < LOADED_N or load < beside:
        return False
    message = (
        "The load is along y and the points of application lie in one plane across it, so y points up, not z: "
        'say it with `axes = "y up"` in a [profiles.NAME] table of labbook.toml.'
    )
    findings.add(FILE, "axes_contradict", message, column=column)
    return True


def _check_drift(force: FloatArray, column: str, findings: FindingCollector) -> None:
    count = min(200, len(force) // 4)
    if count < 20:
        return
    first, last = force[:count], force[-count:]
    unloaded = max(np.abs(first).max(), np.abs(last).max()) < 2 * LOADED_N
    shift = np.mean(last) - np.mean(first)
    if unloaded and abs(shift) > MOST_DRIFT_N:
        message = f"The force of the unloaded plate moves by {shift:.3g} N from start to end: drift."
        findings.add(NOTE, "force_zero_drift", message, column=column)
