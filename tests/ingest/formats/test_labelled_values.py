"""Lines of labelled values and of JSON objects: a column is a label, and no line is quietly read as another."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ingest.model import ColumnDeclaration, Declarations, ReadFile
from ingest.read import read_file
from tests.helpers.wording import says

N = 60
HEIGHTS = np.round(0.40 + 0.01 * np.arange(N) % 0.07, 3)
H_AND_T = {"h": ColumnDeclaration("body_height", "m"), "t": ColumnDeclaration("time", "ms")}


def read(line: Callable[[int, float], str], **declared: Any) -> ReadFile:
    rows = [line(k, h) for k, h in enumerate(HEIGHTS.tolist())]
    return read_file(("\n".join(rows) + "\n").encode(), Declarations(**declared))


@pytest.mark.parametrize(
    ("line", "declared"),
    [
        (lambda k, h: json.dumps({"t_ms": 10 * k, "body_height_mm": round(1000 * h, 1), "state": "flight"}), {}),
        (lambda k, h: json.dumps({"time_ms": 10 * k, "leg": {"body_height_m": h, "ok": True}}), {}),
        (lambda k, h: "[" * (k == 0) + json.dumps({"t_ms": 10 * k, "body_height_m": h}) + ",]"[k == N - 1], {}),
        (lambda k, h: json.dumps({"time": f"2021-06-01T08:00:{k / 100:06.3f}Z", "body_height_m": h}), {}),
        (lambda k, h: f"h:{h},v:15.4,t:{10 * k}", {"columns": H_AND_T}),
        (lambda k, h: f"h:{h:.3f},v:15.4,t:{10 * k}".replace(".", ","), {"columns": H_AND_T}),
        (lambda k, h: f"h: {h} t: {10 * k}", {"columns": H_AND_T}),
        (lambda k, h: f"body_height={h} m t={10 * k} ms", {}),
        (lambda k, h: f"body height: {1000 * h:.1f}mm; time: {k / 100} s", {}),
        (lambda k, h: f"[12:00:{k / 100:06.3f}] INFO hopper: body_height={h} m vbat=15.40 V", {}),
        (lambda k, h: f"12:00:{k / 100:06.3f} -> body_height: {h} m", {}),
        (lambda k, h: f"{10 * k} h={h} v=15.4", {"columns": {**H_AND_T, "1": ColumnDeclaration("time", "ms")}}),
        (lambda k, h: f"t={10 * k} h={h:.3E}".replace("E", "D"), {"columns": H_AND_T}),
    ],
)
def test_columns_are_named_by_their_labels(line: Callable[[int, float], str], declared: Any) -> None:
    result = read(line, **declared)
    assert (result.format, result.refused, result.rows_kept) == ("labelled_values", False, N), result.findings
    (part,) = result.parts
    heights = next(channel for channel in part.channels if channel.name in ("body_height", "leg_body_height_m"))
    assert heights.values == pytest.approx(HEIGHTS, abs=1e-12)
    assert part.rate_hz == pytest.approx(100.0)


def test_a_unit_that_nothing_states_is_asked_for_by_the_label() -> None:
    result = read(lambda k, h: f"h:{h},v:15.4,t:{10 * k}")
    assert result.refused
    says([finding.message for finding in result.findings], "--unit t=")


def test_a_value_is_missing_where_a_line_lacks_its_label() -> None:
    result = read(lambda k, h: f"f: 0.050 t: {10 * k}" if k % 4 == 0 else f"h: {h} t: {10 * k}", columns=H_AND_T)
    assert not result.refused
    (part,) = result.parts
    values = {channel.name: channel.values for channel in part.channels}
    echo = np.arange(N) % 4 == 0
    assert np.array_equal(values["f"], np.where(echo, 0.05, np.nan), equal_nan=True)
    assert np.array_equal(values["body_height"], np.where(echo, np.nan, HEIGHTS), equal_nan=True)
    assert part.rate_hz == pytest.approx(100.0)


def test_lines_of_other_labels_at_the_same_time_are_one_row() -> None:
    result = read(lambda k, h: f"t: {10 * k} h: {h}\nt: {10 * k} f: 0.05", columns=H_AND_T)
    assert (result.rows_kept, result.parts[0].rate_hz) == (N, 100.0)
    assert [channel.values[-1] for channel in result.parts[0].channels] == [HEIGHTS[-1], 0.05]


def test_equal_labels_behind_different_words_are_asked_about() -> None:
    def line(k: int, h: float) -> str:
        return f"{'LR'[k % 2]}: h={h} t={5 * (k // 2)}"

    result = read(line, columns=H_AND_T)
    assert result.refused
    assert any(says(finding.message, 'trials = "prefix"', "'L'", "'R'") for finding in result.findings)
    parts = {part.part: part for part in read(line, columns=H_AND_T, trials="prefix").parts}
    assert {name: part.rate_hz for name, part in parts.items()} == {"trial_l": 200.0, "trial_r": 200.0}
    assert np.array_equal(parts["trial_r"].channels[0].values, HEIGHTS[1::2])


@pytest.mark.parametrize(
    ("damaged", "rejected"),
    [
        (["t=300 ms h=0.4", "1 m v=3"], 2),
        (["t=300 ms h=0.41 mm v=3"], 1),
        (["t=300 ms h=0.41 m v=3 t=301 ms"], 1),
        (["t=300 ms h=0.4x1 m v=3"], 1),
        (["t=300 ms h=0.41 m v=1", "3"], 1),
        (["t=300 ms h=0.41 m v=1", "3.5 t=305 ms h=0.40 mm"], 2),
    ],
)
def test_a_damaged_line_is_a_row_that_is_rejected(damaged: list[str], rejected: int) -> None:
    rows = [f"t={10 * k} ms h=0.40 m v=2" for k in range(300)]
    rows[30:31] = damaged
    result = read_file(("\n".join(rows) + "\n").encode(), Declarations())
    assert (result.refused, result.rows_kept, result.rows_rejected) == (False, 299, rejected)
    assert math.isclose(np.nanmax(result.parts[0].channels[0].values), 0.40)


def test_a_broken_object_is_a_row_that_is_rejected_and_other_lines_none() -> None:
    rows = ["ready", "# run r012", *(json.dumps({"t_ms": k, "body_height_m": 0.4}) for k in range(300))]
    rows[40] = rows[40][:-5]
    result = read_file(("\n".join(rows) + "\n").encode(), Declarations())
    assert (result.refused, result.rows_kept, result.rows_rejected) == (False, 299, 1)
    assert next(finding.line for finding in result.findings if finding.severity == "row") == 41
    assert result.named_runs == ("r012",)


def test_settings_above_a_table_and_words_in_it_are_no_labelled_values() -> None:
    table = ["gain: 3, mass: 4.1", "gain: 4, mass: 4.2", "time [ms],height [m]", *(f"{k},0.4" for k in range(20))]
    assert read_file("\n".join(table).encode(), Declarations()).format == "delimited_log"
