"""Force plates: the sign and axes of what is stored, and whether forces, moments and centre of pressure agree.

Stored is the ground reaction on the robot with z up, whatever frame the maker writes. Plates report the force on
themselves, many with z down: these turn the frame by half a turn about x, a proper rotation, so that
`cop_x = -moment_y / force_z` and `cop_y = moment_x / force_z` hold in both.

The load is judged from the level of the unloaded plate and never from zero, which amplifiers shift. Whatever walks or
jumps on a plate leaves it at one level, and pushes harder at times than it weighs. The unloaded level is the one end
of the range at which the force stays, crowded while its neighbours are passed quickly, and narrow as noise is and the
top of a hump is not; a level inside the range is a body's that stands.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ingest.channels.columns import ColumnPlan, fitting_units, unit_flags
from ingest.channels.names import channel_kind, is_of_plate, plate_of
from ingest.instruments import Instrument
from ingest.model import FILE, NOTE, BoolArray, FindingCollector, FloatArray
from ingest.spool import by_blocks

LOADED_N = 20.0
"""A plate with less on it is unloaded: its centre of pressure, a quotient, means nothing and may be of any size."""
MOST_N = 1e5
"""More, either way, is a damaged row or another unit."""

_WIDTHS = (0.05, 0.1, 0.2)
"""How wide a level is with its noise, as a share of the range: the narrowest width that shows a level counts."""
_CROWDED = 3.0
"""A level has so many times the samples of either neighbour; the top of half a sine has 2.4 times as many."""
_NARROW = 0.85
"""Share of a level's samples in the middle half of its width; of the top of half a sine it is 0.71."""
_BEYOND = 0.1
"""Share of the range that may lie beyond the unloaded level: what filters and vibrations add."""
_LEAST_SAMPLES = 10
_OF_OTHER_END = 0.1
"""A level has so many of the samples at the other end: the tops of impacts, which are few and crowded, have less."""
_STRETCH = 8
"""Samples whose mean has little noise."""
_MOST_SAMPLES = 1 << 17

Axes = Mapping[str, tuple[str, int]]
"""Each axis of the file, the axis it is stored as, its sign: proper rotations, so that moments turn as forces do."""

AXES: Mapping[str, Axes] = {
    "z up": {"x": ("x", 1), "y": ("y", 1), "z": ("z", 1)},
    "z down": {"x": ("x", 1), "y": ("y", -1), "z": ("z", -1)},
    "y up": {"x": ("x", 1), "y": ("z", 1), "z": ("y", -1)},
}
"""The frames of force data by the direction of their vertical axis; x stays where it is."""

_VECTOR = re.compile(r"(force|moment|free_moment|cop)_([xyz])((?:_\d+)?)")
FARTHEST_COP_M = 2.0
"""No centre of pressure is farther from its plate's origin: the belts of the longest treadmills."""
_FEW = 0.01
COP_AGREES = 0.15
MOST_DRIFT_N = 5.0


