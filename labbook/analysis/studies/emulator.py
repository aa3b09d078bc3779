"""The emulator study (thesis 4.3): what two active dampings save at each extension gain, and what height they cost.

Comparisons are those of the report, by the days that control and treatment share. A gain at which no controller jumps
appreciably higher than at the gain before is beyond the motors' torque limit, and is left out with all above it: that
the rise is below a bound is shown by a one-sided test, which a mere lack of significance would not do.
"""

from __future__ import annotations

import itertools
import math
import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from data_schema.errors import InputRefused
from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.deciding import contrast_of
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.outcomes.run_apexes import RunApexes
from labbook.analysis.prediction.simulating import PlainPredictions
from stats.days.contrasts import Effect, linear_contrast
from stats.days.decision import Bounded, Contrast, Estimate, Rule, bounds_tests, undefined_bounds
from stats.exact.tails import t_quantile

_NOTHING = PlainPredictions({})
SAME_POINTS = 3.0
"""Change of the saving from the lowest apex to the highest, in percentage points, below which it counts as none: what
reports call the same height, in percent."""
_COARSE = 0.03
"""Share of a jump's joules from which on the charger's resolution counts as coarse: at 4 % intervals cover .92."""


class Controller(StrEnum):
    """What the extending leg does."""

    CE = "compression-extension"
    CONSTANT = "constant active damping"
    SCALED = "scaled active damping"


@dataclass(frozen=True, slots=True)
class Mean:
    """The mean over runs of one condition with its standard error, None of one run."""

    value: float
    se: float | None
    n: int


@dataclass(frozen=True, slots=True)
class AtGain:
    """A controller at an extension gain; `saving` and `apex_loss` against CE, in percent, None of CE itself.

    `apex_sd_m` is the standard deviation over all jumps of the condition; `simulated_j` and `simulated_apex_m` are what
    the simulator gives. Each is None where it is not known.
    """

    gain: float
    damping_gain: float
    controller: Controller
    joules: Mean
    apex_m: Mean
    saving: Estimate | None
    apex_loss: Estimate | None
    apex_sd_m: float | None
    simulated_j: float | None
    simulated_apex_m: float | None


@dataclass(frozen=True, slots=True)
class Rise:
    """By how much, in percent, the apex of a controller is higher at a gain than at the gain before."""

    gain: float
    before: float
    controller: Controller
    change: Bounded


@dataclass(frozen=True, slots=True)
class SavingsTrend:
    """The least-squares line through the savings of groups over a quantity x, each group counted once.

    `slope` is in percentage points a unit of x; `change` is that of the line from the least x to the largest, in
    percentage points, with two one-sided tests that it lies within bounds. `middle` are the means of x and of the
    savings, which the line goes through.
    """

    groups: tuple[str, ...]
    slope: Estimate
    change: Bounded
    middle: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Trend:
    """The line of savings over the apex under CE, in percentage points a cm; None where fewer than three gains tell."""

    controller: Controller
    line: SavingsTrend | None


@dataclass(frozen=True, slots=True)
class Jumps:
    """How many of the compared runs' jumps count, and of the others how many do not, by reason."""

    counted: int
    excluded: Mapping[str, int]

    @property
    def made(self) -> int:
        """All that were looked at."""
        return self.counted + sum(self.excluded.values())


@dataclass(frozen=True, slots=True)
class EmulatorStudy:
    """What came of it: `rows` of all gains, those `left_out` among them; `rises` from each gain to the next.

    At `coarse` gains the charger's last digit is so much of the joules that the same digits repeat. `jumps` are those
    that apexes are taken from; `not_simulated` is why there is nothing of the simulator, empty where there is.
    """

    rows: tuple[AtGain, ...]
    rises: tuple[Rise, ...]
    left_out: tuple[float, ...]
    trends: tuple[Trend, ...]
    coarse: tuple[float, ...]
    jumps: Jumps
    level: float
    same_percent: float
    not_simulated: str

    def control(self, gain: float) -> AtGain | None:
        """Return CE at a gain."""
        return next((row for row in self.rows if (row.gain, row.controller) == (gain, Controller.CE)), None)

    def analysed(self, controller: Controller) -> list[AtGain]:
        """Return a controller at the gains that are not left out."""
        return [row for row in self.rows if row.controller is controller and row.gain not in self.left_out]


