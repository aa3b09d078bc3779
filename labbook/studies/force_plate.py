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
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import sqlalchemy as sa
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused, UsageError
from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow, refuse_empty_selection
from data_schema.queries.signals import SignalRow, gaps_by_signal, signals_of_runs
from data_schema.reasons import Reason
from data_schema.rounding import error_of, interval_text, number_text
from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import FileRole, Undefined
from ingest.store import Store
from labbook.analysis.comparison.pairing import sort_key
from labbook.analysis.outcomes.detection import gaps_for_detector
from labbook.analysis.outcomes.run_energy import RunEnergy, passive_drains, run_energies
from labbook.analysis.outcomes.run_force import usable_force, vertical_force
from labbook.analysis.prediction.condition_scenes import study_scene
from labbook.analysis.prediction.simulating import plain_predictions
from labbook.analysis.results import Results
from labbook.analysis.study_data import StudyData, gather
from labbook.book.opening import opened
from labbook.config.model import Configuration
from labbook.studies.study import Asked, Found, book_sources, level_of
from labbook.terminal import NOT_IN_JSON
from reports.display import true_minus
from reports.figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILLION, light_grid, paper_figure
from reports.page.study import Study
from simulator.kinematics import lever_m
from simulator.steady.published_results import published_numbers
from stats.clocks import Clocks, align_clocks, corner, leg_touchdowns, moving_average
from stats.compare.agreement import RmseOverIqr, rmse_over_iqr
from stats.compare.shared_error import SharedError
from stats.force_plate import Contact, find_contacts, force_above_zero
from stats.lines.regression import SlopeThroughOrigin, slope_through_origin
from stats.results import plural

