"""The `labbook.toml` of the demonstration book."""

from __future__ import annotations

from labbook.demo.campaign import BATTERIES, IDLE_MINUTES, JUMPS_PER_RUN
from labbook.demo.truth import CONTROL_GAIN, FOOT_RADIUS_M, Truth

FACTORS = ("foot", "k_gain", "b_ad_gain")
ROBOT = "hopper"

_TEMPLATE = """\
# Demonstration: a synthetic campaign of the size of chapter 5, of simulated jumps with known truth.
# Nothing in it was measured. What is true is described in docs/demonstration.md.

[study]
name = "granular bed (synthetic)"
kind = "bed"
reference_voltage_v = {voltage}
jumps_nominal = {jumps}
time_zone = "America/New_York"

[people]
"Ada Nwosu" = "AN"

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

[protocol]
run_duration_s = {duration:g}
detector = "robust"
exclude_first_jumps = 0
exclude_gap_jumps = true
charger_resolution_mah = 1
idle_minutes = {idle}

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
[files]
run_pattern = '^(?P<run>r\\d+)'
"""
_ANALYSIS = """
# Decided before the first file, as a careful author would: apexes scatter by up to 7.5 mm in a condition (4.3.3), so
# that less than 3 % of some 0.3 m is no loss of height.
[analysis]
primary_outcome = "joules"
family = "pooled"
alpha = 0.05
apex_bounds_percent = [-3, 3]
exclusions = ["touched_by_hand", "misfire", "sensor_fault", "wrong_apex", "dropped_packet"]
unit_of_analysis = "shared_days"
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
        voltage=truth.reference_voltage_v,
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
