"""What the thesis says of its simulations (ch. 3) and experiments, against what the simulation gives: found, not tuned.

A claim's text and limits stand in `claims.toml` and `simulator/steady/published.toml`; here is what is measured for
each, at every point of the figures' grids or in every row of the tables: one function a claim.
"""

from __future__ import annotations

import functools
import importlib.resources
import tomllib
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from simulator.steady.tables import BED_GAINS, FEET_M, EmulatorRow, SteadyJump, SteadyTables
from simulator.thesis.figures import FloatArray, Jumps, Motion, OverDamping, Pair, ThesisFigures


@dataclass(frozen=True, slots=True)
class Claim:
    """A claim of the thesis. It holds where every value of what is measured lies from `at_least` to `at_most`.

    `where` is the section or caption, `published` the thesis's own number, `unit` that of number, values and limits.
    Without a `measure` the simulation gives nothing for it. Of an experiment `column` and `gains` say beside which
    simulated numbers it stands in the tables, in the words `beside`; `reason` why it cannot be matched.
    """

    id: str
    where: str
    figures: tuple[str, ...]
    statement: str
    measure: str
    unit: str
    published: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    column: str = ""
    gains: tuple[float, ...] = ()
    beside: str = ""
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Finding:
    """What the simulation gives for a claim: the range and median of `n` values, and how many lie within its limits."""

    claim: Claim
    lowest: float
    median: float
    highest: float
    n: int
    n_within: int

    @property
    def share_within(self) -> float:
        """Share of the values within the claim's limits."""
        return self.n_within / self.n

    @property
    def agrees(self) -> bool:
        """Whether every value lies within the claim's limits."""
        return self.n_within == self.n


def chapter_3_claims() -> tuple[Claim, ...]:
    """Return the claims about the simulations, in the order of the chapter."""
    return _claims("simulator.thesis", "claims")


def experiment_claims() -> tuple[Claim, ...]:
    """Return what is published of emulator, force plate and bed, in the order of the tables."""
    return _claims("simulator.steady", "published")


def _claims(package: str, name: str) -> tuple[Claim, ...]:
    text = (importlib.resources.files(package) / f"{name}.toml").read_text(encoding="utf-8")
    return tuple(
        Claim(**{**one, "figures": tuple(one["figures"]), "gains": tuple(map(float, one.get("gains", ())))})
        for one in tomllib.loads(text)["claim"]
    )


def chapter_3_findings(figures: ThesisFigures, only: Collection[str] | None = None) -> tuple[Finding, ...]:
    """Judge all claims of ch. 3, or those about the figures of these numbers."""
    return tuple(
        judge_claim(claim, OF_FIGURES[claim.id](figures))
        for claim in chapter_3_claims()
        if only is None or not set(only).isdisjoint(claim.figures)
    )


def experiment_findings(tables: SteadyTables) -> tuple[Finding, ...]:
    """Judge what is published of the experiments, but for claims that the simulation gives nothing for."""
    return tuple(judge_claim(claim, OF_TABLES[claim.id](tables)) for claim in experiment_claims() if claim.measure)


def judge_claim(claim: Claim, values: FloatArray) -> Finding:
    """Hold values of any shape against a claim's limits. A jump without an apex is NaN, and within no limits."""
    low = -np.inf if claim.at_least is None else claim.at_least
    high = np.inf if claim.at_most is None else claim.at_most
    return Finding(
        claim,
        lowest=float(np.nanmin(values)),
        median=float(np.nanmedian(values)),
        highest=float(np.nanmax(values)),
        n=values.size,
        n_within=int(np.count_nonzero((values >= low) & (values <= high))),
    )


_SOFT, _STIFF = 0, -1
_SMALL, _LARGE = 0, -1
_ELBOW_SHARE = 0.9
_ELBOW_SPAN_KG_M = 100.0


