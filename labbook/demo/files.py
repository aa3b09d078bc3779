"""The demonstration campaign as files: what the instruments wrote, the book's `labbook.toml`, the truth apart.

A logging charger sees a recharge at 1 Hz: constant current, then less and less.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, replace

import numpy as np

from data_schema.units import MAH_TO_COULOMB
from data_schema.vocabulary import RunKind
from labbook.demo.campaign import BATTERIES, IDLE_MINUTES, JUMPS_PER_RUN, Campaign, DemoRun
from labbook.demo.logger import DECIMALS, RunLog, run_log
from labbook.demo.plate import hopping_record
from labbook.demo.truth import CONTROL_GAIN, FOOT_RADIUS_M, Truth
from labbook.demo.writers import (
    MARK,
    CampaignFiles,
    Recharge,
    Record,
    bertec_text,
    icharger_log,
    string_pot_log,
)

FACTORS = ("foot", "k_gain", "b_ad_gain")
ROBOT = "hopper"

STUDY_TOML = """\
[study]
name = "{name} (synthetic)"
kind = "{kind}"
reference_voltage_v = {voltage_v}
jumps_nominal = {jumps}
time_zone = "America/New_York"

[people]
"Ada Nwosu" = "AN"

"""
_TEMPLATE = (
    """\
# Demonstration: a synthetic campaign of the size of chapter 5, of simulated jumps with known truth.
# Nothing in it was measured. What is true is described in docs/demonstration.md.

"""
    + STUDY_TOML
    + """\
[factors.foot]
kind = "label"
levels = {{ {feet} }}

[factors.k_gain]
kind = "number"
title = "extension stiffness"
levels = {k_gains}

[factors.b_ad_gain]
kind = "number"
title = "active-damping coefficient"
levels = {ad_gains}
control = {control}
control_name = "CE"
treatment = "active damping"

[protocol]
run_duration_s = {duration:g}
detector = "robust"
exclude_first_jumps = 0
exclude_gap_jumps = true
charger_resolution_mah = 1
idle_minutes = {idle}
checks = ["rail_angle", "lubrication"]

[gains.k_gain]
symbol = "k"
slope = 2.56
offset = 67.36
unit = "N/m"

[gains.b_ad_gain]
symbol = "d"
slope = 3.32
offset = 19.67
unit = "kg/s"
zero = 0

[robots.{robot}]
body_mass_kg = 1.8
foot_mass_kg = 0.2
link_1_m = 0.1
link_2_m = 0.2
rest_length_m = 0.27
leg_min_m = 0.1
leg_max_m = 0.3

{batteries}
"""
)
_ANALYSIS = """
# Decided before the first file, as a careful author would: apexes scatter by up to 7.5 mm in a condition (4.3.3), so
# that less than 3 % of some 0.3 m is no loss of height.
[analysis]
primary_outcome = "joules"
family = "pooled"
alpha = 0.05
apex_bounds_percent = [-3, 3]
exclusions = ["touched_by_hand", "misfire", "sensor_fault", "wrong_apex", "dropped_packet"]
"""
_SIMULATION = """
# The thesis states 2.0 kg for the whole robot: known to half a digit. How much of it the foot has is a guess.
[simulation]
scene = "bed"
assumed = ["body_mass", "foot_mass"]
varied_by = 0.1
varied = { body_mass = 0.025 }
factors = { foot = "foot_radius", k_gain = "k_extension", b_ad_gain = "b_ad" }
"""

_HYPOTHESES = """
# What the thesis expected of its experiments (3.3.1, 5.2), and what it found. 5 J of some 45 J were the most that the
# foot changed of a jump of CE in its simulations.
[hypotheses.foot_of_control]
text = "A jump of CE costs the same with either foot"
source = "thesis 3.3.1, prediction 1"
published = "p > .5"
claim = "same"
side = "control"
between = "foot"
within_percent = 10

[hypotheses.largest_saving]
text = "The small foot with the stiff gain saves most"
source = "thesis 3.3.1, prediction 2"
published = "about 15 %, the most of four"
claim = "largest_saving"
group = { foot = "small", k_gain = 400 }

[hypotheses.smallest_saving]
text = "The large foot with the soft gain saves least"
source = "thesis 3.3.1, prediction 2"
published = "p = .071, the only one of four above .05"
claim = "smallest_saving"
group = { foot = "large", k_gain = 300 }

[hypotheses.level_off]
text = "Savings level off: a jump costs the same at all gains of active damping"
source = "thesis 3.3.1, 5.2.1"
published = "p > .15"
claim = "same"
side = "treated"
between = "b_ad_gain"
within_percent = 10

