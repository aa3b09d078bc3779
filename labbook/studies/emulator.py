"""The emulator study (thesis 4.3): what two active dampings save at each extension gain, and what height they cost.

Comparisons are those of the report, by the days that control and treatment share. A gain at which no controller jumps
appreciably higher than at the gain before is beyond the motors' torque limit, and is left out with all above it: that
the rise is below a bound is shown by a one-sided test, which a mere lack of significance would not do.
"""

from __future__ import annotations

import itertools
import math
import statistics
import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, ClassVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from data_schema.errors import InputRefused, UsageError
from data_schema.outcomes import Outcome
from data_schema.queries.runs import refuse_empty_selection
from data_schema.reasons import Reason
from data_schema.rounding import level_text
from data_schema.vocabulary import FactorKind, Rule, Undefined
from labbook.analysis.comparison.deciding import contrast_of
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues, conditions_by_outcome
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import RunApexes
from labbook.analysis.outcomes.run_energy import joules_per_mah
from labbook.analysis.prediction.simulating import PlainPredictions, plain_predictions
from labbook.analysis.results import Results
from labbook.analysis.study_data import gather
from labbook.book.opening import opened
from labbook.config.model import Configuration
from labbook.studies.study import Asked, Found, book_sources, damping_factor, first_given, level_of
from reports.display import list_text
from reports.figures.style import BLUE, GREY, SKY, VERMILLION, light_grid, paper_figure
from reports.page.study import Study
from simulator.steady.published_results import published_numbers
from stats.days.contrasts import Effect, linear_contrast
from stats.days.decision import Bounded, Contrast, Estimate, bounds_tests, undefined_bounds
from stats.tails import t_quantile

CONSTANT, RATIO, SAME_PERCENT = 50.0, 6.0, 2.0
"""The active-damping gain that is the same at all extension gains, the extension gain over the one that is scaled with
it (thesis 4.3), and the rise of the apex below which it is not appreciable, in percent."""
SAME_POINTS = 3.0
"""Change of the saving from the lowest apex to the highest, in percentage points, below which it counts as none: what
reports call the same height, in percent."""
_COARSE = 0.03
"""Share of a jump's joules from which on the charger's resolution counts as coarse: at 4 % intervals cover .92."""
_JUMP_RULES = {"exclude_first_jumps": "2", "exclude_gap_jumps": "true"}
"""Keys of `[protocol]` that say which jumps are left out without asking, and what the thesis has for them."""
_DASH = "–"


class Controller(StrEnum):
    """What the extending leg does."""

    CE = "compression-extension"
    CONSTANT = "constant active damping"
    SCALED = "scaled active damping"

    @property
    def short(self) -> str:
        """Its name in a table."""
        return "CE" if self is Controller.CE else self.partition(" ")[0]

    @property
    def published(self) -> str:
        """What the thesis says that it saves."""
        if self is Controller.CONSTANT:
            return "most at the lowest gain, very little at the highest"
        return f"a consistent {100.0 * published_numbers()['emu.saving_scaled']:g} %"


@dataclass(frozen=True, slots=True)
class Mean:
    """The mean over runs of one condition with its standard error, None of one run."""

    value: float
    se: float | None
    n: int


@dataclass(frozen=True, slots=True)
class AtGain:
    """A controller at an extension gain; what it saves and loses in height against CE, in percent, None of CE itself.

    `apex_sd_m` is the standard deviation over all jumps of the condition; `simulated_j` and `simulated_apex_m` are what
    the simulator gives. Each is None where it is not known.
    """

    gain: float
    damping_gain: float
    controller: Controller
    joules: Mean
    apex_m: Mean
    saving_percent: Estimate | None
    apex_loss_percent: Estimate | None
    apex_sd_m: float | None
    simulated_j: float | None
    simulated_apex_m: float | None


