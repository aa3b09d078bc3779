"""Joules estimated from a force plate and the leg's length, against joules measured at the battery (thesis 3.2.2).

Plate and leg are recorded by two clocks. Touchdowns, a sudden force on the one and a leg that begins to yield on the
other, give offset and drift of one clock against the other for each run (`stats.clocks`). The plate's zero is followed
in the flights. Its force is smoothed with one moving average for all runs, and in each stance force and leg length go
through the leg's kinematics and the motors' model (`Drive`, thesis Eq. 3.5): heat, drag and mechanical power, as the
effects `motor_heat` and `drag` integrate them; as in thesis 3.2.2 no stall torque bounds the force. What a run took
from the battery, less the passive drain, is its measured joules a hop.

The hops of a run share its one recharge, and the runs of a day share the day, so that neither hops nor, where there are
several days, runs are independent: the slope's interval is over days (`slope_through_origin`), of one day over its
runs, and holds the error of the drain line, which all share. That the estimate may miss by more at one gain than at
another is no scatter of days; it is listed by condition.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused
from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.pairing import sort_key
from labbook.analysis.prediction.simulating import PlainPredictions
from simulator.kinematics import lever_m
from stats.clocks import Clocks, align_clocks, corner, leg_touchdowns, moving_average
from stats.compare.shared_error import SharedError
from stats.force_plate import Contact, find_contacts, force_above_zero
from stats.groups.residuals import RmseOverIqr, rmse_over_iqr
from stats.lines.regression import SlopeThroughOrigin, slope_through_origin

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


Floats = NDArray[np.float64]
WINDOWS = tuple(range(1, 53, 2))
"""Samples of the moving averages that are tried, up to 51 ms at 1 kHz; odd, so that none shifts the force in time."""
SHOWN_HOPS, FIRST_HOPS = 20, 3
"""Hops whose traces are drawn, and of a run those in which a robot that is let go from the hand comes to its height."""
_TOUCHDOWN_SAMPLES = (1.0 / 2.0, 1.0 / 6.0)
"""Samples of the plate and of the leg's log by which both may see the same touchdown apart, always to the same side, so
that it is in no scatter: 0.5 ms at 1 kHz and 333 Hz, where it was measured; faster records are not taken to do better.
"""
_LEAST_APART_S = 0.0005


@dataclass(frozen=True, slots=True, eq=False)
class PlateRun:
    """A run: what the battery gave a hop, and both records.

    `plate_time_s` and `force_n` (upward positive, NaN where samples are missing) have shape (n,), `leg_time_s` and
    `length_m` (m,), by either instrument's clock. `shared` is the error of the joules that other runs have too, `hops`
    how many the battery gave, and the foot of `foot_mass_kg` is what the plate carries beside the leg's force. `title`
    is the condition in words, as a person calls its factors.
    """

    name: str
    day: str
    condition: str
    measured_j: float
    shared: SharedError
    hops: int
    foot_mass_kg: float
    drive: Drive
    plate_time_s: Floats
    force_n: Floats
    leg_time_s: Floats
    length_m: Floats
    title: str = ""


@dataclass(frozen=True, slots=True)
class RunEstimate:
    """A run's joules a hop, estimated and measured.

    `hops_j` are those of each stance that both records hold whole, the foremost `first` of them of the run's first
    hops (`FIRST_HOPS`); of `hops_made` the plate saw `stances`. Records may see a touchdown `touchdown_apart_s` apart.
    """

    name: str
    day: str
    condition: str
    measured_j: float
    hops_j: tuple[float, ...]
    first: int
    hops_made: int
    stances: int
    clocks: Clocks
    touchdown_apart_s: float

    @property
    def estimated_j(self) -> float:
        """Mean over the hops."""
        return float(np.mean(self.hops_j))

    @property
    def offset_ci(self) -> tuple[float, float] | Undefined:
        """The interval of the clocks' offset: that of the line, and what a touchdown's definition leaves open."""
        ci = self.clocks.at_zero_ci
        return ci if isinstance(ci, Undefined) else (ci[0] - self.touchdown_apart_s, ci[1] + self.touchdown_apart_s)

    @property
    def ratio(self) -> float:
        """Estimated over measured joules."""
        return self.estimated_j / self.measured_j


_ODD_RATIO = 3.0
"""By this factor the ratio of a run is off the middle one where its charge or its record is likely another's."""


