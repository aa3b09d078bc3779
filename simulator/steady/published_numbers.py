"""What the thesis says of its experiments on emulator, force plate and bed, against what the simulation gives.

What the simulated tables give for each published number: one function a number.
"""

from __future__ import annotations

import importlib.resources
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simulator.steady.tables import BED_GAINS, FEET_M, EmulatorRow, SteadyJump, SteadyTables
from simulator.thesis.claims import Claim, Finding, judge_claim

FloatArray = NDArray[np.float64]
LOWEST_GAIN, HIGHEST_GAIN, EXCLUDED_GAIN = 100.0, 400.0, 500.0
"""Of the published apexes; the third was excluded from analysis."""


def _controllers(row: EmulatorRow) -> tuple[SteadyJump, SteadyJump, SteadyJump]:
    return row.ce, row.scaled, row.constant


def _apex(tables: SteadyTables, gain: float) -> FloatArray:
    return np.array([tables.emulator.at(gain).ce.apex_height_m])


def _line(tables: SteadyTables) -> FloatArray:
    """Largest distance from a line fitted by least squares, relative to the rise; shape (controllers,)."""
    rows = tables.emulator.analysed
    gains = np.array([row.gain for row in rows])
    apexes_m = np.array([[jump.apex_height_m for jump in _controllers(row)] for row in rows])
    slope, height_m = np.polyfit(gains, apexes_m, 1)
    distance_m = np.abs(apexes_m - (np.multiply.outer(gains, slope) + height_m))
    return np.asarray(distance_m.max(axis=0) / np.ptp(apexes_m, axis=0))


def _rise(tables: SteadyTables) -> FloatArray:
    pairs = zip(*(_controllers(tables.emulator.at(gain)) for gain in (HIGHEST_GAIN, EXCLUDED_GAIN)), strict=True)
    return np.array([stiffest.apex_height_m - stiff.apex_height_m for stiff, stiffest in pairs])


def _scatter(tables: SteadyTables) -> FloatArray:
    return np.array([max(jump.apex_sd_m for row in tables.emulator.analysed for jump in _controllers(row))])


def _constant_savings(tables: SteadyTables) -> FloatArray:
    return np.array([row.constant_saving for row in tables.emulator.analysed])


_SMALL, _LARGE = FEET_M
_STIFF, _SOFT = BED_GAINS
_COMBINATIONS = tuple((foot, gain) for foot in FEET_M for gain in BED_GAINS)


def _bed_savings(tables: SteadyTables) -> FloatArray:
    """Saving of each combination and damping gain; shape (feet, extension gains, damping gains)."""
    savings = [[[row.saving for row in tables.bed.of(foot, gain)] for gain in BED_GAINS] for foot in FEET_M]
    return np.array(savings)


def _bed_costs_j(tables: SteadyTables) -> FloatArray:
    """Joules with active damping; the same shape."""
    return np.array([[[row.cost_j for row in tables.bed.of(foot, gain)] for gain in BED_GAINS] for foot in FEET_M])


def _ce_of_feet_j(tables: SteadyTables) -> FloatArray:
    costs_j = [[tables.bed.of(foot, gain)[0].ce_cost_j for gain in BED_GAINS] for foot in FEET_M]
    return np.asarray(np.ptp(np.array(costs_j), axis=0))


def _margin(tables: SteadyTables, foot: str, gain: float) -> FloatArray:
    """Pooled saving of a combination less that of each other one."""
    others = [tables.bed.saving(*other) for other in _COMBINATIONS if other != (foot, gain)]
    return np.asarray(tables.bed.saving(foot, gain) - np.array(others))


def _least_of_largest(savings: FloatArray) -> FloatArray:
    return np.asarray(savings[..., 0] / savings.max(axis=-1))