def _both_figures(figures: ThesisFigures, measure: Callable[[Pair[Jumps]], FloatArray]) -> FloatArray:
    """Measure over initial velocities and over grounds."""
    parts = (measure(figures.over_velocity.jumps), measure(figures.over_ground.jumps))
    return np.concatenate([part.ravel() for part in parts])


def _saving(jumps: Pair[Jumps]) -> FloatArray:
    return 1.0 - jumps.ad.cost_j / jumps.ce.cost_j


def _mechanical_ratio(jumps: Pair[Jumps]) -> FloatArray:
    return jumps.ce.mechanical_j / jumps.ad.mechanical_j


def _heat_share(jumps: Pair[Jumps]) -> FloatArray:
    return np.concatenate([(part.heat_j / part.cost_j).ravel() for part in (jumps.ce, jumps.ad)])


OF_SET_1: dict[str, Callable[[Pair[Jumps]], FloatArray]] = {
    "sim1.saving": _saving,
    "sim1.mech_ratio": _mechanical_ratio,
    "sim1.apex": lambda jumps: np.abs(1.0 - jumps.ad.apex_height_m / jumps.ce.apex_height_m),
    "sim1.mech_saving": lambda jumps: 1.0 - jumps.ad.mechanical_j / jumps.ce.mechanical_j,
    "sim1.heat_saving": lambda jumps: 1.0 - jumps.ad.heat_j / jumps.ce.heat_j,
}
"""Claims about set 1 -> what is measured for each, wherever it is simulated."""


def _distance_before_switch(pair: Pair[Motion]) -> float:
    times_s = np.linspace(0.0, min(pair.ce.switch_time_s, pair.ad.switch_time_s), 1001)
    feet_m = [np.interp(times_s, motion.time_s, motion.foot_height_m) for motion in (pair.ce, pair.ad)]
    return float(np.max(np.abs(feet_m[0] - feet_m[1])))


def _pushed_m(motion: Motion) -> float:
    return float(motion.depth_m[-1]) - motion.at_switch(motion.depth_m)


def _ground_loss_after_switch_j(motion: Motion) -> float:
    return float(motion.ground_loss_j[-1]) - motion.at_switch(motion.ground_loss_j)


def _spring_ratios(figures: ThesisFigures) -> FloatArray:
    pair = figures.energies
    just_before = [int(np.argmax(item.motion.extending)) - 1 for item in (pair.ce, pair.ad)]
    return np.array(
        [
            item.leg_spring_j[at] / item.ground_spring_j[at]
            for item, at in zip((pair.ce, pair.ad), just_before, strict=True)
        ]
    )


def _over_feet_j(jumps: Jumps) -> FloatArray:
    """Largest less smallest cost over the feet; shape (stiffness factors, drag factors, gains, coefficients)."""
    return np.asarray(np.ptp(jumps.cost_j, axis=3))


def _prediction_2(data: OverDamping) -> FloatArray:
    saving = data.saving[..., 1:]
    small_stiff, small_soft = saving[:, :, _STIFF, _SMALL], saving[:, :, _SOFT, _SMALL]
    large_stiff, large_soft = saving[:, :, _STIFF, _LARGE], saving[:, :, _SOFT, _LARGE]
    highest = small_stiff - np.maximum(np.maximum(small_soft, large_stiff), large_soft)
    lowest = np.minimum(np.minimum(small_soft, large_stiff), small_stiff) - large_soft
    return np.asarray(np.minimum(highest, lowest))


def _by_gain(data: OverDamping) -> FloatArray:
    return data.saving[:, :, _STIFF, :, 1:] - data.saving[:, :, _SOFT, :, 1:]


def _by_foot(data: OverDamping) -> FloatArray:
    return data.saving[:, :, :, _SMALL, 1:] - data.saving[:, :, :, _LARGE, 1:]


def _feet_by_ground(data: OverDamping) -> FloatArray:
    spread_j = _over_feet_j(data.jumps)[..., 1:]
    return np.asarray(spread_j[-1, 0] / spread_j[0, -1])


