import dataclasses
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from reports.figures.kind import svg_bytes
from reports.figures.log import draw_log, envelope
from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN


@pytest.mark.parametrize("width_in", [ONE_COLUMN_IN, TWO_COLUMNS_IN])
def test_a_log_has_an_overview_and_a_jump(run_log, width_in):
    figure = draw_log(run_log, width_in)
    overview, panel = figure.axes
    assert overview.get_title("left") == "Run r0042: small foot, CE"
    assert panel.get_title("left") == "Jump 1"
    names = {text.get_text() for text in figure.legends[0].get_texts()}
    assert names == {"apex", "excluded: touched by hand", "touchdown", "lift-off", "gap (dropped)", "gap (pause)"}
    ElementTree.fromstring(svg_bytes(figure))


def test_no_line_crosses_a_gap(run_log):
    lines = [line for line in draw_log(run_log).axes[0].lines if line.get_marker() == "None"]
    for gap in run_log.gaps:
        for line in lines:
            times = np.asarray(line.get_xdata())
            assert not ((times.min() <= gap.start_s) & (times.max() >= gap.end_s))


def test_a_chosen_jump_and_why_it_is_excluded(run_log):
    figure = draw_log(dataclasses.replace(run_log, panel_jump=5))
    assert figure.axes[1].get_title("left") == "Jump 5, excluded: touched by hand"


def test_a_log_without_jumps_or_without_samples(run_log):
    assert len(draw_log(dataclasses.replace(run_log, jumps=())).axes) == 1
    empty = dataclasses.replace(run_log, time_s=np.empty(0), body_height_m=np.empty(0), jumps=(), gaps=())
    ElementTree.fromstring(svg_bytes(draw_log(empty)))


def test_the_same_log_gives_the_same_bytes(run_log):
    assert svg_bytes(draw_log(run_log)) == svg_bytes(draw_log(run_log))


def test_thinning_keeps_every_extreme():
    rng = np.random.default_rng(3)
    time, height = np.arange(216_000) / 300.0, rng.normal(size=216_000)
    height[123_456] = 9.0
    thin_time, thin_height = envelope(time, height)
    assert thin_time.size <= 4000
    assert np.all(np.diff(thin_time) > 0)
    assert (thin_height.max(), thin_height.min()) == (height.max(), height.min())
