"""labbook.toml: what it says is read, what it cannot say is refused, all faults at once."""

from __future__ import annotations

import hashlib
import re
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused, UsageError
from data_schema.vocabulary import FactorKind, StudyKind
from ingest.model import DEFAULT_LIMITS, Limits
from labbook.config.model import Detector, GainSettings, Onset, ProfileColumn, TakeOff
from labbook.config.parsing import parse_configuration, template
from stats.single_jump import ONSET, ONSETS, TAKE_OFF, TAKE_OFFS

SAMPLE = r"""
[study]
name = "granular bed"
kind = "bed"
reference_voltage_v = 15.4
jumps_nominal = 25
time_zone = "America/New_York"
run_names = "LOG{:04d}"

[people]
"Ada Nwosu" = "AN"
"Bo Lund" = "BL"

[factors.foot]
kind = "label"
levels = { small = { radius_m = 0.038 }, large = { radius_m = 0.051, material = "acrylic" } }

[factors.k_gain]
kind = "number"
unit = "1"
levels = [300, 400.0]

[factors.b_ad_gain]
kind = "number"
levels = [0, 50, 62.5]
control = 0
control_name = "CE"
treatment = "active damping"

[protocol]
run_duration_s = 720
detector = "published"
exclude_first_jumps = 2
exclude_gap_jumps = false
onset = "10_percent"
take_off = "50n"
charger_resolution_mah = 1
idle_minutes = [20, 24.5]
checks = ["rail_angle", "plate zeroed"]

[simulation]
scene = "bed"
factors = { foot = "foot_radius", b_ad_gain = "b_ad" }

[analysis]
primary_outcome = "joules"
alpha = 0.05

[hypotheses.saves]
text = "Active damping saves"
claim = "saves"

[gains.b_ad_gain]
symbol = "d"
slope = 3.32
offset = 19.67
unit = "kg/s"
zero = 0

[robots.hopper]
body_mass_kg = 1.8
foot_mass_kg = 0.2
link_1_m = 0.1
link_2_m = 0.2
rest_length_m = 0.27
leg_min_m = 0.1
leg_max_m = 0.3

[batteries.A]
cells = 4
capacity_mah = 6600

[instruments.charger]
kind = "charger"
make = "Junsi"
model = "406 Duo"
serial = "0001"

[files.limits]
most_columns = 12

[profiles.serial_logger]
recognise = ["time", "leftEncoder"]
time = { column = "time", unit = "ms" }
columns = { "leftEncoder" = { channel = "left_encoder" }, "h" = { channel = "body_height", unit = "mm", sign = -1 } }

[profiles.untimed]
recognise = ["encoder"]
files = "gait_*.txt"
rate_hz = 300
encoding = "cp1250"
delimiter = "\t"
decimal = ","
header_row = 0
units_row = 2
first_row = 7
comment = "%"
footer = "end"
date = "d.m.y"
clock = "m:s"
axes = "y up"
trials = "trial"
format = "delimited_log"
instrument = "bertec_acquire"
override_units = true
complete = true
no_robot_check = true

[studies.compaction]
grain_mm = 3.4

[database]
url = "postgresql+psycopg://ada@server/labbook"

[store]
path = "/mnt/lab/book"
"""

OPTIONAL = {
    "grain_mm",
    *('unit = "1"', "control", "run_duration_s", "detector", "exclude_first_jumps", "exclude_gap_jumps"),
    *("onset", "take_off"),
    *("charger_resolution_mah", "idle_minutes", "zero", "make", "model", "serial", "time", "columns"),
    *("run_names", "checks", "most_columns", "control_name", "treatment"),
    *("encoding", "delimiter", "decimal", "header_row", "units_row", "first_row", "comment", "footer", "date", "clock"),
    *("axes", "trials", "format", "instrument", "files", 'recognise = ["encoder"]'),
    *("override_units", "complete", "no_robot_check"),
    *("rate_hz", "url", "path", "factors", "primary_outcome", "alpha"),
}
KEY_LINES = [line for line in SAMPLE.splitlines() if re.match(r"[a-z_0-9]+ = ", line)]


def refusal(text: str) -> str:
    with pytest.raises(InputRefused) as caught:
        parse_configuration(text, "labbook.toml")
    return str(caught.value)