def _diminishing(data: OverDamping) -> FloatArray:
    saving, damping = data.saving, data.active_damping_kg_m
    first = int(np.searchsorted(damping, _ELBOW_SPAN_KG_M))
    last = int(np.searchsorted(damping, damping[-1] - _ELBOW_SPAN_KG_M))
    return np.asarray((saving[..., -1] - saving[..., last]) / saving[..., first])


def _elbow_kg_m(data: OverDamping) -> FloatArray:
    """Smallest coefficient with nine tenths of the largest saving in the range."""
    enough = data.saving >= _ELBOW_SHARE * data.saving.max(axis=-1, keepdims=True)
    return np.asarray(data.active_damping_kg_m[np.argmax(enough, axis=-1)])


OF_FIGURES: dict[str, Callable[[ThesisFigures], FloatArray]] = {
    **{name: functools.partial(_both_figures, measure=measure) for name, measure in OF_SET_1.items()},
    "sim1.excess": lambda figures: figures.over_ground.jumps.ce.cost_j / figures.over_ground.jumps.ad.cost_j - 1.0,
    "sim1.steady_saving": lambda figures: np.array(
        [np.ptp(_saving(jumps)) for jumps in (figures.over_velocity.jumps, figures.over_ground.jumps)]
    ),
    "sim1.mech_ratio_ground": lambda figures: _mechanical_ratio(figures.over_ground.jumps),
    "sim1.efficiency": lambda figures: (
        figures.over_velocity.jumps.ad.efficiency / figures.over_velocity.jumps.ce.efficiency
    ),
    "sim1.efficiency_ground": lambda figures: (
        figures.over_ground.jumps.ce.efficiency / figures.over_ground.jumps.ad.efficiency
    ),
    "sim1.heat": lambda figures: _both_figures(figures, _heat_share),
    "sim1.same_until_switch": lambda figures: np.array(
        [_distance_before_switch(pair) for pair in figures.power_surface.motions]
    ),
    "sim1.push": lambda figures: np.array(
        [_pushed_m(pair.ad) / _pushed_m(pair.ce) for pair in figures.power_surface.motions]
    ),
    "sim1.ground_energy": lambda figures: np.array(
        [
            _ground_loss_after_switch_j(pair.ad) / _ground_loss_after_switch_j(pair.ce)
            for pair in figures.power_surface.motions
        ]
    ),
    "sim1.leg_before_ground": _spring_ratios,
    "sim1.jams": lambda figures: np.array([float(pair.ce.jams) for pair in figures.power_surface.motions]),
    "sim2.foot_ce": lambda figures: _over_feet_j(figures.over_damping.jumps)[0, :, _STIFF, 0],
    "sim2.foot_ce_anywhere": lambda figures: _over_feet_j(figures.over_damping.jumps)[..., 0],
    "sim2.pred1": lambda figures: (
        _over_feet_j(figures.over_damping.jumps)[..., 0] / figures.over_damping.jumps.cost_j[..., 0].mean(axis=3)
    ),
    "sim2.pred2": lambda figures: _prediction_2(figures.over_damping),
    "sim2.stiff_gain": lambda figures: _by_gain(figures.over_damping),
    "sim2.small_foot": lambda figures: _by_foot(figures.over_damping),
    "sim2.large_foot": lambda figures: -_by_foot(figures.over_damping),
    "sim2.foot_ad": lambda figures: _feet_by_ground(figures.over_damping),
    "sim2.first_saving": lambda figures: np.diff(figures.over_damping.saving[..., :3], axis=-1),
    "sim2.elbow": lambda figures: _diminishing(figures.over_damping),
    "sim2.elbow_ground": lambda figures: _elbow_kg_m(figures.over_damping)[-1] - _elbow_kg_m(figures.over_damping)[0],
    "sim2.elbow_foot": lambda figures: (
        _elbow_kg_m(figures.over_damping)[..., _LARGE] - _elbow_kg_m(figures.over_damping)[..., _SMALL]
    ),
}
"""Claim of ch. 3 -> its values, of any shape."""


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


