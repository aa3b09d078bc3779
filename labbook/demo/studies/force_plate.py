"""The force-plate study (thesis 3.2.2) as a campaign with a known truth: simulated jumps, as instruments see them.

On each of four days the robot jumps 80 times at each of four extension gains, in the thesis's order, and idles twice.
The jumps are the simulator's (`force_plate` scene): those in which it settles, then settled ones of extension
stiffnesses that differ by up to 2 %, as no two hops are equal. The battery gives what the whole jumps cost in the
simulation; what days and runs differ by is drawn. The plate has noise, and the robot's clock and the plate's differ.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from labbook.demo.plate import HELD_S, RATE_HZ, Hopping, apex_of, pieces, record_of
from labbook.demo.studies.runs import RUNS_TOML, Made, StudyRun, StudyScatter, drawn_days, logs_of, samples_not_dropped
from labbook.demo.writers import MARK, CampaignFiles, PlateRecord, Record, bertec_text

GAINS = (300, 600, 500, 400)
"""In the order of the day (thesis 3.2.2)."""
DAYS, HOPS = 4, 80
IDLE_S = (60, 180)
VOLTAGE_V = 15.4
_LOG_STEP_S = 0.003
"""Whole milliseconds at 333 Hz."""
_WATCHED_S = 0.4
"""Records begin within the time in which the robot is held."""
_FIRST_DAY = dt.date(2021, 3, 1)
_LOG_DRIFT, _LOG_DRIFT_SD = 80e-6, 5e-6
_LEG_NOISE_M, _LEG_RATE_NOISE_M_S, _HEIGHT_NOISE_M = 5e-5, 0.01, 0.001
_PLATE_CREEP_N_S = 0.02
_DROP_CHANCE, _LONGEST_DROP = 0.06, 12
_OVERHEAD_S = 22


SCATTER = StudyScatter(day=0.01, run=0.01)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PlateStudyRun(StudyRun):
    """A run as it was, and what both instruments recorded of it.

    `clocks` are the true offset in s (what the log's clock shows at the plate's first sample, from the log's first on)
    and drift of the log's clock against the plate's; `cost_j` and `stance_j` are the means over its jumps. An idle run
    has no `gain`.
    """

    cost_j: float = 0.0
    stance_j: float = 0.0
    clocks: tuple[float, float] = (0.0, 0.0)
    plate: PlateRecord | None = None
    gain: int | None = None


def plate_campaign(
    seed: int, *, days: int = DAYS, hops: int = HOPS, scatter: StudyScatter = SCATTER, noise: float = 1.0
) -> list[PlateStudyRun]:
    """Draw the campaign; `noise` multiplies the instruments' errors and the share of packets that are lost."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 4]))

    def make(gain: int, day_share: float) -> Made:
        share = (1.0 + day_share) * (1.0 + rng.normal(0.0, scatter.run))
        settling, settled = pieces(gain)
        jumps = [*settling, *(settled[which] for which in rng.integers(len(settled), size=hops))][:hops]
        hopping = Hopping.of(jumps)
        recorded = _recorded(rng, hopping, gain, noise)
        joules = share * recorded["cost_j"] * hops
        return Made({"k_gain": gain}, hops, int(hopping.last_s) + _OVERHEAD_S, joules, lambda: recorded)

    dates = [_FIRST_DAY + dt.timedelta(days=day) for day in range(days)]
    return drawn_days(rng, PlateStudyRun, scatter, dates, IDLE_S, VOLTAGE_V, lambda: GAINS, make)


def _recorded(rng: np.random.Generator, hopping: Hopping, gain: int, noise: float) -> dict[str, Any]:
    """Record a run by both instruments: what both saw and what is true of it, by field of `PlateStudyRun`."""
    jumps, last_s = hopping.jumps, hopping.last_s
    # The plate's clock is true but for its stamps; the log's runs slow by its drift.
    begin_s, log_begin_s = rng.uniform(0.0, _WATCHED_S, 2).tolist()
    drift = _LOG_DRIFT + float(rng.normal(0.0, _LOG_DRIFT_SD))
    plate_s = np.arange(begin_s, last_s + HELD_S, 1.0 / RATE_HZ)
    log_s = np.arange(log_begin_s, last_s + HELD_S, _LOG_STEP_S * (1.0 + drift))
    n = log_s.size
    log_ms = int(rng.integers(15_000, 40_000)) + np.arange(n) * round(1000 * _LOG_STEP_S)
    force_n = hopping.sampled("force_n", plate_s)
    force_n += hopping.impacts(rng, plate_s) + noise * _PLATE_CREEP_N_S * plate_s
    plate = record_of(rng, force_n, noise)
    per_plate = float((plate.time_ms[-1] - plate.time_ms[0]) / 1e3 / (plate_s[-1] - plate_s[0]))
    rest_m, caught_m = float(jumps[0].leg_m[0]), float(jumps[-1].body_m[apex_of(jumps[-1])])
    channels = {
        channel: hopping.sampled(what, log_s, before, after) + noise * rng.normal(0.0, sd, n)
        for channel, what, before, after, sd in (
            ("body_height [m]", "body_m", rest_m, caught_m, _HEIGHT_NOISE_M),
            ("leg_length [m]", "leg_m", rest_m, rest_m, _LEG_NOISE_M),
            ("leg_velocity [m/s]", "leg_rate_m_s", 0.0, 0.0, _LEG_RATE_NOISE_M_S),
        )
    }
    channels["k_gain"] = np.full(n, float(gain))
    dropped = int(rng.binomial(len(jumps), min(noise * _DROP_CHANCE, 1.0)))
    recorded = samples_not_dropped(rng, n, dropped, _LONGEST_DROP)
    recorded[0] = True
    return {
        "gain": gain,
        "cost_j": float(np.mean([piece.cost_j for piece in jumps])),
        "stance_j": float(np.mean([piece.stance_j for piece in jumps])),
        "clocks": ((begin_s - log_begin_s) / (1.0 + drift), 1.0 / (1.0 + drift) / per_plate - 1.0),
        "plate": plate,
        "log_ms": log_ms[recorded],
        "channels": {channel: values[recorded] for channel, values in channels.items()},
    }


_FURTHER = """\
[simulation]
scene = "force_plate"
factors = { k_gain = "k_extension" }
"""
_PROTOCOL = """\
[protocol]
run_duration_s = 65
exclude_first_jumps = 0"""


def demonstration(seed: int) -> CampaignFiles:
    """Draw a campaign; return what is written of it."""
    return plate_files(plate_campaign(seed))


def plate_files(campaign: Sequence[PlateStudyRun]) -> CampaignFiles:
    """Return what is written of a campaign."""
    text = RUNS_TOML.format(
        study="force-plate",
        section="3.2.2",
        name="force plate",
        kind="force_plate",
        voltage_v=VOLTAGE_V,
        jumps=HOPS,
        gains=sorted(GAINS),
        protocol=_PROTOCOL,
        idle_minutes=[seconds / 60 for seconds in IDLE_S],
        body_mass_kg=1.825,
        rest_length_m=0.27,
        capacity_mah=6600,
    )
    plates = (
        Record(f"force/{run.name}_bertec_{MARK}.txt", bertec_text(run.plate), _truth(run))
        for run in campaign
        if run.plate is not None
    )
    records = chain(plates, logs_of(campaign, {"k_gain": 1}))
    return CampaignFiles(configuration=text + _FURTHER, records=records, truth={}, runs=campaign, factors=("k_gain",))


def _truth(run: PlateStudyRun) -> dict[str, object]:
    offset_s, drift = run.clocks
    return {
        "run": run.name,
        "k_gain": run.gain,
        "joules_per_jump": run.cost_j,
        "joules_in_stance": run.stance_j,
        "clock_offset_s": offset_s,
        "clock_drift": drift,
    }
