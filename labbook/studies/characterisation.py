"""What a leg's gains are in physical units: its stiffness and damping from oscillations of a mass (thesis 4.2.6)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from data_schema.errors import InputRefused
from data_schema.grouping import grouped
from data_schema.reasons import Reason
from data_schema.rounding import error_of, interval_text, number_text
from data_schema.vocabulary import Undefined
from ingest.formats.study_sheets import read_oscillation, read_trials
from labbook.studies.study import Asked, Found, level_of, sheet_source
from labbook.terminal import NOT_IN_JSON
from reports.figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILLION, light_grid, paper_figure
from reports.page.study import Study
from simulator.steady.published_results import published_numbers
from stats.compare.summary import autocorrelation
from stats.lines.oscillations import (
    Coefficient,
    Oscillation,
    OscillationFit,
    fit_oscillations,
    fitted_with,
    plane_of,
)
from stats.lines.stiffness import MINIMUM_POINTS, GainLine, fit_gain_line, velocity_over_rate

FEWEST_GAINS = 3
TOGETHER = 1.25
"""Factor by which intervals are wider for residuals that go together, above which that is reported."""
_OTHER_UNIT = 3.0
"""Velocity over the rate of the position, or its inverse, from which on a unit is wrong."""
_STYLES, _MARKERS, _COLOURS = ("-", "--", ":", "-."), "osD^v", (VERMILLION, BLACK, BLUE, GREEN, ORANGE)
_ASIDE = 0.006
"""How far beside each other points of one gain stand, in the range of gains."""


@dataclass(frozen=True, slots=True)
class Condition:
    """What is fitted together, whatever the mass; `neutral_m` is the leg's length without load, if the sheet says it.

    Conditions sort by it, then by their gains.
    """

    neutral_m: float | None
    gain: float
    damping_gain: float

    def sort_key(self) -> tuple[float, float, float]:
        """Order conditions."""
        return self.neutral_m or 0.0, self.gain, self.damping_gain

    def text(self) -> str:
        """Name it in a sentence."""
        return f"gain {self.gain:g}, damping gain {self.damping_gain:g}{_at(self.neutral_m)}"


@dataclass(frozen=True, slots=True, eq=False)
class Trial(Oscillation):
    """One trajectory as its log `file` has it, and the condition that it is of."""

    file: str
    condition: Condition


@dataclass(frozen=True, slots=True)
class OfMass:
    """What the trajectories of one mass say of a condition, and the number of their points."""

    mass_kg: float
    n: int
    stiffness_n_m: Coefficient
    damping_kg_s: Coefficient


@dataclass(frozen=True, slots=True)
class Plane:
    """The thesis's fit, forces by differences of velocities over position and velocity; biased by noise."""

    stiffness_n_m: float
    damping_kg_s: float


@dataclass(frozen=True, slots=True)
class MeasuredGains(Condition):
    """One condition: the leg's stiffness and damping, of all masses and of each.

    `masses_left_out` says why masses in kg have no fit of their own. `residual_lag1` is the correlation of neighbouring
    velocities' residuals: above 0 the leg is no linear spring, or the log was smoothed. The intervals are `widened` by
    this factor, at most, for residuals that go together. `plane` is the thesis's fit.
    """

    masses_kg: tuple[float, ...]
    trajectories: int
    n: int
    stiffness_n_m: Coefficient
    damping_kg_s: Coefficient
    masses: tuple[OfMass, ...]
    masses_left_out: Mapping[float, str]
    residual_lag1: float | Undefined
    widened: float
    plane: Plane
    trials: tuple[Trial, ...] = field(metadata=NOT_IN_JSON)
    fit: OscillationFit = field(metadata=NOT_IN_JSON)


@dataclass(frozen=True, slots=True)
class GainLines:
    """Of one neutral length: stiffness over gain and damping over damping gain; undefined with too few gains."""

    neutral_m: float | None
    stiffness: GainLine | Undefined
    damping: GainLine | Undefined


@dataclass(frozen=True, slots=True)
class TooFew(Condition):
    """A condition that was left out, with the number of its points."""

    n: int