def odd_runs(runs: Sequence[RunEstimate]) -> list[RunEstimate]:
    """Return the runs whose ratio of estimated and measured joules is off the median of all by `_ODD_RATIO`."""
    middle = float(np.median([one.ratio for one in runs]))
    return [one for one in runs if not middle / _ODD_RATIO < one.ratio < middle * _ODD_RATIO]


def _touchdown_apart_s(run: PlateRun) -> float:
    steps_s = [float(np.median(np.diff(time_s))) for time_s in (run.plate_time_s, run.leg_time_s)]
    return max(_LEAST_APART_S, *(share * step_s for share, step_s in zip(_TOUCHDOWN_SAMPLES, steps_s, strict=True)))


@dataclass(frozen=True, slots=True, eq=False)
class HopTraces:
    """Smoothed force and leg length of one run's hops over the time since touchdown; missing where a hop has ended.

    The foremost `first` are of the run's first hops.
    """

    condition: str
    first: int
    time_s: Floats
    force_n: Floats
    length_m: Floats


@dataclass(frozen=True, slots=True, eq=False)
class ForcePlateStudy:
    """The slope of estimated over measured joules, and all that it is computed from.

    `window` is in samples of `sample_s`, `by_corner` whether the rule chose it. By window of `windows`, `differences`
    (N, all but the first) are the sums of absolute differences from the force smoothed with the window before, and
    `slopes` what the slope would be; `slope_without_foot` is the slope where the foot's weight is taken off the force.
    `ratios` are estimated over measured joules by condition, `titles` the conditions in words. `simulated`
    is by condition, None where nobody asked.
    """

    runs: tuple[RunEstimate, ...]
    slope: SlopeThroughOrigin
    slope_without_foot: float
    rmse: RmseOverIqr
    ratios: Mapping[str, float]
    titles: Mapping[str, str]
    window: int
    by_corner: bool
    sample_s: float
    windows: tuple[int, ...]
    differences: tuple[float, ...]
    slopes: tuple[float, ...]
    traces: tuple[HopTraces, ...]
    left_out: Mapping[str, Undefined]
    simulated: PlainPredictions | None = None


