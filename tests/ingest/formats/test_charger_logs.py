"""Logs of chargers, those of iChargers of both generations and of cheali-charger: fields, signs, checksums, stages, the
counter against the current; synthetic, after public descriptions and logs.
"""

from __future__ import annotations

import numpy as np
import pytest

from ingest.model import ColumnDeclaration, Declarations, ReadFile
from ingest.read import read_file
from tests.ingest.formats.synthetic_chargers import cheali_rows, lines, serial_rows, with_checksum
from tests.ingest.reading import counts, values
from tests.ingest.synthetic import icharger_line, icharger_rows

DUO = icharger_rows()


def log(rows: list[str], rate_hz: float = 0.5) -> ReadFile:
    """Read records; those of an older iCharger, without a clock, at a declared rate."""
    return read_file(lines(rows), Declarations(rate_hz=rate_hz if rows[0].split(";")[2] == "" else None))


def fields(row: str) -> list[int]:
    return [int(field) for field in row[1:].split(";")[:-1]]


def with_field(rows: list[str], place: int, factor: int) -> list[str]:
    """Records with one field multiplied, `place` from the end where negative."""
    changed = []
    for row in rows:
        cells = row.split(";")[:-1]
        cells[place] = str(int(cells[place]) * factor)
        changed.append(with_checksum(";".join(cells) + ";"))
    return changed


@pytest.mark.parametrize("cells", [6, 8, 10])
@pytest.mark.parametrize(("mode", "sign"), [(1, 1), (2, 1), (2, -1)])
def test_an_older_icharger_is_read_at_the_declared_rate(mode: int, sign: int, cells: int) -> None:
    rows = serial_rows(mode=mode, sign=sign, cells=cells)
    asked, result = read_file(lines(rows), Declarations()), log(rows)
    assert (asked.format, asked.refused, counts(asked)["rate_missing"]) == ("icharger_serial", True, 1)
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


@pytest.mark.parametrize(("rising", "mode"), [(1, "charge"), (-1, "discharge")])
@pytest.mark.parametrize(("cells", "percent"), [(6, True), (6, False), (8, True), (8, False)])
def test_cheali_charger(rising: int, mode: str, cells: int, percent: bool) -> None:
    result = log(cheali_rows(rising=rising, cells=cells, percent=percent))
    assert (result.format, result.refused) == ("cheali_log", False)
    (part,), (charge,) = result.parts, result.charges
    assert part.rate_hz == pytest.approx(2.0)
    assert (charge.charge_mah, charge.mode, charge.duration_s) == (299.0, mode, 299.5)
    found = values(result)
    assert found["current"] == pytest.approx(np.full(600, rising * 3.6))
    assert found["charge"][-1] == rising * 299.0
    assert (found["temperature_internal"][0], found["temperature_external"][0]) == pytest.approx((30.8, 25.1))
    assert found["cell_4_voltage"][0] == pytest.approx(3.9)
    assert "direction_by_voltage" in counts(result)


def test_cheali_debug_channels_are_counted_and_left_out() -> None:
    debug = [with_checksum(f"$2;1;{n}.0;" + "7;" * 30) for n in range(20)]
    rows = cheali_rows(100)
    result = log([*rows[:50], *debug, with_checksum("$3;1;25.0;100;90;"), *rows[50:]])
    assert (result.refused, result.rows_kept) == (False, 100)
    assert counts(result)["debug_line"] == 21


@pytest.mark.parametrize(("mode", "name", "sign"), [(1, "charge", 1), (2, "discharge", -1)])
def test_one_recharge_and_one_signal_a_channel(mode: int, name: str, sign: int) -> None:
    result = log(icharger_rows(mode=mode))
    assert not result.refused
    (charge,), (part,) = result.charges, result.parts
    assert (charge.charge_mah, charge.mode, charge.resolution_mah, charge.duration_s) == (399.0, name, 1.0, 399.0)
    assert charge.end_voltage_v == pytest.approx(15.756)
    found = values(part)
    assert found["current"] == pytest.approx(np.full(400, sign * 3.6))
    assert found["charge"][-1] == sign * 399.0
    assert found["cell_4_voltage"][0] == pytest.approx(3.9)
    assert "cell_5_voltage" not in found


def test_a_line_with_a_wrong_checksum_leaves_a_rejected_gap() -> None:
    result = log([*DUO[:50], DUO[50].replace("24000", "24001"), *DUO[51:]])
    assert "checksum_wrong" in counts(result)
    assert [gap.kind for gap in result.parts[0].gaps] == ["rejected"]
    assert result.charges[0].charge_mah == 399.0


def test_the_counter_is_compared_only_where_the_log_is_whole() -> None:
    result = log(DUO[:100] + DUO[150:])
    assert not result.refused
    assert [gap.kind for gap in result.parts[0].gaps] == ["pause"]


def test_model_line_nul_and_resistances_are_no_data() -> None:
    resistances = icharger_line(1, 128, *[12] * 13)
    head = ["@Model:4010DUO; Fireware:V2.20; Hardware:V2.00; SN:1\0", ""]
    result = log([*head, *DUO[:9], resistances, *DUO[9:]])
    assert not result.refused
    assert (result.rows_read, result.rows_kept) == (400, 400)
    assert {"instrument", "resistance_line"} <= counts(result).keys()


def test_eight_cell_models_have_two_fields_fewer() -> None:
    result = log([icharger_line(*fields(row)[:-2]) for row in DUO])
    assert not result.refused
    assert result.charges[0].charge_mah == 399.0