def emulator_study(
    conditions: Mapping[Outcome, Sequence[ConditionValues]],
    gain: str,
    damping: str,
    *,
    constant: float,
    ratio: float,
    same_percent: float,
    resolution_j: float,
    level: float,
    simulated: PlainPredictions = _NOTHING,
) -> EmulatorStudy:
    """Compare the controllers at each gain.

    Parameters
    ----------
    conditions : of joules and apexes, as `condition_values` gives them
    gain, damping : names of the factors of the extension gain and the active-damping gain, the latter with a control
    constant : active-damping gain that is the same at all gains
    ratio : extension gain over the active-damping gain that is scaled with it; whole gains may be rounded
    same_percent : a rise of the apex below it is not appreciable
    resolution_j : joules a jump that correspond to the charger's last digit
    simulated : what `plain_predictions` gives

    Raises
    ------
    InputRefused where CE was not run at two gains, or neither active damping beside it.
    """
    found = {outcome: _by_place(conditions[outcome], gain, damping) for outcome in (Outcome.JOULES, Outcome.APEX)}
    both = {place for place in found[Outcome.JOULES] if place in found[Outcome.APEX]}
    gains = sorted({at for at, _damped in both if (at, 0.0) in both})
    if len(gains) < 2:
        raise InputRefused(
            f"{len(gains)} of the {gain} have runs of the control with joules and apexes, and the study needs two at "
            "least: run the control at each gain."
        )
    placed = {
        controller: {at: damped for at in gains for damped in _dampings(both, at, controller, constant, ratio)}
        for controller in Controller
    }
    if not placed[Controller.CONSTANT] and not placed[Controller.SCALED]:
        raise InputRefused(
            f"no run has the {damping} {constant:g}, or a {ratio:g}th of its {gain}: say with --constant and --ratio "
            "which active damping was run."
        )
    rows = tuple(
        _at_gain(found, at, placed[controller][at], controller, level, simulated)
        for at in gains
        for controller in Controller
        if at in placed[controller]
    )
    rises = tuple(
        Rise(at, before, controller, _rise(found, (at, places[at]), (before, places[before]), same_percent))
        for controller, places in placed.items()
        for before, at in itertools.pairwise(gains)
        if at in places and before in places
    )
    left_out = _beyond_limit(rises, gains, same_percent)
    of_ce = [row for row in rows if row.controller is Controller.CE]
    coarse = tuple(row.gain for row in of_ce if resolution_j > _COARSE * row.joules.value)
    trends = tuple(
        Trend(controller, _line(found[Outcome.JOULES], controller, rows, {*left_out, *coarse}, level))
        for controller in (Controller.CONSTANT, Controller.SCALED)
        if placed[controller]
    )
    apexes = found[Outcome.APEX]
    jumps = _jumps([apexes[place] for place in sorted({(row.gain, row.damping_gain) for row in rows})])
    return EmulatorStudy(rows, rises, left_out, trends, coarse, jumps, level, same_percent, simulated.why_not)


_Place = tuple[float, float]
_Found = Mapping[Outcome, Mapping[_Place, ConditionValues]]


def _by_place(conditions: Sequence[ConditionValues], gain: str, damping: str) -> dict[_Place, ConditionValues]:
    found: dict[_Place, ConditionValues] = {}
    for one in conditions:
        place = float(one.levels[gain]), float(one.levels[damping])
        if place in found:
            raise InputRefused(
                f"runs at {gain} {place[0]:g} and {damping} {place[1]:g} differ in another factor: choose one of its "
                "levels with --where."
            )
        found[place] = one
    return found


def _dampings(places: set[_Place], at: float, controller: Controller, constant: float, ratio: float) -> list[float]:
    """Return the active-damping gain of a controller at a gain, none where it was not run."""
    wanted = {Controller.CE: 0.0, Controller.CONSTANT: constant, Controller.SCALED: at / ratio}[controller]
    run = [damped for other, damped in places if other == at and abs(damped - wanted) <= 0.5]
    return sorted(run, key=lambda damped: abs(damped - wanted))[:1]


def _at_gain(
    found: _Found,
    at: float,
    damped: float,
    controller: Controller,
    level: float,
    simulated: PlainPredictions,
) -> AtGain:
    joules, apexes = (found[outcome][at, damped] for outcome in (Outcome.JOULES, Outcome.APEX))
    control = {outcome: found[outcome][at, 0.0] for outcome in (Outcome.JOULES, Outcome.APEX)}
    is_control = controller is Controller.CE
    return AtGain(
        at,
        damped,
        controller,
        _mean(joules),
        _mean(apexes),
        None if is_control else contrast_of(_pair(control[Outcome.JOULES], joules)).savings(level),
        None if is_control else contrast_of(_pair(control[Outcome.APEX], apexes)).savings(level),
        _sd(apexes),
        simulated.value(joules.key, Outcome.JOULES),
        simulated.value(joules.key, Outcome.APEX),
    )


def _sd(apexes: ConditionValues) -> float | None:
    heights_m = [
        height_m for run in apexes.runs if isinstance(run.result, RunApexes) for height_m in run.result.heights_m
    ]
    return float(np.std(heights_m, ddof=1)) if len(heights_m) > 1 else None


