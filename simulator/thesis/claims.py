"""The published claims of ch. 3 against what the simulation gives: found, not tuned.

What the simulator gives for each claim of ch. 3: every point of the figures' grids, one function a claim.
"""

from __future__ import annotations

import importlib.resources
import tomllib
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulator.thesis.comparisons import Jumps, OverDamping
from simulator.thesis.figures import ThesisFigures
from simulator.thesis.motions import Motion, Pair

FloatArray = NDArray[np.float64]
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


def _apex_difference(jumps: Pair[Jumps]) -> FloatArray:
    return np.asarray(np.abs(jumps.ce.apex_height_m - jumps.ad.apex_height_m) / jumps.ce.apex_height_m)


def _heat_share(jumps: Pair[Jumps]) -> FloatArray:
    return np.concatenate([(part.heat_j / part.cost_j).ravel() for part in (jumps.ce, jumps.ad)])


def _spread(values: FloatArray) -> float:
    return float(np.max(values) - np.min(values))


def _motions(figures: ThesisFigures) -> tuple[Pair[Motion], ...]:
    return figures.power_surface.motions


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


def _ce_share(data: OverDamping) -> FloatArray:
    return np.asarray(_over_feet_j(data.jumps)[..., 0] / data.jumps.cost_j[..., 0].mean(axis=3))


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


VALUES: dict[str, Callable[[ThesisFigures], FloatArray]] = {
    "sim1.saving": lambda figures: _both_figures(figures, _saving),
    "sim1.excess": lambda figures: figures.over_ground.jumps.ce.cost_j / figures.over_ground.jumps.ad.cost_j - 1.0,
    "sim1.steady_saving": lambda figures: np.array(
        [_spread(_saving(jumps)) for jumps in (figures.over_velocity.jumps, figures.over_ground.jumps)]
    ),
    "sim1.mech_ratio": lambda figures: _both_figures(figures, _mechanical_ratio),
    "sim1.mech_ratio_ground": lambda figures: _mechanical_ratio(figures.over_ground.jumps),
    "sim1.efficiency": lambda figures: (
        figures.over_velocity.jumps.ad.efficiency / figures.over_velocity.jumps.ce.efficiency
    ),
    "sim1.efficiency_ground": lambda figures: (
        figures.over_ground.jumps.ce.efficiency / figures.over_ground.jumps.ad.efficiency
    ),
    "sim1.apex": lambda figures: _both_figures(figures, _apex_difference),
    "sim1.heat": lambda figures: _both_figures(figures, _heat_share),
    "sim1.same_until_switch": lambda figures: np.array([_distance_before_switch(pair) for pair in _motions(figures)]),
    "sim1.push": lambda figures: np.array([_pushed_m(pair.ad) / _pushed_m(pair.ce) for pair in _motions(figures)]),
    "sim1.ground_energy": lambda figures: np.array(
        [_ground_loss_after_switch_j(pair.ad) / _ground_loss_after_switch_j(pair.ce) for pair in _motions(figures)]
    ),
    "sim1.leg_before_ground": _spring_ratios,
    "sim1.jams": lambda figures: np.array([float(pair.ce.jams) for pair in _motions(figures)]),
    "sim2.foot_ce": lambda figures: _over_feet_j(figures.over_damping.jumps)[0, :, _STIFF, 0],
    "sim2.foot_ce_anywhere": lambda figures: _over_feet_j(figures.over_damping.jumps)[..., 0],
    "sim2.pred1": lambda figures: _ce_share(figures.over_damping),
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
"""Claim -> its values, of any shape."""


@dataclass(frozen=True, slots=True)
class Claim:
    """A claim of the thesis. It holds where every value of what is measured lies from `at_least` to `at_most`.

    `where` is the section or caption, `published` the thesis's own number, `unit` that of number, values and limits.
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


def claims() -> tuple[Claim, ...]:
    """Return the claims, in the order of the chapter."""
    text = (importlib.resources.files("simulator.thesis") / "claims.toml").read_text(encoding="utf-8")
    return tuple(Claim(**{**entry, "figures": tuple(entry["figures"])}) for entry in tomllib.loads(text)["claim"])


def finding(claim: Claim, figures: ThesisFigures) -> Finding:
    """Compute a claim's values and judge them."""
    return judge_claim(claim, VALUES[claim.id](figures))


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


def findings(figures: ThesisFigures, only: Collection[str] | None = None) -> tuple[Finding, ...]:
    """Judge all claims, or those about the figures of these numbers."""
    return tuple(
        finding(claim, figures) for claim in claims() if only is None or not set(only).isdisjoint(claim.figures)
    )
