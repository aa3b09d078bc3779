"""The real sample files beside the project, as a fresh book without declarations reads them."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from ingest.model import ColumnDeclaration, Declarations, Profile, ReadFile
from ingest.read import read_file
from tests.ingest.reading import rules, values

PROJECT = Path(__file__).parents[2]
SAMPLES = PROJECT.parent / "shared" / "samples"
EXPECTED = list(csv.DictReader((PROJECT / "tests" / "sample_expectations.csv").read_text().splitlines()))

pytestmark = pytest.mark.skipif(
    not SAMPLES.is_dir(), reason="the sample files lie beside the project: ../shared/samples"
)


def read(name: str, declared: Declarations | None = None) -> ReadFile:
    return read_file((SAMPLES / name).read_bytes(), declared or Declarations())


def test_every_sample_file_is_listed() -> None:
    present = {str(path.relative_to(SAMPLES)) for path in SAMPLES.rglob("*") if path.is_file()}
    assert {row["file"] for row in EXPECTED} == present


@pytest.mark.parametrize("row", EXPECTED, ids=lambda row: row["file"])
def test_sample_file_is_read_as_listed(row: dict[str, str]) -> None:
    result = read(row["file"])
    assert ("refused" if result.refused else "imported") == row["status"]
    assert result.format == row["format"]
    assert result.rows_kept == int(row["rows_kept"])
    if row["rule"]:
        assert row["rule"] in rules(result)
    if row["status"] == "refused":
        assert all(len(finding.message) > 40 for finding in result.findings if finding.severity == "file")


@pytest.mark.parametrize(
    ("name", "channel", "mah", "seconds", "volts"),
    [("LiPo[Storage_952_CH1].txt", 1, 464.0, 446.0, 23.268), ("LiPo[Storage_953_CH2].txt", 2, 582.0, 628.0, 23.314)],
)
def test_charger_log_gives_signals_and_one_recharge(
    name: str, channel: int, mah: float, seconds: float, volts: float
) -> None:
    result = read(f"charger/{name}")
    (part,) = result.parts
    assert part.part == f"channel_{channel}"
    assert part.rate_hz == pytest.approx(1.0)
    values = {data.name: data.values for data in part.channels}
    assert values["temperature_internal"][0] == pytest.approx(38.0)
    assert sum(name.startswith("cell_") for name in values) == 6
    (charge,) = result.charges
    assert charge.charge_mah == mah
    assert charge.duration_s == seconds
    assert charge.end_voltage_v == pytest.approx(volts)
    assert charge.mode == "charge"


LOGGER = Profile(
    "serial_logger",
    ("time", "leftMode", "rightMode"),
    time_column="time",
    time_unit="ms",
    columns={
        "voltage": ColumnDeclaration("battery_voltage", "mV"),
        "leftEncoder": ColumnDeclaration("left_encoder", "1"),
    },
)


@pytest.mark.parametrize(("name", "rows"), [("encoders6.csv", 972), ("batteryVoltage5.csv", 800)])
def test_robot_log_is_imported_with_a_declared_profile(name: str, rows: int) -> None:
    result = read(f"robot/{name}", Declarations(profiles=(LOGGER,)))
    assert not result.refused
    assert result.rows_kept == rows
    (part,) = result.parts
    assert part.rate_hz == pytest.approx(200.0, rel=0.01)
    assert part.start_original in ("39625 ms", "53370 ms")
    if "battery" in name:
        assert values(result)["battery_voltage"][0] == pytest.approx(7.879)


def test_opensim_ground_reactions_have_z_up() -> None:
    result = read("force/grf_run.mot")
    stored = values(result)
    assert result.parts[0].rate_hz == pytest.approx(300.0)
    assert (stored["force_z"].max(), stored["force_z_2"].max()) == pytest.approx((1751.20, 1623.05), abs=0.01)
    assert stored["force_y"].min() == pytest.approx(-26.128, abs=1e-3)  # written as 26.128 along z


def test_cortex_plates_have_z_up_and_metres() -> None:
    stored = values(read("force/walk1.forces"))
    loads = [stored[f"force_z_{plate}"].max() for plate in (3, 4, 5, 6)]
    assert loads == pytest.approx([836.15, 816.02, 802.34, 850.84])
    assert stored["cop_x_3"].max() == pytest.approx(1.75245)
    assert stored["free_moment_z_5"].max() == pytest.approx(19.20537)


def test_nexus_devices_are_counted_by_frame_and_sub_frame() -> None:
    result = read("force/analogs.csv")
    (part,) = result.parts
    assert (part.part, part.rate_hz, len(part.time_s), part.gaps) == ("devices", 2000.0, 11_600, ())
    assert values(result)["imported_analog_emg_voltage_1"][0] == pytest.approx(-0.0220516)
