import dataclasses
import xml.etree.ElementTree as ElementTree

import pytest

from reports.figures.kind import svg_bytes
from reports.figures.work_precision import draw_work_precision
from simulator.accuracy.methods import NAMES, TITLES
from simulator.accuracy.reference_of import Reference
from simulator.accuracy.study import AccuracyStudy, Point, Series
from simulator.scene_file import load_scene

METHODS = ("slow", "quick", "labbook")


def series(name, seconds):
    points = [
        Point(10.0**-n, "apex", {output: 100.0**-n / 10.0**place for place, output in enumerate(NAMES)}, 1, seconds * n)
        for n in range(1, 5)
    ]
    return Series(name, "accuracy", "", tuple(points))


@pytest.fixture(scope="module")
def study():
    exact = dict.fromkeys(NAMES, 1e-12)
    reference = Reference("made up", True, "apex", dict.fromkeys(NAMES, 1.0), exact, exact)
    found = (series(name, seconds) for name, seconds in zip(METHODS, (1.0, 1e-2, 1e-5), strict=True))
    return AccuracyStudy(load_scene("sim2"), reference, tuple(found))


@pytest.fixture(scope="module")
def figure(study):
    figure = draw_work_precision(study, "own: one jump", ["slow at rtol 1e-9: gave up."])
    ElementTree.fromstring(svg_bytes(figure))
    return figure


def test_a_panel_an_output_and_every_method_named_once(study, figure):
    assert [axes.get_title("left") for axes in figure.axes] == list(TITLES.values())
    legend = figure.legends[0]
    assert [text.get_text() for text in legend.get_texts()] == [
        "slow",
        "quick",
        "labbook (beside its marks: accuracy)",
        "round-off: nothing is claimed",
    ]
    assert "gave up" in legend.get_title().get_text()
    for axes in figure.axes:
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
        assert len(axes.lines) == len(METHODS)
        assert [text.get_text() for text in axes.texts] == ["0.1", "1e-2", "1e-3", "1e-4"]


def test_all_that_was_found_is_inside_the_axes(study, figure):
    for axes, output in zip(figure.axes, NAMES, strict=True):
        low, high = axes.get_ylim()
        assert low < 1e-12
        assert all(low < point.errors[output] < high for series in study.series for point in series.points)


def test_an_output_of_which_nothing_is_known_has_no_panel(study):
    unknown = {**study.reference.doubt, "cost_J": None}
    three = draw_work_precision(
        dataclasses.replace(study, reference=dataclasses.replace(study.reference, doubt=unknown)), "own"
    )
    assert [axes.get_visible() for axes in three.axes] == [True, True, True, False]
    ElementTree.fromstring(svg_bytes(three))
