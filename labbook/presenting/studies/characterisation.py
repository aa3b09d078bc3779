"""The characterisation of a leg: as sentences and a table, as data, and as what its figure draws."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from data_schema.rounding import error_of, interval_text, number_text
from data_schema.vocabulary import Undefined
from labbook.analysis.studies.characterisation import (
    TOGETHER,
    Characterisation,
    Coefficient,
    GainLines,
    MeasuredGains,
    OfMass,
)
from labbook.presenting.numbers import value_data
from reports.figures.characterisation import OverGain, Trajectory
from simulator.steady.published_results import published_numbers
from stats.lines.stiffness import MINIMUM_POINTS, GainLine

HEAD = ("neutral", "gain", "damping gain", "stiffness N/m", "CI", "damping kg/s", "CI", "points")


def sentences(study: Characterisation) -> list[str]:
    """Say the lines of each neutral length, what the thesis found, and what was left out."""
    texts = []
    for lines in study.lines:
        where = "" if lines.neutral_m is None else f" at {_length_text(lines.neutral_m)}"
        texts += [
            _line_text(f"Stiffness{where}", lines.stiffness, "N/m"),
            _line_text(f"Damping{where}", lines.damping, "kg/s"),
        ]
    texts += [_published(), _plane_text(study.conditions)]
    for condition, count in study.too_few.items():
        texts.append(f"Left out, as {MINIMUM_POINTS} points are needed: {_condition_text(*condition)}, with {count}.")
    for one in study.conditions:
        for mass_kg, why in one.masses_left_out.items():
            texts.append(f"No coefficients of {mass_kg:g} kg alone, {_of(one)}: {why}")
    if odd := [one for one in study.conditions if one.widened > TOGETHER]:
        most = max(one.widened for one in odd)
        texts.append(
            f"Neighbouring residuals go together ({'; '.join(map(_of, odd))}): intervals are wider for it, by up to a "
            f"factor of {most:.1f}. If the logs were not smoothed, the leg is no linear spring."
        )
    return texts


def _condition_text(neutral_m: float | None, gain: float, damping_gain: float) -> str:
    where = "" if neutral_m is None else f" at {_length_text(neutral_m)}"
    return f"gain {gain:g}, damping gain {damping_gain:g}{where}"


def _of(one: MeasuredGains) -> str:
    return _condition_text(one.neutral_m, one.gain, one.damping_gain)


def _published() -> str:
    known = published_numbers()
    lines = (
        f"{what} {known[f'gain.{what}']:g} {unit} x gain + {known[f'gain.{what}0']:g} {unit}"
        for what, unit in (("stiffness", "N/m"), ("damping", "kg/s"))
    )
    return f"The thesis's leg: {', '.join(lines)} (5.1.1)."


def _plane_text(conditions: Sequence[MeasuredGains]) -> str:
    """Say how far the thesis's planes are from the fitted motion, and what of that is their bias there."""
    stiffness = max(conditions, key=lambda one: abs(one.plane.fit.stiffness_n_m / one.stiffness.value - 1.0))
    damping = max(conditions, key=lambda one: abs(one.plane.fit.damping_kg_s - one.damping.value))
    in_stiffness, in_damping = stiffness.plane.fit, damping.plane.fit
    of_stiffness = in_stiffness.stiffness_n_m, stiffness.stiffness.value, stiffness.plane.bias[0]
    of_damping = in_damping.damping_kg_s, damping.damping.value, damping.plane.bias[1]
    return (
        "Planes through forces by differences of velocities (thesis 4.2.6, in --json) differ most in stiffness for "
        f"{_off_text(stiffness, of_stiffness, in_stiffness.stiffness_se, 'N/m')}, and in damping for "
        f"{_off_text(damping, of_damping, in_damping.damping_se, 'kg/s')}."
    )


def _off_text(one: MeasuredGains, values: tuple[float, float, float], error: float, unit: str) -> str:
    plane, motion, bias = (number_text(value, error=error) for value in values)
    return (
        f"{_of(one)}: {plane} {unit} where the motion has {motion} {unit}, with a bias by differences of noisy data of "
        f"{bias} {unit}"
    )


def rows(study: Characterisation) -> list[tuple[str, ...]]:
    """Return the table of the conditions."""
    return [
        (
            "" if one.neutral_m is None else _length_text(one.neutral_m),
            f"{one.gain:g}",
            f"{one.damping_gain:g}",
            *_texts(one.stiffness),
            *_texts(one.damping),
            str(one.n),
        )
        for one in study.conditions
    ]


