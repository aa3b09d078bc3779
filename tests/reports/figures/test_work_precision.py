import dataclasses
import xml.etree.ElementTree as ElementTree

import pytest

from reports.drawn import Curve, Mark, Panel, WorkPrecision
from reports.figures.kind import svg_bytes
from reports.figures.work_precision import draw_work_precision

METHODS = ("slow", "quick", "labbook")


def curves(factor):
    return tuple(
        Curve(name, "accuracy", tuple(Mark(f"1e-{n}", seconds * n, factor * 100.0**-n) for n in range(1, 5)))
        for name, seconds in zip(METHODS, (1.0, 1e-2, 1e-5), strict=True)
    )


@pytest.fixture(scope="module")
def study():
    outputs = ("Deepest foot", "Lift-off time", "Apex height", "Cost in joules")
    panels = tuple(Panel(output, 1e-12, curves(10.0**-n)) for n, output in enumerate(outputs))
    return WorkPrecision("own: one jump", METHODS, panels, ("slow at rtol 1e-9: gave up.",))


@pytest.fixture(scope="module")
def figure(study):
    figure = draw_work_precision(study)
    ElementTree.fromstring(svg_bytes(figure))
    return figure


def test_a_panel_an_output_and_every_method_named_once(study, figure):
    assert [axes.get_title("left") for axes in figure.axes] == [panel.output for panel in study.panels]
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
        assert [text.get_text() for text in axes.texts] == ["1e-1", "1e-2", "1e-3", "1e-4"]


def test_all_that_was_found_is_inside_the_axes(study, figure):
    for axes, panel in zip(figure.axes, study.panels, strict=True):
        low, high = axes.get_ylim()
        assert low < panel.floor
        assert all(low < mark.error < high for curve in panel.curves for mark in curve.marks)


def test_settings_beside_the_leftmost_marks_do_not_touch_the_axis(figure):
    for axes in figure.axes:
        left_edge = axes.get_window_extent().x0
        assert min(text.get_window_extent().x0 for text in axes.texts) > left_edge + 2.0
        assert all(line.get_window_extent().x1 < axes.get_window_extent().x1 for line in axes.lines)


def test_a_method_keeps_its_colour_where_another_does_not_cover_the_scene(study):
    def colours(drawn):
        return {line.get_label(): line.get_color() for line in draw_work_precision(drawn).axes[0].lines}

    without = tuple(dataclasses.replace(panel, curves=panel.curves[1:]) for panel in study.panels)
    fewer = colours(dataclasses.replace(study, panels=without))
    assert fewer == {name: colour for name, colour in colours(study).items() if name != "slow"}


def test_fewer_outputs_than_places_and_nothing_at_all(study):
    three = draw_work_precision(dataclasses.replace(study, panels=study.panels[:3], notes=()))
    assert [axes.get_visible() for axes in three.axes] == [True, True, True, False]
    ElementTree.fromstring(svg_bytes(three))