@dataclass(frozen=True, slots=True)
class Rise:
    """By how much, in percent, the apex of a controller is higher at a gain than at the gain before.

    `no_rise`: it is shown to be no appreciably higher, as the end of its 90 % interval lies below the bound.
    """

    gain: float
    before: float
    controller: Controller
    change_percent: Bounded
    no_rise: bool

    def text(self) -> str:
        """Write it in a sentence."""
        name, change = self.controller.short, self.change_percent
        if isinstance(change.value, Undefined):
            return f"{name}: {change.value.reason}"
        if isinstance(change.ci, Undefined):
            return f"{name} {_fixed(change.value, 2, '+')} %, no interval: {change.ci.reason}"
        low, high = (_fixed(end, 2, "+") for end in change.ci)
        return f"{name} {_fixed(change.value, 2, '+')} %, 90 % CI {low} to {high}"


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

    def text(self) -> str:
        """Say that the saving rises or falls, that it does by less than the bound, or that neither is shown."""
        slope, change = self.slope, self.change
        if isinstance(slope.ci, Undefined) or isinstance(slope.value, Undefined):
            return ""
        low, high = slope.ci
        interval = f"{level_text(slope.level)} CI {_fixed(low, 2)} to {_fixed(high, 2)}"
        per_cm = f"{_fixed(slope.value, 2)} points a cm ({interval})"
        if not low <= 0.0 <= high:
            return f"it {'rises' if slope.value > 0.0 else 'falls'} with the apex: {per_cm}"
        if isinstance(change.ci, Undefined) or change.equivalent is not True:
            return f"a trend with the apex is neither shown nor excluded: {per_cm}"
        ends = " to ".join(_fixed(end, 1, "+") for end in change.ci)
        return (
            f"no trend with the apex: from the lowest to the highest it changes by less than {change.high:g} points "
            f"({level_text(1.0 - 2.0 * change.alpha)} CI {ends})"
        )


@dataclass(frozen=True, slots=True)
class Trend:
    """The line of savings over the apex under CE, in percentage points a cm; None where fewer than three gains tell."""

    controller: Controller
    line: SavingsTrend | None


@dataclass(frozen=True, slots=True)
class Jumps:
    """How many of the compared runs' jumps were looked at and count, and how many do not, by reason."""

    made: int
    counted: int
    excluded: Mapping[str, int]

    def text(self) -> str:
        """Say how many jumps count, and why the others do not."""
        out: Counter[str] = Counter()
        for reason, n in self.excluded.items():
            if reason == "touches a gap":
                reason = "with a dropped packet in flight"
            elif reason.startswith("among the first"):
                reason = f"{reason} of a run"
            elif not reason.startswith("rejected"):
                reason = "without an apex"
            out[reason] += n
        why = f"; left out: {list_text([f'{n} {reason}' for reason, n in out.most_common()])}" if out else ""
        return f"Apexes are those of {self.counted} of {self.made} jumps{why}."


