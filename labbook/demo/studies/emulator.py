"""The emulator study (thesis 4.3) as a campaign with a known truth: simulated jumps, as instruments see them.

On each of four days the robot makes 100 jumps at each of five extension gains under compression-extension, constant and
scaled active damping, in random order, and idles twice. The jumps are the simulator's (`emulator` scene); what days,
runs and jumps differ by is drawn. The battery gives what the jumps cost in the simulation, at 16.8 V. The campaign is
written as files in the instruments' formats, and as a book that has ingested them.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any

import numpy as np

from labbook.demo.studies.runs import RUNS_TOML, Made, StudyRun, StudyScatter, drawn_days, logs_of, samples_not_dropped
from labbook.demo.truth import FloatArray
from labbook.demo.writers import CampaignFiles

GAINS = (100, 200, 300, 400, 500)
CONSTANT, RATIO = 50, 6
DAYS, JUMPS = 4, 100
_FACTORS = ("k_gain", "b_ad_gain")
IDLE_S = (120, 600)
VOLTAGE_V = 16.8
REST_LENGTH_M = 0.25
"""Of the scene: the body stands so high when its foot touches the platform."""
_RATE_HZ = 300
_HELD_S, _OVERHEAD_S = 1.0, 22
_FIRST_DAY = dt.date(2019, 7, 8)
_HEIGHT_NOISE_M, _HEIGHT_STEP_M = 0.001, 0.8 / 2**12
_DROP_CHANCE, _LONGEST_DROP = 0.05, 12


SCATTER = StudyScatter(day=0.01, run=0.015)
RUN_HEIGHT, JUMP_HEIGHT = 0.01, 0.02
"""Standard deviations of flights by run and by jump, as shares."""


@dataclass(frozen=True, slots=True)
class Truth:
    """A condition as it is simulated: joules of a jump over all jumps, and the mean apex without the first two."""

    gain: int
    damping_gain: int
    joules: float
    apex_m: float


def dampings(gain: int) -> list[int]:
    """Return the active-damping gains at an extension gain: none, constant, and scaled, rounded as in the thesis."""
    return sorted({0, CONSTANT, round(gain / RATIO)})


@cache
def _motion(gain: int, damping_gain: int, jumps: int) -> tuple[Truth, FloatArray, FloatArray, FloatArray]:
    """Simulate a condition: its truth, and when the body is how high, with the number of the jump."""
    from simulator.gains import active_damping_kg_m, stiffness_n_m
    from simulator.jump import simulate
    from simulator.scene_file import load_scene

    values = {"k_extension": stiffness_n_m(gain), "b_ad": active_damping_kg_m(damping_gain)}
    result = simulate(load_scene("emulator").changed(values, jumps=jumps), 1e-6, trajectory=True)
    motion = result.trajectory
    if motion is None:
        raise RuntimeError(f"{result.scene.name} has no recorded motion")
    apexes = [jump.apex_height_m for jump in result.jumps if jump.apex_height_m is not None]
    truth = Truth(
        gain, damping_gain, float(np.mean([jump.cost_J for jump in result.jumps])), float(np.mean(apexes[2:]))
    )
    time_s, height_m, number = (motion[name].to_numpy() for name in ("time", "body_height", "jump"))
    return truth, time_s, height_m, number.astype(np.float64)


def truths(jumps: int = JUMPS) -> list[Truth]:
    """Return the truth of every condition."""
    return [_motion(gain, damping, jumps)[0] for gain in GAINS for damping in dampings(gain)]


def emulator_campaign(seed: int, *, days: int = DAYS, jumps: int = JUMPS, logs: bool = True) -> list[StudyRun]:
    """Draw the campaign; without `logs`, charges alone."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 5]))
    conditions = [(gain, damping) for gain in GAINS for damping in dampings(gain)]

    def make(condition: tuple[int, int], day_share: float) -> Made:
        truth, time_s, height_m, number = _motion(*condition, jumps)
        share = 1.0 + day_share + rng.normal(0.0, SCATTER.run)
        return Made(
            dict(zip(_FACTORS, condition, strict=True)),
            jumps,
            int(time_s[-1] + 2 * _HELD_S) + _OVERHEAD_S,
            share * truth.joules * jumps,
            lambda: _log(rng, (time_s, height_m, number), condition, jumps) if logs else {},
        )

    def order() -> list[tuple[int, int]]:
        return [conditions[i] for i in rng.permutation(len(conditions))]

    dates = [_FIRST_DAY + dt.timedelta(days=3 * day) for day in range(days)]
    return drawn_days(rng, StudyRun, SCATTER, dates, IDLE_S, VOLTAGE_V, order, make)