def orient(
    plans: Sequence[ColumnPlan], stored: dict[int, FloatArray], instrument: Instrument, findings: FindingCollector
) -> tuple[tuple[ColumnPlan, ...], dict[int, Load]]:
    """Return the plans with the stored axes and their final signs, and apply these to `stored` (by position).

    Returned beside them are the loads that the stored vertical forces show, by the number of the plate.

    A sign that is declared of a column stands; it is applied already. Those of its plate follow a vertical force; all
    others the one sign of the instrument: that of one which is declared, or whose axes are; else that by which the
    largest load on any such plate is upward; else the maker's. A file whose maker is not
    known, and whose forces change without showing which way a load goes, is refused.
    """
    axes, maker = AXES[instrument.frame], instrument.maker
    upright, upward = next((axis, turn) for axis, (stored_as, turn) in axes.items() if stored_as == "z")
    vertical = [plan for plan in plans if channel_kind(plan.channel) == f"force_{upright}"]
    of_plate = {plate_of(plan.channel): upward * plan.declared_sign for plan in vertical if plan.declared_sign}
    loads = [(load, plan) for plan in vertical if (load := find_load(stored[plan.position])) is not None]
    large = [found for found in loads if found[0].largest_n > LOADED_N]
    undeclared = [found for found in large if plate_of(found[1].channel) not in of_plate]
    seen = max(undeclared, key=lambda found: found[0].largest_n, default=None)
    sign = usual = -1 if instrument.action else 1
    source = "declared" if instrument.declared else maker
    reason = f"{instrument.frame}{', force on the plate' if instrument.action else ''}: {source}" if source else ""
    is_declared = instrument.declared or all(plate_of(plan.channel) in of_plate for plan in vertical)
    if seen is not None and not is_declared and upward * seen[0].sign != usual:
        sign, reason = -usual, f"sign: the opposite of {maker or 'a reaction'}, by the load"
    oriented = [_turned(plan, axes, of_plate.get(plate_of(plan.channel), sign), reason) for plan in plans]
    turns = {after.position: before.sign * after.sign for before, after in zip(plans, oriented, strict=True)}
    for position, turn in turns.items():
        if turn == -1:
            stored[position] = by_blocks(stored[position], lambda block: 0.0 - block)
    if not is_declared:
        change = max((change_n(stored[plan.position]) for plan in vertical), default=0.0) if seen is None else 0.0
        undecided = [plan for plan in oriented if plate_of(plan.channel) not in of_plate]
        _note_inferred(undecided, seen, sign != usual, change, instrument, findings)
    for load, plan in large:
        if load.sign * turns[plan.position] == -1:
            declared = is_declared or plate_of(plan.channel) in of_plate
            message = (
                f"The load goes down from the unloaded level of {load.unloaded_n:.3g} N: stored so, by the sign that "
                f"{'is declared' if declared else 'the plate with the largest load has'}; is it the opposite?"
            )
            findings.add(NOTE, "force_sign_contradicts", message, column=plan.source_name)
    turned = {plate_of(plan.channel): load.turned() if turns[plan.position] == -1 else load for load, plan in loads}
    return tuple(oriented), turned


def _turned(plan: ColumnPlan, axes: Axes, sign: int, reason: str) -> ColumnPlan:
    """Return the plan of a component with the stored axis, and the sign of its instrument unless one is declared."""
    vector = _VECTOR.fullmatch(plan.channel)
    if vector is None:
        return plan
    axis, turn = axes[vector[2]]
    channel = f"{vector[1]}_{axis}{vector[3]}"
    if plan.declared_sign is not None:
        return dataclasses.replace(plan, channel=channel)
    turn *= 1 if vector[1] == "cop" else sign
    assumed = (*plan.assumed, reason) if reason else plan.assumed
    return dataclasses.replace(plan, channel=channel, sign=plan.sign * turn, assumed=assumed)


