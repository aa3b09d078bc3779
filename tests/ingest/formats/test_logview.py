"""LogView's OpenFormat without names, and OpenFormat Zero with headers. Synthetic, after the public description."""

from __future__ import annotations

import pytest

from ingest.model import ColumnDeclaration, Declarations, Profile
from ingest.read import read_file
from tests.ingest.formats.synthetic_chargers import bare_rows, lines, with_checksum
from tests.ingest.reading import rules, values

COLUMNS = {"value_1": ColumnDeclaration("battery_voltage", "mV"), "value_2": ColumnDeclaration("current", "mA")}
NAMED = Declarations(time_unit="ms", columns=COLUMNS)


ZERO = ["$N$;My Data", "$C$;Temp 1 [°C,T];Battery voltage [V,U];Current [A]"]


def zero_rows(n: int = 100) -> list[str]:
    return [f"${20 + k / 10:.1f};{15.6 + k / 1000:.3f};-0,25" for k in range(n)]


def test_a_bare_recording_asks_for_names_and_the_unit_of_time() -> None:
    result = read_file(lines(bare_rows()), Declarations())
    assert (result.format, result.refused) == ("logview_openformat", True)
    assert {"columns_unnamed", "time_unit_missing"} <= rules(result)


@pytest.mark.parametrize("checksum", [True, False])
@pytest.mark.parametrize("by_profile", [True, False])
def test_a_bare_recording_is_read_as_declared(checksum: bool, by_profile: bool) -> None:
    profile = Profile("meter", ("phase", "value_1", "value_2"), time_column="time", time_unit="ms", columns=COLUMNS)
    declared = Declarations(profiles=(profile,)) if by_profile else NAMED
    result = read_file(lines(bare_rows(checksum=checksum)), declared)
    assert (result.refused, result.rows_kept) == (False, 100)
    assert values(result)["battery_voltage"][:2] == pytest.approx([15.6, 15.601])
    assert values(result)["current"][0] == pytest.approx(-0.2)
    assert result.parts[0].rate_hz == pytest.approx(1.0)


def test_without_a_clock_the_rate_is_declared() -> None:
    rows = lines(bare_rows(clock=False))
    assert "rate_missing" in rules(read_file(rows, Declarations(columns=COLUMNS)))
    result = read_file(rows, Declarations(columns=COLUMNS, rate_hz=2.0))
    assert (result.refused, result.parts[0].rate_hz) == (False, 2.0)


def test_two_channels_interleaved_are_two_signals() -> None:
    rows = [row for pair in zip(bare_rows(), bare_rows(channel=2), strict=True) for row in pair]
    result = read_file(lines(rows), NAMED)
    assert [part.part for part in result.parts] == ["channel_1", "channel_2"]
    assert all(len(part.time_s) == 100 for part in result.parts)


def test_a_wrong_checksum_and_a_thousands_separator_cost_their_lines() -> None:
    rows = bare_rows(300)
    rows[100] = rows[100].replace("15700", "15701")
    rows[200] = with_checksum("$1;1;200000;1.580,5;-200;")
    result = read_file(lines(rows), NAMED)
    assert (result.rows_kept, result.rows_rejected) == (298, 2)
    assert {"checksum_wrong", "record_malformed"} <= rules(result)


@pytest.mark.parametrize(("sign", "mode"), [(1, "charge"), (-1, "discharge")])
def test_counter_and_current_that_are_declared_make_a_charge(sign: int, mode: str) -> None:
    rows = [with_checksum(f"$1;1;{n * 1000};{15600 + sign * n};{sign * 3600};{sign * n};") for n in range(200)]
    columns = {**COLUMNS, "value_3": ColumnDeclaration("charge", "mAh")}
    result = read_file(lines(rows), Declarations(time_unit="ms", columns=columns))
    assert not result.refused
    assert [(charge.charge_mah, charge.mode) for charge in result.charges] == [(199.0, mode)]
    wrong = {**columns, "value_3": ColumnDeclaration("charge", "Ah")}
    assert "charge_contradicts_current" in rules(read_file(lines(rows), Declarations(time_unit="ms", columns=wrong)))


def test_openformat_zero_names_its_columns_and_asks_for_the_time() -> None:
    asked = read_file(lines([*ZERO, *zero_rows()]), Declarations())
    assert (asked.format, asked.refused) == ("logview_zero", True)
    assert "rate_missing" in rules(asked)
    result = read_file(lines([*ZERO, "$I$;500", "$L$;a remark", *zero_rows()]), Declarations())
    assert (result.refused, result.rows_kept, result.parts[0].rate_hz) == (False, 100, 2.0)
    assert {channel.name: channel.unit for channel in result.parts[0].channels} == {
        "temp_1": "degC",
        "battery_voltage": "V",
        "current": "A",
    }
    assert values(result)["current"][0] == -0.25


def test_openformat_zero_with_time_and_factors() -> None:
    rows = [f"$5.1;2816{k // 60:02}{k % 60:02};{1000 + k}" for k in range(120)]
    head = ["$N$;a", "$C$;Temp [°C,T];Battery voltage [V]", "$T$;1;ddHHmmss", "$F$;2;0.01", "$V$;DOUBLE"]
    result = read_file(lines([*head, *rows]), Declarations())
    assert not result.refused
    assert result.parts[0].rate_hz == pytest.approx(1.0)
    assert values(result)["temp"][0] == pytest.approx(10.2)
    assert values(result)["battery_voltage"][-1] == pytest.approx(11.19)
    assert result.role == "charge"


def test_openformat_zero_in_hexadecimal_and_several_recordings() -> None:
    head = ["$N$;a", "$C$;Temp [°C,T];Counts", "$T$;0;ddHHmmss", "$V$;HEX"]
    rows = [f"$281600{k:02};{10 + k:X};CC" for k in range(60)]
    result = read_file(lines([*head, *rows, "$N$;b", *rows]), Declarations())
    assert (result.refused, [part.part for part in result.parts]) == (False, ["log", "log_2"])
    assert values(result.parts[1])["temp"][:3].tolist() == [10.0, 11.0, 12.0]
    assert values(result)["counts"][0] == 204.0


@pytest.mark.parametrize(
    "header", ["$T$;0;yyyyMMdd", "$T$;x;ddHHmmss", "$F$;1;2", "$F$;1;2;x", "$O$;1;1;1", "$C2$;Temp", "$I$;0"]
)
def test_a_header_that_is_not_understood_refuses(header: str) -> None:
    result = read_file(lines([*ZERO, "$I$;500", header, *zero_rows()]), Declarations())
    assert (result.format, result.refused) == ("logview_zero", True)