def _texts(one: Coefficient) -> tuple[str, str]:
    value, low, high = (number_text(number, error=one.se) for number in (one.value, *one.ci))
    return value, f"{low} to {high}"


def _length_text(neutral_m: float) -> str:
    return f"{100.0 * neutral_m:.3g} cm"


def _line_text(what: str, line: GainLine | Undefined, unit: str) -> str:
    if isinstance(line, Undefined):
        return f"{what}: no line, {line.reason}."
    slope, offset = (
        f"{number_text(value, error=error_of(ci))} {unit} ({interval_text(ci, line.fit.level)})"
        for value, ci in ((line.slope, line.slope_ci), (line.offset, line.offset_ci))
    )
    return f"{what} = {slope} x gain + {offset}; n = {line.fit.n} conditions."


def as_data(study: Characterisation) -> dict[str, Any]:
    """Return all numbers for JSON."""
    return {
        "conditions": [_condition(one) for one in study.conditions],
        "lines": [_lines_data(one) for one in study.lines],
        "too_few": [
            {"neutral_m": neutral_m, "gain": gain, "damping_gain": damping_gain, "n": count}
            for (neutral_m, gain, damping_gain), count in study.too_few.items()
        ],
        "level": study.level,
    }


def _condition(one: MeasuredGains) -> dict[str, Any]:
    return {
        "neutral_m": one.neutral_m,
        "gain": one.gain,
        "damping_gain": one.damping_gain,
        "masses_kg": sorted({motion.mass_kg for motion in one.motions}),
        "trajectories": one.trajectories,
        "n": one.n,
        "residual_lag1": value_data(one.residual_lag1),
        "widened": one.widened,
        **_coefficients(one),
        "masses": [{"mass_kg": mass.mass_kg, "n": mass.n, **_coefficients(mass)} for mass in one.masses],
        "masses_left_out": [{"mass_kg": mass_kg, "why": why} for mass_kg, why in one.masses_left_out.items()],
        "plane": {
            **one.plane.fit.to_dict(),
            "stiffness_bias_n_m": one.plane.bias[0],
            "damping_bias_kg_s": one.plane.bias[1],
        },
    }


def _coefficients(one: MeasuredGains | OfMass) -> dict[str, Any]:
    return {
        name: {"value": found.value, "se": found.se, "ci": list(found.ci)}
        for name, found in (("stiffness_n_m", one.stiffness), ("damping_kg_s", one.damping))
    }


def _lines_data(one: GainLines) -> dict[str, Any]:
    return {
        "neutral_m": one.neutral_m,
        **{
            name: None if isinstance(line, Undefined) else line.to_dict()
            for name, line in (("stiffness", one.stiffness), ("damping", one.damping))
        },
    }


def figure_data(study: Characterisation) -> tuple[list[Trajectory], list[OverGain], list[OverGain]]:
    """Return what the figure shows: a trajectory of each mass where the leg is damped least, stiffness, and damping."""
    least = min(study.conditions, key=lambda one: one.damping.value / one.stiffness.value**0.5)
    of_masses = {one.mass_kg: one for one in reversed(least.motions)}  # the first of each
    where = "" if least.neutral_m is None else f", {_length_text(least.neutral_m)}"
    place = [lines.neutral_m for lines in study.lines].index(least.neutral_m)
    motions = [
        Trajectory(f"Gain {least.gain:g}{where}", place, one.displacement_m, one.force_n, one.fitted_m, one.fitted_n)
        for one in of_masses.values()
    ]
    series: tuple[list[OverGain], list[OverGain]] = ([], [])
    for lines in study.lines:
        same = [one for one in study.conditions if one.neutral_m == lines.neutral_m]
        label = "measured" if lines.neutral_m is None else f"neutral length {_length_text(lines.neutral_m)}"
        points = [(one, mass) for one in same for mass in one.masses]
        masses = [mass.mass_kg for _, mass in points]
        filled = [mass.n >= MINIMUM_POINTS for _, mass in points]
        both = (
            ([one.gain for one, _ in points], [mass.stiffness for _, mass in points], lines.stiffness),
            ([one.damping_gain for one, _ in points], [mass.damping for _, mass in points], lines.damping),
        )
        for found, (gains, coefficients, line) in zip(series, both, strict=True):
            ends = None
            if not isinstance(line, Undefined):
                low, high = line.gains
                ends = (low, high), (line.slope * low + line.offset, line.slope * high + line.offset)
            values, intervals = [one.value for one in coefficients], [one.ci for one in coefficients]
            found.append(OverGain(label, gains, masses, values, intervals, filled, ends))
    return motions, *series
