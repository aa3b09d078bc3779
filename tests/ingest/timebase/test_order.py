"""Order of time stamps: what is rejected, where a counter wraps, where a recording begins anew."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.model import ColumnDeclaration, Declarations, FindingCollector
from ingest.read import read_file
from ingest.tables.table import Block
from ingest.timebase.axis import Order, put_in_order
from tests.helpers.wording import says
from tests.ingest.reading import read, rules
from tests.ingest.synthetic import text


def order(seconds: list[float]) -> tuple[Order, list[str]]:
    findings = FindingCollector()
    stamps, rows = np.array(seconds), np.arange(len(seconds))
    block = Block({}, {}, rows + 2, rows, 0)
    found = put_in_order(stamps, np.ones(len(stamps), dtype=bool), block, findings, "time")
    return found, [finding.rule for finding in findings.findings()]


@given(st.lists(st.floats(-1e6, 1e6) | st.just(float("nan")), max_size=60))
def test_what_is_kept_always_increases_within_its_segment(seconds: list[float]) -> None:
    found, _ = order(seconds)
    rows = np.flatnonzero(found.keep)
    assert bool(found.starts) == bool(rows.size)
    stops = [*found.starts[1:], len(seconds)] if found.starts else []
    for start, stop in zip(found.starts, stops, strict=True):
        inside = rows[(rows >= start) & (rows < stop)]
        assert (np.diff(np.array(seconds)[inside]) > 0).all()


def test_a_slow_clock_that_starts_again_begins_a_segment() -> None:
    """All rows of a log at 1 Hz were left out until the clock had caught up."""
    for step in (1.0, 10.0):
        found, rules = order([step * k for k in range(500, 600)] + [step * k for k in range(80)])
        assert (found.starts, rules) == ((0, 100), ["time_restarted"])
        assert found.keep.all()


@pytest.mark.parametrize("every", [1, 4])
@pytest.mark.parametrize("n", [8, 200])
def test_a_long_table_is_asked_for_the_column_that_parts_its_series(every: int, n: int) -> None:
    """Two series under the same stamps were one channel at twice the rate."""
    rows = [f"{k / 100:.2f},foot_height,0.1\n" * (k % every == 0) + f"{k / 100:.2f},body_height,0.4" for k in range(n)]
    data = "\n".join(["time_s,field,value", *rows, ""]).encode()
    result = read_file(data, Declarations())
    assert says(next(each.message for each in result.findings if each.severity == "file"), 'trials = "field"')
    names = ("body_height", "foot_height")
    metres = {name: ColumnDeclaration(unit="m") for name in names}
    parts = {part.part: part for part in read_file(data, Declarations(trials="field", columns=metres)).parts}
    assert parts["trial_body_height"].rate_hz == pytest.approx(100.0)
    assert parts["trial_foot_height"].rate_hz == pytest.approx(100.0 / every)
    assert [parts[f"trial_{name}"].channels[0].name for name in names] == [*names]
    assert set(parts["trial_foot_height"].channels[0].values) == {0.1}
    one = Declarations(trials="field", columns={"value": ColumnDeclaration("body_height", "m")})
    assert "declared_column_absent" in rules(read_file(data, one))


def test_series_have_the_units_beside_them() -> None:
    """A unit in a column of its own was ignored."""
    rows = [
        f"{k / 100:.2f},{name},{value},{unit}"
        for k in range(50)
        for name, value, unit in (("height", 400 + k, "mm"), ("battery_voltage", 15.4, "V"))
    ]
    data = "\n".join(["time_s,sensor,value,unit", *rows, ""]).encode()
    declared = Declarations(trials="sensor", columns={"height": ColumnDeclaration("body_height")})
    result = read_file(data, declared)
    channels = {part.channels[0].name: part.channels[0] for part in result.parts}
    assert not result.refused
    assert channels["body_height"].values == pytest.approx(0.4 + 0.001 * np.arange(50))
    assert set(channels["battery_voltage"].values) == {15.4}
    other = data.replace(b"battery_voltage,15.4,V", b"battery_voltage,15400,mV", 1)
    assert "cell_units_differ" in rules(read_file(other, declared))


def test_words_beside_a_known_channel_are_trials() -> None:
    rows = [f"{k / 100:.2f},{word},{0.4 + k / 1000:.3f}" for word in ("left", "right") for k in range(50)]
    result = read(text("time_s,side,body_height_m", rows), trials="side")
    assert [part.part for part in result.parts] == ["trial_left", "trial_right"]
    assert {part.channels[0].name for part in result.parts} == {"body_height"}


@pytest.mark.parametrize("jitter_ms", [0, 2])
def test_series_of_clocks_of_their_own_are_asked_about(jitter_ms: int) -> None:
    """Two sensors, each by its own clock, were one channel at 350 Hz."""
    noise = np.random.default_rng(1).integers(0, jitter_ms + 1, (100, 2))
    rows = [
        f"{word},{20 * k + 3 * at + noise[k, at]},0.4" for k in range(100) for at, word in enumerate(("BODY", "FOOT"))
    ]
    columns = {"2": ColumnDeclaration("time", "ms"), "BODY": ColumnDeclaration("body_height", "m")}
    data = "\n".join([*rows, ""]).encode()
    by_place = {**columns, "3": ColumnDeclaration("body_height", "m")}
    assert "series_interleaved" in rules(read(data, columns=by_place))
    result = read(data, columns=columns, trials="1")
    assert [part.part for part in result.parts] == ["trial_body", "trial_foot"]
    assert [part.channels[0].name for part in result.parts] == ["body_height", "foot"]
    alternating = [f"{'LR'[k % 2]},{10 * k + noise[k // 2, k % 2]},0.4" for k in range(200)]
    assert "series_interleaved" not in rules(read("\n".join([*alternating, ""]).encode(), columns=by_place))


def test_words_beside_stamps_that_repeat_by_chance_part_no_series() -> None:
    rows = [f"{k // 2 / 100:.2f},{'stance' if k % 9 else 'flight'},0.4" for k in range(90)]
    assert "series_interleaved" not in rules(read(text("time_s,state,height_m", rows)))
