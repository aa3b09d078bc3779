import dataclasses
import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from reports.drawn import LegDrawing, ModeSpan, Trajectory
from reports.figures.jump_animation import FRAMES_PER_SECOND, MOST_FRAMES, frame_times, knee_m, write_animation
from reports.figures.kind import svg_bytes
from reports.figures.trajectory import draw_trajectory

LEG = LegDrawing(0.1, 0.2, 0.03)


@pytest.fixture
def trajectory():
    time = np.linspace(0.0, 0.12, 60)
    foot = np.where(time < 0.05, -time, -0.05 + 0.2 * np.maximum(time - 0.08, 0.0))
    return Trajectory(
        title="own: one jump",
        time_s=time,
        body_height_m=0.2 + 0.1 * np.sin(20 * time),
        foot_height_m=foot,
        leg_force_n=50 * np.cos(20 * time),
        ground_height_m=np.minimum.accumulate(foot),
        leg=LEG,
        spans=(
            ModeSpan(0.0, 0.05, "intruding", "platform yields"),
            ModeSpan(0.05, 0.06, "jammed", "stands"),
            ModeSpan(0.06, 0.065, "intruding", "platform yields"),
            ModeSpan(0.065, 0.08, "jammed", "stands"),
            ModeSpan(0.08, 0.12, "flight", "flight"),
        ),
        marks=(("lift-off", 0.08), ("apex", 0.1)),
    )


def test_heights_and_force_over_one_time_with_every_mode_named_once(trajectory):
    figure = draw_trajectory(trajectory)
    heights, force = figure.axes
    assert heights.get_title("left") == "own: one jump"
    assert (heights.get_ylabel(), force.get_ylabel(), force.get_xlabel()) == ("Height (m)", "Leg force (N)", "Time (s)")
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert sorted(names) == sorted(
        ["platform yields", "stands", "body", "foot", "ground", "lift-off", "apex", "leg's push"]
    )
    bands = [patch for patch in heights.patches if patch.get_alpha()]
    assert len(bands) == 4  # flight has none
    ElementTree.fromstring(svg_bytes(figure))


@given(st.floats(0.1001, 0.2999), st.floats(-1.0, 1.0))
def test_the_knee_is_a_link_from_the_hip_and_a_link_from_the_foot(length, foot):
    out, up = knee_m(LEG, foot + length, foot)
    assert math.hypot(out, foot + length - up) == pytest.approx(LEG.upper_link_m)
    assert math.hypot(out, up - foot) == pytest.approx(LEG.lower_link_m)


def test_a_leg_longer_than_it_reaches_is_drawn_straight():
    assert knee_m(LEG, 0.35, 0.0) == (0.0, pytest.approx(0.25))


def test_an_animation_plays_slower_and_shows_all_of_the_motion(trajectory, tmp_path):
    path = tmp_path / "jump.gif"
    write_animation(trajectory, path)
    times, slower = frame_times(trajectory)
    assert (times[0], times[-1]) == (trajectory.time_s[0], trajectory.time_s[-1])
    with Image.open(path) as picture:
        assert picture.n_frames == len(times)
        length_s = len(times) * picture.info["duration"] / 1000.0
    assert length_s == pytest.approx(slower * 0.12, abs=2.0 / FRAMES_PER_SECOND)


def test_an_animation_has_the_title_of_the_plot(trajectory, tmp_path):
    """Above the axes, all of it, and in every frame: with another title, that is other and nothing else."""

    short = dataclasses.replace(trajectory, time_s=0.1 * trajectory.time_s, spans=(), marks=())

    def frames(title):
        write_animation(dataclasses.replace(short, title=title), tmp_path / "jump.gif")
        with Image.open(tmp_path / "jump.gif") as picture:
            for number in (0, picture.n_frames - 1):
                picture.seek(number)
                yield np.asarray(picture.convert("L"), dtype=int)

    one, other = list(frames("own: one jump")), list(frames("jump: one own"))  # of one height and depth
    for first, second in zip(one, other, strict=True):
        rows, columns = np.nonzero(np.abs(first - second) > 60)
        assert rows.size > 50
        assert 0 < rows.min() <= rows.max() < 0.05 * first.shape[0]
        assert 0 < columns.min() <= columns.max() < 0.5 * first.shape[1]
    for first, longer in zip(one, frames("own: one jump, " + "with many words in its title, " * 6), strict=True):
        assert longer.shape[0] > first.shape[0]  # more lines make the picture higher
        assert (longer[:, -1] > 250).all()  # and none is cut off


def test_a_long_motion_has_no_more_frames_than_a_short_one(trajectory):
    hour = dataclasses.replace(trajectory, time_s=np.linspace(0.0, 3600.0, trajectory.time_s.size))
    times, slower = frame_times(hour)
    assert len(times) == MOST_FRAMES
    assert slower < 1.0