def test_everything_is_read() -> None:
    configuration = parse_configuration(SAMPLE, "labbook.toml")
    study = configuration.study
    assert (study.name, study.kind, study.reference_voltage_v) == ("granular bed", StudyKind.BED, 15.4)
    assert (study.jumps_nominal, study.time_zone) == (25, "America/New_York")
    assert dict(configuration.people) == {"Ada Nwosu": "AN", "Bo Lund": "BL"}
    assert list(configuration.factors) == ["foot", "k_gain", "b_ad_gain"]
    foot, k_gain, b_ad_gain = configuration.factors.values()
    assert (foot.kind, [level.label for level in foot.levels]) == (FactorKind.LABEL, ["small", "large"])
    assert foot.levels[1].attributes == {"radius_m": 0.051, "material": "acrylic"}
    assert [(level.label, level.value) for level in k_gain.levels] == [("300", 300.0), ("400", 400.0)]
    assert (k_gain.unit, k_gain.control) == ("1", None)
    assert ([level.label for level in b_ad_gain.levels], b_ad_gain.control) == (["0", "50", "62.5"], "0")
    assert (b_ad_gain.control_name, b_ad_gain.treatment) == ("CE", "active damping")
    protocol = configuration.protocol
    assert (protocol.run_duration_s, protocol.detector) == (720.0, Detector.PUBLISHED)
    assert (protocol.exclude_first_jumps, protocol.exclude_gap_jumps) == (2, False)
    assert (protocol.onset, protocol.take_off) == ("10_percent", "50n")
    assert (protocol.charger_resolution_mah, protocol.idle_minutes) == (1.0, (20.0, 24.5))
    assert protocol.checks == ("rail_angle", "plate zeroed")
    assert configuration.gains["b_ad_gain"] == GainSettings("d", 3.32, 19.67, "kg/s", 0.0)
    assert configuration.robots["hopper"].rest_length_m == 0.27
    assert configuration.batteries["A"].capacity_mah == 6600.0
    assert configuration.instruments["charger"].model == "406 Duo"
    assert study.run_names.name(47) == "LOG0047"
    assert configuration.files.limits == {"most_columns": 12}
    logger, untimed = configuration.profiles.values()
    assert (logger.recognise, logger.files) == (("time", "leftEncoder"), None)
    assert logger.settings == {"time_column": "time", "time_unit": "ms"}
    assert logger.columns["h"] == ProfileColumn("body_height", "mm", -1)
    assert logger.columns["leftEncoder"] == ProfileColumn("left_encoder", None, None)
    assert (untimed.recognise, untimed.files, untimed.columns) == (("encoder",), "gait_*.txt", {})
    assert untimed.settings == {
        "rate_hz": 300.0, "encoding": "cp1250", "delimiter": "\t", "decimal_sign": ",", "header_row": 0,
        "units_row": 2, "first_row": 7, "comment": "%", "footer": "end", "date_format": "d.m.y",
        "clock_format": "m:s", "axes": "y up", "trials": "trial", "format": "delimited_log",
        "instrument": "bertec_acquire", "override_units": True, "complete": True, "no_robot_check": True,
    }  # fmt: skip
    assert configuration.database_url == "postgresql+psycopg://ada@server/labbook"
    assert configuration.store_path == "/mnt/lab/book"
    assert (configuration.text, configuration.sha256) == (SAMPLE, hashlib.sha256(SAMPLE.encode()).hexdigest())


def test_a_gain_is_converted_and_its_zero_is_nothing() -> None:
    gain = GainSettings("d", 3.32, 19.67, "kg/s", 0.0)
    assert gain.physical(0.0) == 0.0
    assert gain.physical(50.0) == 3.32 * 50.0 + 19.67
    assert GainSettings("k", 2.56, 67.36, "N/m", None).physical(0.0) == 67.36


@pytest.mark.parametrize("line", KEY_LINES)
def test_a_misspelt_key_is_refused_with_the_nearest(line: str) -> None:
    key = line.split(" ")[0]
    message = refusal(SAMPLE.replace(f"\n{line}\n", f"\n{line.replace(key, key + 'x', 1)}\n", 1))
    assert f"{key + 'x'!r} is not" in message
    assert f"mean {key!r}?" in message


@pytest.mark.parametrize("table", re.findall(r"(?m)^\[(\w+)", SAMPLE))
def test_a_misspelt_table_is_refused_with_the_nearest(table: str) -> None:
    message = refusal(re.sub(rf"(?m)^\[{table}\b", f"[{table}x", SAMPLE))
    assert f"{table + 'x'!r} is not" in message
    assert f"mean {table!r}?" in message


def test_rules_of_single_jumps_are_those_that_are_known() -> None:
    protocol = parse_configuration(re.sub(r"(onset|take_off) = .*", "", SAMPLE), "labbook.toml").protocol
    assert (set(Onset), set(TakeOff)) == (set(ONSETS), set(TAKE_OFFS))
    assert (protocol.onset, protocol.take_off) == (ONSET, TAKE_OFF)


@pytest.mark.parametrize("line", KEY_LINES)
def test_a_key_is_required_or_has_a_default(line: str) -> None:
    key = line.split(" ")[0]
    without = SAMPLE.replace(f"\n{line}\n", "\n", 1)
    if key in OPTIONAL or line in OPTIONAL:
        parse_configuration(without, "labbook.toml")
    else:
        assert f".{key}: " in refusal(without)


