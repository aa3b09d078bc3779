"""iCharger logs: checksum, scales, sign, counter against current; synthetic, after the layout of public logs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.model import Declarations, ReadFile
from ingest.read import read_file
from tests.ingest.synthetic import icharger_line, icharger_rows

ROWS = icharger_rows()


def read(rows: list[str], end: str = "\n") -> ReadFile:
    return read_file((end.join(rows) + end).encode("latin-1"), Declarations())


def rules(result: ReadFile) -> set[str]:
    return {finding.rule for finding in result.findings}


def fields(row: str) -> list[int]:
    return [int(field) for field in row[1:].split(";")[:-1]]


@pytest.mark.parametrize(("mode", "name", "sign"), [(1, "charge", 1), (2, "discharge", -1)])
def test_one_recharge_and_one_signal_a_channel(mode: int, name: str, sign: int) -> None:
    result = read(icharger_rows(mode=mode))
    assert not result.refused
    (charge,), (part,) = result.charges, result.parts
    assert (charge.charge_mah, charge.mode, charge.resolution_mah, charge.duration_s) == (399.0, name, 1.0, 399.0)
    assert charge.end_voltage_v == pytest.approx(15.756)
    values = {channel.name: channel.values for channel in part.channels}
    assert values["current"] == pytest.approx(np.full(400, sign * 3.6))
    assert values["charge"][-1] == sign * 399.0
    assert values["cell_4_voltage"][0] == pytest.approx(3.9)
    assert "cell_5_voltage" not in values


@given(st.integers(0, 399), st.integers(0, 60), st.integers(1, 255))
def test_any_changed_byte_of_a_line_costs_that_line_and_no_other(row: int, place: int, flip: int) -> None:
    line = bytearray(ROWS[row].encode())
    line[min(place, len(line) - 1)] ^= flip
    data = b"\n".join([*(r.encode() for r in ROWS[:row]), bytes(line), *(r.encode() for r in ROWS[row + 1 :])]) + b"\n"
    result = read_file(data, Declarations())
    if result.format == "icharger_log" and row > 0:
        assert result.rows_kept in (399, 400)
        kept = np.concatenate([part.time_s for part in result.parts])
        assert len(kept) == result.rows_kept


def test_a_line_with_a_wrong_checksum_leaves_a_rejected_gap() -> None:
    result = read([*ROWS[:50], ROWS[50].replace("24000", "24001"), *ROWS[51:]])
    assert "checksum_wrong" in rules(result)
    assert [gap.kind for gap in result.parts[0].gaps] == ["rejected"]
    assert result.charges[0].charge_mah == 399.0


def test_a_wrong_scale_of_the_counter_is_refused() -> None:
    result = read(icharger_rows(counter_scale=0.98))
    assert result.refused
    assert "charge_contradicts_current" in rules(result)


def test_the_counter_is_compared_only_where_the_log_is_whole() -> None:
    result = read(ROWS[:100] + ROWS[150:])
    assert not result.refused
    assert [gap.kind for gap in result.parts[0].gaps] == ["pause"]


def test_a_negative_charge_while_charging_is_refused() -> None:
    flipped = [[-value if place == 8 else value for place, value in enumerate(fields(row))] for row in ROWS]
    assert "charge_sign" in rules(read([icharger_line(*row) for row in flipped]))


def test_model_line_nul_and_resistances_are_no_data() -> None:
    resistances = icharger_line(1, 128, *[12] * 13)
    head = ["@Model:4010DUO; Fireware:V2.20; Hardware:V2.00; SN:1\0", ""]
    result = read([*head, *ROWS[:9], resistances, *ROWS[9:]], "\r\n")
    assert not result.refused
    assert (result.rows_read, result.rows_kept) == (400, 400)
    assert {"instrument", "resistance_line"} <= rules(result)


def test_two_channels_interleaved_are_two_signals_and_two_recharges() -> None:
    other = icharger_rows(channel=2, mode=2)
    result = read([row for pair in zip(ROWS, other, strict=True) for row in pair])
    assert [part.part for part in result.parts] == ["channel_1", "channel_2"]
    assert [charge.mode for charge in result.charges] == ["charge", "discharge"]
    assert [charge.row_number for charge in result.charges] == [1, 2]


def test_a_restart_is_a_recharge_of_its_own() -> None:
    result = read(ROWS + ROWS)
    assert [part.part for part in result.parts] == ["channel_1", "channel_1_segment_2"]
    assert len(result.charges) == 2
    assert "time_restarted" in rules(result)


def test_lines_that_come_twice_are_out_of_order_and_no_second_recharge() -> None:
    result = read(ROWS[:200] + ROWS[197:])
    assert [charge.charge_mah for charge in result.charges] == [399.0]
    assert (result.rows_kept, result.rows_rejected) == (400, 3)
    assert {"time_duplicate", "time_backwards"} & rules(result)


def test_eight_cell_models_have_two_fields_fewer() -> None:
    result = read([icharger_line(*fields(row)[:-2]) for row in ROWS])
    assert not result.refused
    assert result.charges[0].charge_mah == 399.0


def test_a_line_of_another_model_refuses_the_file() -> None:
    other = icharger_line(1, 1, 24000, 16000, 100, 3900, 3900, 0, 0, 0, 0, 380, 0, 9)
    result = read([*ROWS[:50], other, *ROWS[50:]])
    assert result.refused
    assert "icharger_layout_unknown" in rules(result)


def test_watching_alone_counts_no_recharge() -> None:
    result = read(icharger_rows(mode=3, current_a=0.0))
    assert (result.refused, result.charges) == (False, ())
    assert "no_recharge" in rules(result)


def test_a_missing_balance_lead_is_noted() -> None:
    loose = [
        [0 if place == 12 and n % 7 == 0 else value for place, value in enumerate(fields(row))]
        for n, row in enumerate(ROWS)
    ]
    assert {"cell_zero", "cell_sum"} <= rules(read([icharger_line(*row) for row in loose]))
