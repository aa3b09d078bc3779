import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from reports.drawn import ModeSpan, Trajectory
from reports.figures.kind import svg_bytes
from reports.figures.trajectory import draw_trajectory


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
