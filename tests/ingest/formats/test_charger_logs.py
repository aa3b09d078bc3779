"""Logs of older iChargers and of cheali-charger: fields, signs, checksums, stages, counter against current."""

from __future__ import annotations

import numpy as np
import pytest

from ingest.model import ColumnDeclaration, Declarations, ReadFile
from ingest.read import read_file
from tests.ingest.formats.synthetic_chargers import cheali_rows, lines, serial_rows, with_checksum

HALF_HERTZ = Declarations(rate_hz=0.5)


def rules(result: ReadFile) -> dict[str, int]:
    return {finding.rule: finding.count for finding in result.findings}


def values(result: ReadFile, part: int = 0) -> dict[str, np.ndarray]:
    return {channel.name: channel.values for channel in result.parts[part].channels}


def test_an_older_icharger_asks_for_its_rate() -> None:
    result = read_file(lines(serial_rows()), Declarations())
    assert (result.format, result.refused) == ("icharger_serial", True)
    assert "rate_missing" in rules(result)


@pytest.mark.parametrize("cells", [6, 8, 10])
@pytest.mark.parametrize(("mode", "sign"), [(1, 1), (2, 1), (2, -1)])
def test_an_older_icharger_is_read_at_the_declared_rate(mode: int, sign: int, cells: int) -> None:
    result = read_file(lines(serial_rows(mode=mode, sign=sign, cells=cells)), HALF_HERTZ)
    assert not result.refused
    (charge,) = result.charges
    assert (charge.charge_mah, charge.duration_s) == (299.0, 598.0)
    assert charge.mode == ("charge" if mode == 1 else "discharge")
    found = values(result)
    stored = 1 if mode == 1 else -1
    assert found["current"] == pytest.approx(np.full(300, stored * 1.8))
    assert found["charge"][-1] == stored * 299.0
    assert found["battery_voltage"][0] == pytest.approx(15.6)
    assert found["input_voltage"][0] == pytest.approx(14.0)
    assert (found["temperature_internal"][0], found["temperature_external"][0]) == pytest.approx((32.8, 25.1))
    assert [name for name in found if name.startswith("cell_")] == [f"cell_{n}_voltage" for n in range(1, 5)]


@pytest.mark.parametrize("rate_hz", [1.0, 0.48])
def test_a_rate_that_counter_and_current_contradict_is_refused(rate_hz: float) -> None:
    result = read_file(lines(serial_rows()), Declarations(rate_hz=rate_hz))
    assert "charge_contradicts_current" in rules(result)
    assert result.refused


def test_a_charge_with_the_current_of_a_discharge_is_refused() -> None:
    result = read_file(lines(serial_rows(mode=1, sign=-1)), HALF_HERTZ)
    assert result.refused
    assert "charge_sign" in rules(result)


def test_stages_of_a_cycle_are_charges_of_their_own() -> None:
    result = read_file(lines(serial_rows(200, mode=1) + serial_rows(100, mode=2)), HALF_HERTZ)
    assert [(charge.mode, charge.charge_mah) for charge in result.charges] == [("charge", 199.0), ("discharge", 99.0)]
    assert [part.part for part in result.parts] == ["channel_1", "channel_1_segment_2"]


@pytest.mark.parametrize(("rising", "mode"), [(1, "charge"), (-1, "discharge")])
@pytest.mark.parametrize(("cells", "percent"), [(6, True), (6, False), (8, True), (8, False)])
def test_cheali_charger(rising: int, mode: str, cells: int, percent: bool) -> None:
    result = read_file(lines(cheali_rows(rising=rising, cells=cells, percent=percent)), Declarations())
    assert (result.format, result.refused) == ("cheali_log", False)
    (part,), (charge,) = result.parts, result.charges
    assert part.rate_hz == pytest.approx(2.0)
    assert (charge.charge_mah, charge.mode, charge.duration_s) == (299.0, mode, 299.5)
    found = values(result)
    assert found["current"] == pytest.approx(np.full(600, rising * 3.6))
    assert found["charge"][-1] == rising * 299.0
    assert (found["temperature_internal"][0], found["temperature_external"][0]) == pytest.approx((30.8, 25.1))
    assert found["cell_4_voltage"][0] == pytest.approx(3.9)
    assert "direction_by_voltage" in rules(result)


