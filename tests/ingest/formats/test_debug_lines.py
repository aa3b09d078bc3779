"""Logs of `name: value` lines: rows are turns of the names, broken turns are counted, the rate is asked for."""

from __future__ import annotations

import numpy as np
import pytest

from ingest.model import ColumnDeclaration, Declarations, ReadFile
from ingest.read import read_file
from tests.ingest.reading import counts

N = 300
RATE = Declarations(rate_hz=100.0)


def pairs(n: int = N) -> list[str]:
    """Two motors in turn, after a public description of such logs; synthetic."""
    return [f"motor{1 + k % 2}: {-2957986 + k}" for k in range(2 * n)]


def read(lines: list[str], declared: Declarations = RATE, end: str = "\n") -> ReadFile:
    return read_file(("\n".join(lines) + end).encode(), declared)


def test_the_rate_is_asked_for() -> None:
    result = read(pairs(), Declarations())
    assert (result.format, result.refused, result.rows_read) == ("debug_lines", True, N)
    assert "rate_missing" in counts(result)
    settings = read([f"gain{k}: {k}" for k in range(20)])
    assert settings.format != "debug_lines"


def test_turns_are_rows() -> None:
    result = read(["Starting", "", *pairs()])
    assert (result.refused, result.rows_kept) == (False, N)
    (part,) = result.parts
    assert [channel.name for channel in part.channels] == ["motor1", "motor2"]
    assert part.channels[1].values.tolist() == [-2957986.0 + k for k in range(1, 2 * N, 2)]
    assert part.rate_hz == 100.0
    assert counts(result)["debug_line"] == 1


@pytest.mark.parametrize("lost", [100, 101, 2 * N - 1])
def test_a_broken_pair_is_counted_and_shifts_nothing(lost: int) -> None:
    lines = pairs()
    result = read(lines[:lost] + lines[lost + 1 :])
    assert (result.refused, result.rows_kept, result.rows_rejected) == (False, N - 1, 1)
    assert counts(result)["turn_broken"] == 1
    (part,) = result.parts
    assert np.array_equal(part.channels[1].values - part.channels[0].values, np.ones(N - 1))
    assert [gap.kind for gap in part.gaps] == (["rejected"] if lost < 2 * N - 1 else [])


@pytest.mark.parametrize("place", [100, 101])
def test_a_line_end_inside_a_number_costs_its_pair(place: int) -> None:
    lines = pairs()
    lines[place] = lines[place][:12] + "\n" + lines[place][12:]
    result = read(lines)
    assert (result.refused, result.rows_kept, result.rows_rejected) == (False, N - 1, 1)
    assert result.parts[0].channels[place % 2].values.max() < -2957000


def test_names_units_and_a_time_among_them() -> None:
    lines = [
        f"{name}" for k in range(N) for name in (f"t = {4 * k} ms", f"height = {0.4 + k / 1000:.3f} m", f"u = {k}")
    ]
    result = read(lines, Declarations())
    assert not result.refused
    (part,) = result.parts
    assert [(channel.name, channel.unit) for channel in part.channels] == [("body_height", "m"), ("u", None)]
    assert part.rate_hz == pytest.approx(250.0)


def test_a_value_in_another_unit_breaks_its_turn() -> None:
    lines = [f"height: {400 + k} mm" for k in range(N)]
    lines[150] = "height: 0.55 m"
    result = read(lines)
    assert (result.rows_kept, result.rows_rejected) == (N - 1, 1)
    assert result.parts[0].channels[0].values.max() == pytest.approx(0.699)


def test_quotes_join_no_lines() -> None:
    lines = pairs()
    for place in (100, 104):
        lines[place] = lines[place].replace(": -", ': "')
    result = read(lines)
    assert (result.rows_kept, result.rows_rejected) == (N - 2, 2)


def test_names_can_be_declared() -> None:
    columns = {"motor1": ColumnDeclaration("leg_length", "mm"), "motor2": ColumnDeclaration("left", "1")}
    result = read([f"motor{1 + k % 2}: {150 + k % 7}" for k in range(200)], Declarations(rate_hz=50.0, columns=columns))
    assert [channel.name for channel in result.parts[0].channels] == ["leg_length", "left"]
    assert result.parts[0].channels[0].values[0] == pytest.approx(0.150)
