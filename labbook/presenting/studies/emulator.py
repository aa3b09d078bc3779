"""The emulator study: as sentences, as a table, as data, and as what the figure draws."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from itertools import chain
from typing import Any

import numpy as np

from data_schema.rounding import level_text
from data_schema.vocabulary import Undefined
from labbook.analysis.studies.emulator import (
    AtGain,
    Controller,
    EmulatorStudy,
    Jumps,
    Rise,
    SavingsTrend,
    Trend,
    no_rise,
)
from labbook.presenting.numbers import value_data
from reports.display import BESIDE, list_text
from reports.figures.emulator import ControllerPoints
from simulator.steady.published_results import published_numbers
from stats.days.decision import Bounded, Estimate

HEAD = ("gain", "controller", "n", "joules (J)", "saving (%)", "apex (cm)", "apex lost (%)")
_SHORT = {Controller.CE: "CE", Controller.CONSTANT: "constant", Controller.SCALED: "scaled"}


def _published_saving(controller: Controller) -> str:
    if controller is Controller.CONSTANT:
        return "most at the lowest gain, very little at the highest"
    return f"a consistent {100.0 * published_numbers()['emu.saving_scaled']:g} %"


def sentences(study: EmulatorStudy) -> list[str]:
    """Say what either active damping saves, what height it costs, and which gains are left out and why."""
    lines = [_saves(study, trend) for trend in study.trends]
    run = {trend.controller for trend in study.trends}
    lines += [
        f"{str(one).capitalize()} was not run: no run has its active-damping gain (--constant, --ratio)."
        for one in (Controller.CONSTANT, Controller.SCALED)
        if one not in run
    ]
    if study.jumps.made:
        lines.append(_jumps_text(study.jumps))
    losses = {(row.gain, row.damping_gain): row for trend in study.trends for row in study.analysed(trend.controller)}
    lines.append(_lost(list(losses.values())))  # constant and scaled may be one condition
    lines.append(_left_out(study))
    if study.not_simulated:
        lines.append(f"Not simulated: {study.not_simulated}")
    if study.coarse:
        lines.append(
            f"At {_gains(study.coarse)} the charger's last digit is more than 3 % of what the jumps took: the same "
            "digits repeat from day to day, and intervals of savings are too narrow. Let the robot jump longer there."
        )
    return lines


def comparison_rows(study: EmulatorStudy) -> list[tuple[str, ...]]:
    """Return what was measured beside what the simulator gives and what the thesis says (4.3, 4.4)."""
    found, published = [], published_numbers()
    for gain, apex in ((100.0, "emu.apex_low"), (400.0, "emu.apex_high")):
        if (row := study.control(gain)) is not None:
            cells = [_cm(row.apex_m.value), _cm(row.simulated_apex_m), _fixed(100.0 * published[apex], 1)]
            found.append((f"apex under CE at gain {gain:g} (cm)", *cells))
    retained = [row for row in study.rows if row.gain not in study.left_out]
    if sds := [1e3 * row.apex_sd_m for row in retained if row.apex_sd_m is not None]:
        below = f"< {1e3 * published['emu.apex_sd']:g}"
        found.append(("largest SD of the apexes of a condition (mm)", _fixed(max(sds), 1), "–", below))
    for trend in study.trends:
        savings = [row.saving for row in study.analysed(trend.controller) if row.saving is not None]
        of_joules = _simulated_changes(study, trend.controller, lambda row: row.simulated_j)
        cells = [_ends_text(_values(savings)), _ends_text(of_joules), _published_saving(trend.controller)]
        found.append((f"saving, {trend.controller} (%)", *cells))
    rows = [row for trend in study.trends for row in study.analysed(trend.controller)]
    lost = [row.apex_loss for row in rows if row.apex_loss is not None]
    of_apex = [_simulated_changes(study, trend.controller, lambda row: row.simulated_apex_m) for trend in study.trends]
    found.append(
        ("apex lost (%)", _ends_text(_values(lost)), _ends_text([*chain(*of_apex)]), f"< {_published_loss():g}")
    )
    return found


def _values(found: Iterable[Estimate]) -> list[float]:
    return [one.value for one in found if isinstance(one.value, float)]


def _simulated_changes(
    study: EmulatorStudy, controller: Controller, of: Callable[[AtGain], float | None]
) -> list[float]:
    """Return by how many percent less a controller has of something than CE, in the simulation."""
    pairs = [(of(row), study.control(row.gain)) for row in study.analysed(controller)]
    known = [(value, of(control)) for value, control in pairs if control is not None]
    return [100.0 * (1.0 - value / of_ce) for value, of_ce in known if value is not None and of_ce]


def _ends_text(values: Sequence[float]) -> str:
    return f"{_fixed(min(values), 1)} to {_fixed(max(values), 1)}" if values else "–"


def _cm(metres: float | None) -> str:
    return "–" if metres is None else _fixed(100.0 * metres, 2)


def _jumps_text(jumps: Jumps) -> str:
    """Say how many jumps count, and why the others do not."""
    out: Counter[str] = Counter()
    for reason, n in jumps.excluded.items():
        out[_excluded_text(reason)] += n
    why = f"; left out: {list_text([f'{n} {reason}' for reason, n in out.most_common()])}" if out else ""
    return f"Apexes are those of {jumps.counted} of {jumps.made} jumps{why}."


def _excluded_text(reason: str) -> str:
    if reason == "touches a gap":
        return "with a dropped packet in flight"
    if reason.startswith("among the first"):
        return f"{reason} of a run"
    return reason if reason.startswith("rejected") else "without an apex"


def _saves(study: EmulatorStudy, trend: Trend) -> str:
    rows = study.analysed(trend.controller)
    savings = {row.gain: row.saving for row in rows if row.saving is not None}
    values = _values(savings.values())
    name = str(trend.controller).capitalize()
    if not values:
        return f"{name}: nothing is known of its savings."
    tested = [saving.ci for saving in savings.values() if not isinstance(saving.ci, Undefined)]
    without = [gain for gain, saving in savings.items() if isinstance(saving.ci, Undefined)]
    shown = sum(low > 0.0 or high < 0.0 for low, high in tested)
    text = (
        f"{name} saves {_ends_text(values)} % at gains {_listed(savings)} (thesis: "
        f"{_published_saving(trend.controller)})"
    )
    text += f"; the saving is significant at {shown} of {len(tested)}." if tested else "."
    if without:
        text += (
            f" At {_gains(tuple(without))} there is no interval: two runs of both on a day, or four shared days, tell."
        )
    if trend.line is None or isinstance(trend.line.slope.ci, Undefined):
        return text
    coarse = tuple(gain for gain in savings if gain in study.coarse)
    but = f" (not {_listed(coarse)}, which the charger reads too coarsely)" if coarse else ""
    return f"{text} Over gains {list_text(trend.line.groups)}{but}, {_trend_text(trend.line)}."


def _trend_text(line: SavingsTrend) -> str:
    """Say that the saving rises or falls, that it does by less than the bound, or that neither is shown."""
    slope, change = line.slope, line.change
    assert isinstance(slope.value, float) and not isinstance(slope.ci, Undefined)  # noqa: S101, PT018
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


def _listed(gains: Iterable[float]) -> str:
    return list_text([f"{gain:g}" for gain in gains])


def _fixed(value: float, places: int, sign: str = "") -> str:
    return f"{value:{sign}.{places}f}".replace("-", "\N{MINUS SIGN}")


def _lost(rows: list[AtGain]) -> str:
    found = [row.apex_loss for row in rows if row.apex_loss is not None]
    values = _values(found)
    ends = [loss.ci[1] for loss in found if not isinstance(loss.ci, Undefined)]
    if not values:
        return "No apex is compared with that under CE."
    below = sum(end < _published_loss() for end in ends)
    shown = f", which {below} of {len(ends)} intervals show" if ends else ""
    return (
        f"Active damping costs {_ends_text(values)} % of the apex height (thesis: less than "
        f"{_published_loss():g} %{shown})."
    )


def _published_loss() -> float:
    return 100.0 * published_numbers()["emu.apex_loss"]


def _left_out(study: EmulatorStudy) -> str:
    bound = f"{study.same_percent:g} %"
    if study.left_out:
        first = study.left_out[0]
        rises = [rise for rise in study.rises if rise.gain == first]
        step = f"From {rises[0].before:g} to {first:g}"
        return (
            f"Left out: {_gains(study.left_out)}, beyond the motors' torque limit. {step} no controller's"
            f" apex is {bound} or more higher ({list_text([_rise_text(rise) for rise in rises])})."
        )
    highest = max((rise.gain for rise in study.rises), default=None)
    last = [rise for rise in study.rises if rise.gain == highest and not isinstance(rise.change.ci, Undefined)]
    if not last:
        return "No gain is left out: no apex has an interval beside that at the gain before."
    return (
        f"No gain is left out: at each the apex may be {bound} or more above the one before; from "
        f"{last[0].before:g} to {last[0].gain:g}, {list_text([_rise_text(rise) for rise in last])}."
    )


def _gains(gains: tuple[float, ...]) -> str:
    return ("gain " if len(gains) == 1 else "gains ") + _listed(gains)


def _rise_text(rise: Rise) -> str:
    name, change = _SHORT[rise.controller], rise.change
    if isinstance(change.value, Undefined):
        return f"{name}: {change.value.reason}"
    if isinstance(change.ci, Undefined):
        return f"{name} {_fixed(change.value, 2, '+')} %, no interval: {change.ci.reason}"
    low, high = (_fixed(end, 2, "+") for end in change.ci)
    return f"{name} {_fixed(change.value, 2, '+')} %, 90 % CI {low} to {high}"


def rows(study: EmulatorStudy) -> list[list[str]]:
    """Return a row for each gain and controller."""
    return [
        [
            f"{row.gain:g}" + (" (left out)" if row.gain in study.left_out else ""),
            _SHORT[row.controller]
            if row.controller is Controller.CE
            else f"{_SHORT[row.controller]} ({row.damping_gain:g})",
            str(row.joules.n),
            f"{row.joules.value:.2f}",
            _estimate(row.saving, 1),
            f"{100.0 * row.apex_m.value:.2f}",
            _estimate(row.apex_loss, 2),
        ]
        for row in study.rows
    ]


def _estimate(found: Estimate | None, places: int) -> str:
    if found is None or isinstance(found.value, Undefined):
        return "–"
    if isinstance(found.ci, Undefined):
        return _fixed(found.value, places)
    low, high = (_fixed(end, places) for end in found.ci)
    return f"{_fixed(found.value, places)} ({low} to {high})"


def as_data(study: EmulatorStudy) -> dict[str, Any]:
    """Return all numbers for JSON, unrounded."""
    return {
        "level": study.level,
        "left_out": list(study.left_out),
        "coarse": list(study.coarse),
        "beside": [dict(zip(BESIDE, one, strict=True)) for one in comparison_rows(study)],
        "jumps": {"counted": study.jumps.counted, "made": study.jumps.made, "excluded": dict(study.jumps.excluded)},
        "gains": [
            {
                "gain": row.gain,
                "damping_gain": row.damping_gain,
                "controller": str(row.controller),
                "joules": asdict(row.joules),
                "apex_m": asdict(row.apex_m),
                "apex_sd_m": row.apex_sd_m,
                "simulated": {"joules": row.simulated_j, "apex_m": row.simulated_apex_m},
                "saving_percent": _data(row.saving),
                "apex_loss_percent": _data(row.apex_loss),
            }
            for row in study.rows
        ],
        "rises": [
            {
                "gain": rise.gain,
                "before": rise.before,
                "controller": str(rise.controller),
                "change_percent": _data(rise.change),
                "same_percent": study.same_percent,
                "no_rise": no_rise(rise, study.same_percent),
            }
            for rise in study.rises
        ],
        "trends": [{"controller": str(trend.controller), **_trend_data(trend.line)} for trend in study.trends],
    }


def _trend_data(line: SavingsTrend | None) -> dict[str, Any]:
    if line is None:
        return {"gains": [], "slope_points_per_cm": None, "change_points": None}
    change = {**(_data(line.change) or {}), "bound": line.change.high, "equivalent": value_data(line.change.equivalent)}
    slope = {**(_data(line.slope) or {}), "p": value_data(line.slope.p)}
    return {"gains": [*map(float, line.groups)], "slope_points_per_cm": slope, "change_points": change}


def _data(found: Estimate | Bounded | None) -> dict[str, Any] | None:
    if found is None:
        return None
    if isinstance(found.value, Undefined):
        return {"undefined": found.value.reason}
    if isinstance(found.ci, Undefined):
        return {"value": found.value, "undefined": found.ci.reason}
    return {"value": found.value, "ci_low": found.ci[0], "ci_high": found.ci[1]}


def figure_data(study: EmulatorStudy) -> tuple[list[ControllerPoints], tuple[float, ...], str]:
    """Return what the figure shows."""
    heights = {row.gain: 100.0 * row.apex_m.value for row in study.rows if row.controller is Controller.CE}
    trends = {trend.controller: trend for trend in study.trends}
    points = []
    for controller in Controller:
        own = [row for row in study.rows if row.controller is controller]
        points.append(
            ControllerPoints(
                _SHORT[controller] if controller is Controller.CE else str(controller),
                [row.gain for row in own],
                [(row.joules.value, _or_nan(row.joules.se)) for row in own],
                [(100.0 * row.apex_m.value, 100.0 * _or_nan(row.apex_m.se)) for row in own],
                [heights[row.gain] for row in own],
                [_ends(row.saving) if row.gain not in study.left_out else None for row in own],
                [_ends(row.apex_loss) if row.gain not in study.left_out else None for row in own],
                _drawn_trend(trends.get(controller), heights),
            )
        )
    return points, study.left_out, f"{level_text(study.level)} CI"


def _or_nan(se: float | None) -> float:
    return np.nan if se is None else se


def _ends(found: Estimate | None) -> tuple[float, float, float] | None:
    """Return a value and the ends of its interval, NaN where it has none."""
    if found is None or isinstance(found.value, Undefined):
        return None
    return found.value, *((np.nan, np.nan) if isinstance(found.ci, Undefined) else found.ci)


def _drawn_trend(trend: Trend | None, heights_cm: Mapping[float, float]) -> list[tuple[float, float]]:
    """Return the ends of the line, nothing where there is none."""
    line = None if trend is None else trend.line
    if line is None or isinstance(line.slope.value, Undefined):
        return []
    across, slope = [heights_cm[float(gain)] for gain in line.groups], line.slope.value
    return [(x, line.middle[1] + slope * (x - line.middle[0])) for x in (min(across), max(across))]