@dataclass(frozen=True, slots=True)
class Characterisation(Study):
    """All conditions with enough points, the lines by neutral length, and the conditions left out."""

    title: ClassVar[str] = "What the leg's gains are in N/m and kg/s"
    conditions: tuple[MeasuredGains, ...]
    lines: tuple[GainLines, ...]
    too_few: tuple[TooFew, ...]
    level: float

    def sentences(self) -> list[str]:
        """Say the lines of each neutral length, what the thesis found, and what was left out."""
        known, texts = published_numbers(), []
        for lines in self.lines:
            where = _at(lines.neutral_m)
            texts.append(_line_text(f"Stiffness{where}", lines.stiffness, "N/m"))
            texts.append(_line_text(f"Damping{where}", lines.damping, "kg/s"))
        texts.append(
            f"The thesis's leg: stiffness {known['gain.stiffness']:g} N/m x gain + {known['gain.stiffness0']:g} N/m, "
            f"damping {known['gain.damping']:g} kg/s x gain + {known['gain.damping0']:g} kg/s (5.1.1)."
        )
        texts.append(self._plane_text())
        few = f"Left out, as {MINIMUM_POINTS} points are needed: "
        texts += [f"{few}{one.text()}, with {one.n}." for one in self.too_few]
        for one in self.conditions:
            for mass_kg, why in one.masses_left_out.items():
                texts.append(f"No coefficients of {mass_kg:g} kg alone, {one.text()}: {why}")
        if odd := [one for one in self.conditions if one.widened > TOGETHER]:
            texts.append(
                f"Neighbouring residuals go together ({'; '.join(one.text() for one in odd)}): intervals are "
                f"wider for it, by up to a factor of {max(one.widened for one in odd):.1f}. If the logs were not "
                "smoothed, the leg is no linear spring."
            )
        return texts

    def _plane_text(self) -> str:
        """Say how far the thesis's planes are from the fitted motion."""

        def off(one: MeasuredGains, plane: float, motion: Coefficient, unit: str) -> str:
            value, error = number_text(motion.value, error=motion.se), number_text(plane, error=motion.se)
            return f"{one.text()}: {error} {unit} where the motion has {value} {unit}"

        stiff = max(self.conditions, key=lambda one: abs(one.plane.stiffness_n_m / one.stiffness_n_m.value - 1.0))
        damped = max(self.conditions, key=lambda one: abs(one.plane.damping_kg_s - one.damping_kg_s.value))
        return (
            "Planes through forces by differences of velocities (thesis 4.2.6, in --json) differ most in stiffness for "
            f"{off(stiff, stiff.plane.stiffness_n_m, stiff.stiffness_n_m, 'N/m')}, and in damping for "
            f"{off(damped, damped.plane.damping_kg_s, damped.damping_kg_s, 'kg/s')}."
        )

    def table(self) -> list[Sequence[str]]:
        """Return the table of the conditions."""
        head = ("neutral", "gain", "damping gain", "stiffness N/m", "CI", "damping kg/s", "CI", "points")
        return [
            head,
            *(
                (
                    _length_text(one.neutral_m),
                    f"{one.gain:g}",
                    f"{one.damping_gain:g}",
                    *_texts(one.stiffness_n_m),
                    *_texts(one.damping_kg_s),
                    str(one.n),
                )
                for one in self.conditions
            ),
        ]

    def caption(self) -> str:
        """Say what is drawn."""
        return (
            "Force over compression where the leg is damped least, measured and fitted, one trajectory a mass; "
            "stiffness over position gain and damping over velocity gain, points of one mass each, filled where it has "
            f"{MINIMUM_POINTS} points alone, lines through fits of all masses."
        )

    def draw(self) -> Figure:
        """Draw trajectories with their fits, and both coefficients over the gains that were set (thesis fig. 4.5)."""
        from matplotlib.lines import Line2D

        with paper_figure(2.7) as figure:
            of_motion, *panels = figure.subplots(1, 3)
            least = min(self.conditions, key=lambda one: one.damping_kg_s.value / one.stiffness_n_m.value**0.5)
            of_masses = {one.mass_kg: place for place, one in reversed(list(enumerate(least.trials)))}
            place = [lines.neutral_m for lines in self.lines].index(least.neutral_m)
            for number in of_masses.values():
                trial = least.trials[number]
                measured_m, _velocity, measured_n = trial.points()
                motion = np.stack([trial.displacement_m, trial.velocity_m_s]) - least.fit.residuals[number]
                fitted_n = least.fit.values @ np.stack([*motion, np.ones(motion[0].size)])
                of_motion.plot(100.0 * measured_m, measured_n, ".", color=GREY, markersize=2)
                of_motion.plot(100.0 * motion[0], fitted_n, color=_colour(place), linewidth=0.9)
            of_motion.set_xlabel("Compression (cm)")
            of_motion.set_ylabel("Force of the leg (N)")
            of_motion.set_title(f"Gain {least.gain:g}{_at(least.neutral_m, ', ')}")
            light_grid(of_motion)
            labels = (("Position gain", "Stiffness (N/m)"), ("Velocity gain", "Damping (kg/s)"))
            for axes, (across, up), of_stiffness in zip(panels, labels, (True, False), strict=True):
                self._draw_over_gain(axes, of_stiffness=of_stiffness)
                axes.set_xlabel(across)
                axes.set_ylabel(up)
                axes.set_ylim(bottom=0.0)
                light_grid(axes)
            handles = [
                Line2D([], [], color=_colour(place), ls=_STYLES[place % len(_STYLES)])
                for place in range(len(self.lines))
            ]
            names = [_at(one.neutral_m, "neutral length ") or "measured" for one in self.lines]
            masses = self._masses_kg()
            marks = [_MARKERS[place % len(_MARKERS)] for place in range(len(masses))]
            handles += [Line2D([], [], color=GREY, marker=mark, linestyle="") for mark in marks]
            names += [f"{mass:g} kg" for mass in masses]
            figure.legend(handles, names, loc="outside lower center", ncols=6)
            return figure

    def _masses_kg(self) -> list[float]:
        return sorted({mass.mass_kg for one in self.conditions for mass in one.masses})

    def _draw_over_gain(self, axes: Axes, *, of_stiffness: bool) -> None:
        """Draw each length's line of one coefficient, and the points of each mass beside each other."""
        gains = [one.gain if of_stiffness else one.damping_gain for one in self.conditions]
        widest, masses = max(gains, default=1.0) or 1.0, self._masses_kg()
        beside = len(self.lines) * len(masses)
        for place, lines in enumerate(self.lines):
            line = lines.stiffness if of_stiffness else lines.damping
            colour = _colour(place)
            for gain, one in zip(gains, self.conditions, strict=True):
                for mass in one.masses if one.neutral_m == lines.neutral_m else ():
                    which = masses.index(mass.mass_kg)
                    step = place * len(masses) + which - 0.5 * (beside - 1)
                    found = mass.stiffness_n_m if of_stiffness else mass.damping_kg_s
                    axes.errorbar(
                        [gain + _ASIDE * widest * step],
                        [found.value],
                        yerr=[[found.value - found.ci[0]], [found.ci[1] - found.value]],
                        fmt=_MARKERS[which % len(_MARKERS)],
                        color=colour,
                        markerfacecolor=colour if mass.n >= MINIMUM_POINTS else "white",
                        markersize=3,
                        capsize=1.5,
                        zorder=3,
                    )
            if not isinstance(line, Undefined):
                ends = np.array(line.gains)
                axes.plot(
                    ends, line.slope * ends + line.offset, color=colour, ls=_STYLES[place % len(_STYLES)], linewidth=0.9
                )