def _note_inferred(
    plans: Sequence[ColumnPlan],
    seen: tuple[Load, ColumnPlan] | None,
    is_opposite: bool,
    change: float,
    instrument: Instrument,
    findings: FindingCollector,
) -> None:
    """Say by what the sign of an instrument was chosen that nobody declared, unless the file and its load prove it."""
    if is_opposite and seen is not None:
        message = (
            f"From the unloaded level of {seen[0].unloaded_n:.3g} N the load goes down: all forces and moments are "
            "stored with the opposite sign; `--instrument reaction_z_up` leaves them as written."
        )
        findings.add(NOTE, "force_sign_flipped", message, column=seen[1].source_name)
        return
    of_plates = {plan.source_name: channel_kind(plan.channel) for plan in plans if is_of_plate(plan.channel)}
    vertical = next((name for name, kind in of_plates.items() if kind == "force_z"), None)
    open_ = [name for name, kind in of_plates.items() if seen is None or kind != "force_z"]
    unseen = "No load comes and goes that shows the sign of the forces"
    if change > LOADED_N and not instrument.evidence:
        message = (
            f"The vertical force changes by {change:.3g} N, and not from and to the level of an unloaded plate: say "
            '`--axes "z up"` if a load is positive, `--axes "z down"` if it is negative.'
        )
        findings.add(FILE, "force_sign_unclear", message, column=vertical)
        return
    if open_ and not instrument.evidence:
        message = (
            f"{'Nothing' if seen is not None else f'{unseen}, and nothing'} tells whose axes these are: stored as "
            "written, as the reaction on the robot with z up; if they are the force on the plate with z down, say "
            "`--instrument action_z_down`, or the maker's name."
        )
    elif seen is None and vertical is not None:
        message = (
            f"{unseen}: it is that of {instrument.maker}; if it is the opposite, say `sign = -1` of the "
            "vertical force in a [profiles.NAME] table of labbook.toml."
        )
    else:
        return
    findings.add(NOTE, "force_sign_assumed", message, column=vertical, count=len(open_), value=", ".join(open_))


def check_plates(
    plans: Sequence[ColumnPlan],
    stored: dict[int, FloatArray],
    loads: Mapping[int, Load],
    usable: BoolArray,
    findings: FindingCollector,
) -> tuple[ColumnPlan, ...]:
    """Check every plate against itself. A centre of pressure of unstated unit takes the unit and sign that agree.

    `loads` are by the number of the plate; `usable`, shape (n_rows,), excludes rejected rows. Where no load is seen
    nothing is said against moments and centre of pressure.
    """
    checked = list(plans)
    for plate in sorted({plate_of(plan.channel) for plan in plans if is_of_plate(plan.channel)}):
        index = {
            channel_kind(plan.channel): number
            for number, plan in enumerate(checked)
            if is_of_plate(plan.channel) and plate_of(plan.channel) == plate
        }
        values = {kind: stored[checked[number].position] for kind, number in index.items()}
        if "force_z" not in values:
            continue
        force_column = checked[index["force_z"]].source_name
        if _is_y_up(values, force_column, findings):
            continue
        _check_axes(values, force_column, findings)
        load = loads.get(plate)
        _check_drift(values["force_z"], load, force_column, findings)
        zero_n = 0.0 if load is None else load.unloaded_n
        is_on = values["force_z"] != 0.0 if load is None else load.is_on(values["force_z"])
        for cop, moment, sign in (("cop_x", "moment_y", -1.0), ("cop_y", "moment_x", 1.0)):
            if moment in values:
                known = usable & np.isfinite(values[moment])
                loaded, unloaded = is_on & known, values[moment][~is_on & known]
                if np.count_nonzero(loaded) < 10:
                    continue
                moment_zero = float(np.median(unloaded)) if load is not None and unloaded.size else 0.0
                expected = sign * (values[moment][loaded] - moment_zero) / (values["force_z"][loaded] - zero_n)
                distance_m = float(np.median(np.abs(expected)))
                if load is not None and distance_m > FARTHEST_COP_M:
                    message = f"Moment over force puts the centre of pressure {distance_m:.3g} m away: N*mm?"
                    message += f" If so, say {unit_flags(checked[index[moment]], ['N*mm'])}."
                    findings.add(FILE, "moment_unit_implausible", message, column=checked[index[moment]].source_name)
                elif cop in values:
                    number = index[cop]
                    checked[number] = _fit_cop(checked[number], stored, loaded, expected, load is not None, findings)
            if cop in values and load is not None:
                plan = checked[index[cop]]
                _note_outside(stored[plan.position][usable & is_on], plan, findings)
    return tuple(checked)


