"""Text exports of force plates: one hop in every maker's layout comes out the same; all files synthetic."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from data_schema.errors import UsageError
from ingest.model import ColumnDeclaration, Declarations
from ingest.read import read_file
from tests.ingest import synthetic_plates as made
from tests.ingest.reading import read, rules, values

WRITERS: dict[str, tuple[Callable[[], bytes], float]] = {
    "opensim": (made.opensim, 300.0),
    "cortex_forces": (made.cortex, 450.0),
    "bioware": (made.bioware, 1000.0),
    "vicon_csv": (made.vicon, 1000.0),
    "forcedecks": (made.forcedecks, 500.0),
    "pasco": (made.pasco, 1000.0),
    "qualisys_tsv": (made.qualisys, 500.0),
    "amti_text": (made.amti, 100.0),
}
COUNTED = ("opensim", "cortex_forces", "bioware", "qualisys_tsv")
"""Formats whose header says how many samples there are."""


@pytest.mark.parametrize("name", WRITERS)
def test_every_maker_gives_the_same_hops(name: str) -> None:
    write, rate_hz = WRITERS[name]
    result = read(write())
    assert not result.refused, result.findings
    part = result.parts[0]
    assert (result.format, result.role) == (name, "force")
    assert part.rate_hz == pytest.approx(rate_hz, rel=1e-4)
    assert np.allclose(np.diff(part.time_s), 1 / rate_hz, rtol=0.02)
    stored, expected = values(part), made.plate(made.hops(len(part.time_s), rate_hz))
    assert np.allclose(stored["force_z"], expected["force_z"], atol=0.01)
    loaded = expected["force_z"] > 0
    for channel in expected.keys() & stored.keys():
        assert np.allclose(stored[channel][loaded], expected[channel][loaded], atol=0.01), channel
    units = {channel.name.removesuffix("_2"): channel.unit for channel in part.channels}
    assert all(units[channel] == "N" for channel in units if channel.startswith("force"))
    assert all(units[channel] == "m" for channel in units if channel.startswith("cop"))
    assert all(units[channel] == "N*m" for channel in units if "moment" in channel)


@pytest.mark.parametrize("name", COUNTED)
@pytest.mark.parametrize("share", [0.5, 0.9, 0.999])
def test_a_file_cut_short_is_refused(name: str, share: float) -> None:
    data = WRITERS[name][0]()
    assert read(data[: int(share * len(data))]).refused


@pytest.mark.parametrize("name", COUNTED)
def test_a_row_too_few_or_too_many_contradicts_the_header(name: str) -> None:
    lines = WRITERS[name][0]().splitlines(keepends=True)
    for changed in (lines[:-1], [*lines, lines[-1]]):
        result = read(b"".join(changed))
        assert result.refused
        assert rules(result) & {"sample_count_contradicts", "time_duplicate"}


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("opensim", b"version=1", b"version=9"),
        ("cortex_forces", b"NumberOfForcePlates=2", b"NumberOfForcePlates=3"),
        ("bioware", b"Version 5.", b"Version 3."),
        ("forcedecks", b"Export,1.0", b"Export,7.0"),
        ("qualisys_tsv", b"FREQUENCY\t500", b"FREQUENCY\t-"),
        ("vicon_csv", b"Frame,Sub Frame", b"Frames,Sub Frame"),
    ],
)
def test_a_layout_of_another_version_is_refused_with_a_way_in(name: str, old: bytes, new: bytes) -> None:
    data = WRITERS[name][0]()
    assert old in data
    result = read(data.replace(old, new))
    assert result.refused
    assert any("--format delimited_log" in finding.message for finding in result.findings)


def test_an_opensim_file_without_forces_is_a_log() -> None:
    rows = "\n".join(f"{n / 100:.2f}\t{n % 7}\t{n % 5}" for n in range(200))
    data = f"Coordinates\nversion=1\nnRows=200\nnColumns=3\ninDegrees=yes\nendheader\ntime\thip\tknee\n{rows}\n"
    result = read(data.encode())
    assert not result.refused
    assert (result.role, result.parts[0].part) == ("log", "log")


def test_cortex_asks_for_the_vertical_where_points_and_load_disagree() -> None:
    lifted = made.cortex().replace(b"\t0.00\t-50.00\t", b"\t40.00\t-50.00\t")
    assert "axes_unclear" in rules(read(lifted))
    stored = values(read(lifted, Declarations(axes="y up")).parts[0])
    assert stored["force_z"].max() == pytest.approx(made.LOAD_N, abs=0.5)


def test_bioware_tells_plates_apart_by_their_device_and_takes_no_reset_clock() -> None:
    # The first plate has its vertical force only: by counting names, Fx of the second would be the first's.
    lines = made.bioware().decode().split("\r\n")
    wide = next(index for index, line in enumerate(lines) if line.startswith("abs time"))
    cut = [0, 3, *range(10, 19)]
    kept = [
        "\t".join(line.split("\t")[k] for k in cut) if line.count("\t") == 18 or (index >= wide and line) else line
        for index, line in enumerate(lines)
    ]
    result = read("\r\n".join(kept).encode())
    assert not result.refused, result.findings
    stored = values(result.parts[0])
    assert {"force_z", "force_x_2", "force_z_2"} <= stored.keys()
    assert "force_x" not in stored
    assert result.parts[0].start_utc is None
    assert "clock_implausible" in rules(result)


def test_bioware_with_decimal_commas_and_without_the_unit_of_time() -> None:
    result = read(made.bioware(version="5.6.1.0", decimal=",").replace(b"abs time (s)", b"abs time"))
    assert not result.refused, result.findings
    assert result.parts[0].rate_hz == pytest.approx(1000.0)
    assert values(result.parts[0])["force_z"].max() == pytest.approx(made.LOAD_N, abs=0.5)


def normalised(load_n: float = made.LOAD_N, units: bytes = b"N") -> bytes:
    """A BioWare export with settings of normalisation, as they stand in exports that are not normalised, too."""
    data = made.bioware(load_n=load_n).replace(b"Normalized force (N):\t0", b"Normalized force (N):\t800.000000")
    data = data.replace(b"Normalized length (m):\t0", b"Normalized length (m):\t1.000000")
    return data.replace(b"\tN\tN\tN\tN", b"".join(b"\t" + units for _ in range(4)))


def test_normalisation_is_a_setting_of_bioware_that_a_unit_stands_against() -> None:
    result = read(normalised())
    assert not result.refused, result.findings
    for channel, column in values(read(made.bioware()).parts[0]).items():
        assert values(result.parts[0])[channel] == pytest.approx(column), channel


@pytest.mark.parametrize(
    ("data", "unit"),
    [(normalised(units=b""), "N"), (normalised(load_n=3.0), "N"), (normalised(load_n=3.0, units=b""), "kN")],
    ids=["no unit", "three weights called newtons", "three weights"],
)
def test_body_weights_are_no_newtons_unless_they_are_declared(data: bytes, unit: str) -> None:
    result = read(data)
    assert result.refused
    assert "values_normalised" in rules(result)
    said = {f"F{axis}": ColumnDeclaration(unit=unit) for axis in "xyz"}
    assert not read(data, Declarations(columns=said)).refused


@pytest.mark.parametrize(
    ("data", "rate_hz"),
    [
        (made.bioware().replace(b"1000.000000", b"500.000000"), None),
        (made.forcedecks().replace(b"Frequency,500", b"Frequency,1000"), None),
        (made.vicon().replace(b"\r\n100,,", b"\r\n200,,"), None),
        (made.amti(), 1000.0),
    ],
    ids=["BioWare", "ForceDecks", "two sections of Nexus", "declared against NetForce"],
)
def test_a_rate_that_contradicts_the_time_or_the_header_is_refused(data: bytes, rate_hz: float | None) -> None:
    result = read(data, Declarations(rate_hz=rate_hz))
    assert result.refused
    assert "rate_contradicts" in rules(result)


@pytest.mark.parametrize("padded", [True, False])
def test_every_section_of_nexus_is_a_part_at_its_own_rate(padded: bool) -> None:
    result = read(made.vicon(padded=padded))
    assert not result.refused, result.findings
    assert [(part.part, part.rate_hz) for part in result.parts] == [("devices", 1000.0), ("trajectories", 100.0)]
    marker = values(result.parts[1])
    assert {"robot_hip_z", "robot_toe_z"} <= marker.keys()
    assert marker["robot_hip_z"][:3] == pytest.approx([401, 402, 403])
    assert result.rows_kept == 1100


@pytest.mark.parametrize("sign", [b"\t", b";"])
def test_nexus_between_tabs_or_semicolons_is_read_as_between_commas(sign: bytes) -> None:
    """It was said to have not five header lines, which it had."""
    data = made.vicon(n=200)
    commas, others = (read_file(each, Declarations()) for each in (data, data.replace(b",", sign)))
    assert not others.refused
    for part, other in zip(commas.parts, others.parts, strict=True):
        for channel, same in zip(part.channels, other.channels, strict=True):
            assert (channel.name, channel.values.tolist()) == (same.name, same.values.tolist())


def test_a_frame_that_nexus_left_out_is_a_gap() -> None:
    lines = made.vicon().splitlines(keepends=True)
    part = read(b"".join(line for line in lines if not line.startswith(b"7,"))).parts[0]
    (gap,) = part.gaps
    assert (gap.samples_missing, gap.start_s) == (10, pytest.approx(0.059))


def test_a_last_frame_without_all_its_samples_is_a_file_cut_short() -> None:
    lines = made.vicon().splitlines(keepends=True)
    end = next(index for index, line in enumerate(lines) if line.startswith(b"100,9,"))
    result = read(b"".join(lines[:end]))
    assert result.refused
    assert "frame_incomplete" in rules(result)


def test_sections_of_one_trial_must_agree() -> None:
    lines = made.vicon().splitlines(keepends=True)
    assert "frames_contradict" in rules(read(b"".join(lines[:-5])))
    disordered = [*lines[:20], *lines[30:40], *lines[20:30], *lines[40:]]
    assert "frames_disordered" in rules(read(b"".join(disordered)))


def test_the_tare_of_forcedecks_is_not_taken_off_again() -> None:
    for version in ("1.0", "2.0"):
        result = read(made.forcedecks(version=version), Declarations(time_zone="UTC"))
        (part,) = result.parts
        stored = values(part)
        assert stored.keys() == {"force_z", "force_z_2"}
        assert (stored["force_z"] + stored["force_z_2"]).max() == pytest.approx(2 * made.LOAD_N, rel=0.01)
        assert part.start_utc == "2026-03-02T10:11:12.123456Z"
        assert "tare_applied" in rules(result)


def test_runs_side_by_side_are_parts_of_their_own_length() -> None:
    result = read(made.pasco())
    assert [(part.part, len(part.time_s)) for part in result.parts] == [("run_1", 1000), ("run_2", 600)]
    for part in result.parts:
        assert part.rate_hz == pytest.approx(1000.0)
        assert values(part)["force_beam_1"].max() == pytest.approx(15.0, abs=0.1)
        assert part.start_original in ("0 s", "02/03/2026 10:11")
    assert "value_missing" not in rules(result)
    assert result.rows_kept == 1600


@pytest.mark.parametrize("up", ["z up", "z down"])
def test_qualisys_is_read_with_or_without_names_and_times(up: str) -> None:
    named = "\t".join(["SAMPLE", "TIME", *(f"Force_{axis}" for axis in "XYZ"), *"MMM", "COP_X", "COP_Y", "COP_Z"])
    lines = made.qualisys(up=up).decode().split("\r\n")
    with_names = "\r\n".join([*lines[:26], named, *lines[26:]]).encode()
    plain = values(read(made.qualisys(up=up)))
    for data in (made.qualisys(up=up, longer=False), with_names):
        result = read(data)
        assert result.parts[0].rate_hz == pytest.approx(500.0)
        for name in ("force_x", "force_z", "moment_z", "cop_x"):
            assert np.allclose(values(result)[name], plain[name]), name


def test_qualisys_without_corners_asks_which_axis_is_vertical() -> None:
    lines = made.qualisys().split(b"\r\n")
    data = b"\r\n".join(line for line in lines if b"CORNER" not in line)
    assert "axes_unclear" in rules(read(data))
    assert not read(data, Declarations(axes="z down")).refused


def test_netforce_without_a_header_is_read_once_instrument_and_rate_are_said() -> None:
    data = made.amti(header=False)
    assert read(data).refused
    assert "rate_missing" in rules(read(data, Declarations(instrument="amti")))
    result = read(data, Declarations(instrument="amti", rate_hz=100.0))
    assert (result.format, result.refused) == ("amti_text", False)
    assert {"force_z", "moment_y_2"} <= values(result.parts[0]).keys()


GAIT_UNITS = {
    **{f"F{axis}": ColumnDeclaration(f"force_{axis}", "N") for axis in "xyz"},
    **{f"COP{axis}": ColumnDeclaration(f"cop_{axis}", "mm") for axis in "xyz"},
    "My": ColumnDeclaration("free_moment_y", "N*mm"),
}


def gait(n: int = 400, rate_hz: float = 150.0) -> bytes:
    """A table of one plate with y up and no units, as laboratories of gait keep them."""
    stored = made.plate(made.hops(n, rate_hz))
    data = [np.arange(n) / rate_hz, *made.y_up(stored, "force")]
    data += [1000 * values for values in (*made.y_up(stored, "cop"), stored["free_moment_z"])]
    return "\n".join(["Time\tFx\tFy\tFz\tCOPx\tCOPy\tCOPz\tMy", *made.table(data), ""]).encode()


def test_a_table_with_y_up_is_never_read_as_if_z_were() -> None:
    # Read with z up it would have had sideways forces of 3 N for the load of 60 N, and a note.
    assert rules(read(gait())) >= {"time_unit_missing", "unit_missing", "axes_contradict"}
    assert "axes_contradict" in rules(read(gait(), Declarations(time_unit="s", columns=GAIT_UNITS)))
    result = read(gait(), Declarations(time_unit="s", columns=GAIT_UNITS, axes="y up"))
    assert not result.refused, result.findings
    stored, expected = values(result.parts[0]), made.plate(made.hops(400, 150.0))
    for name in ("force_x", "force_y", "force_z", "cop_x", "cop_y", "cop_z", "free_moment_z"):
        assert np.allclose(stored[name], expected[name], atol=1e-3), name
    force = next(channel for channel in result.parts[0].channels if channel.name == "force_y")
    assert (force.source_name, force.sign, force.assumed) == ("Fz", -1, ("y up: declared",))


@pytest.mark.parametrize(
    ("header", "columns"),
    [
        ("", {"1": ColumnDeclaration("force_z", "N"), "2": ColumnDeclaration("force_z_2", "N")}),
        ("fp1,fp2", {"fp1": ColumnDeclaration("force_z", "N"), "fp2": ColumnDeclaration("force_z_2", "N")}),
        ("#Sample,GRFv", {"GRFv": ColumnDeclaration(unit="N")}),
        ("# vertical ground reaction\n#Sample,GRFv", {"GRFv": ColumnDeclaration(unit="N")}),
    ],
)
def test_bare_columns_are_read_once_rate_and_units_are_said(header: str, columns: dict[str, ColumnDeclaration]) -> None:
    fz = made.hops(600, 600.0)
    first = np.arange(1, 601) if "Sample" in header else fz
    rows = [f"{a:.0f},{b:.3f}" if "Sample" in header else f"{a:.3f},{b:.3f}" for a, b in zip(first, fz, strict=True)]
    data = "\n".join([*([header] if header else []), *rows, ""]).encode()
    assert rules(read(data)) & {"rate_missing", "header_missing"}
    assert read(data, Declarations(columns=columns)).refused
    result = read(data, Declarations(columns=columns, rate_hz=600.0))
    assert not result.refused, result.findings
    assert values(result.parts[0])["force_z"] == pytest.approx(fz, abs=1e-3)
    assert result.parts[0].rate_hz == 600.0


def test_raw_amplifier_channels_are_said_to_be_no_forces() -> None:
    rows = [
        f"{n / 100:.6f}\t" + "\t".join(f"{0.01 * (n % 7) + channel:.6f}" for channel in range(8)) for n in range(300)
    ]
    result = read("\n".join(["Time (s)\t" + "\t".join(f"Channel {n}" for n in range(8)), *rows, ""]).encode())
    assert (result.format, result.role, result.refused) == ("kistler_channels", "log", False)
    assert "raw_channels" in rules(result)
    assert {channel.unit for channel in result.parts[0].channels} == {None}


def test_a_last_number_that_may_go_on_is_not_taken() -> None:
    whole = made.opensim().decode().replace(".00000000", "")
    assert not read(whole.encode()).refused
    result = read(whole.encode().rstrip())
    assert {"last_line_cut", "sample_count_contradicts"} <= rules(result)
    assert not read(whole.encode().rstrip(), Declarations(complete=True)).refused


@pytest.mark.parametrize("rate", [b"1,000", b"45 0", b"-450", b"0", b"4500000000 kHz"])
def test_a_rate_that_is_no_plain_number_is_never_half_read(rate: bytes) -> None:
    result = read(made.cortex().replace(b"SampleRate=450.000000", b"SampleRate=" + rate))
    assert result.refused
    assert "layout_unknown" in rules(result)


def test_a_plate_that_carries_little_has_the_sign_of_its_maker() -> None:
    for data in (made.amti(load_n=9.0), made.qualisys(load_n=9.0)):
        result = read(data)
        assert "force_sign_flipped" not in rules(result)
        assert values(result.parts[0])["force_z"].max() == pytest.approx(9.0, abs=0.5)


def test_zeros_of_an_unloaded_plate_are_no_held_sensor() -> None:
    assert "channel_held" not in rules(read(made.forcedecks()))


def test_an_unknown_frame_is_refused_with_the_nearest() -> None:
    with pytest.raises(UsageError, match="y up"):
        read(made.opensim(), Declarations(axes="y upp"))


def test_a_centre_of_pressure_with_a_unit_is_not_fitted_to_the_moments() -> None:
    # Written in mm of the laboratory, far from the plate's middle: it stays, and is said to disagree.
    lines = made.vicon().decode().split("\r\n")
    moved = [line.replace(",100.0000,50.0000,", ",-100.0000,50.0000,") for line in lines]
    result = read("\r\n".join(moved).encode())
    stored = values(result.parts[0])
    assert stored["cop_x"][:100] == pytest.approx(-0.1)
    assert "cop_disagrees" in rules(result)


def test_a_comma_that_may_be_a_thousand_is_asked_about() -> None:
    rows = [f'"{n},{500 + n % 7}","{2 + n % 5},{100 + n % 9}"' for n in range(1, 300)]
    data = "\r\n".join(["Run #1,Run #1", "Time (s),Normal Force (N)", *rows, ""]).encode()
    assert "decimal_sign_unclear" in rules(read(data))
    assert "decimal_sign_unclear" not in rules(read(data, Declarations(decimal_sign=",")))


def test_a_first_row_that_is_damaged_is_no_line_of_the_header() -> None:
    lines = made.amti().split(b"\r\n")
    lines[4] = lines[4].replace(b",", b";", 1)
    assert read(b"\r\n".join(lines)).refused
