"""From header cells to channels: names, units, declarations, profiles."""

from __future__ import annotations

import shlex

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.vocabulary import CHANNELS
from ingest.channels.names import channel_kind, channel_of, parse_header
from ingest.declared import flag_names, positions_of
from ingest.model import ChannelData, ColumnDeclaration, Declarations, ReadFile
from ingest.read import read_file
from tests.helpers.wording import says
from tests.ingest.reading import finding, refusal, rules
from tests.ingest.synthetic import text


def log(header: str, value: str = "0.25", n: int = 50) -> bytes:
    return text(f"time [ms],{header}", [f"{3 * k},{value}" for k in range(n)])


def read(header: str, value: str = "0.25", declared: Declarations | None = None) -> ReadFile:
    return read_file(log(header, value), declared or Declarations())


def channel(result: ReadFile) -> ChannelData:
    assert not result.refused, result.findings
    return result.parts[0].channels[0]


def test_the_end_of_a_name_is_no_unit_of_another_quantity() -> None:
    assert refusal(read("v_in")).rule == "unit_missing"
    assert channel(read("battery")).name == "battery"


@pytest.mark.parametrize(
    ("header", "name", "unit", "stored"),
    [
        ("height [cm]", "body_height", "cm", 0.0025),
        ("height (mm)", "body_height", "mm", 0.00025),
        ("height_mm", "body_height", "mm", 0.00025),
        ("Body Height / mm", "body_height", "mm", 0.00025),
        ("stringPot [in]", "body_height", "in", 0.00635),
        ("leg_velocity_m_s", "leg_velocity", "m/s", 0.25),
        ("Vbat [mV]", "battery_voltage", "mV", 0.00025),
        ("battery_V", "battery_voltage", "V", 0.25),
        ("batteryVoltage_mV", "battery_voltage", "mV", 0.00025),
        ("int temp [°C]", "temperature_internal", "degC", 0.25),
        ("k_gain", "k_gain", None, 0.25),
        ("state", "controller_state", None, 0.25),
        ("Fz [kN]", "force_z", "kN", 250.0),
        ("Mx [N.mm]", "moment_x", "N*mm", 0.00025),
        ("mAh", "charge", "mAh", 0.25),
    ],
)
def test_known_columns_become_channels_in_stored_units(header: str, name: str, unit: str | None, stored: float) -> None:
    data = channel(read(header))
    assert (data.name, data.source_unit, data.source_name) == (name, unit, header)
    assert data.unit == CHANNELS[name].unit
    assert data.values == pytest.approx(np.full(50, stored))
    assert data.values == pytest.approx(data.sign * (data.scale * 0.25 + data.offset))


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("leftEncoder", "left_encoder", None),
        ("z [m]", "z", "m"),
        ("voltage", "voltage", None),
        ("status_s", "status_s", None),
        ("wheel speed [rpm]", "wheel_speed", "rpm"),
        ("k (N/mm)", "k", "N/mm"),
        ("q0 (rad)", "q0", "rad"),
        ("=cmd|x", "cmd_x", None),
        ("???", "column_2", None),
    ],
)
def test_unknown_columns_keep_their_own_name_and_no_invented_unit(header: str, name: str, unit: str | None) -> None:
    result = read(header)
    data = channel(result)
    assert (data.name, data.unit, data.scale) == (name, unit, 1.0)
    assert "unknown_column" in rules(result)


def test_a_known_quantity_without_unit_is_asked_for() -> None:
    result = read("height")
    assert result.refused
    says(finding(result, "unit_missing").message, '--unit "height=UNIT"', "mm")


def test_a_declaration_names_unit_channel_and_sign() -> None:
    declared = Declarations(columns={"h": ColumnDeclaration("body_height", "mm", -1)})
    data = channel(read("h", "-250", declared))
    assert (data.name, data.unit, data.source_unit, data.sign) == ("body_height", "m", "mm", -1)
    assert data.values == pytest.approx(np.full(50, 0.25))


def test_a_declared_column_that_is_absent_is_noted_with_the_nearest() -> None:
    result = read("leftEncoder", declared=Declarations(columns={"leftEncodr": ColumnDeclaration(unit="1")}))
    says(finding(result, "declared_column_absent").message, "'leftEncoder'")


@pytest.mark.parametrize(
    ("header", "base", "unit"),
    [
        ("Fz (N/kg)", "Fz", "N/kg"),
        ("P (W/kg)", "P", "W/kg"),
        ("k (N/mm)", "k", "N/mm"),
        ("c (mAh/g)", "c", "mAh/g"),
        ("torque in N·m/kg", "torque", "N*m/kg"),
        ("q [N/(m s)]", "q", "N/(m s)"),
        ("rate (1/s)", "rate", "1/s"),
        ("Fz (left) [N]", "Fz (left)", "N"),
        ("Body Height/mm", "Body Height", "mm"),
        ("leg_mm/s", "leg", "mm/s"),
        ("v_in/mV", "v_in", "mV"),
        ("side (L/R)", "side (L/R)", None),
        ("height (N/A)", "height (N/A)", None),
        ("x (m/f)", "x (m/f)", None),
        ("F_N/kg", "F_N/kg", None),
        ("height (filtered)", "height (filtered)", None),
        ("height [counts]", "height", "counts"),
    ],
)
def test_a_unit_is_taken_whole_or_not_at_all(header: str, base: str, unit: str | None) -> None:
    """Of `Fz (N/kg)` the unit was kg, of `k (N/mm)` mm, of `c (mAh/g)` g."""
    cell = parse_header(header)
    assert (cell.base, cell.unit) == (base, unit)


def test_a_force_per_mass_is_no_force_and_can_be_kept_as_what_it_is() -> None:
    says(refusal(read("Fz (N/kg)")).message, "N/kg", "own.fz")
    kept = channel(read("Fz (N/kg)", declared=Declarations(columns={"Fz": ColumnDeclaration("fz")})))
    assert (kept.name, kept.unit, kept.scale) == ("fz", "N/kg", 1.0)


@given(st.lists(st.text(st.sampled_from('ab=:#12 "`$[]()mN/\\'), max_size=6), min_size=1, max_size=8))
def test_a_flag_names_the_one_column_that_it_means(names: list[str]) -> None:
    for position, flag in enumerate(flag_names(names)):
        assert len(shlex.split(f'--column "{flag}=body_height:m"')) == 2
        taken = set(names) | {parse_header(name).base for name in names}
        if flag in (names[position], parse_header(names[position]).base) or flag not in taken:
            assert positions_of(flag, names) == (position,)


def test_every_known_channel_is_recognised_under_its_own_name() -> None:
    for name in CHANNELS:
        assert channel_of(name) == name
        assert channel_kind(name) == name
    assert channel_of("Fz2") == "force_z_2"
    assert channel_kind("force_z_2") == "force_z"
