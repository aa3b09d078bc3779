import dataclasses
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from reports.display import LogGap, LogJump
from reports.figures.kind import svg_bytes
from reports.figures.log import draw_log, draw_logs_overlaid, envelope
from tests.helpers.wording import says

NAMED = {"apex", "not used", "touchdown", "lift-off", "enlarged below"}


def named(figure):
    """What the legend names; it hides none of the panels and is not cut off."""
    (legend,) = figure.legends
    figure.draw_without_rendering()
    place, page = legend.get_window_extent(), figure.bbox
    assert page.x0 <= place.x0 < place.x1 <= page.x1
    assert page.y0 <= place.y0 < place.y1 <= min(axes.get_tightbbox().y0 for axes in figure.axes)
    return {text.get_text() for text in legend.get_texts()}


def test_a_log_has_an_overview_and_a_jump(run_log):
    figure = draw_log(run_log)
    overview, panel = figure.axes
    says(overview.get_title("left"), "r0042", "small foot")
    says(panel.get_title("left"), "Jump", "1", "6.6")
    assert named(figure) == {*NAMED, "gap (dropped)", "gap (pause)"}
    ElementTree.fromstring(svg_bytes(figure))


def test_no_line_crosses_a_gap(run_log):
    lines = [line for line in draw_log(run_log).axes[0].lines if line.get_marker() == "None"]
    for gap in run_log.gaps:
        for line in lines:
            times = np.asarray(line.get_xdata())
            assert not ((times.min() <= gap.start_s) & (times.max() >= gap.end_s))


def test_a_chosen_jump_and_why_it_is_excluded(run_log):
    figure = draw_log(dataclasses.replace(run_log, panel_jump=5))
    says(figure.axes[1].get_title("left"), "5", "62.65", "touched by hand")


def test_a_log_without_jumps_or_without_samples(run_log):
    assert len(draw_log(dataclasses.replace(run_log, jumps=())).axes) == 1
    empty = dataclasses.replace(run_log, time_s=np.empty(0), body_height_m=np.empty(0), jumps=(), gaps=())
    ElementTree.fromstring(svg_bytes(draw_log(empty)))


def test_thinning_keeps_every_extreme():
    rng = np.random.default_rng(3)
    time, height = np.arange(216_000) / 300.0, rng.normal(size=216_000)
    height[123_456] = 9.0
    thin_time, thin_height = envelope(time, height)
    assert thin_time.size <= 4000
    assert np.all(np.diff(thin_time) > 0)
    assert (thin_height.max(), thin_height.min()) == (height.max(), height.min())


def test_a_misfire_is_marked_on_the_trace_and_shown_as_one(run_log):
    misfire = LogJump(9, 50.0, None, touchdown_s=50.0, excluded="no flight", misfire=True)
    figure = draw_log(dataclasses.replace(run_log, jumps=(*run_log.jumps, misfire), panel_jump=9))
    overview, panel = figure.axes
    says(panel.get_title("left"), "9", "50.00 s", "misfire")
    marks = [at for line in overview.lines if line.get_marker() == "X" for at in line.get_xydata().tolist()]
    assert [50.0, np.interp(50.0, run_log.time_s, run_log.body_height_m)] in marks
    assert "lift-off" in named(figure)  # of the other jumps


def test_leg_length_is_drawn_below_the_jump_where_it_was_recorded(run_log):
    lengths = np.where(run_log.time_s < 60.0, 0.27, np.nan)
    figure = draw_log(dataclasses.replace(run_log, leg_length_m=lengths))
    assert len(figure.axes) == 3
    assert figure.axes[1].get_xlim() == figure.axes[2].get_xlim()


def test_a_restart_of_unknown_length_lets_times_begin_again(run_log):
    pause = LogGap(60.0, 65.0, "restart, of unknown length", length_known=False)
    figure = draw_log(dataclasses.replace(run_log, gaps=(run_log.gaps[0], pause, run_log.gaps[1]), panel_jump=6))
    overview, panel = figure.axes
    shown = overview.xaxis.get_major_formatter()
    assert [shown(at_s, 0) for at_s in (0.0, 60.0, 65.0, 80.0)] == ["0", "60", "0", "15"]
    says(panel.get_title("left"), "6", "11.6")  # at 76.65 s of the axis
    assert "gap (restart, of unknown length)" in named(figure)


def moved(log, by_s):
    """The same log, begun later."""
    jumps = [
        dataclasses.replace(
            jump, at_s=jump.at_s + by_s, touchdown_s=jump.touchdown_s + by_s, lift_off_s=jump.lift_off_s + by_s
        )
        for jump in log.jumps
    ]
    gaps = [dataclasses.replace(gap, start_s=gap.start_s + by_s, end_s=gap.end_s + by_s) for gap in log.gaps]
    return dataclasses.replace(log, run="r0043", time_s=log.time_s + by_s, jumps=tuple(jumps), gaps=tuple(gaps))


def traces(axes):
    """The points of each colour, those of one log after the other."""
    found = {}
    for line in axes.lines:
        found.setdefault(line.get_color(), []).append(np.asarray(line.get_xydata()))
    return [np.concatenate(several) for several in found.values()]


def test_two_logs_lie_over_each_other_from_their_first_lift_off_or_else_their_start(run_log):
    for log, panels in ((run_log, 2), (dataclasses.replace(run_log, jumps=()), 1)):
        figure = draw_logs_overlaid(log, moved(log, 7.5))
        assert len(figure.axes) == panels
        first, second = traces(figure.axes[0])
        np.testing.assert_allclose(first, second, atol=1e-9)
        at_0_s = log.jumps[0].lift_off_s if log.jumps else log.time_s[0]
        assert first[:, 0].min() == pytest.approx(log.time_s[0] - at_0_s)
        says([text.get_text() for text in figure.legends[0].get_texts()], "r0043")
        says(figure.axes[-1].get_xlabel(), "(s)")
        says(figure.axes[-1].get_ylabel(), "(m)")
        ElementTree.fromstring(svg_bytes(figure))


def test_a_log_ends_where_its_times_are_not_known(run_log):
    cut = dataclasses.replace(run_log, gaps=(LogGap(50.0, 55.0, "restart", length_known=False),), jumps=())
    first, second = traces(draw_logs_overlaid(cut, dataclasses.replace(run_log, jumps=())).axes[0])
    assert first[:, 0].max() == pytest.approx(50.0, abs=0.1)
    assert second[:, 0].max() > 100.0


def test_a_log_without_samples_lies_beside_one_with_them(run_log):
    empty = dataclasses.replace(run_log, time_s=np.empty(0), body_height_m=np.empty(0), jumps=(), gaps=())
    ElementTree.fromstring(svg_bytes(draw_logs_overlaid(run_log, empty)))