Floats = NDArray[np.float64]
WINDOWS = tuple(range(1, 53, 2))
"""Samples of the moving averages that are tried, up to 51 ms at 1 kHz; odd, so that none shifts the force in time."""
SHOWN_HOPS, FIRST_HOPS = 20, 3
"""Hops whose traces are drawn, and of a run those in which a robot that is let go from the hand comes to its height."""
MOTOR_PARAMETERS = ("torque_constant", "motor_resistance", "velocity_constant")
"""Of a scene, as `Drive` calls them too."""
LEG_LENGTH = "leg_length"
_TOUCHDOWN_SAMPLES = (1.0 / 2.0, 1.0 / 6.0)
"""Samples of the plate and of the leg's log by which both may see the same touchdown apart, always to the same side, so
that it is in no scatter: 0.5 ms at 1 kHz and 333 Hz, where it was measured; faster records are not taken to do better.
"""
_LEAST_APART_S = 0.0005
_FEWEST_CONDITIONS = 2
_ODD_RATIO = 3.0
"""By this factor the ratio of a run is off the middle one where its charge or its record is likely another's."""
_DASH = "–"


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

    def levers_m(self, length_m: ArrayLike) -> Floats:
        """Return the joint's lever arm at each leg length, shape (n,)."""
        lengths = np.asarray(length_m, np.float64)
        levers = (lever_m(self.upper_link, self.lower_link, length) for length in lengths.tolist())
        return np.fromiter(levers, np.float64, lengths.size)

    def heat_w(self, force_n: Floats, levers_m: Floats) -> Floats:
        """Return the heat in the windings of both motors, R I^2 / 2 for the current I of both together."""
        current_a = force_n * levers_m / self.torque_constant
        return np.asarray(0.5 * self.motor_resistance * current_a**2)

    def drag_w(self, speed_m_s: Floats, levers_m: Floats) -> Floats:
        """Return the electromechanical drag at the leg's speed, extension positive."""
        factor = self.torque_constant * self.velocity_constant / self.motor_resistance
        return np.asarray(factor * (speed_m_s / levers_m) ** 2)


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
    hops (`FIRST_HOPS`); of `hops_made` the plate saw `stances`. `offset_ci` is the interval of the clocks' offset: that
    of the line, and what a touchdown's definition leaves open, `touchdown_apart_s`.
    """

    run: str
    day: str
    condition: str
    measured_j: float
    estimated_j: float
    hops_j: tuple[float, ...]
    first: int
    hops_made: int
    stances: int
    clocks: Clocks
    touchdown_apart_s: float
    offset_ci: tuple[float, float] | Undefined

    @property
    def ratio(self) -> float:
        """Estimated over measured joules."""
        return self.estimated_j / self.measured_j


@dataclass(frozen=True, slots=True)
class PlateCondition:
    """A condition, in words too: joules a hop, measured and simulated, and estimated over measured ones.

    For a figure the smoothed force and leg length of one run's hops over the time since touchdown, a row a hop, NaN
    where it has ended; the foremost `first` are of the run's first hops.
    """

    condition: str
    title: str
    measured_j: float
    ratio: float
    simulated_j: float | None
    first: int
    time_s: Floats = field(metadata=NOT_IN_JSON)
    force_n: Floats = field(metadata=NOT_IN_JSON)
    length_m: Floats = field(metadata=NOT_IN_JSON)


@dataclass(frozen=True, slots=True)
class Window:
    """A moving average of so many samples: the slope with it, and the sum of absolute differences from the one before.

    The difference, in N, is that of all forces in stance; None of the first.
    """

    window: int
    difference_n: float | None
    slope: float


@dataclass(frozen=True, slots=True)
class ForcePlateStudy(Study):
    """The slope of estimated over measured joules, and all that it is computed from.

    `window` is in samples of `sample_s`, `window_by_corner` whether the rule chose it. `slope_without_foot` is the
    slope where the foot's weight is taken off the force. `left_out` says why runs are.
    """

    title: ClassVar[str] = "Joules of plate and leg against the battery's"
    slope: SlopeThroughOrigin
    slope_without_foot: float
    rmse: RmseOverIqr
    conditions: tuple[PlateCondition, ...]
    window: int
    window_by_corner: bool
    sample_s: float
    windows: tuple[Window, ...]
    runs: tuple[RunEstimate, ...]
    left_out: Mapping[str, Undefined]
    not_simulated: str

    def sentences(self) -> list[str]:
        """Say the slope, then what it was computed from: runs, clocks, window, and what was left out."""
        published, days = published_numbers(), len({one.day for one in self.runs})
        over = f"{plural(self.slope.n, 'run')} of {plural(len(self.conditions), 'condition')}"
        over = f"{plural(days, 'day')}, {over}" if days > 1 else over
        of_conditions = ", ".join(f"{number_text(one.ratio, 3)} at {one.condition}" for one in self.conditions)
        drifts = [1e6 * one.clocks.drift for one in self.runs]
        between = true_minus(f"{min(drifts):.0f} to {max(drifts):.0f}")
        spread_ms = max(1e3 * one.clocks.residual_sd_s for one in self.runs)
        lines = [
            f"Estimated joules are {self._slope_text()} times the measured ones (over {over}); the thesis found "
            f"{published['plate.slope']:g} (3.2.2).",
            f"RMSE/IQR of the hops about this line: {self._rmse_text('undefined')} (n = {self.rmse.n} hops); the "
            f"thesis {published['plate.rmse_iqr']:g}.",
            f"Estimated over measured: {of_conditions}.",
            "The plate carries the foot's weight too, the leg does not: less that, the slope is "
            f"{number_text(self.slope_without_foot, 3)}.",
            self._window_text(),
            f"The log's clock drifts by {between} ppm against the plate's; touchdowns lie {spread_ms:.2g} ms or less "
            "from one line (standard deviation, by run).",
        ]
        if left := sum(one.stances - len(one.hops_j) for one in self.runs):
            lines.append(
                f"{plural(left, 'hop')} with samples missing in the log {'is' if left == 1 else 'are'} left out."
            )
        other = [f"{one.run} ({one.stances} of {one.hops_made})" for one in self.runs if one.stances != one.hops_made]
        if other:
            lines.append(
                f"The plate saw other stances than hops were made in {', '.join(other)}: check jumps_made, and samples "
                "that are missing."
            )
        middle = float(np.median([one.ratio for one in self.runs]))
        if odd := [one for one in self.runs if not middle / _ODD_RATIO < one.ratio < middle * _ODD_RATIO]:
            named = ", ".join(f"{one.run} ({number_text(one.ratio, 2)})" for one in odd)
            lines.append(
                f"Estimated over measured is far from that of the other runs in {named}: check the charge and the log."
            )
        if self.left_out:
            named = ", ".join(f"{name} ({why.reason})" for name, why in self.left_out.items())
            lines.append(f"Left out: {named}.")
        if self.not_simulated:
            lines.append(f"Not simulated: {self.not_simulated}")
        if days == 1:
            lines.append("All runs are of one day, and the interval says nothing of other days.")
        return lines

    def _slope_text(self) -> str:
        slope = self.slope
        number = number_text(slope.slope, error=error_of(slope.ci))
        if isinstance(slope.ci, Undefined):
            return f"{number} (no interval: {slope.ci.reason})"
        return f"{number} ({interval_text(slope.ci, slope.level)})"

    def _rmse_text(self, none: str) -> str:
        return none if isinstance(self.rmse.ratio, Undefined) else number_text(self.rmse.ratio, 2)

    def _window_text(self) -> str:
        how = "the corner of what the next window changes" if self.window_by_corner else "as given"
        place = [one.window for one in self.windows].index(self.window)
        low, high = self.windows[max(place - 1, 0)], self.windows[min(place + 1, len(self.windows) - 1)]
        steep = (high.slope - low.slope) / (high.window - low.window)
        pairs = zip(self.windows, self.windows[1:], strict=False)
        equal = [one.window for before, one in pairs if before.slope > 1.0 >= one.slope]
        at_1 = f", and to 1 at {equal[0]}" if equal else ""
        first, last = self.windows[0], self.windows[-1]
        return (
            f"The force is smoothed over {plural(self.window, 'sample')} "
            f"({1e3 * self.sample_s * self.window:.3g} ms; {how}). One sample more changes the slope by "
            f"{true_minus(number_text(steep, 2))} there: from {number_text(first.slope, 3)} without smoothing to "
            f"{number_text(last.slope, 3)} over {last.window} samples{at_1}."
        )

    def table(self) -> list[Sequence[str]]:
        """Return the table of the runs; the last column is the standard deviation of the touchdowns in ms."""
        head = ("run", "day", "condition", "measured J", "estimated J", "hops", "offset s", "drift ppm", "ms")
        return [
            head,
            *(
                (
                    one.run,
                    one.day,
                    one.condition,
                    f"{one.measured_j:.2f}",
                    f"{one.estimated_j:.2f}",
                    f"{len(one.hops_j)} of {one.hops_made}",
                    true_minus(f"{one.clocks.at_zero_s:.4f}"),
                    true_minus(f"{1e6 * one.clocks.drift:.1f}"),
                    f"{1e3 * one.clocks.residual_sd_s:.2f}",
                )
                for one in self.runs
            ),
        ]

    def beside(self) -> list[tuple[str, ...]]:
        """Return what was measured beside what the simulator gives and what the thesis says (3.2.2)."""
        slope, rmse, window = (f"{published_numbers()[f'plate.{of}']:g}" for of in ("slope", "rmse_iqr", "window"))
        found: list[tuple[str, ...]] = [
            ("slope, estimated over measured joules", self._slope_text(), _DASH, slope),
            ("RMSE/IQR about it", self._rmse_text(_DASH), _DASH, rmse),
            ("moving average (samples)", str(self.window), _DASH, window),
        ]
        for one in self.conditions:
            simulated = _DASH if one.simulated_j is None else f"{one.simulated_j:.2f}"
            found.append((f"joules a hop at {one.title}", f"{one.measured_j:.2f}", simulated, _DASH))
        return found

    def caption(self) -> str:
        """Say what is drawn."""
        return (
            f"Force and leg length of up to {SHOWN_HOPS} hops of one run a condition, on one clock, since touchdown "
            f"(bold line); the first {FIRST_HOPS} (dashed, hollow) start from the hand, and lower. Joules of each hop "
            "and means of runs, over the measured ones; the line goes through the origin. What the next wider moving "
            "average changes of the force in stance, relative to the narrowest; the window used; the slope by window."
        )

    def draw(self) -> Figure:
        """Draw traces of hops, estimated over measured joules, and what the window does (thesis fig. 3.7)."""
        colours, markers, dashed = (BLUE, VERMILLION, GREEN, ORANGE, BLACK), "os^vD", (0, (2, 2))
        with paper_figure(4.7) as figure:
            panels = figure.subplots(2, 2).T.ravel()
            force, leg, joules, windows = panels
            for place, one in enumerate(self.conditions):
                colour, marker = colours[place % len(colours)], markers[place % len(markers)]
                for row, (forces, lengths) in enumerate(zip(one.force_n, one.length_m, strict=True)):
                    look: dict[str, Any] = {"color": colour, "linewidth": 0.4, "alpha": 0.6}
                    if row < one.first:
                        look |= {"linestyle": dashed, "linewidth": 0.6}
                    force.plot(1e3 * one.time_s, forces, **look)
                    leg.plot(1e3 * one.time_s, 100.0 * lengths, **look)
                for run in self.runs:
                    if run.condition == one.condition:
                        _draw_hops(joules, run, colour, marker)
                force.plot([], [], marker=marker, color=colour, markersize=3.5, linewidth=1.5, label=one.title)
            look = {"color": GREY, "linewidth": 1.0, "marker": "o", "markerfacecolor": "none", "markersize": 3}
            force.plot([], [], linestyle=dashed, label="the first hops of a run", **look)
            for axes, up in ((force, "Force on the plate (N)"), (leg, "Leg length (cm)")):
                axes.axvline(0.0, color=BLACK, linewidth=1.2)
                axes.set_xlabel("Time since touchdown (ms)")
                axes.set_ylabel(up)
            self._draw_line(joules)
            self._draw_windows(windows)
            for axes in panels:
                light_grid(axes)
            handles, names = force.get_legend_handles_labels()
            figure.legend(handles, names, loc="outside lower center", ncols=3)
            return figure

    def _draw_line(self, axes: Axes) -> None:
        """Draw the line where there are hops, and that of equal joules."""
        measured = [one.measured_j for one in self.runs]
        ends = np.array([0.92 * min(measured), 1.06 * max(measured)])
        axes.plot(ends, self.slope.slope * ends, color=BLACK, linewidth=0.9, label=f"slope {self._slope_text()}")
        axes.plot(ends, ends, color=BLACK, linewidth=0.6, linestyle=":", label="equal")
        axes.set_xlim(*ends)
        axes.set_xlabel("Measured joules a hop (J)")
        axes.set_ylabel("Estimated joules a hop (J)")
        low, high = axes.get_ylim()
        axes.set_ylim(low, high + 0.25 * (high - low))
        axes.legend(loc="upper left", handlelength=1.2)

    def _draw_windows(self, axes: Axes) -> None:
        """Draw differences, relative to the first, and slopes over the window, each with its axis."""
        across, slopes = [one.window for one in self.windows[1:]], [one.slope for one in self.windows[1:]]
        differences = np.array([one.difference_n for one in self.windows[1:]], np.float64)
        axes.plot(across, differences / differences[0], "o-", color=BLUE, markersize=2, linewidth=0.8)
        axes.axvline(self.window, color=BLACK, linewidth=0.8, linestyle="--")
        why = f"{'corner' if self.window_by_corner else 'as given'}: {self.window} samples"
        axes.text(self.window + 1.0, 0.97, why, transform=axes.get_xaxis_transform(), va="top", fontsize=7)
        axes.set_xlabel("Window of the moving average (samples)")
        axes.set_ylabel("Change of the force, relative", color=BLUE)
        axes.set_ylim(bottom=0.0)
        right = axes.twinx()
        right.plot(across, slopes, "s-", color=VERMILLION, markersize=2, linewidth=0.8)
        right.set_ylabel("Slope, estimated / measured", color=VERMILLION)
        right.spines.right.set_visible(True)


def _draw_hops(axes: Axes, run: RunEstimate, colour: str, marker: str) -> None:
    """Draw the hops of a run as points spread over 0.8 J by the golden section, the first ones hollow, and the mean."""
    across = [run.measured_j + 0.8 * ((place * 0.618) % 1.0 - 0.5) for place in range(len(run.hops_j))]
    few = run.first
    hollow: dict[str, Any] = {"markersize": 2.5, "markerfacecolor": "none", "markeredgewidth": 0.6}
    axes.plot(across[:few], run.hops_j[:few], "o", color=colour, **hollow)
    axes.plot(across[few:], run.hops_j[few:], "o", color=colour, alpha=0.35, markersize=1.8, markeredgewidth=0)
    look: dict[str, Any] = {"color": colour, "markersize": 4.5, "markeredgecolor": "white", "markeredgewidth": 0.6}
    axes.plot(run.measured_j, run.estimated_j, marker, **look)


def ask(asked: Asked) -> Found[ForcePlateStudy]:
    """Open the book and compare joules estimated from the plate's forces with those of the battery.

    Raises `UsageError` for a window that is even or none, `InputRefused` as `compare_joules` does, and, with the line
    of labbook.toml to write, for a book without what it takes: records of the plate, leg lengths, joules, motors, and
    at least two conditions.
    """
    with opened(asked.book) as book, book.reading() as connection:
        options = asked.settled("force-plate", book.configuration)
        level, window = level_of(options), options.window
        refuse_empty_selection(connection, options.where)
        if window is not None and window not in WINDOWS:
            raise UsageError(
                f"--window {window}: give an odd number of samples from {WINDOWS[0]} to {WINDOWS[-1]}; an even one "
                "would shift the force in time."
            )
        data = gather(connection, book.configuration, options.where)
        runs, left_out = _plate_runs(connection, book.store, data, asked)
        simulated = plain_predictions(connection, data, asked.step)
        names = {run.condition_key: _condition(run) for run in data.runs}
        joules = {name: simulated.value(key, Outcome.JOULES) for key, name in names.items()}
        asked.step("estimating joules")
        study = compare_joules(runs, window, level, left_out, joules, simulated.why_not)
        return Found(study, book_sources(connection, book.configuration, options.where or "all"))


def _plate_runs(
    connection: sa.Connection, store: Store, data: StudyData, asked: Asked
) -> tuple[list[PlateRun], dict[str, Undefined]]:
    """Read the runs that both instruments recorded and the charger knows, and say why others are left out."""
    on_plate = [run for run in data.runs if data.forces.get(run.uid)]
    if not on_plate:
        raise InputRefused(
            f"none of {len(data.runs)} runs has a force-plate record: `labbook ingest` the plate's exports beside the "
            "logs, named after their runs."
        )
    legs: dict[str, list[SignalRow]] = {}
    for signal in signals_of_runs(connection, FileRole.LOG):
        if LEG_LENGTH in signal.channels:
            legs.setdefault(signal.run_uid, []).append(signal)
    _check_study(data.configuration, on_plate, legs)
    computed = Results()
    energies = run_energies(computed, data, passive_drains(computed, data))
    missing = data.reasons(energies.missing, FileRole.CHARGE)
    found, left_out = [], dict[str, Undefined]()
    for run in on_plate:
        asked.step(f"reading {run.name}")
        energy = missing[run.uid] if run.uid in missing else energies.results[run.uid]
        made = _plate_run(connection, store, data, run, legs.get(run.uid, ()), energy)
        if isinstance(made, Undefined):
            left_out[run.name] = made
        else:
            found.append(made)
    if not found:
        name, why = next(iter(left_out.items()))
        raise InputRefused(
            f"no run on the plate has both a leg length and joules; {name}: {why.reason}. Joules need the recharge of "
            "each run, and idle runs of several durations."
        )
    if len({run.condition for run in found}) < _FEWEST_CONDITIONS:
        raise InputRefused(
            f"all runs on the plate are of one condition ({found[0].condition}), and a slope needs hops of different "
            "joules: run other extension gains too."
        )
    return found, left_out


def _check_study(configuration: Configuration, runs: Sequence[RunRow], legs: Mapping[str, Sequence[SignalRow]]) -> None:
    """Refuse a book that lacks what all runs need, with the line to write."""
    if not configuration.factors:
        raise UsageError(
            "labbook.toml has no factor, and the slope is over extension gains: write them as [factors.k_gain] with "
            'kind = "number" and levels = [300, 400, 500, 600].'
        )
    if configuration.simulation is None:
        raise UsageError(
            "labbook.toml does not say with which motors joules are estimated: write [simulation] with "
            'scene = "force_plate" (and your motors under parameters = { torque_constant = 0.0955, ... }).'
        )
    if not any(legs.get(run.uid) for run in runs):
        raise InputRefused(
            f"no log of the runs on the plate ({runs[0].name}, ...) has the channel leg_length: declare its column in "
            'labbook.toml, [profiles.NAME.columns] Leg = { channel = "leg_length", unit = "mm" }, and `labbook files '
            "reread` the logs."
        )


def _plate_run(
    connection: sa.Connection,
    store: Store,
    data: StudyData,
    run: RunRow,
    legs: Sequence[SignalRow],
    energy: RunEnergy | Undefined,
) -> PlateRun | Undefined:
    """Read a run's force and leg length, of which samples saved twice are one; or say what it lacks."""
    force = usable_force(data.forces[run.uid])
    if isinstance(force, Undefined):
        return force
    distinct = list({signal.sha256: signal for signal in legs}.values())
    if len(distinct) != 1:
        return Undefined(Reason.SEVERAL_LEG_LENGTHS, n=len(distinct)) if distinct else Undefined(Reason.NO_LEG_LENGTH)
    if isinstance(energy, Undefined):
        return energy
    measured_j = energy.joules_per_jump.value
    if isinstance(measured_j, Undefined):
        return measured_j
    if measured_j <= 0.0:
        return Undefined(Reason.JOULES_NOT_POSITIVE, joules=measured_j)
    robot, settings = data.configuration.robots.get(run.robot), data.configuration.simulation
    if robot is None or settings is None:
        raise UsageError(
            f"labbook.toml has no robot {run.robot!r}, whose links run {run.name} needs: write [robots.{run.robot}] "
            "with link_1_m and link_2_m."
        )
    factors = data.configuration.factors
    gaps = gaps_by_signal(connection, [force.uid])[force.uid]
    plate_time_s, force_n = vertical_force(store, force, gaps_for_detector(gaps))
    samples, scene = store.samples(distinct[0].store_path, [LEG_LENGTH]), study_scene(settings)
    known = np.isfinite(samples[LEG_LENGTH])
    motors = {name: settings.parameters.get(name, scene[name]) for name in MOTOR_PARAMETERS}
    return PlateRun(
        name=run.name,
        day=run.day,
        condition=_condition(run),
        title=", ".join(
            " ".join(filter(None, (factors[name].title or name, label, factors[name].unit)))
            for name, label in run.levels.items()
        ),
        measured_j=measured_j,
        shared=energy.shared_error,
        hops=run.jumps_made,
        foot_mass_kg=robot.foot_mass_kg,
        drive=Drive(upper_link=robot.link_1_m, lower_link=robot.link_2_m, **motors),
        plate_time_s=plate_time_s,
        force_n=force_n,
        leg_time_s=samples["time"][known],
        length_m=samples[LEG_LENGTH][known],
    )