FAULTS = [
    ('name = "granular bed"', 'name = " "', "study.name: ' ' is not a text, or empty"),
    ('kind = "bed"', 'kind = "bedd"', "study.kind: 'bedd' is not a known kind: did you mean 'bed'?"),
    ("= 15.4", '= "15.4"', "study.reference_voltage_v: '15.4' is not a number greater than 0"),
    ("jumps_nominal = 25", "jumps_nominal = 25.0", "study.jumps_nominal: 25.0 is not a whole number of 1 or more"),
    ("America/New_York", "America/New_Yrok", "study.time_zone: 'America/New_Yrok' is not a known time zone: did you"),
    ('"Bo Lund" = "BL"', '"Bo Lund" = "AN"', "people.Bo Lund: the initials 'AN' also stand for someone else"),
    ("radius_m = 0.038", "radius_m = true", "factors.foot.levels.small.radius_m: True is not a text"),
    ("[300, 400.0]", "[300, nan, '4']", "factors.k_gain.levels: nan is not a number"),
    ("[0, 50, 62.5]", "[0, 50, 50.0]", "factors.b_ad_gain.levels: '50' is there 2 times"),
    ("control = 0", "control = 5", "factors.b_ad_gain.control: '5' is not a known level: did you mean '50'?"),
    ("run_duration_s = 720", "run_duration_s = 0", "protocol.run_duration_s: 0 is not a number greater than 0"),
    ('"published"', '"robus"', "protocol.detector: 'robus' is not a known detector: did you mean 'robust'?"),
    ("exclude_first_jumps = 2", "exclude_first_jumps = -2", "protocol.exclude_first_jumps: -2 is not a whole number"),
    ("exclude_gap_jumps = false", "exclude_gap_jumps = 0", "protocol.exclude_gap_jumps: 0 is neither true nor false"),
    ("charger_resolution_mah = 1", "charger_resolution_mah = inf", "protocol.charger_resolution_mah: inf is not a"),
    ("[20, 24.5]", "[20, 0]", "protocol.idle_minutes: 0 is not a time in minutes"),
    ("slope = 3.32", "slope = 0", "gains.b_ad_gain.slope: 0 makes every gain the same"),
    ("leg_min_m = 0.1", "leg_min_m = 0.4", "robots.hopper.leg_min_m: 0.4 is not less than leg_max_m"),
    ("cells = 4", "cells = true", "batteries.A.cells: True is not a whole number of 1 or more"),
    ("LOG{:04d}", "LOG", "study.run_names: 'LOG' does not say how runs are numbered"),
    ('"plate zeroed"', '"rail_angle"', "protocol.checks: 'rail_angle' is no name of a check, or there twice"),
    ('recognise = ["time", "leftEncoder"]', "recognise = []", "profiles.serial_logger.recognise: names no column"),
    ('encoding = "cp1250"', 'encoding = "utf-16"', "profiles.untimed.encoding: 'utf-16' does not hold plain letters"),
    ('delimiter = "\\t"', 'delimiter = "ab"', "profiles.untimed.delimiter: 'ab' cannot part cells"),
    ("first_row = 7", "first_row = 401", "profiles.untimed.first_row: 401 is beyond line 400"),
    ('date = "d.m.y"', 'date = "dmy"', "profiles.untimed.date: 'dmy' is not a known date: "),
    ('axes = "y up"', 'axes = "y"', "profiles.untimed.axes: 'y' is not a known axes: allowed are 'y up'"),
    ('files = "gait_*.txt"', f'files = "{"g" * 201}"', "profiles.untimed.files: has 201 letters"),
    ("sign = -1", "sign = 2", "profiles.serial_logger.columns.h.sign: 2 is no sign"),
    ('"left_encoder"', '"body_height"', "profiles.serial_logger.columns: 'body_height' is the channel of several"),
    (
        "rate_hz = 300",
        'rate_hz = 300\ntime = { column = "t" }',
        "profiles.untimed.rate_hz: stands beside a time column",
    ),
    (
        '"postgresql+psycopg://',
        '"mysql://',
        "database.url: 'mysql://ada@server/labbook' is no address of a PostgreSQL",
    ),
]


@pytest.mark.parametrize(("old", "new", "words"), FAULTS)
def test_each_fault_has_its_place_and_remedy(old: str, new: str, words: str) -> None:
    message = refusal(SAMPLE.replace(old, new, 1))
    assert words in message
    assert message.endswith((".", "?"))


def test_a_voltage_that_no_pack_has_is_refused() -> None:
    told = refusal(SAMPLE.replace("= 15.4", "= 15400", 1))
    assert "study.reference_voltage_v: 15400 is not a number greater than 0, 1000 at most" in told