@dataclass(frozen=True, slots=True)
class EmulatorStudy(Study):
    """Each controller at all `gains`, those `left_out` among them; `rises` from each gain to the next.

    At `coarse` gains the charger's last digit is so much of the joules that the same digits repeat. `jumps` are those
    that apexes are taken from; `not_simulated` is why there is nothing of the simulator, empty where there is.
    """

    title: ClassVar[str] = "What active damping saves at each gain"
    gains: tuple[AtGain, ...]
    rises: tuple[Rise, ...]
    left_out: tuple[float, ...]
    trends: tuple[Trend, ...]
    coarse: tuple[float, ...]
    jumps: Jumps
    level: float
    same_percent: float
    not_simulated: str

    @property
    def _controls(self) -> dict[float, AtGain]:
        """CE at each gain."""
        return {row.gain: row for row in self.gains if row.controller is Controller.CE}

    def analysed(self, controller: Controller) -> list[AtGain]:
        """Return a controller at the gains that are not left out."""
        return [row for row in self.gains if row.controller is controller and row.gain not in self.left_out]

    def sentences(self) -> list[str]:
        """Say what either active damping saves, what height it costs, and which gains are left out and why."""
        lines = [self._saves(trend) for trend in self.trends]
        run = {trend.controller for trend in self.trends}
        lines += [
            f"{str(one).capitalize()} was not run: no run has its active-damping gain (--constant, --ratio)."
            for one in (Controller.CONSTANT, Controller.SCALED)
            if one not in run
        ]
        if self.jumps.made:
            lines.append(self.jumps.text())
        lines += [self._lost(), self._left_out_text()]
        if self.not_simulated:
            lines.append(f"Not simulated: {self.not_simulated}")
        if self.coarse:
            lines.append(
                f"At {_gains(self.coarse)} the charger's last digit is more than 3 % of what the jumps took: the same "
                "digits repeat from day to day, and intervals of savings are too narrow. Let the robot jump longer "
                "there."
            )
        return lines

    def _saves(self, trend: Trend) -> str:
        rows = self.analysed(trend.controller)
        savings = {row.gain: row.saving_percent for row in rows if row.saving_percent is not None}
        values, name = _values(savings.values()), str(trend.controller).capitalize()
        if not values:
            return f"{name}: nothing is known of its savings."
        tested = [saving.ci for saving in savings.values() if not isinstance(saving.ci, Undefined)]
        shown = sum(low > 0.0 or high < 0.0 for low, high in tested)
        text = f"{name} saves {_ends_text(values)} % at gains {_listed(savings)} (thesis: {trend.controller.published})"
        text += f"; the saving is significant at {shown} of {len(tested)}." if tested else "."
        if without := [gain for gain, saving in savings.items() if isinstance(saving.ci, Undefined)]:
            text += f" At {_gains(without)} there is no interval: two runs of both on a day, or four shared days, tell."
        if trend.line is None or not (of_line := trend.line.text()):
            return text
        coarse = [gain for gain in savings if gain in self.coarse]
        but = f" (not {_listed(coarse)}, which the charger reads too coarsely)" if coarse else ""
        return f"{text} Over gains {list_text(trend.line.groups)}{but}, {of_line}."

    def _lost(self) -> str:
        """Say how many intervals of the lost apex lie below what the thesis found."""
        rows = [row for trend in self.trends for row in self.analysed(trend.controller)]
        losses = list({(row.gain, row.damping_gain): row for row in rows}.values())  # both may be one condition
        known = [row.apex_loss_percent for row in losses if row.apex_loss_percent is not None]
        values, ends = _values(known), [one.ci[1] for one in known if not isinstance(one.ci, Undefined)]
        if not values:
            return "No apex is compared with that under CE."
        below = sum(end < _published_loss() for end in ends)
        shown = f", which {below} of {len(ends)} intervals show" if ends else ""
        return (
            f"Active damping costs {_ends_text(values)} % of the apex height (thesis: less than "
            f"{_published_loss():g} %{shown})."
        )

    def _left_out_text(self) -> str:
        bound = f"{self.same_percent:g} %"
        if self.left_out:
            first = self.left_out[0]
            rises = [rise for rise in self.rises if rise.gain == first]
            return (
                f"Left out: {_gains(self.left_out)}, beyond the motors' torque limit. From {rises[0].before:g} to "
                f"{first:g} no controller's apex is {bound} or more higher "
                f"({list_text([rise.text() for rise in rises])})."
            )
        highest = max((rise.gain for rise in self.rises), default=None)
        last = [rise for rise in self.rises if rise.gain == highest]
        last = [rise for rise in last if not isinstance(rise.change_percent.ci, Undefined)]
        if not last:
            return "No gain is left out: no apex has an interval beside that at the gain before."
        return (
            f"No gain is left out: at each the apex may be {bound} or more above the one before; from "
            f"{last[0].before:g} to {last[0].gain:g}, {list_text([rise.text() for rise in last])}."
        )

    def table(self) -> list[Sequence[str]]:
        """Return a row for each gain and controller."""
        head = ("gain", "controller", "n", "joules (J)", "saving (%)", "apex (cm)", "apex lost (%)")
        return [
            head,
            *(
                [
                    f"{row.gain:g}" + (" (left out)" if row.gain in self.left_out else ""),
                    row.controller.short + ("" if row.controller is Controller.CE else f" ({row.damping_gain:g})"),
                    str(row.joules.n),
                    f"{row.joules.value:.2f}",
                    _estimate_text(row.saving_percent, 1),
                    f"{100.0 * row.apex_m.value:.2f}",
                    _estimate_text(row.apex_loss_percent, 2),
                ]
                for row in self.gains
            ),
        ]

    def beside(self) -> list[tuple[str, ...]]:
        """Return what was measured beside what the simulator gives and what the thesis says (4.3, 4.4)."""
        found, published = list[tuple[str, ...]](), published_numbers()
        for gain, apex in ((100.0, "emu.apex_low"), (400.0, "emu.apex_high")):
            if (row := self._controls.get(gain)) is not None:
                simulated = _DASH if row.simulated_apex_m is None else _fixed(100.0 * row.simulated_apex_m, 2)
                cells = _fixed(100.0 * row.apex_m.value, 2), simulated, _fixed(100.0 * published[apex], 1)
                found.append((f"apex under CE at gain {gain:g} (cm)", *cells))
        retained = [row for row in self.gains if row.gain not in self.left_out]
        if sds := [1e3 * row.apex_sd_m for row in retained if row.apex_sd_m is not None]:
            below = f"< {1e3 * published['emu.apex_sd']:g}"
            found.append(("largest SD of the apexes of a condition (mm)", _fixed(max(sds), 1), _DASH, below))
        lost, simulated_lost = list[float](), list[float]()
        for trend in self.trends:
            rows = self.analysed(trend.controller)
            simulated_j = self._simulated_changes(rows, lambda row: row.simulated_j)
            measured = _ends_text(_values(row.saving_percent for row in rows))
            name = f"saving, {trend.controller} (%)"
            found.append((name, measured, _ends_text(simulated_j), trend.controller.published))
            lost += _values(row.apex_loss_percent for row in rows)
            simulated_lost += self._simulated_changes(rows, lambda row: row.simulated_apex_m)
        found.append(("apex lost (%)", _ends_text(lost), _ends_text(simulated_lost), f"< {_published_loss():g}"))
        return found

    def _simulated_changes(self, rows: Sequence[AtGain], of: Callable[[AtGain], float | None]) -> list[float]:
        """Return by how many percent less a controller has of something than CE, in the simulation."""
        pairs = [(of(row), of(self._controls[row.gain])) for row in rows]  # each gain has a control
        return [100.0 * (1.0 - value / of_ce) for value, of_ce in pairs if value is not None and of_ce]

    def caption(self) -> str:
        """Say what is drawn."""
        return (
            "Joules and apexes by extension gain, means and standard errors over runs; savings over the apex under CE, "
            "and their line; apex lost. A mark without a bar has none, or one smaller than itself; controllers stand "
            "apart."
        )

    def draw(self) -> Figure:
        """Draw joules, apexes, savings and lost height (thesis fig. 4.6, 4.7).

        Gains that are left out have a grey ground, and neither saving nor lost height.
        """
        with paper_figure(4.2) as figure:
            (energy, savings), (height, lost) = figure.subplots(2, 2)
            ce_cm = {gain: 100.0 * row.apex_m.value for gain, row in self._controls.items()}
            looks = zip(Controller, (("o", VERMILLION), ("s", SKY), ("^", BLUE)), (-1, 0, 1), strict=True)
            for controller, (marker, color), aside in looks:
                rows, retained = [row for row in self.gains if row.controller is controller], self.analysed(controller)
                look = {"fmt": marker, "color": color, "markersize": 3, "capsize": 2.5, "linewidth": 0.8}
                gains = [row.gain + 12.0 * aside for row in rows]
                for axes, means, unit in (
                    (energy, [row.joules for row in rows], 1.0),
                    (height, [row.apex_m for row in rows], 100.0),
                ):
                    errors = [np.nan if one.se is None else unit * one.se for one in means]
                    axes.errorbar(gains, [unit * one.value for one in means], yerr=errors, **look)
                _draw_estimates(
                    savings, {ce_cm[row.gain] + 0.4 * (aside - 0.5): row.saving_percent for row in retained}, look
                )
                _draw_estimates(lost, {row.gain + 12.0 * aside: row.apex_loss_percent for row in retained}, look)
                line = next((one.line for one in self.trends if one.controller is controller), None)
                if line is not None and not isinstance(line.slope.value, Undefined):
                    across = [ce_cm[float(gain)] for gain in line.groups]
                    ends = np.array([min(across), max(across)])
                    savings.plot(
                        ends, line.middle[1] + line.slope.value * (ends - line.middle[0]), color=color, linewidth=0.9
                    )
                label = controller.short if controller is Controller.CE else str(controller)
                energy.plot([], [], marker, color=color, label=label)
            for axes in (energy, height, lost):
                for place, gain in enumerate(self.left_out):
                    label = "left out" if axes is energy and place == 0 else ""
                    axes.axvspan(gain - 40, gain + 40, color=GREY, alpha=0.2, linewidth=0, label=label)
                axes.set_xlabel("Extension gain")
            if any(one.line is not None for one in self.trends):
                energy.plot([], [], color=GREY, linewidth=0.9, label="line of savings")
            savings.axhline(0.0, color=GREY, linewidth=0.8)
            lost.axhline(0.0, color=GREY, linewidth=0.8)
            energy.set_ylabel("Energy of a jump (J)")
            height.set_ylabel("Apex height (cm)")
            savings.set_xlabel("Apex under CE (cm)")
            savings.set_ylabel(f"Saving (%), {level_text(self.level)} CI")
            lost.set_ylabel(f"Apex lost (%), {level_text(self.level)} CI")
            for axes in figure.axes:
                light_grid(axes)
            figure.legend(
                loc="outside lower center", ncols=5, title="Joules and apexes: means and standard errors over runs"
            )
            return figure