def _condition(run: RunRow) -> str:
    return ", ".join(f"{factor} {label}" for factor, label in run.levels.items())


def compare_joules(
    runs: Sequence[PlateRun],
    window: int | None = None,
    level: float = 0.95,
    left_out: Mapping[str, Undefined] = {},
    simulated_j: Mapping[str, float | None] = {},
    not_simulated: str = "",
) -> ForcePlateStudy:
    """Estimate the joules of each hop, and fit their line through the origin over the measured ones.

    Without a `window` (odd, in samples) it is the corner of the differences that the next one of `WINDOWS` makes to the
    forces in stance of all runs. `simulated_j` are by condition. Raises `InputRefused` for records whose clocks cannot
    be aligned, and for a leg out of reach.
    """
    stances = [_stances(run, level) for run in runs]
    steps_s = [float(np.median(np.diff(run.plate_time_s))) for run in runs]
    for run, step_s in zip(runs, steps_s, strict=True):
        if abs(step_s / steps_s[0] - 1.0) > 0.01:
            raise InputRefused(
                f"the plate's rate is {1 / steps_s[0]:.4g} Hz in {runs[0].name} and {1 / step_s:.4g} Hz in {run.name}, "
                "and one window smooths all: select runs of one rate with --where."
            )
    measured, days = [run.measured_j for run in runs], [run.day for run in runs]
    groups = days if len(set(days)) > 1 else [run.name for run in runs]
    shared = [run.shared for run in runs]

    def slope(joules: Sequence[Floats]) -> SlopeThroughOrigin:
        return slope_through_origin(measured, [float(hops.mean()) for hops in joules], groups, shared, level)

    windows, estimates = list[Window](), list[list[Floats]]()
    before: list[Floats] | None = None
    for tried in WINDOWS:
        forces = [one.force_n(tried) for one in stances]
        difference_n = None
        if before is not None:
            difference_n = sum(float(np.abs(now - then).sum()) for now, then in zip(forces, before, strict=True))
        estimates.append([one.joules(force_n) for one, force_n in zip(stances, forces, strict=True)])
        windows.append(Window(tried, difference_n, slope(estimates[-1]).slope))
        before = forces
    differences_n = [one.difference_n for one in windows if one.difference_n is not None]
    chosen = corner(WINDOWS[1:], differences_n) if window is None else window
    at_window = estimates[WINDOWS.index(chosen)]
    line = slope(at_window)
    expected = np.repeat(line.slope * np.array(measured), [hops.size for hops in at_window])
    made = [_estimate(run, one, hops) for run, one, hops in zip(runs, stances, at_window, strict=True)]
    return ForcePlateStudy(
        slope=line,
        slope_without_foot=slope(
            [one.joules(one.force_n(chosen) - one.run.foot_mass_kg * STANDARD_GRAVITY_M_S2) for one in stances]
        ).slope,
        rmse=rmse_over_iqr(np.concatenate(at_window), expected),
        conditions=tuple(
            _of_condition([one for one in made if one.condition == condition], stances, chosen, simulated_j)
            for condition in sorted({run.condition for run in runs}, key=sort_key)
        ),
        window=chosen,
        window_by_corner=window is None,
        sample_s=steps_s[0],
        windows=tuple(windows),
        runs=tuple(made),
        left_out=left_out,
        not_simulated=not_simulated,
    )