def test_all_faults_are_reported_at_once_one_a_line() -> None:
    text = SAMPLE
    for old, new, _ in FAULTS:
        text = text.replace(old, new, 1)
    message = refusal(text)
    for _, _, words in FAULTS:
        assert words in message
    lines = message.split("\n")
    assert lines[0].startswith(f"labbook.toml has {len(lines) - 1} faults")
    assert all(line.startswith("  ") and line.endswith((".", "?")) for line in lines[1:])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[study\nname = 1", "not TOML"),
        ("x = " + "[" * 5000, "TOML|deep"),
        ("x = " + "9" * 5000, "not TOML"),
        ("", "study: is missing: write \\[study\\]"),
        ("study = 3", "study: 3 is not a table"),
        (SAMPLE.replace("[files.limits]", "[people]\n[files.limits]"), "not TOML"),
        (SAMPLE.replace("America/New_York", "America"), "'America' is not a known time zone"),
        (SAMPLE.replace("America/New_York", "/etc/passwd"), "'/etc/passwd' is not a known time zone"),
        (SAMPLE.replace("LOG{:04d}", "{:02d}-{:02d}"), "does not say how runs are numbered"),
        (SAMPLE.replace("LOG{:04d}", "LOG{0.__class__}"), "does not say how runs are numbered"),
        (SAMPLE.replace("factors.k_gain", "factors.day"), "'day' is no name for a factor"),
        (SAMPLE.replace("factors.k_gain", 'factors."k gain"'), "'k gain' is no name for a factor"),
        (SAMPLE.replace("factors.k_gain", "factors.FOOT"), "'FOOT' is no name for a factor, or is taken"),
        (SAMPLE.replace("gains.b_ad_gain", "gains.b_add_gain"), "did you mean 'b_ad_gain'"),
        (SAMPLE.replace("gains.b_ad_gain", "gains.foot"), "'foot' is not a known factor of kind number"),
        (SAMPLE.replace('kind = "label"\n', 'kind = "number"\n'), "is not a list: write numbers"),
        (SAMPLE.replace("levels = [300, 400.0]", "levels = []"), "there are none: write for example"),
        (SAMPLE.replace('"Ada Nwosu"', '" Ada"'), "a name is not empty, padded"),
        (SAMPLE.replace("cells = 4", "cells = 9223372036854775808"), "not a whole number"),
        (
            SAMPLE.replace("[batteries.A]\ncells = 4\ncapacity_mah = 6600", "[batteries]\nA = 3"),
            "batteries.A: 3 is not a",
        ),
        (SAMPLE.replace("capacity_mah = 6600", "capacity_mah = 1" + "0" * 400), "is not a number greater than 0"),
    ],
)
def test_what_cannot_be_read_is_refused(text: str, words: str) -> None:
    assert re.search(words, refusal(text))


def test_the_template_is_ready_to_be_read() -> None:
    configuration = parse_configuration(template("granular bed", "Ada Nwosu"), "labbook.toml")
    assert configuration.study.name == "granular bed"
    assert dict(configuration.people) == {"Ada Nwosu": "AN"}
    # No other lab's robot, pack or duration, by which files of this one would be refused.
    assert configuration.robots == configuration.batteries == configuration.factors == {}
    assert (configuration.protocol.run_duration_s, configuration.protocol.checks) == (None, ())
    assert configuration.database_url is None


def test_every_example_in_the_template_is_right() -> None:
    text = re.sub(r"(?m)^#(?! )", "", template("bed", "Ada Nwosu", "AdN", "Europe/Oslo"))
    configuration = parse_configuration(text, "labbook.toml")
    assert set(configuration.gains) < set(configuration.factors)
    assert configuration.profiles
    assert configuration.instruments
    assert Limits(**configuration.files.limits) == DEFAULT_LIMITS
    assert configuration.people["Ada Nwosu"] == "AdN"
    assert configuration.study.time_zone == "Europe/Oslo"
    assert set(tomllib.loads(text)) == set(tomllib.loads(SAMPLE))  # it shows every table that there is


plain = st.text("aZ ø砂\"'\\#=[]{}\x7f\t\n", min_size=1, max_size=12)


@given(plain, plain)
def test_any_name_survives_the_template(name: str, person: str) -> None:
    if person != person.strip() or re.search(r"[\x00-\x1f\x7f]", person):
        with pytest.raises(UsageError, match="is not a name to sign with"):
            template(name, person)
        return
    configuration = parse_configuration(template(name, person), "labbook.toml")
    assert list(configuration.people) == [person]
    good = name == name.strip() and not re.search(r"[\x00-\x1f\x7f]", name)
    assert configuration.study.name == (name if good else "study")