def _note_outside(cop_m: FloatArray, plan: ColumnPlan, findings: FindingCollector) -> None:
    """Report centres of pressure of a loaded plate, more than a hundredth, that lie outside any plate."""
    place = np.abs(cop_m)
    outside = place[place > FARTHEST_COP_M]
    if len(outside) <= _FEW * len(place):
        return
    units = fitting_units(plan, float(np.median(outside)), 0.0, FARTHEST_COP_M)
    advice = f"; if its unit is another, say {unit_flags(plan, units)}" if units else ""
    message = (
        f"The centre of pressure of the loaded plate lies {np.median(outside):.3g} m from its origin, outside any "
        f"plate: the room's origin, or not the unit of the file{advice}."
    )
    findings.add(NOTE, "cop_outside_plate", message, column=plan.source_name, count=len(outside))


def _fit_cop(
    plan: ColumnPlan,
    stored: dict[int, FloatArray],
    loaded: BoolArray,
    expected: FloatArray,
    is_load_seen: bool,
    findings: FindingCollector,
) -> ColumnPlan:
    cop = stored[plan.position][loaded]
    far = (np.abs(expected) > 0.005) & np.isfinite(cop) & (cop != 0.0)  # nearer to the middle a ratio has no meaning
    if np.count_nonzero(far) < 10:
        return plan
    ratio = float(np.median(cop[far] / expected[far]))
    own_unit = any(sentence.startswith("unit ") for sentence in plan.assumed)
    signs = (1, -1) if plan.declared_sign is None else (1,)
    for scale, sign in itertools.product((1.0, 1e-3), signs):
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
    if not is_load_seen:
        return plan
    message = (
        "The centre of pressure of the file does not equal moments over force: filtered, or of another origin; kept."
    )
    findings.add(NOTE, "cop_disagrees", message, column=plan.source_name)
    return plan


def _range_n(force: FloatArray) -> float:
    """Return how much a force changes, its largest and smallest half per cent of samples left out."""
    force = force[np.abs(force) < MOST_N]
    return float(np.ptp(np.percentile(force, (0.5, 99.5)))) if force.size else 0.0


def _check_axes(values: Mapping[str | None, FloatArray], column: str, findings: FindingCollector) -> None:
    vertical = _range_n(values["force_z"])
    for axis in ("force_x", "force_y"):
        sideways = _range_n(values[axis]) if axis in values else 0.0
        if sideways > LOADED_N and sideways > 1.5 * vertical:
            message = f"{axis} carries more load than force_z: are the columns swapped?"
            findings.add(NOTE, "force_axes_suspect", message, column=column)


def _is_y_up(values: Mapping[str | None, FloatArray], column: str, findings: FindingCollector) -> bool:
    """Refuse a plate with its load along y and its points of application in the plane y = 0: there y points up."""
    if not {"force_y", "cop_y", "cop_z"} <= values.keys():
        return False
    in_plane = np.ptp(values["cop_y"]) == 0 and np.ptp(values["cop_z"]) > 0
    if not in_plane or _range_n(values["force_y"]) < max(LOADED_N, _range_n(values["force_z"])):
        return False
    message = (
        "The load is along y and the points of application lie in one plane across it, so y points up, not z: "
        'say it with `axes = "y up"` in a [profiles.NAME] table of labbook.toml.'
    )
    findings.add(FILE, "axes_contradict", message, column=column)
    return True