def _estimate(run: PlateRun, stances: _Stances, hops: Floats) -> RunEstimate:
    steps_s = [float(np.median(np.diff(time_s))) for time_s in (run.plate_time_s, run.leg_time_s)]
    apart_s = max(_LEAST_APART_S, *(share * step_s for share, step_s in zip(_TOUCHDOWN_SAMPLES, steps_s, strict=True)))
    ci = stances.clocks.at_zero_ci
    return RunEstimate(
        run=run.name,
        day=run.day,
        condition=run.condition,
        measured_j=run.measured_j,
        estimated_j=float(np.mean(hops)),
        hops_j=tuple(hops.tolist()),
        first=stances.first,
        hops_made=run.hops,
        stances=stances.stances,
        clocks=stances.clocks,
        touchdown_apart_s=apart_s,
        offset_ci=ci if isinstance(ci, Undefined) else (ci[0] - apart_s, ci[1] + apart_s),
    )


def _of_condition(
    made: Sequence[RunEstimate], stances: Sequence[_Stances], window: int, simulated_j: Mapping[str, float | None]
) -> PlateCondition:
    condition, total_j = made[0].condition, sum(one.measured_j for one in made)
    first = next(one for one in stances if one.run.condition == condition)
    return PlateCondition(
        condition,
        first.run.title or condition,
        total_j / len(made),
        sum(one.estimated_j for one in made) / total_j,
        simulated_j.get(condition),
        first.first,
        *first.traces(window),
    )


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

    def force_n(self, window: int) -> Floats:
        """Return the smoothed force in stance."""
        return moving_average(self.above_n, window)[self.at]

    def joules(self, force_n: Floats) -> Floats:
        """Return the joules of each stance."""
        drive = self.run.drive
        power_w = drive.heat_w(force_n, self.levers_m) + drive.drag_w(self.speed_m_s, self.levers_m)
        return np.asarray(np.add.reduceat(self.weights_s * (power_w + force_n * self.speed_m_s), self.begins))

    def traces(self, window: int) -> tuple[Floats, Floats, Floats]:
        """Return of the first stances time since touchdown, and smoothed force and leg length, a row a stance."""
        force_n, ends = self.force_n(window), [*self.begins[1:].tolist(), self.at.size]
        parts = [slice(begin, end) for begin, end in zip(self.begins.tolist(), ends, strict=True)][:SHOWN_HOPS]
        longest = max(part.stop - part.start for part in parts)
        force, length = np.full((2, len(parts), longest), np.nan)
        for row, part in enumerate(parts):
            force[row, : part.stop - part.start] = force_n[part]
            length[row, : part.stop - part.start] = self.length_m[part]
        return np.arange(longest) * float(np.median(np.diff(self.run.plate_time_s))), force, length


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
    low, high = run.drive.reach_m
    out = at[(length_m[at] <= low) | (length_m[at] >= high)]
    if out.size:
        raise InputRefused(
            f"run {run.name}: the leg is {length_m[out[0]]:.3f} m long at {run.plate_time_s[out[0]]:.2f} s, and links "
            f"of {run.drive.upper_link:g} and {run.drive.lower_link:g} m reach {low:g} to {high:g} m: measure the "
            "links ([robots] of labbook.toml) and the leg's length when it is held straight."
        )
    halves_s = [0.5 * np.diff(run.plate_time_s[begin:end]) for begin, end in ranges]
    # what each sample counts for in the integral by trapezoids
    weights_s = np.concatenate([np.pad(half_s, (0, 1)) + np.pad(half_s, (1, 0)) for half_s in halves_s])
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