def compare_joules(
    runs: Sequence[PlateRun], window: int | None = None, level: float = 0.95, left_out: Mapping[str, Undefined] = {}
) -> ForcePlateStudy:
    """Estimate the joules of each hop, and fit their line through the origin over the measured ones.

    Without a `window` (odd, in samples) it is the corner of the differences that the next one of `WINDOWS` makes to the
    forces in stance of all runs. Raises `InputRefused` for records whose clocks cannot be aligned, and for a leg out of
    reach.
    """
    stances = [_stances(run, level) for run in runs]
    steps_s = [float(np.median(np.diff(run.plate_time_s))) for run in runs]
    for run, step_s in zip(runs, steps_s, strict=True):
        if abs(step_s / steps_s[0] - 1.0) > 0.01:
            raise InputRefused(
                f"the plate's rate is {1 / steps_s[0]:.4g} Hz in {runs[0].name} and {1 / step_s:.4g} Hz in {run.name}, "
                "and one window smooths all: select runs of one rate with --where."
            )
    differences, estimates = [], list[list[Floats]]()
    before: list[Floats] = []
    for tried in WINDOWS:
        forces = [one.force_n(tried) for one in stances]
        if before:
            pairs = zip(forces, before, strict=True)
            differences.append(sum(float(np.abs(now - then).sum()) for now, then in pairs))
        estimates.append([one.joules(force_n) for one, force_n in zip(stances, forces, strict=True)])
        before = forces
    chosen = corner(WINDOWS[1:], differences) if window is None else window
    at_window = estimates[WINDOWS.index(chosen)]
    measured = [run.measured_j for run in runs]
    days = [run.day for run in runs]
    groups = days if len(set(days)) > 1 else [run.name for run in runs]
    shared = [run.shared for run in runs]

    def slope(joules: Sequence[Floats]) -> SlopeThroughOrigin:
        return slope_through_origin(measured, [float(hops.mean()) for hops in joules], groups, shared, level)

    line = slope(at_window)
    every = np.concatenate(at_window)
    expected = np.repeat(line.slope * np.array(measured), [hops.size for hops in at_window])
    conditions = sorted({run.condition for run in runs}, key=sort_key)
    return ForcePlateStudy(
        runs=tuple(
            RunEstimate(
                run.name,
                run.day,
                run.condition,
                run.measured_j,
                tuple(hops.tolist()),
                one.first,
                run.hops,
                one.stances,
                one.clocks,
                _touchdown_apart_s(run),
            )
            for run, one, hops in zip(runs, stances, at_window, strict=True)
        ),
        slope=line,
        slope_without_foot=slope([one.joules(one.force_n(chosen) - one.foot_weight_n) for one in stances]).slope,
        rmse=rmse_over_iqr(every, expected),
        ratios={condition: _ratio(condition, runs, at_window) for condition in conditions},
        titles={run.condition: run.title or run.condition for run in runs},
        window=chosen,
        by_corner=window is None,
        sample_s=steps_s[0],
        windows=WINDOWS,
        differences=tuple(differences),
        slopes=tuple(slope(joules).slope for joules in estimates),
        traces=tuple(
            next(one.traces(chosen) for run, one in zip(runs, stances, strict=True) if run.condition == condition)
            for condition in conditions
        ),
        left_out=left_out,
    )


def _ratio(condition: str, runs: Sequence[PlateRun], joules: Sequence[Floats]) -> float:
    of_it = [
        (float(hops.mean()), run.measured_j)
        for run, hops in zip(runs, joules, strict=True)
        if run.condition == condition
    ]
    return sum(estimated for estimated, _ in of_it) / sum(measured for _, measured in of_it)


@dataclass(frozen=True, slots=True, eq=False)
class _Stances:
    """The stances of a run that both records hold whole, one after another.

    `above_n` is the plate's force above its zero in all samples; `at` are those in stance, in which the leg has the
    levers and speeds, and which count for `weights_s` in an integral; each stance begins at one of `begins`. Of all
    `stances` on the plate, so many of the first `FIRST_HOPS` are among these as `first` says.
    """

    run: PlateRun
    clocks: Clocks
    above_n: Floats
    at: NDArray[np.intp]
    begins: NDArray[np.intp]
    length_m: Floats
    levers_m: Floats
    speed_m_s: Floats
    weights_s: Floats
    stances: int
    first: int

    @property
    def foot_weight_n(self) -> float:
        """Weight of the foot, which stands on the plate and is not carried by the leg."""
        return self.run.foot_mass_kg * STANDARD_GRAVITY_M_S2

    def force_n(self, window: int) -> Floats:
        """Return the smoothed force in stance."""
        return moving_average(self.above_n, window)[self.at]

    def joules(self, force_n: Floats) -> Floats:
        """Return the joules of each stance."""
        drive = self.run.drive
        power_w = drive.heat_w(force_n, self.levers_m) + drive.drag_w(self.speed_m_s, self.levers_m)
        return np.asarray(np.add.reduceat(self.weights_s * (power_w + force_n * self.speed_m_s), self.begins))

    def traces(self, window: int) -> HopTraces:
        """Return what a figure shows of the first stances."""
        force_n, ends = self.force_n(window), [*self.begins[1:].tolist(), self.at.size]
        parts = [slice(begin, end) for begin, end in zip(self.begins.tolist(), ends, strict=True)][:SHOWN_HOPS]
        longest = max(part.stop - part.start for part in parts)
        shape = (len(parts), longest)
        force, length = np.full(shape, np.nan), np.full(shape, np.nan)
        for row, part in enumerate(parts):
            force[row, : part.stop - part.start] = force_n[part]
            length[row, : part.stop - part.start] = self.length_m[part]
        step_s = float(np.median(np.diff(self.run.plate_time_s)))
        return HopTraces(self.run.condition, self.first, np.arange(longest) * step_s, force, length)