[hypotheses.no_lower_apex]
text = "Active damping costs no apex height"
source = "thesis 5.2.2"
published = "up to 3 mm higher"
claim = "not_lower"
outcome = "apex"
within_percent = 3
"""


def book_toml(truth: Truth, *, predicted: bool = True, decided: bool = True) -> bytes:
    """Return the configuration of a book for a campaign with this truth.

    `predicted`: with the scene to simulate; `decided`: with what is decided about the analysis.
    """
    feet = dict.fromkeys(group.foot for group in truth.groups)
    text = _TEMPLATE.format(
        name="granular bed",
        kind="bed",
        voltage_v=truth.reference_voltage_v,
        jumps=JUMPS_PER_RUN,
        feet=", ".join(f"{foot} = {{ radius_m = {FOOT_RADIUS_M[foot]} }}" for foot in feet),
        k_gains=sorted({group.k_gain for group in truth.groups}),
        ad_gains=[CONTROL_GAIN, *truth.ad_gains],
        control=CONTROL_GAIN,
        duration=truth.run_duration_s,
        idle=list(IDLE_MINUTES),
        robot=ROBOT,
        batteries="\n".join(f"[batteries.{name}]\ncells = 4\ncapacity_mah = 6600\n" for name in BATTERIES),
    )
    return (text + (_ANALYSIS if decided else "") + (_SIMULATION + _HYPOTHESES if predicted else "")).encode()


_CURRENT_A = 1.0
_LEAST_CURRENT_A = 0.1
_RAMP_A_S = 0.25
_TAPER_FROM = 0.88
"""Part of the charge after which the current falls in proportion to what is left."""
_CELLS = 4
_CELL_RISE_V = 0.035
_CELL_RESISTANCE_OHM = 0.004


def recharge_course(seed: int, charge_mah: int, end_voltage_v: float) -> Recharge:
    """Draw a recharge that ends with the counter at `charge_mah` and the resting pack at `end_voltage_v`."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 3]))
    goal_c = charge_mah * MAH_TO_COULOMB
    currents_a, charged_c = [0.0], [0.0]
    while charged_c[-1] < goal_c:
        left = (goal_c - charged_c[-1]) / (goal_c * (1 - _TAPER_FROM))
        current_a = min(_CURRENT_A, currents_a[-1] + _RAMP_A_S, max(_LEAST_CURRENT_A, _CURRENT_A * left))
        current_a = round(current_a, 2)  # the log's resolution
        charged_c.append(charged_c[-1] + (currents_a[-1] + current_a) / 2)
        currents_a.append(current_a)
    current_a_array = np.array(currents_a)
    n = current_a_array.size
    done = np.minimum(np.array(charged_c) / goal_c, 1.0)
    rest_v = end_voltage_v / _CELLS - _CELL_RISE_V * (1 - done)
    imbalance_v = rng.normal(0, 0.002, _CELLS)
    loaded_v = rest_v[:, None] + _CELL_RESISTANCE_OHM * current_a_array[:, None]
    cell_v = loaded_v + (imbalance_v - imbalance_v.mean()) + rng.normal(0, 0.0008, (n, _CELLS))
    return Recharge(
        time_s=np.arange(n, dtype=np.float64),
        current_a=current_a_array,
        input_v=23.8 - 0.05 * current_a_array + rng.normal(0, 0.01, n),
        pack_v=cell_v.sum(axis=1) + rng.normal(0, 0.001, n),
        charge_mah=np.floor(done * charge_mah),
        internal_c=31.0 + 4.0 * done,
        external_c=np.zeros(n),
        cell_v=cell_v,
    )


def campaign_files(campaign: Campaign, *, full: bool = False) -> CampaignFiles:
    """Return what is written of a campaign.

    `instruments/runs.csv`, `instruments/logs/*.csv`, `instruments/charger/*.csv` (a sheet a day) and `*.txt` (a
    charger's own log), `instruments/force/*.txt`, `labbook.toml`, and `truth.json`. `full` writes logs of 12
    minutes (16 MB each) in place of about 80 seconds.
    """
    mistakes = {correction.run: {correction.field: correction.written} for correction in campaign.corrections}
    dates = sorted({run.date for run in campaign.runs})
    return CampaignFiles(
        configuration=book_toml(campaign.truth).decode(),
        records=_records(campaign, full),
        truth={
            "seed": campaign.seed,
            "full": full,
            **campaign.truth.as_json(),
            "corrections": [asdict(correction) for correction in campaign.corrections],
        },
        runs=[replace(run, levels={**run.levels, **mistakes.get(run.name, {})}) for run in campaign.runs],
        factors=FACTORS,
        planned=(
            campaign.seed,
            [
                (
                    run.name,
                    dates.index(run.date) + 1,
                    "" if run.condition is None else f"{run.condition.foot} {run.condition.k_gain}",
                    {name: str(level) for name, level in run.levels.items()} or None,
                )
                for run in campaign.runs
            ],
        ),
        corrections=campaign.corrections,
    )


def _records(campaign: Campaign, full: bool) -> Iterator[Record]:
    for run in campaign.of_kind(RunKind.CHARACTERISATION):
        if run.condition is not None:
            record = bertec_text(hopping_record(campaign.seed, run.condition.k_gain, run.jumps_made))
            yield Record(f"force/{run.name}_bertec_{MARK}.txt", record)
            course = recharge_course(campaign.seed, run.charge_mah, run.end_voltage_v)
            yield Record(f"charger/{run.name}_icharger_{MARK}.txt", icharger_log(course))
    for run in campaign.of_kind(RunKind.JUMPS):
        log = run_log(campaign.seed, campaign.truth, run, full=full)
        text = string_pot_log(log.time_ms, log.channels, DECIMALS)
        yield Record(f"logs/{run.name}_{MARK}.csv", text, _run_truth(run, log))


def _run_truth(run: DemoRun, log: RunLog) -> dict[str, object]:
    """What is true of one log: its apexes on the log's clock, its misfires and its dropped packets."""
    return {
        "run": run.name,
        "condition": None if run.condition is None else asdict(run.condition),
        "misfired_jumps": (np.flatnonzero(run.misfired) + 1).tolist(),
        "jumps_touched_by_gap": (np.flatnonzero(log.touched) + 1).tolist(),
        "first_sample_ms": int(log.time_ms[0]),
        "apex_ms": log.apex_ms.round(3).tolist(),
        "apex_height_m": log.apex_height_m.round(9).tolist(),
        "dropped": log.dropped.tolist(),
    }