def _check_drift(force: FloatArray, load: Load | None, column: str, findings: FindingCollector) -> None:
    count = min(200, len(force) // 4)
    if count < 20:
        return
    first, last = force[:count], force[-count:]
    ends = np.concatenate([first, last])
    is_quiet = np.ptp(ends) < 2 * LOADED_N and (load is None or not load.is_on(ends).any())
    shift = np.mean(last) - np.mean(first)
    if is_quiet and abs(shift) > MOST_DRIFT_N:
        message = f"The force of the plate at rest moves by {shift:.3g} N from start to end: drift, or a light body."
        findings.add(NOTE, "force_zero_drift", message, column=column)


@dataclass(frozen=True, slots=True)
class Load:
    """What a vertical force shows: the unloaded level, on which side of it the load is (1 or -1), the largest load."""

    unloaded_n: float
    sign: int
    largest_n: float

    def of(self, force_n: FloatArray) -> FloatArray:
        """Return the load in samples of this force, shape (n,), in newtons."""
        return self.sign * (force_n - self.unloaded_n)

    def is_on(self, force_n: FloatArray) -> BoolArray:
        """Return in which samples of this force, shape (n,), the plate is loaded."""
        return np.asarray(self.of(force_n) > LOADED_N)

    def turned(self) -> Load:
        """Return the load of the force with the opposite sign."""
        return Load(0.0 - self.unloaded_n, -self.sign, self.largest_n)


def _stretches(force_n: FloatArray) -> FloatArray:
    """Return stretches of successive samples, shape (n, _STRETCH), of all of a long record, without damaged ones."""
    stretches = force_n[: len(force_n) // _STRETCH * _STRETCH].reshape(-1, _STRETCH)
    stretches = stretches[:: 1 + len(force_n) // _MOST_SAMPLES]
    return stretches[(np.abs(stretches) < MOST_N).all(axis=1)]


def change_n(force_n: FloatArray) -> float:
    """Return how much a force, shape (n,), changes beyond its noise, in newtons."""
    stretches = _stretches(force_n)
    return float(np.ptp(stretches.mean(axis=1))) if len(stretches) else 0.0


def find_load(force_n: FloatArray) -> Load | None:
    """Find the load in a vertical force, shape (n,), NaN where a sample is missing.

    Returns None where nothing shows it: an idle or a quietly loaded plate; no level is returned to; the load is a level
    as well, as that of a weight which is put on the plate; or it comes or goes but once, as where a body steps off.
    """
    stretches = _stretches(force_n)
    force = np.sort(stretches, axis=None)
    if len(force) < 2 * _LEAST_SAMPLES:
        return None
    spikes = min(10, len(force) // 100)
    low, high = float(force[spikes]), float(force[-1 - spikes])
    if not high > low:
        return None
    for share in _WIDTHS:
        width, beyond = share * (high - low), _BEYOND * (high - low)
        starts = np.arange(low - width, high, width / 4)
        edges = np.searchsorted(force, [starts - width, starts, starts + width, starts + 2 * width])
        below, inside, above = np.diff(edges, axis=0)
        middles = force[np.minimum((edges[1] + edges[2]) // 2, len(force) - 1)]
        (near,) = np.diff(np.searchsorted(force, [middles - width / 4, middles + width / 4]), axis=0)
        level = (inside >= _CROWDED * np.maximum(below, above)) & (near >= _NARROW * inside)
        level &= inside >= _LEAST_SAMPLES
        at_low, from_high = np.searchsorted(force, [low + beyond, high - beyond])
        lowest = level & (starts <= low + beyond) & (inside >= _OF_OTHER_END * (len(force) - from_high))
        highest = level & (starts + width >= high - beyond) & (inside >= _OF_OTHER_END * at_low)
        if lowest.any() and highest.any():
            return None
        if lowest.any() or highest.any():
            sign, ends = (1, lowest) if lowest.any() else (-1, highest)
            outermost = np.flatnonzero(ends)[::sign]
            outermost = outermost[np.abs(starts[outermost] - starts[outermost[0]]) < width]
            unloaded_n = float(middles[outermost[np.argmax(inside[outermost])]]) + 0.0  # no negative zero
            loaded = 2.0 * sign * (stretches.mean(axis=1) - unloaded_n) > high - low
            if np.count_nonzero(loaded[1:] != loaded[:-1]) < 2 + loaded[0]:
                return None
            return Load(unloaded_n, sign, high - unloaded_n if sign == 1 else unloaded_n - low)
    return None