def _stances(run: PlateRun, level: float) -> _Stances:
    contacts = find_contacts(run.plate_time_s, run.force_n)
    above_n = force_above_zero(run.plate_time_s, run.force_n)
    if isinstance(contacts, Undefined) or isinstance(above_n, Undefined):
        why = [one.reason for one in (contacts, above_n) if isinstance(one, Undefined)]
        raise InputRefused(f"run {run.name}: no stance on the plate, {why[0]}: record flights and contacts.")
    try:
        clocks = align_clocks([one.start_s for one in contacts], leg_touchdowns(run.leg_time_s, run.length_m), level)
    except InputRefused as error:
        raise InputRefused(f"run {run.name}: plate and leg cannot be aligned; {error}.") from error
    leg_s = clocks.second_s(run.plate_time_s)
    length_m = np.interp(leg_s, run.leg_time_s, run.length_m)
    speed_m_s = np.interp(leg_s, run.leg_time_s, np.gradient(run.length_m, run.leg_time_s))
    whole = [_range(run, clocks, contact) for contact in contacts]
    ranges = [one for one in whole if one is not None]
    if not ranges:
        raise InputRefused(f"run {run.name}: no stance is whole in both records: look for its missing samples.")
    at = np.concatenate([np.arange(begin, end) for begin, end in ranges])
    _check_reach(run, run.plate_time_s[at], length_m[at])
    weights_s = np.concatenate([_weights(run.plate_time_s[begin:end]) for begin, end in ranges])
    return _Stances(
        run=run,
        clocks=clocks,
        above_n=np.nan_to_num(above_n),
        at=at,
        begins=np.cumsum([0, *(end - begin for begin, end in ranges[:-1])]),
        length_m=length_m[at],
        levers_m=run.drive.levers_m(length_m[at]),
        speed_m_s=speed_m_s[at],
        weights_s=weights_s,
        stances=len(contacts),
        first=sum(one is not None for one in whole[:FIRST_HOPS]),
    )


def _range(run: PlateRun, clocks: Clocks, contact: Contact) -> tuple[int, int] | None:
    """Return the half-open range of a stance's samples on the plate, None where the log lacks samples there."""
    begin, end = np.searchsorted(run.plate_time_s, [contact.start_s, contact.end_s])
    first, last = np.searchsorted(run.leg_time_s, clocks.second_s([contact.start_s, contact.end_s]))
    if first < 1 or last >= run.leg_time_s.size or end - begin < 2:
        return None
    steps_s = np.diff(run.leg_time_s[first - 1 : last + 1])
    return None if steps_s.max() > 1.5 * np.median(np.diff(run.leg_time_s)) else (int(begin), int(end))


def _weights(time_s: Floats) -> Floats:
    """Return what each sample counts for in the integral by trapezoids."""
    half_s = 0.5 * np.diff(time_s)
    return np.asarray(np.concatenate([[0.0], half_s]) + np.concatenate([half_s, [0.0]]))


def _check_reach(run: PlateRun, time_s: Floats, length_m: Floats) -> None:
    low, high = run.drive.reach_m
    out = np.flatnonzero((length_m <= low) | (length_m >= high))
    if out.size:
        raise InputRefused(
            f"run {run.name}: the leg is {length_m[out[0]]:.3f} m long at {time_s[out[0]]:.2f} s, and links of "
            f"{run.drive.upper_link:g} and {run.drive.lower_link:g} m reach {low:g} to {high:g} m: measure the links "
            "([robots] of labbook.toml) and the leg's length when it is held straight."
        )