def _draw_estimates(axes: Axes, found: Mapping[float, Estimate | None], look: Mapping[str, Any]) -> None:
    """Draw the estimates that there are over their places, with their intervals."""
    known = [(x, one.value, one.ci) for x, one in found.items() if one is not None and isinstance(one.value, float)]
    ends = [(np.nan, np.nan) if isinstance(ci, Undefined) else (y - ci[0], ci[1] - y) for _x, y, ci in known]
    bars = np.array(ends).reshape(-1, 2).T
    axes.errorbar([x for x, _y, _ci in known], [y for _x, y, _ci in known], yerr=bars, **look)


def _published_loss() -> float:
    return 100.0 * published_numbers()["emu.apex_loss"]


def _values(found: Iterable[Estimate | None]) -> list[float]:
    return [one.value for one in found if one is not None and isinstance(one.value, float)]


def _ends_text(values: Sequence[float]) -> str:
    return f"{_fixed(min(values), 1)} to {_fixed(max(values), 1)}" if values else _DASH


def _fixed(value: float, places: int, sign: str = "") -> str:
    return f"{value:{sign}.{places}f}".replace("-", "\N{MINUS SIGN}")


def _estimate_text(found: Estimate | None, places: int) -> str:
    if found is None or isinstance(found.value, Undefined):
        return _DASH
    text = _fixed(found.value, places)
    return (
        text if isinstance(found.ci, Undefined) else f"{text} ({' to '.join(_fixed(end, places) for end in found.ci)})"
    )