def test_a_line_of_another_model_refuses_the_file() -> None:
    other = icharger_line(1, 1, 24000, 16000, 100, 3900, 3900, 0, 0, 0, 0, 380, 0, 9)
    result = log([*DUO[:50], other, *DUO[50:]])
    assert result.refused
    assert "icharger_layout_unknown" in counts(result)


def test_a_missing_balance_lead_is_noted() -> None:
    loose = [row if n % 7 else with_field([row], 12, 0)[0] for n, row in enumerate(DUO)]
    assert {"cell_zero", "cell_sum"} <= counts(log(loose)).keys()


@pytest.mark.parametrize(
    ("rows", "rate_hz", "rule"),
    [
        (serial_rows(), 1.0, "charge_contradicts_current"),
        (serial_rows(), 0.48, "charge_contradicts_current"),
        (with_field(cheali_rows(), 5, 10), 0.5, "charge_contradicts_current"),
        (icharger_rows(counter_scale=0.98), 0.5, "charge_contradicts_current"),
        (serial_rows(mode=1, sign=-1), 0.5, "charge_sign"),
        (with_field(DUO, 8, -1), 0.5, "charge_sign"),
    ],
)
def test_a_counter_that_current_or_mode_contradicts_is_refused(rows: list[str], rate_hz: float, rule: str) -> None:
    result = log(rows, rate_hz)
    assert result.refused
    assert rule in counts(result)


@pytest.mark.parametrize(
    ("rows", "charges"),
    [
        (serial_rows(200, mode=1) + serial_rows(100, mode=2), [("charge", 199.0), ("discharge", 99.0)]),
        (cheali_rows(300) + cheali_rows(400, rising=-1), [("charge", 149.0), ("discharge", 199.0)]),
        (DUO + DUO, [("charge", 399.0)] * 2),
    ],
    ids=["stages of a cycle", "cheali-charger", "DUO"],
)
def test_what_begins_anew_is_a_charge_of_its_own(rows: list[str], charges: list[tuple[str, float]]) -> None:
    result = log(rows)
    assert [(charge.mode, charge.charge_mah) for charge in result.charges] == charges
    assert [part.part for part in result.parts] == ["channel_1", "channel_1_segment_2"]
    assert counts(result)["time_restarted"] == 1
    assert counts(result)["field_ignored"] == (result.format == "cheali_log")


@pytest.mark.parametrize(
    ("rows", "back", "rejected"),
    [
        # A counter that stands still cannot tell that the first came again.
        (serial_rows(500), 4, {"time_backwards": 3}),
        (cheali_rows(500), 4, {"time_backwards": 3, "time_duplicate": 1}),
        (DUO, 3, {"time_backwards": 2, "time_duplicate": 1}),
    ],
    ids=["serial", "cheali-charger", "DUO"],
)
def test_lines_that_come_twice_are_no_second_charge(rows: list[str], back: int, rejected: dict[str, int]) -> None:
    result = log(rows[:200] + rows[200 - back :])
    assert (result.refused, len(result.charges)) == (False, 1)
    assert (result.rows_kept, result.charges[0].charge_mah) == (
        len(rows) + back - result.rows_rejected,
        log(rows).charges[0].charge_mah,
    )
    assert {finding.rule: finding.count for finding in result.findings if finding.severity == "row"} == rejected
    assert result.rows_rejected == sum(rejected.values())


def on_channel_2(rows: list[str]) -> list[str]:
    return [with_checksum(row.rpartition(";")[0].replace("$1;", "$2;", 1) + ";") for row in rows]


@pytest.mark.parametrize(
    "outputs", [(serial_rows(), serial_rows(mode=2)), (DUO, icharger_rows(mode=2))], ids=["serial", "DUO"]
)
def test_two_interleaved_outputs_are_two_signals_and_two_charges(outputs: tuple[list[str], list[str]]) -> None:
    result = log([row for pair in zip(outputs[0], on_channel_2(outputs[1]), strict=True) for row in pair])
    assert [part.part for part in result.parts] == ["channel_1", "channel_2"]
    assert [(charge.row_number, charge.mode) for charge in result.charges] == [(1, "charge"), (2, "discharge")]


@pytest.mark.parametrize("rows", [cheali_rows(rising=0), icharger_rows(mode=3, current_a=0.0)])
def test_what_only_watches_or_shows_no_direction_counts_no_recharge(rows: list[str]) -> None:
    result = log(rows)
    assert (result.refused, result.charges) == (False, ())
    assert "no_recharge" in counts(result)


def test_a_csv_of_an_icharger_logger_asks_for_units_and_runs_past_midnight() -> None:
    rows = [f"{stamp}, {14000 + n}, {15600 + n}, 180" for n, stamp in enumerate(("23:59:58", "00:00:00", "00:00:02"))]
    data = ("time, V_in, V_bat, I_cgh\n" + "\n".join(rows) + "\n").encode()
    assert "unit_missing" in counts(read_file(data, Declarations()))
    columns = {name: ColumnDeclaration(unit="mV") for name in ("V_in", "V_bat")}
    result = read_file(data, Declarations(columns=columns))
    assert not result.refused
    assert result.parts[0].time_s.tolist() == [0.0, 2.0, 4.0]
    assert values(result)["battery_voltage"][0] == pytest.approx(15.6)


SMALL = {
    "icharger_serial": (lines(serial_rows(5)), Declarations(rate_hz=0.5)),
    "cheali_log": (lines(cheali_rows(5)), Declarations()),
    "icharger_log": (lines(icharger_rows(5)), Declarations()),
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
