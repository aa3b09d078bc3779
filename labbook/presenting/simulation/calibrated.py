"""A calibration as sentences and as data."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from scipy import stats

from data_schema.vocabulary import Undefined
from labbook.analysis.prediction.calibrating import Calibrated, Calibration
from reports.display import count_text, given_text, list_text, p_text, shown_unit, with_unit

HEAD = ("parameter", "value", "std. error", "profile likelihood", "from")


def sentences(found: Calibration) -> list[str]:
    """Say how well the scene fits, what was identified, and what held-out conditions show."""
    p = float(stats.f.sf(found.chi_squared / found.df, found.df, found.df_of_errors))
    rms = [
        f"{with_unit(f'{_shown(value, outcome.unit):.3g}', shown_unit(outcome.unit)[0])} in {outcome}"
        for outcome, value in found.rms.items()
    ]
    fits = "The scene describes what was measured" if p > 0.05 else "The scene does not describe all that was measured"
    lines = [
        f"{fits}: F({found.df}, {found.df_of_errors}) = {found.chi_squared / found.df:.4g} ({p_text(p)}), "
        f"{list_text(rms)} (root mean square of {count_text(found.n_means, 'mean')})."
    ]
    if found.chi_squared > found.df:
        lines.append(
            f"Standard errors and profiles are widened {math.sqrt(found.chi_squared / found.df):.3g} times for it."
        )
    unknown = [one.name for one in found.parameters if not one.identified]
    if unknown:
        number = f" (condition number {found.condition:.2g})" if math.isfinite(found.condition) else ""
        lines.append(
            f"These data do not identify {list_text(unknown)}{number}: fix what you know better, or fit fewer."
        )
    lines += [
        f"{one.name} is at {one.value:.5g}, a bound of what a scene can have: on that side the data set no end."
        for one in found.parameters
        if one.at_bound
    ]
    lines += [
        f"Held out group by group, {one.within} of {one.of} means of {one.outcome} lie within their "
        f"{level_text_of(found.level)} intervals (root mean square "
        f"{with_unit(f'{_shown(one.rms, one.outcome.unit):.3g}', shown_unit(one.outcome.unit)[0])})."
        for one in found.held_out
    ]
    return lines


def how_to_use(found: Calibration, scene: str) -> str:
    """Write what to put into labbook.toml, so that predictions carry the errors of what was fitted."""
    parts = {one.name: one.se / one.value for one in found.parameters if isinstance(one.se, float)}
    varied = ", ".join(f"{name} = {part:.2g}" for name, part in parts.items() if 0.0 < part < 1.0)
    return f'Under [simulation]: scene = "{scene}"' + (f", varied = {{ {varied} }}" if varied else "")


def level_text_of(level: float) -> str:
    """Write a level: "95 %"."""
    return with_unit(given_text(100.0 * level), "%")


def _shown(value: float, unit: str) -> float:
    return value * shown_unit(unit)[1]


def rows(found: Calibration) -> list[list[str]]:
    """Return a row for each parameter."""
    return [
        [
            f"{one.name} ({one.unit})" if one.unit != "1" else one.name,
            f"{one.value:.5g}",
            "–" if isinstance(one.se, Undefined) else f"{one.se:.2g}",
            _profile_text(one),
            f"{one.started_at:.5g}",
        ]
        for one in found.parameters
    ]


def _profile_text(one: Calibrated) -> str:
    low, high = one.profile
    if low is None and high is None:
        return "not identified"
    if low is None or high is None:
        return f"below {high:.5g}" if low is None else f"above {low:.5g}"
    return f"{low:.5g} to {high:.5g}"


def as_data(found: Calibration) -> dict[str, Any]:
    """Return the same for programs, unrounded."""
    return {
        "parameters": [
            {
                **asdict(one),
                "se": None if isinstance(one.se, Undefined) else one.se,
                "identified": one.identified,
                "at_bound": one.at_bound,
            }
            for one in found.parameters
        ],
        "chi_squared": found.chi_squared,
        "df": found.df,
        "df_of_errors": found.df_of_errors,
        "condition_number": found.condition if math.isfinite(found.condition) else None,
        "rms": {outcome.key: value for outcome, value in found.rms.items()},
        "held_out": [
            {"outcome": one.outcome.key, "within": one.within, "of": one.of, "rms": one.rms} for one in found.held_out
        ],
        "means": found.n_means,
        "runs": {outcome.key: n for outcome, n in found.n_runs.items()},
        "level": found.level,
    }