def _listed(gains: Iterable[float]) -> str:
    return list_text([f"{gain:g}" for gain in gains])


def _gains(gains: Sequence[float]) -> str:
    return ("gain " if len(gains) == 1 else "gains ") + _listed(gains)


def ask(asked: Asked) -> Found[EmulatorStudy]:
    """Open the book and compare the controllers at each extension gain.

    Raises `UsageError` for a book whose factors are not an extension gain and an active-damping gain with a control,
    and for options that are none; `InputRefused` as `emulator_study` does, and for a book whose `[protocol]` does not
    say which jumps are left out.
    """
    with opened(asked.book) as book, book.reading() as connection:
        configuration, options = book.configuration, asked.settled("emulator", book.configuration)
        level = level_of(options)
        ratio, same_percent = first_given(options.ratio, RATIO), first_given(options.same_percent, SAME_PERCENT)
        if ratio <= 0.0 or not 0.0 < same_percent < 100.0:
            raise UsageError("--ratio is above 0 and --same between 0 and 100, in percent: give such numbers.")
        gain, damping = _factors(configuration)
        given = tomllib.loads(configuration.text).get("protocol", {})
        if missing := [f"{key} = {usual}" for key, usual in _JUMP_RULES.items() if key not in given]:
            raise InputRefused(
                "labbook.toml does not say which jumps the study leaves out: write under [protocol] "
                f"{' and '.join(missing)} (thesis 4.3.3; 0 and false leave none out)."
            )
        asked.step("joules and apex heights")
        refuse_empty_selection(connection, options.where)
        evidence = gather(connection, configuration, options.where)
        conditions = conditions_by_outcome(
            Results(),
            Detections(connection, book.store, asked.step),
            evidence,
            (Outcome.JOULES, Outcome.APEX),
        )
        simulated = plain_predictions(connection, evidence, asked.step)
        sources = book_sources(connection, configuration, options.where or "all")
    study = configuration.study
    steps_mah = [charge.resolution_mah for run in evidence.runs for charge in evidence.charges.get(run.uid, ())]
    found = emulator_study(
        conditions,
        gain,
        damping,
        constant=first_given(options.constant, CONSTANT),
        ratio=ratio,
        same_percent=same_percent,
        resolution_j=max(steps_mah, default=0.0) * joules_per_mah(study.reference_voltage_v, study.jumps_nominal),
        level=level,
        simulated=simulated,
    )
    return Found(found, sources)