def _constant_savings(tables: SteadyTables) -> FloatArray:
    return np.array([row.constant_saving for row in tables.emulator.analysed])


_SMALL_FOOT, _LARGE_FOOT = FEET_M
_STIFF_GAIN, _SOFT_GAIN = BED_GAINS
_COMBINATIONS = tuple((foot, gain) for foot in FEET_M for gain in BED_GAINS)


def _bed_savings(tables: SteadyTables) -> FloatArray:
    """Saving of each combination and damping gain; shape (feet, extension gains, damping gains)."""
    savings = [[[row.saving for row in tables.bed.of(foot, gain)] for gain in BED_GAINS] for foot in FEET_M]
    return np.array(savings)


def _bed_costs_j(tables: SteadyTables) -> FloatArray:
    """Joules with active damping; the same shape."""
    return np.array([[[row.cost_j for row in tables.bed.of(foot, gain)] for gain in BED_GAINS] for foot in FEET_M])


def _margin(tables: SteadyTables, foot: str, gain: float) -> FloatArray:
    """Pooled saving of a combination less that of each other one."""
    others = [tables.bed.saving(*other) for other in _COMBINATIONS if other != (foot, gain)]
    return np.asarray(tables.bed.saving(foot, gain) - np.array(others))


OF_TABLES: dict[str, Callable[[SteadyTables], FloatArray]] = {
    "emu.apex_low": lambda tables: _apex(tables, LOWEST_GAIN),
    "emu.apex_high": lambda tables: _apex(tables, HIGHEST_GAIN),
    "emu.apex_line": _line,
    "emu.apex_plateau": _rise,
    "emu.apex_sd": lambda tables: np.array(
        [max(jump.apex_sd_m for row in tables.emulator.analysed for jump in _controllers(row))]
    ),
    "emu.apex_loss": lambda tables: np.array(
        [loss for row in tables.emulator.analysed for loss in (row.scaled_loss, row.constant_loss)]
    ),
    "emu.improves": lambda tables: np.array([(row.scaled_saving, row.constant_saving) for row in tables.emulator.rows]),
    "emu.saving_scaled": lambda tables: np.array([row.scaled_saving for row in tables.emulator.analysed]),
    "emu.saving_constant_low": lambda tables: _constant_savings(tables)[:1],
    "emu.saving_constant_high": lambda tables: _constant_savings(tables)[-1:],
    "emu.saving_constant_falls": lambda tables: np.diff(_constant_savings(tables)),
    "bed.saves": _bed_savings,
    "bed.saving_best": lambda tables: np.array([tables.bed.saving(_SMALL_FOOT, _STIFF_GAIN)]),
    "bed.best_combination": lambda tables: _margin(tables, _SMALL_FOOT, _STIFF_GAIN),
    "bed.least_combination": lambda tables: -_margin(tables, _LARGE_FOOT, _SOFT_GAIN),
    "bed.foot_ce": lambda tables: np.ptp(
        [[tables.bed.of(foot, gain)[0].ce_cost_j for gain in BED_GAINS] for foot in FEET_M], axis=0
    ),
    "bed.foot_ad": lambda tables: np.subtract(*_bed_costs_j(tables).mean(axis=-1)[::-1]),
    "bed.small_foot": lambda tables: np.subtract(*_bed_savings(tables)),
    "bed.anova": lambda tables: np.ptp(_bed_costs_j(tables), axis=-1),
    "bed.elbow": lambda tables: _bed_savings(tables)[..., 0] / _bed_savings(tables).max(axis=-1),
    "bed.apex_gain": lambda tables: np.array(
        [row.apex_gain_m for foot, gain in _COMBINATIONS for row in tables.bed.of(foot, gain)]
    ),
}
"""Claim about an experiment -> its values, of all gains and controllers that it is about."""
