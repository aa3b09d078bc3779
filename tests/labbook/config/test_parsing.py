"""labbook.toml: what it says is read, what it cannot say is refused, all faults at once."""

from __future__ import annotations

import hashlib
import re
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused, UsageError
from data_schema.vocabulary import FactorKind, ReasonCode, StudyKind
from ingest.model import DEFAULT_LIMITS, Limits
from labbook.config.model import Bounds, Configuration, Detector, GainSettings, Onset, ProfileColumn, TakeOff
from labbook.config.parsing import parse_configuration, template
from labbook.config.reading import json_schema
from labbook.config.run_names import RunNames
from stats.single_jump import ONSET, ONSETS, TAKE_OFF, TAKE_OFFS
from tests.helpers.wording import says

ACCEPTED_FOR = (ReasonCode.LOOKS_RIGHT, ReasonCode.WITH_THE_REST)
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
reject_reasons = ["sensor_fault", "misfire"]

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
columns = { leftEncoder = { channel = "own.left_encoder" }, h = { channel = "body_height", unit = "mm", sign = -1 } }

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

[sharing]
license = "CC-BY-4.0"

[privacy]
leave_out = ["people", "notes"]
"""

OPTIONAL = {
    *("grain_mm", "license", "leave_out"),
    *('unit = "1"', "control", "run_duration_s", "detector", "exclude_first_jumps", "exclude_gap_jumps"),
    *("onset", "take_off"),
    *("charger_resolution_mah", "idle_minutes", "zero", "make", "model", "serial", "time", "columns"),
    *("run_names", "checks", "reject_reasons", "most_columns", "control_name", "treatment"),
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
    of_study = study.name, study.kind, study.reference_voltage_v, study.jumps_nominal, study.time_zone
    assert of_study == ("granular bed", StudyKind.BED, 15.4, 25, "America/New_York")
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
    assert protocol.reject_reasons == ("sensor_fault", "misfire")
    assert configuration.gains["b_ad_gain"] == GainSettings("d", 3.32, 19.67, "kg/s", 0.0)
    assert configuration.robots["hopper"].rest_length_m == 0.27
    assert configuration.batteries["A"].capacity_mah == 6600.0
    assert configuration.instruments["charger"].model == "406 Duo"
    assert RunNames(study.run_names).name(47) == "LOG0047"
    assert configuration.files.limits == {"most_columns": 12}
    logger, untimed = configuration.profiles.values()
    assert (logger.recognise, logger.files) == (("time", "leftEncoder"), None)
    assert logger.settings == {"time_column": "time", "time_unit": "ms"}
    assert logger.columns["h"] == ProfileColumn(channel="body_height", unit="mm", sign=-1)
    assert logger.columns["leftEncoder"] == ProfileColumn(channel="own.left_encoder")
    assert (untimed.recognise, untimed.files, untimed.columns) == (("encoder",), "gait_*.txt", {})
    assert untimed.settings == {
        "rate_hz": 300.0, "encoding": "cp1250", "delimiter": "\t", "decimal_sign": ",", "header_row": 0,
        "units_row": 2, "first_row": 7, "comment": "%", "footer": "end", "date_format": "d.m.y",
        "clock_format": "m:s", "axes": "y up", "trials": "trial", "format": "delimited_log",
        "instrument": "bertec_acquire", "override_units": True, "complete": True, "no_robot_check": True,
    }  # fmt: skip
    assert configuration.database.url == "postgresql+psycopg://ada@server/labbook"
    assert configuration.store.path == "/mnt/lab/book"
    assert (configuration.text, configuration.sha256) == (SAMPLE, hashlib.sha256(SAMPLE.encode()).hexdigest())


def test_a_gain_is_converted_and_its_zero_is_nothing() -> None:
    gain = GainSettings("d", 3.32, 19.67, "kg/s", 0.0)
    assert gain.physical(0.0) == 0.0
    assert gain.physical(50.0) == 3.32 * 50.0 + 19.67
    assert GainSettings("k", 2.56, 67.36, "N/m", None).physical(0.0) == 67.36


def test_a_misspelt_key_or_table_is_refused_with_the_nearest() -> None:
    for line in KEY_LINES:
        key = line.split(" ")[0]
        message = refusal(SAMPLE.replace(f"\n{line}\n", f"\n{line.replace(key, key + 'x', 1)}\n", 1))
        assert says(message, repr(key + "x"), repr(key)), line
    for table in re.findall(r"(?m)^\[(\w+)", SAMPLE):
        assert says(refusal(re.sub(rf"(?m)^\[{table}\b", f"[{table}x", SAMPLE)), repr(table + "x"), repr(table))


def test_rules_of_single_jumps_are_those_that_are_known() -> None:
    protocol = parse_configuration(re.sub(r"(onset|take_off) = .*", "", SAMPLE), "labbook.toml").protocol
    assert (set(Onset), set(TakeOff)) == (set(ONSETS), set(TAKE_OFFS))
    assert (protocol.onset, protocol.take_off) == (ONSET, TAKE_OFF)


def test_all_reasons_are_offered_where_none_are_listed() -> None:
    protocol = parse_configuration(SAMPLE.replace("\nreject_reasons = ", "\n# "), "labbook.toml").protocol
    assert protocol.reject_reasons == tuple(reason for reason in ReasonCode if reason not in ACCEPTED_FOR)


def test_a_key_is_required_or_has_a_default() -> None:
    for line in KEY_LINES:
        key = line.split(" ")[0]
        without = SAMPLE.replace(f"\n{line}\n", "\n", 1)
        if key in OPTIONAL or line in OPTIONAL:
            parse_configuration(without, "labbook.toml")
        else:
            assert f".{key}: " in refusal(without), line


NOT_READ = [
    ('name = "granular bed"', 'name = " "', "study.name: ' '"),
    ('kind = "bed"', 'kind = "bedd"', "study.kind: 'bedd'", "'bed'"),
    ("= 15.4", '= "15.4"', "study.reference_voltage_v: '15.4'", "> 0"),
    ("jumps_nominal = 25", "jumps_nominal = 25.0", "study.jumps_nominal: 25.0", "whole"),
    ("radius_m = 0.038", "radius_m = true", "factors.foot.levels.small.radius_m: True"),
    ("[300, 400.0]", "[300, nan, '4']", "factors.k_gain.levels: nan"),
    ("run_duration_s = 720", "run_duration_s = 0", "protocol.run_duration_s: 0"),
    ('"published"', '"robus"', "protocol.detector: 'robus'", "'robust'"),
    ("exclude_first_jumps = 2", "exclude_first_jumps = -2", "protocol.exclude_first_jumps: -2"),
    ("exclude_gap_jumps = false", "exclude_gap_jumps = 0", "protocol.exclude_gap_jumps: 0", "true or false"),
    ("charger_resolution_mah = 1", "charger_resolution_mah = inf", "protocol.charger_resolution_mah: inf"),
    ("[20, 24.5]", "[20, 0]", "protocol.idle_minutes: 0"),
    ('"misfire"]', '"misfires"]', "protocol.reject_reasons: 'misfires'", "'misfire'"),
    ('"sensor_fault"', '"looks_right"', "protocol.reject_reasons: 'looks_right'", "'other'"),
    ("cells = 4", "cells = true", "batteries.A.cells: True"),
    ("capacity_mah = 6600", "capacity_mah = 1" + "0" * 400, "batteries.A.capacity_mah: 1000"),
    ('delimiter = "\\t"', 'delimiter = "ab"', "profiles.untimed.delimiter: 'ab'"),
    ("first_row = 7", "first_row = 401", "profiles.untimed.first_row: 401"),
    ("sign = -1", "sign = 2", "profiles.serial_logger.columns.h.sign: '2'", "'-1'"),
    ('"postgresql+psycopg://', '"mysql://', "database.url: 'mysql://ada@server/labbook'"),
    ('"Bo Lund"', '" Bo"', 'people." Bo": '),
    ("most_columns = 12", "most_colums = 12", "files.limits.most_colums", "'most_columns'"),
]
"""What one key cannot say."""
NOT_MEANT = [
    ("America/New_York", "America/New_Yrok", "study.time_zone: 'America/New_Yrok'", "'America/New_York'"),
    ('"Bo Lund" = "BL"', '"Bo Lund" = "AN"', 'people."Bo Lund": ', "'AN'"),
    ("[0, 50, 62.5]", "[0, 50, 50.0]", "factors.b_ad_gain.levels: '50'", "2 times"),
    ("control = 0", "control = 5", "factors.b_ad_gain.control: '5'", "'50'"),
    ("slope = 3.32", "slope = 0", "gains.b_ad_gain.slope: 0"),
    ("leg_min_m = 0.1", "leg_min_m = 0.4", "robots.hopper.leg_min_m: 0.4"),
    ("LOG{:04d}", "LOG", "study.run_names: 'LOG'"),
    ('"plate zeroed"', '"rail_angle"', "protocol.checks: 'rail_angle'"),
    ('"sensor_fault", "misfire"', '"misfire", "misfire"', "protocol.reject_reasons: 'misfire'", "2 times"),
    ('recognise = ["time", "leftEncoder"]', "recognise = []", "profiles.serial_logger.recognise: ", "`files`"),
    ('encoding = "cp1250"', 'encoding = "utf-16"', "profiles.untimed.encoding: 'utf-16'"),
    ('date = "d.m.y"', 'date = "dmy"', "profiles.untimed.date: 'dmy'"),
    ('axes = "y up"', 'axes = "y"', "profiles.untimed.axes: 'y'", "'y up'"),
    ('"own.left_encoder"', '"body_height"', "profiles.serial_logger.columns: 'body_height'"),
    ('"own.left_encoder"', '"left_encoder"', "serial_logger.columns.leftEncoder.channel: 'left_encoder'", "own."),
    ('unit = "mm"', 'unit = "kg"', "profiles.serial_logger.columns.h.unit: 'kg'"),
    ("rate_hz = 300", 'rate_hz = 300\ntime = { column = "t" }', "profiles.untimed.rate_hz: "),
    ("[studies.compaction]", "[studies.bed]", "studies.bed.grain_mm: 'grain_mm'"),
    ("[studies.compaction]", "[studies.compacting]", "studies.compacting: 'compacting'", "'compaction'"),
    ("America/New_York", "America", "'America'"),
    ("America/New_York", "/etc/passwd", "'/etc/passwd'"),
    ("LOG{:04d}", "{:02d}-{:02d}", "study.run_names"),
    ("LOG{:04d}", "LOG{0.__class__}", "study.run_names"),
    ("factors.k_gain", "factors.day", "factors.day: 'day'"),
    ("factors.k_gain", 'factors."k gain"', "'k gain'"),
    ("factors.k_gain", "factors.FOOT", "'FOOT'"),
    ("gains.b_ad_gain", "gains.b_add_gain", "'b_ad_gain'"),
    ("gains.b_ad_gain", "gains.foot", "'foot'", "number"),
    ('kind = "label"\n', 'kind = "number"\n', "factors.foot.levels: ", "numbers"),
    ("levels = [300, 400.0]", "levels = []", "factors.k_gain.levels: ", "[300, 400]"),
]
"""What keys cannot say together, or about what labbook does not know."""


@pytest.mark.parametrize(("old", "new", "facts"), [(old, new, facts) for old, new, *facts in NOT_READ + NOT_MEANT])
def test_each_fault_has_its_place_and_remedy(old: str, new: str, facts: list[str]) -> None:
    assert old in SAMPLE
    message = refusal(SAMPLE.replace(old, new, 1))
    assert says(message, *facts)
    assert message.endswith((".", "?"))


def test_faults_are_reported_at_once_one_a_line() -> None:
    for faults in (NOT_READ, NOT_MEANT[:14]):
        text = SAMPLE
        for old, new, *_ in faults:
            text = text.replace(old, new, 1)
        head, *lines = refusal(text).split("\n")
        assert f"{len(lines)} faults" in head
        assert len(lines) >= len(faults)
        for _old, _new, *facts in faults:
            assert any(all(fact in line for fact in facts) for line in lines), facts


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ("[study\nname = 1", ["TOML"]),
        ("x = " + "[" * 5000, ["labbook.toml"]),
        ("x = " + "9" * 5000, ["TOML"]),
        ("", ["study: ", "[study]"]),
        ("study = 3", ["study: 3", "[study]"]),
        (
            SAMPLE.replace('"CC-BY-4.0"', '"all rights, reserved"'),
            ["sharing.license", "all rights, reserved", "CC-BY-4.0"],
        ),
        (SAMPLE.replace('"notes"]', '"note"]'), ["privacy.leave_out", "'note'", "'notes'"]),
        (SAMPLE.replace("[batteries.A]\ncells = 4\ncapacity_mah = 6600", "[batteries]\nA = 3"), ["batteries.A: 3"]),
    ],
)
def test_what_cannot_be_read_is_refused(text: str, facts: list[str]) -> None:
    assert says(refusal(text), *facts)


def test_the_schema_knows_every_key() -> None:
    schema, sample = json_schema(Configuration), tomllib.loads(SAMPLE)
    assert set(schema["properties"]) == set(sample)
    of_study = schema["$defs"]["StudySettings"]
    assert set(of_study["properties"]) == set(sample["study"])
    assert of_study["additionalProperties"] is False
    assert "joules" in schema["$defs"]["Outcome"]["enum"]


def test_the_template_is_ready_to_be_read() -> None:
    configuration = parse_configuration(template("granular bed", "Ada Nwosu"), "labbook.toml")
    assert configuration.study.name == "granular bed"
    assert dict(configuration.people) == {"Ada Nwosu": "AN"}
    # No other lab's robot, pack or duration, by which files of this one would be refused.
    assert configuration.robots == configuration.batteries == configuration.factors == {}
    assert (configuration.protocol.run_duration_s, configuration.protocol.checks) == (None, ())
    # Nothing is decided, supposed or predicted yet.
    assert (configuration.analysis, configuration.hypotheses, configuration.simulation) == (None, {}, None)


def test_every_example_in_the_template_is_right() -> None:
    text = re.sub(r"(?m)^#(?! )", "", template("bed", "Ada Nwosu", "AdN", "Europe/Oslo"))
    configuration = parse_configuration(text, "labbook.toml")
    assert set(configuration.gains) < set(configuration.factors)
    assert configuration.analysis is not None
    assert configuration.analysis.apex_bounds == Bounds(-3.0, 3.0, percent=True)
    assert configuration.simulation is not None
    assert set(configuration.simulation.factors.values()) == {"foot_radius", "k_extension", "b_ad"}
    assert Limits(**configuration.files.limits) == DEFAULT_LIMITS
    assert (configuration.people["Ada Nwosu"], configuration.study.time_zone) == ("AdN", "Europe/Oslo")
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