def _colour(place: int) -> str:
    return _COLOURS[place % len(_COLOURS)]


def _length_text(neutral_m: float | None) -> str:
    return "" if neutral_m is None else f"{100.0 * neutral_m:.3g} cm"


def _at(neutral_m: float | None, before: str = " at ") -> str:
    return "" if neutral_m is None else f"{before}{_length_text(neutral_m)}"


def _texts(one: Coefficient) -> tuple[str, str]:
    value, low, high = (number_text(number, error=one.se) for number in (one.value, *one.ci))
    return value, f"{low} to {high}"


def _line_text(what: str, line: GainLine | Undefined, unit: str) -> str:
    if isinstance(line, Undefined):
        return f"{what}: no line, {line.reason}."
    slope, offset = (
        f"{number_text(value, error=error_of(ci))} {unit} ({interval_text(ci, line.fit.level)})"
        for value, ci in ((line.slope, line.slope_ci), (line.offset, line.offset_ci))
    )
    return f"{what} = {slope} x gain + {offset}; n = {line.fit.n} conditions."


def ask(asked: Asked) -> Found[Characterisation]:
    """Read the sheet with one trajectory a row, and the log of each, whose path counts from the sheet's folder."""
    with sheet_source("characterisation", asked) as source:
        sheet = read_trials(source.file(source.path))
        trials = []
        for place, name in enumerate(sheet.words["file"]):
            log = replace(source.file(source.path.parent / name), name=name)
            columns = {column: values[place] for column, values in sheet.values.items()}
            condition = Condition(columns.get("neutral"), columns["gain"], columns["damping_gain"])
            trials.append(Trial(columns["mass"], *read_oscillation(log), name, condition))
        return Found(characterisation(trials, level_of(source.options)), source.sources, source.files)


