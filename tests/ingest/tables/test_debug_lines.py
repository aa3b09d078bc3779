"""Tables that programs print among other things: debug lines between rows, a preamble, aligned names, a rule."""

from __future__ import annotations

import numpy as np
import pytest

from tests.ingest.reading import counts, read
from tests.ingest.synthetic import robot_log, robot_rows, text

HEADER = "time [ms], height [m], leg_length [m], k_gain"
DEBUG = [f"Acceleration: {value / 100:.2f}" for value in range(590, 640)]


@pytest.mark.parametrize("place", [0, 30, 60])
@pytest.mark.parametrize("last_newline", [True, False])
def test_debug_lines_are_counted_and_cost_no_row(place: int, last_newline: bool) -> None:
    rows = robot_rows(60)
    data = text(HEADER, [*rows[:place], "", *DEBUG, "", *rows[place:]])
    result = read(data if last_newline else data.removesuffix(b"\n"))
    assert not result.refused
    assert (result.rows_read, result.rows_kept) == (60, 60)
    assert counts(result)["debug_line"] == len(DEBUG)
    plain = read(robot_log(60))
    assert np.array_equal(result.parts[0].channels[0].values, plain.parts[0].channels[0].values)


def test_a_row_cut_anywhere_is_no_debug_line() -> None:
    rows = robot_rows(60)
    for length in range(1, len(rows[30])):
        result = read(text(HEADER, [*rows[:30], rows[30][:length], *rows[31:]]))
        assert "debug_line" not in counts(result)
        assert result.rows_kept < 60 or "k_gain" in {channel.name for channel in result.parts[0].channels}


def test_a_line_of_words_for_every_column_is_no_debug_line() -> None:
    rows = robot_rows(60)
    result = read(text(HEADER, [*rows[:30], "time: [s],height: [mm],leg: [mm],gain", *rows[30:]]))
    assert "debug_line" not in counts(result)


def test_a_table_of_states_keeps_rows_that_look_like_debug_lines() -> None:
    rows = [f"STANCE: {n % 2},{n},{0.4 + n / 1000}" for n in range(40)]
    result = read(text("state name,time [ms],height [m]", rows))
    assert (result.refused, result.rows_kept) == (False, 40)


PREAMBLE = """Reprinted from a journal 29, pp. 1637-1642,
Copyright (1996), with permission.

"""


def test_names_aligned_by_doubled_tabs_over_a_rule_are_read_below_a_preamble() -> None:
    rows = [f"{n * 0.0201:.4f}\t{0.15 + n / 1000:.4f}\t{0.16 + n / 1000:.4f}" for n in range(50)]
    result = read(text(PREAMBLE + "Time\t\theight [m]\t\tleg_length [m]\n" + "-" * 42, rows, "\r\n"), time_unit="s")
    assert not result.refused
    assert result.rows_read == 50
    assert [channel.name for channel in result.parts[0].channels] == ["body_height", "leg_length"]
    assert result.parts[0].rate_hz == pytest.approx(1 / 0.0201, rel=1e-3)