def test_cheali_debug_channels_are_counted_and_left_out() -> None:
    debug = [with_checksum(f"$2;1;{n}.0;" + "7;" * 30) for n in range(20)]
    rows = cheali_rows(100)
    result = read_file(lines([*rows[:50], *debug, with_checksum("$3;1;25.0;100;90;"), *rows[50:]]), Declarations())
    assert (result.refused, result.rows_kept) == (False, 100)
    assert rules(result)["debug_line"] == 21


def test_cheali_voltage_that_stands_still_counts_no_recharge() -> None:
    result = read_file(lines(cheali_rows(rising=0)), Declarations())
    assert (result.refused, result.charges) == (False, ())
    assert "no_recharge" in rules(result)


def test_a_wrong_scale_of_the_counter_is_refused() -> None:
    rows = [row.split(";") for row in cheali_rows()]
    scaled = [with_checksum(";".join([*row[:5], str(int(row[5]) * 10), *row[6:-1]]) + ";") for row in rows]
    result = read_file(lines(scaled), Declarations())
    assert result.refused
    assert "charge_contradicts_current" in rules(result)


def test_a_restart_of_cheali_charger_is_a_charge_of_its_own() -> None:
    result = read_file(lines(cheali_rows(300) + cheali_rows(400, rising=-1)), Declarations())
    assert [(charge.mode, charge.charge_mah) for charge in result.charges] == [("charge", 149.0), ("discharge", 199.0)]
    assert [part.part for part in result.parts] == ["channel_1", "channel_1_segment_2"]


@pytest.mark.parametrize("rows", [serial_rows(500), cheali_rows(500)])
def test_lines_that_come_twice_are_no_second_charge(rows: list[str]) -> None:
    result = read_file(lines(rows[:200] + rows[196:]), HALF_HERTZ if rows == serial_rows(500) else Declarations())
    assert (result.refused, len(result.charges)) == (False, 1)
    assert result.rows_rejected in (3, 4)  # a counter that stands still cannot tell that the first came again


def test_two_interleaved_outputs_are_two_signals_and_two_charges() -> None:
    second = [with_checksum(row.rpartition(";")[0].replace("$1;", "$2;", 1) + ";") for row in serial_rows(mode=2)]
    rows = [row for pair in zip(serial_rows(), second, strict=True) for row in pair]
    result = read_file(lines(rows), HALF_HERTZ)
    assert [part.part for part in result.parts] == ["channel_1", "channel_2"]
    assert [charge.mode for charge in result.charges] == ["charge", "discharge"]


def test_a_csv_of_an_icharger_logger_asks_for_units_and_runs_past_midnight() -> None:
    rows = [f"{stamp}, {14000 + n}, {15600 + n}, 180" for n, stamp in enumerate(("23:59:58", "00:00:00", "00:00:02"))]
    data = ("time, V_in, V_bat, I_cgh\n" + "\n".join(rows) + "\n").encode()
    assert "unit_missing" in rules(read_file(data, Declarations()))
    columns = {name: ColumnDeclaration(unit="mV") for name in ("V_in", "V_bat")}
    result = read_file(data, Declarations(columns=columns))
    assert not result.refused
    assert result.parts[0].time_s.tolist() == [0.0, 2.0, 4.0]
    assert values(result)["battery_voltage"][0] == pytest.approx(15.6)


SMALL = {
    "icharger_serial": (lines(serial_rows(5)), HALF_HERTZ),
    "cheali_log": (lines(cheali_rows(5)), Declarations()),
}


@pytest.mark.parametrize("name", SMALL)
def test_a_changed_byte_costs_its_line_and_no_other(name: str) -> None:
    data, declared = SMALL[name]
    start = data.index(b"\r\n") + 2
    for place in range(start, data.index(b"\r\n", start)):
        changed = bytearray(data)
        changed[place] ^= 1
        result = read_file(bytes(changed), declared)
        assert (result.rows_read, result.rows_rejected) == (5, 1)