def _factors(configuration: Configuration) -> tuple[str, str]:
    """Return the names of the factors of the extension gain and of the active-damping gain."""
    damping = damping_factor(configuration, "0, 17, 33, 50, 67, 83")
    others = [name for name, factor in configuration.factors.items() if factor.kind is FactorKind.NUMBER]
    others.remove(damping)
    if len(others) != 1:
        raise UsageError(
            f"labbook.toml has {len(others)} further factors of kind number, and the study needs one, the extension "
            'gain: write [factors.k_gain] with kind = "number" and levels = [100, 200, 300, 400, 500].'
        )
    return others[0], damping


_Place = tuple[float, float]
"""Extension gain and active-damping gain."""
_Conditions = Mapping[_Place, ConditionValues]


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
    simulated: PlainPredictions | None = None,
) -> EmulatorStudy:
    """Compare the controllers at each gain.

    Parameters
    ----------
    conditions : of joules and apexes
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
    simulated = simulated or PlainPredictions({})
    joules, apexes = (_by_place(conditions[outcome], gain, damping) for outcome in (Outcome.JOULES, Outcome.APEX))
    both = {place for place in joules if place in apexes}
    gains = sorted({at for at, _damped in both if (at, 0.0) in both})
    if len(gains) < 2:
        raise InputRefused(
            f"{len(gains)} of the {gain} have runs of the control with joules and apexes, and the study needs two at "
            "least: run the control at each gain."
        )

    def damped_of(controller: Controller, at: float) -> float | None:
        """Return the active-damping gain of a controller at a gain, None where it was not run."""
        wanted = {Controller.CE: 0.0, Controller.CONSTANT: constant, Controller.SCALED: at / ratio}[controller]
        run = [damped for other, damped in both if other == at and abs(damped - wanted) <= 0.5]
        return min(run, key=lambda damped: abs(damped - wanted), default=None)

    placed = {
        controller: {at: (at, damped) for at in gains if (damped := damped_of(controller, at)) is not None}
        for controller in Controller
    }
    if not placed[Controller.CONSTANT] and not placed[Controller.SCALED]:
        raise InputRefused(
            f"no run has the {damping} {constant:g}, or a {ratio:g}th of its {gain}: say with --constant and --ratio "
            "which active damping was run."
        )

    def at_gain(controller: Controller, place: _Place) -> AtGain:
        control, key = (place[0], 0.0), joules[place].key
        is_control = controller is Controller.CE
        return AtGain(
            *place,
            controller,
            _mean(joules[place]),
            _mean(apexes[place]),
            None if is_control else _contrast(joules, control, place).savings(level),
            None if is_control else _contrast(apexes, control, place).savings(level),
            _sd(apexes[place]),
            simulated.value(key, Outcome.JOULES),
            simulated.value(key, Outcome.APEX),
        )

    def rise(controller: Controller, before: _Place, at: _Place) -> Rise:
        change = _contrast(apexes, before, at).equivalence(-same_percent, same_percent)
        no_rise = not isinstance(change.ci, Undefined) and change.ci[1] < same_percent
        return Rise(at[0], before[0], controller, change, no_rise)

    rows = [
        at_gain(controller, placed[controller][at])
        for at in gains
        for controller in Controller
        if at in placed[controller]
    ]
    rises = [
        rise(controller, places[before], places[at])
        for controller, places in placed.items()
        for before, at in itertools.pairwise(gains)
        if at in places and before in places
    ]
    of_rises = {at: [one.no_rise for one in rises if one.gain == at] for at in gains}
    limit = next((at for at in gains if of_rises[at] and all(of_rises[at])), math.inf)
    left_out = tuple(at for at in gains if at >= limit)
    of_ce = [row for row in rows if row.controller is Controller.CE]
    coarse = tuple(row.gain for row in of_ce if resolution_j > _COARSE * row.joules.value)
    apex_cm = {f"{row.gain:g}": 100.0 * row.apex_m.value for row in of_ce}
    trends = []
    for controller in (Controller.CONSTANT, Controller.SCALED):
        contrasts = {
            f"{at:g}": _contrast(joules, (at, 0.0), place)
            for at, place in placed[controller].items()
            if at not in left_out and at not in coarse
        }
        if placed[controller]:
            trends.append(Trend(controller, savings_trend(contrasts, apex_cm, SAME_POINTS, level)))
    return EmulatorStudy(
        gains=tuple(rows),
        rises=tuple(rises),
        left_out=left_out,
        trends=tuple(trends),
        coarse=coarse,
        jumps=_jumps([apexes[place] for place in sorted({(row.gain, row.damping_gain) for row in rows})]),
        level=level,
        same_percent=same_percent,
        not_simulated=simulated.why_not,
    )


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


def _contrast(conditions: _Conditions, control: _Place, treated: _Place) -> Contrast:
    return contrast_of(Pair("", "", {}, "", (conditions[control],), (conditions[treated],)))


def _mean(one: ConditionValues) -> Mean:
    values = np.array(one.values)
    se = float(values.std(ddof=1) / np.sqrt(values.size)) if values.size > 1 else None
    return Mean(float(values.mean()), se, values.size)


def _sd(apexes: ConditionValues) -> float | None:
    of_runs = [run.result for run in apexes.runs]
    heights_m = [height_m for one in of_runs if isinstance(one, RunApexes) for height_m in one.heights_m]
    return float(np.std(heights_m, ddof=1)) if len(heights_m) > 1 else None


def _jumps(conditions: Sequence[ConditionValues]) -> Jumps:
    of_runs = [run.result for one in conditions for run in one.runs if isinstance(run.result, RunApexes)]
    excluded: Counter[str] = Counter()
    for run in of_runs:
        excluded.update(run.excluded)
    counted = sum(len(run.heights_m) for run in of_runs)
    return Jumps(counted + excluded.total(), counted, dict(excluded))


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

    change, bounds = trend(reach, 1.0 - 2.0 * alpha), (-bound, bound)
    if isinstance(change.ci, Undefined) or not isinstance(change.value, float) or not isinstance(change.df, float):
        why = change.ci if isinstance(change.ci, Undefined) else Undefined(Reason.GROUPS_WITHOUT_SCATTER)
        within = undefined_bounds(why, bounds, alpha, change.value)
    else:
        error = (change.ci[1] - change.value) / t_quantile(change.level, change.df)
        tests = (change.value + bound) / error, (change.value - bound) / error
        within = bounds_tests(change.value, bounds, change.ci, alpha, tests, change.df)
    saved = statistics.fmean(100.0 * (1.0 - one.ratio) for one in claimed.values())
    return SavingsTrend(tuple(claimed), trend(1.0, level), within, (middle, saved))
