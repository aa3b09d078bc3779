"""The `labbook.toml` that `labbook init` writes: what every book needs filled in, the rest as examples."""

from __future__ import annotations

import json

from data_schema.errors import UsageError
from labbook.config.reading import is_plain

_TEMPLATE = """\
# The configuration of this book. Lines that start with "# " explain; lines that start with "#" and no space are
# examples: take the # away and put your own in. A key that labbook does not know is refused, with the nearest one.

[study]
name = NAME
# bed, emulator, force_plate or field
kind = "bed"
# Joules are charge times this voltage: the packs' storage voltage where they are recharged to that (4 x 3.85 V).
reference_voltage_v = 15.4
# How many jumps a run has by protocol.
jumps_nominal = 25
# Days and clock times are local to this zone, for example "America/New_York".
time_zone = ZONE
# How runs are called: the number in braces, of three digits. LOG{:04d} is LOG0001; a file belongs to the run that its
# name states.
run_names = "r{:03d}"

[people]
# Who may speak in this book: name = initials.
PERSON = INITIALS

# What is varied between runs. The level named as control makes a condition a control; without one, nothing can be
# compared: name it before the first run is made.
#[factors.foot]
#kind = "label"
#levels = { small = { radius_m = 0.038 }, large = { radius_m = 0.051 } }

#[factors.k_gain]
#kind = "number"
#title = "extension stiffness"
#levels = [300, 400]

#[factors.b_ad_gain]
#kind = "number"
#title = "active-damping coefficient"
#levels = [0, 50, 100, 150, 200, 250]
#control = 0
# What the control is called in text, and the other levels together; without these, by their labels.
#control_name = "CE"
#treatment = "active damping"

[protocol]
# Power on to power off, where all runs of jumps last as long.
#run_duration_s = 720
# robust, or published: the one of the thesis.
detector = "robust"
exclude_first_jumps = 0
# Leave out jumps with a dropped packet in flight.
exclude_gap_jumps = true
# By which published rules a single jump begins and leaves a force plate (docs/your-own-data.md has others).
onset = "5sd_back_30ms"
take_off = "flight_5sd"
# The step of the charger's mAh, where the charges themselves do not show it.
#charger_resolution_mah = 1
# Runs without jumps, from which the passive drain is fitted.
idle_minutes = [20, 24, 30, 40, 50, 60]
# What is looked at before a day's first run: `labbook today` asks for each.
#checks = ["rail_angle", "lubrication", "battery_conditioned", "sensor_zero"]

# What a gain means: physical value = slope * gain + offset; at the gain zero, nothing is applied.
#[gains.k_gain]
#symbol = "k"
#slope = 2.56
#offset = 67.36
#unit = "N/m"

#[gains.b_ad_gain]
#symbol = "d"
#slope = 3.32
#offset = 19.67
#unit = "kg/s"
#zero = 0

# Robots and packs that runs are made with, weighed and measured before the first run: files are compared with them.
#[robots.hopper]
#body_mass_kg = 1.8
#foot_mass_kg = 0.2
#link_1_m = 0.1
#link_2_m = 0.2
#rest_length_m = 0.27
#leg_min_m = 0.1
#leg_max_m = 0.3

#[batteries.A]
#cells = 4
#capacity_mah = 6600

#[instruments.charger]
#kind = "charger"
#make = "Junsi"
#model = "iCharger 406 Duo"
#serial = "0001"

# What one file may ask for at most, so that a damaged or hostile one cannot fill memory or disk.
#[files.limits]
#largest_file_bytes = 8589934592
#most_columns = 4096
#longest_line_bytes = 1048576
#largest_expanded_bytes = 2147483648
#largest_expansion = 200
#most_members = 200
#deepest_nesting = 2
#most_cells = 20000000

# What is decided about the analysis before the first run: the book keeps it, and the report calls exploratory whatever
# departs from it. Comparisons of the primary outcome are corrected over the family: each (level against the control) or
# pooled. Apexes within the bounds count as no loss of height. exclusions: for which reasons jumps may be left out.
# alternative "one-sided" asks only whether there is a saving, of the claims and of hypotheses alike.
#[analysis]
#primary_outcome = "joules"
#family = "pooled"
#alpha = 0.05
#alternative = "two-sided"
#apex_bounds_percent = [-3, 3]
#exclusions = ["touched_by_hand", "misfire", "sensor_fault", "wrong_apex", "dropped_packet"]
#contrasts = [{ kind = "trend" }]

# What the simulator predicts each condition with: the report shows it beside what was measured. `factors` says which
# parameter a factor's physical value is; parameters without a source are varied by this part, for the error. A scene of
# your own is a file beside this one: scene = "own.toml".
#[simulation]
#scene = "bed"
#varied_by = 0.1
#factors = { foot = "foot_radius", k_gain = "k_extension", b_ad_gain = "b_ad" }

# What you expect: `labbook compare` and the report say whether it holds (docs/hypotheses.md).
#[hypotheses.foot_of_control]
#text = "A jump of the control costs the same with either foot"
#claim = "same"
#side = "control"
#between = "foot"
#within_percent = 10

# What the thesis's studies are asked with, where the command line does not say it (docs/studies.md).
#[studies.compaction]
#grain_mm = 3.4

# Any logger, without programming: recognise lists columns that only its files have. Without a time column, leave the
# line "time" out and write rate_hz = 300.
#[profiles.serial_logger]
#recognise = ["time", "leftEncoder"]
#time = { column = "time", unit = "ms" }
#columns = { leftEncoder = { channel = "own.left_encoder", unit = "1" }, h = { channel = "body_height", unit = "mm" } }

# A database that several people share, and the folder that they all reach.
#[database]
#url = "postgresql+psycopg://labbook@server/labbook"

#[store]
#path = "/mnt/lab/mybook"
"""


def template(name: str, person: str, initials: str | None = None, time_zone: str = "UTC") -> str:
    """Write the configuration of a new book, ready to be read; `initials` default to the first letters of `person`.

    A name that cannot stand in a configuration (an odd folder's) becomes "study". Raises `UsageError` for a person
    whose name cannot.
    """
    if not is_plain(person):
        raise UsageError(f"{person!r} is not a name to sign with: give one such as --as 'Ada Nwosu'.")
    values = {
        "NAME": name if is_plain(name) else "study",
        "ZONE": time_zone,
        "PERSON": person,
        "INITIALS": initials or "".join(word[0] for word in person.split()).upper(),
    }
    lines = []
    for line in _TEMPLATE.split("\n"):
        words = [json.dumps(values[word], ensure_ascii=False) if word in values else word for word in line.split(" ")]
        lines.append(" ".join(words))
    return "\n".join(lines)