def _log(
    rng: np.random.Generator,
    motion: tuple[FloatArray, FloatArray, FloatArray],
    condition: tuple[int, int],
    jumps: int,
) -> dict[str, Any]:
    """Record a run, by field of `StudyRun`: heights above the touchdown's are stretched by what it and its jumps differ
    by.
    """
    times_s, heights_m, numbers = motion
    shares = 1.0 + rng.normal(0.0, RUN_HEIGHT) + rng.normal(0.0, JUMP_HEIGHT, jumps)
    above_m = np.maximum(heights_m - REST_LENGTH_M, 0.0)
    made_m = np.where(above_m > 0.0, REST_LENGTH_M + shares[numbers.astype(int)] * above_m, heights_m)
    time_s = np.arange(-_HELD_S, times_s[-1] + _HELD_S, 1.0 / _RATE_HZ)
    height_m = np.interp(time_s, times_s, made_m) + rng.normal(0.0, _HEIGHT_NOISE_M, time_s.size)
    height_m = np.round(height_m / _HEIGHT_STEP_M) * _HEIGHT_STEP_M
    log_ms = np.round(1000.0 * (time_s + _HELD_S)).astype(np.int64) + int(rng.integers(15_000, 40_000))
    recorded = samples_not_dropped(rng, time_s.size, int(rng.binomial(jumps, _DROP_CHANCE)), _LONGEST_DROP, first=1)
    gain, damping = condition
    channels = {
        "body_height [m]": height_m,
        "k_gain": np.full(time_s.size, float(gain)),
        "b_ad_gain": np.full(time_s.size, float(damping)),
    }
    return {"log_ms": log_ms[recorded], "channels": {name: values[recorded] for name, values in channels.items()}}


_FURTHER = """\
[factors.b_ad_gain]
kind = "number"
title = "active-damping coefficient"
levels = {dampings}
control = 0
control_name = "CE"
treatment = "active damping"

[gains.b_ad_gain]
symbol = "d"
slope = 3.32
offset = 0
unit = "kg/s"
zero = 0

[analysis]
primary_outcome = "joules"
family = "each"
apex_bounds_percent = [-6, 6]

[simulation]
scene = "emulator"
factors = {{ k_gain = "k_extension", b_ad_gain = "b_ad" }}

[hypotheses.saves]
text = "Active damping saves energy at every gain"
source = "thesis 4.3"
published = "in all conditions"
claim = "saves"

[hypotheses.no_lower_apex]
text = "It costs less than 6 % of the apex height"
source = "thesis 4.3.3"
published = "less than 6 %"
claim = "not_lower"
outcome = "apex"
within_percent = 6

[hypotheses.torque_limit]
text = "The apex is the same at gains 400 and 500"
source = "thesis 4.3.3"
published = "no appreciable difference"
claim = "same"
side = "control"
outcome = "apex"
between = "k_gain"
levels = [400, 500]
within_percent = 2
"""
_PROTOCOL = """\
# The first two jumps, and those with a dropped packet in flight, are left out (thesis 4.3.3).
[protocol]
exclude_first_jumps = 2"""


def demonstration(seed: int) -> CampaignFiles:
    """Draw a campaign; return what is written of it."""
    return emulator_files(emulator_campaign(seed))


def emulator_files(campaign: Sequence[StudyRun]) -> CampaignFiles:
    """Return what is written of a campaign."""
    jumps = max(run.jumps_made for run in campaign)
    further = _FURTHER.format(dampings=sorted({damping for gain in GAINS for damping in dampings(gain)}))
    text = RUNS_TOML.format(
        study="emulator",
        section="4.3",
        name="ground emulator",
        kind="emulator",
        voltage_v=VOLTAGE_V,
        jumps=jumps,
        gains=list(GAINS),
        protocol=_PROTOCOL,
        idle_minutes=[seconds // 60 for seconds in IDLE_S],
        body_mass_kg=1.575,
        rest_length_m=REST_LENGTH_M,
        capacity_mah=7200,
    )
    truth = {"conditions": [asdict(one) for one in truths(jumps)]}
    logs = logs_of(campaign, dict.fromkeys(_FACTORS, 1))
    return CampaignFiles(configuration=text + further, records=logs, truth=truth, runs=campaign, factors=_FACTORS)