def characterisation(trials: Sequence[Trial], level: float = 0.95) -> Characterisation:
    """Fit each condition's stiffness and damping, and the lines of physical coefficients over gains.

    Conditions with fewer than 250 points are left out. Raises `InputRefused` where none has as many, where a velocity
    is three times or more off the rate of the position, and where a motion is none of a mass on a spring and a damper.
    """
    for one in trials:
        share = velocity_over_rate(one.time_s, one.displacement_m, one.velocity_m_s)
        if share is not None and not 1.0 / _OTHER_UNIT < share < _OTHER_UNIT:
            off = f"{number_text(1.0 / share)} times smaller" if share < 1.0 else f"{number_text(share)} times larger"
            raise InputRefused(
                f"the velocity in {one.file} is {off} than the rate of the position: a unit in its header is likely "
                "wrong."
            )
    by_condition = grouped(trials, [one.condition for one in trials])
    points = {condition: sum(one.time_s.size for one in several) for condition, several in by_condition.items()}
    if max(points.values(), default=0) < MINIMUM_POINTS:
        raise InputRefused(
            f"no condition has {MINIMUM_POINTS} points (thesis 4.2.6), the most is {max(points.values(), default=0)}: "
            "record more trajectories of each."
        )
    enough = [condition for condition, count in points.items() if count >= MINIMUM_POINTS]
    conditions = []
    for condition in sorted(enough, key=Condition.sort_key):
        with _refused_as_no_spring(by_condition[condition]):
            conditions.append(_measured(condition, by_condition[condition], level))
    few = [(condition, count) for condition, count in points.items() if condition not in enough]
    return Characterisation(
        conditions=tuple(conditions),
        lines=tuple(
            GainLines(
                length,
                _line([one.gain for one in several], [one.stiffness_n_m for one in several], level),
                _line([one.damping_gain for one in several], [one.damping_kg_s for one in several], level),
            )
            for length, several in grouped(conditions, [one.neutral_m for one in conditions]).items()
        ),
        too_few=tuple(TooFew(one.neutral_m, one.gain, one.damping_gain, count) for one, count in few),
        level=level,
    )


@contextmanager
def _refused_as_no_spring(several: Sequence[Trial]) -> Iterator[None]:
    """Refuse trajectories by their files, those too whose fit comes to no finite number."""
    names = ", ".join(one.file for one in several[:3])
    try:
        with np.errstate(all="ignore"):
            yield
    except InputRefused as error:
        raise InputRefused(f"{names}: {error}") from error
    except (ArithmeticError, ValueError) as error:  # LinAlgError is a ValueError
        raise InputRefused(
            f"{names}: no mass on a spring and a damper moves so; look at the units, and log from the release on."
        ) from error


def _measured(condition: Condition, several: Sequence[Trial], level: float) -> MeasuredGains:
    plane = plane_of(several)
    _at_zero, stiffness_n_m, damping_kg_s = plane.coefficients
    if stiffness_n_m <= 0.0:
        raise InputRefused(
            "the force does not rise with the compression: give positions that grow as it is compressed, and "
            "velocities that are their rate."
        )
    fit = fit_oscillations(several, plane, level)
    masses, left_out = _of_masses(several, fit, level)
    return MeasuredGains(
        neutral_m=condition.neutral_m,
        gain=condition.gain,
        damping_gain=condition.damping_gain,
        masses_kg=tuple(sorted({one.mass_kg for one in several})),
        trajectories=len(several),
        n=sum(one.time_s.size for one in several),
        stiffness_n_m=fit.stiffness,
        damping_kg_s=fit.damping,
        masses=masses,
        masses_left_out=left_out,
        residual_lag1=autocorrelation(np.concatenate([of_one[1] for of_one in fit.residuals])),
        widened=fit.widened,
        plane=Plane(stiffness_n_m, damping_kg_s),
        trials=tuple(several),
        fit=fit,
    )


def _of_masses(
    several: Sequence[Trial], pooled: OscillationFit, level: float
) -> tuple[tuple[OfMass, ...], dict[float, str]]:
    """Fit the trajectories of each mass alone, with the weights of all; also why masses have none."""
    found, left_out = [], dict[float, str]()
    for mass_kg in sorted({one.mass_kg for one in several}):
        same = [one for one in several if one.mass_kg == mass_kg]
        try:
            with _refused_as_no_spring(same):
                alone = pooled if len(same) == len(several) else fitted_with(same, pooled.values, pooled.spreads, level)
        except InputRefused as error:
            left_out[mass_kg] = str(error)
        else:
            found.append(OfMass(mass_kg, sum(one.time_s.size for one in same), alone.stiffness, alone.damping))
    return tuple(found), left_out


def _line(gains: Sequence[float], found: Sequence[Coefficient], level: float) -> GainLine | Undefined:
    if len(set(gains)) < FEWEST_GAINS:
        return Undefined(Reason.TOO_FEW_GAINS, n=len(set(gains)), least=FEWEST_GAINS)
    errors = [one.se for one in found]
    weighted = errors if min(errors) > 0.0 else None
    return fit_gain_line(gains, [one.value for one in found], standard_error=weighted, level=level)