MEASURES: dict[str, Callable[[SteadyTables], FloatArray]] = {
    "emu.apex_low": lambda tables: _apex(tables, LOWEST_GAIN),
    "emu.apex_high": lambda tables: _apex(tables, HIGHEST_GAIN),
    "emu.apex_line": _line,
    "emu.apex_plateau": _rise,
    "emu.apex_sd": _scatter,
    "emu.apex_loss": lambda tables: np.array(
        [loss for row in tables.emulator.analysed for loss in (row.scaled_loss, row.constant_loss)]
    ),
    "emu.improves": lambda tables: np.array([(row.scaled_saving, row.constant_saving) for row in tables.emulator.rows]),
    "emu.saving_scaled": lambda tables: np.array([row.scaled_saving for row in tables.emulator.analysed]),
    "emu.saving_constant_low": lambda tables: _constant_savings(tables)[:1],
    "emu.saving_constant_high": lambda tables: _constant_savings(tables)[-1:],
    "emu.saving_constant_falls": lambda tables: np.diff(_constant_savings(tables)),
    "bed.saves": _bed_savings,
    "bed.saving_best": lambda tables: np.array([tables.bed.saving(_SMALL, _STIFF)]),
    "bed.best_combination": lambda tables: _margin(tables, _SMALL, _STIFF),
    "bed.least_combination": lambda tables: -_margin(tables, _LARGE, _SOFT),
    "bed.foot_ce": _ce_of_feet_j,
    "bed.foot_ad": lambda tables: np.subtract(*_bed_costs_j(tables).mean(axis=-1)[::-1]),
    "bed.small_foot": lambda tables: np.subtract(*_bed_savings(tables)),
    "bed.anova": lambda tables: np.ptp(_bed_costs_j(tables), axis=-1),
    "bed.elbow": lambda tables: _least_of_largest(_bed_savings(tables)),
    "bed.apex_gain": lambda tables: np.array(
        [row.apex_gain_m for foot, gain in _COMBINATIONS for row in tables.bed.of(foot, gain)]
    ),
}
"""Published number -> its values, those of all gains and controllers that it is about."""


_APEXES = ("emu.apex_low", "emu.apex_high")
_OWN_KEYS = ("column", "gains", "beside", "reason")


@dataclass(frozen=True, slots=True)
class PublishedNumber:
    """A published number or statement as a claim, without a `measure` where the simulation gives nothing for it.

    `column` and `gains` say beside which simulated numbers it stands in the tables, in the words `beside`; `reason`
    why it cannot be matched, where it cannot.
    """

    claim: Claim
    column: str = ""
    gains: tuple[float, ...] = ()
    beside: str = ""
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Comparison:
    """A published number and what the simulation gives for it: None where it gives nothing to compare."""

    published: PublishedNumber
    finding: Finding | None

    @property
    def agrees(self) -> bool:
        """Whether the simulation gives it."""
        return self.finding is not None and self.finding.agrees


def published_numbers() -> tuple[PublishedNumber, ...]:
    """Return what is published, in the order of the tables."""
    text = (importlib.resources.files("simulator.steady") / "published.toml").read_text(encoding="utf-8")
    return tuple(_number(entry) for entry in tomllib.loads(text)["number"])


def comparisons(tables: SteadyTables) -> tuple[Comparison, ...]:
    """Hold everything published against the tables."""
    return tuple(
        Comparison(
            number, judge_claim(number.claim, MEASURES[number.claim.id](tables)) if number.claim.measure else None
        )
        for number in published_numbers()
    )


def apex_between_m(gain: float) -> float:
    """Return the apex in m at a gain between the two at which apexes are published, on the straight line."""
    known = [
        (number.gains[0], number.claim.published)
        for number in published_numbers()
        if number.claim.id in _APEXES and number.claim.published is not None
    ]
    gains, apexes_m = zip(*known, strict=True)
    return float(np.interp(gain, gains, apexes_m))


def _number(entry: dict[str, Any]) -> PublishedNumber:
    own = {key: entry.pop(key) for key in _OWN_KEYS if key in entry}
    own["gains"] = tuple(float(gain) for gain in own.get("gains", ()))
    return PublishedNumber(Claim(**{**entry, "figures": tuple(entry["figures"])}), **own)