def _jumps(conditions: Sequence[ConditionValues]) -> Jumps:
    of_runs = [run.result for one in conditions for run in one.runs if isinstance(run.result, RunApexes)]
    excluded: Counter[str] = Counter()
    for run in of_runs:
        excluded.update(run.excluded)
    return Jumps(sum(len(run.heights_m) for run in of_runs), dict(excluded))


def _mean(one: ConditionValues) -> Mean:
    values = np.array(one.values)
    se = float(values.std(ddof=1) / np.sqrt(values.size)) if values.size > 1 else None
    return Mean(float(values.mean()), se, values.size)


def _pair(control: ConditionValues, treated: ConditionValues) -> Pair:
    return Pair("", "", {}, "", (control,), (treated,))


def _rise(found: _Found, at: _Place, before: _Place, same_percent: float) -> Bounded:
    apexes = found[Outcome.APEX]
    return contrast_of(_pair(apexes[before], apexes[at])).equivalence(-same_percent, same_percent)


def no_rise(rise: Rise, same_percent: float) -> bool:
    """Whether the apex is shown to be no appreciably higher: the end of its 90 % interval lies below the bound."""
    return not isinstance(rise.change.ci, Undefined) and rise.change.ci[1] < same_percent


def _beyond_limit(rises: Sequence[Rise], gains: Sequence[float], same_percent: float) -> tuple[float, ...]:
    """Return the gains from the first on at which no controller jumps appreciably higher than before."""
    for at in gains[1:]:
        of_gain = [rise for rise in rises if rise.gain == at]
        if of_gain and all(no_rise(rise, same_percent) for rise in of_gain):
            return tuple(gain for gain in gains if gain >= at)
    return ()


def _line(
    joules: Mapping[_Place, ConditionValues],
    controller: Controller,
    rows: Sequence[AtGain],
    without: set[float],
    level: float,
) -> SavingsTrend | None:
    """Fit the savings over the apex under CE in cm; gains that the charger reads too coarsely are not in it."""
    apex_cm = {f"{row.gain:g}": 100.0 * row.apex_m.value for row in rows if row.controller is Controller.CE}
    contrasts = {
        f"{row.gain:g}": contrast_of(_pair(joules[row.gain, 0.0], joules[row.gain, row.damping_gain]))
        for row in rows
        if row.controller is controller and row.gain not in without
    }
    return savings_trend(contrasts, apex_cm, SAME_POINTS, level)


def savings_trend(
    contrasts: Mapping[str, Contrast], x: Mapping[str, float], bound: float, level: float = 0.95
) -> SavingsTrend | None:
    """Fit the trend of savings over `x`, by group; None for fewer than three groups with a claim, or a single x.

    `bound` is the change, in percentage points, that would still count as none; its one-sided tests have the level
    1 - `level`.
    """
    claimed = {name: one for name, one in contrasts.items() if one.rule is not Rule.NONE}
    middle = statistics.fmean(x[name] for name in claimed) if claimed else 0.0
    away = {name: x[name] - middle for name in claimed}
    squares = math.fsum(each * each for each in away.values())
    if len(claimed) < 3 or squares == 0.0:
        return None
    reach, alpha = max(away.values()) - min(away.values()), 1.0 - level
    runs = {f"{name} control": one.runs.control for name, one in claimed.items()}
    runs |= {f"{name} treated": one.runs.treated for name, one in claimed.items()}

    def trend(unit: float, level: float) -> Estimate:
        effects = [Effect(unit * each / squares, f"{name} treated", f"{name} control") for name, each in away.items()]
        return linear_contrast(runs, effects, percent=True, level=level).estimate

    saved = statistics.fmean(100.0 * (1.0 - one.ratio) for one in claimed.values())
    return SavingsTrend(
        tuple(claimed), trend(1.0, level), _within(trend(reach, 1.0 - 2.0 * alpha), bound, alpha), (middle, saved)
    )


def _within(change: Estimate, bound: float, alpha: float) -> Bounded:
    """Test that a change lies within bounds on both sides of 0; its interval has the level 1 - 2 alpha."""
    bounds = (-bound, bound)
    if isinstance(change.ci, Undefined) or isinstance(change.value, Undefined) or isinstance(change.df, Undefined):
        why = change.ci if isinstance(change.ci, Undefined) else Undefined(Reason.GROUPS_WITHOUT_SCATTER)
        return undefined_bounds(why, bounds, alpha, change.value)
    error = (change.ci[1] - change.value) / t_quantile(change.level, change.df)
    tests = ((change.value + bound) / error, (change.value - bound) / error)
    return bounds_tests(change.value, bounds, change.ci, alpha, tests, change.df)
