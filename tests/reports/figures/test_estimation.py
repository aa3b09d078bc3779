import dataclasses
import itertools
import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.figures.estimation import Estimation, EstimationGroup, draw_estimation
from reports.figures.estimation_parts import swarm
from reports.figures.kind import svg_bytes
from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN
from reports.numbers import Number
from tests.helpers.wording import says

WIDTHS = [ONE_COLUMN_IN, pytest.param(TWO_COLUMNS_IN, marks=pytest.mark.soak)]


@pytest.fixture
def two():
    control, treated = (16.4, 15.8, 17.1, 16.0), (14.2, 13.1, 13.9)
    groups = (EstimationGroup("CE", control), EstimationGroup("active damping", treated))
    return Estimation("Energy", "J", groups, 0, (None, Number(-2.59, "J", ci_low=-3.6, ci_high=-1.5)))


@pytest.fixture
def five():
    rng = np.random.default_rng(3)
    groups = tuple(
        EstimationGroup(name, tuple(rng.normal(0.15, 0.002, n).tolist()))
        for name, n in zip(("0", "100", "200", "300", "400"), (10, 10, 40, 2, 1), strict=True)
    )
    number = Number(-0.001, "m", ci_low=-0.003, ci_high=0.001)
    alone = Number(
        -0.001,
        "m",
        ci_low=Undefined(Reason.AS_SAID, said="one value"),
        ci_high=Undefined(Reason.AS_SAID, said="one value"),
    )
    differences = (None, number, number, Number(Undefined(Reason.AS_SAID, said="no value"), "m"), alone)
    return Estimation("Apex height", "m", groups, 0, differences, bounds=(-0.005, 0.005))


def points(axes):
    """Every mark of the swarms: they are the half transparent ones."""
    return [tuple(at) for line in axes.lines if line.get_alpha() == 0.75 for at in line.get_xydata()]


def words(figure):
    return [text.get_text() for axes in figure.axes for text in axes.texts]


@pytest.mark.parametrize("width_in", WIDTHS)
def test_zero_of_the_differences_lies_at_the_mean_of_the_reference(two, width_in):
    for turned in (
        two,
        dataclasses.replace(two, groups=two.groups[::-1], reference=1, differences=(two.differences[1], None)),
    ):
        left, right = draw_estimation(turned, width_in).axes
        mean = math.fsum(two.groups[0].values) / 4
        zero = left.transData.inverted().transform(right.transData.transform((0, 0.0)))[1]
        assert zero == pytest.approx(mean, rel=1e-12)
        says(right.get_ylabel(), "difference from CE")
        assert left.get_ylabel() == "Energy (J)"
        assert [label.get_text().split("\n")[0] for label in left.get_xticklabels()] == [
            "CE", "active damping", "difference",
        ]  # fmt: skip
        drawn = points(left)
        assert sorted(y for x, y in drawn if abs(x) < 0.4) == sorted(two.groups[0].values)
        assert sorted(y for x, y in drawn if abs(x - 1) < 0.4) == sorted(two.groups[1].values)
        assert any(np.allclose(line.get_ydata(), [mean - 3.6, mean - 1.5]) for line in left.lines)


@pytest.mark.parametrize("width_in", WIDTHS)
def test_more_groups_have_their_differences_below_in_the_unit_that_is_shown(five, width_in):
    figure = draw_estimation(five, width_in)
    upper, lower = figure.axes
    assert upper.get_ylabel() == "Apex height (mm)"
    says(lower.get_ylabel(), "Mean difference", "0", "95")
    assert len(points(upper)) == 63
    assert sorted(y for _x, y in points(upper)) == pytest.approx(
        sorted(1000 * value for group in five.groups for value in group.values)
    )
    levels = {round(float(line.get_ydata()[0]), 9) for line in lower.lines}
    assert {-5.0, 5.0, -1.0, -3.0} <= levels
    assert words(figure) == ["undefined", "no interval"]
    ElementTree.fromstring(svg_bytes(figure))


@pytest.mark.parametrize("width_in", WIDTHS)
def test_names_and_axes_lie_inside_the_figure_and_apart(five, width_in):
    named = dataclasses.replace(five.groups[0], name="active-damping coefficient 0 kg/s")
    figure = draw_estimation(dataclasses.replace(five, groups=(named, *five.groups[1:])), width_in)
    figure.draw_without_rendering()
    boxes = [label.get_window_extent() for label in figure.axes[1].get_xticklabels()]
    assert all(one.x1 < other.x0 for one, other in itertools.pairwise(boxes))
    for axes in figure.axes:
        box = axes.yaxis.label.get_window_extent()
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.y1 <= figure.bbox.y1


def test_a_difference_in_another_unit_or_much_wider_than_the_values_has_a_panel_below(two):
    percent = Number(15.0, "%", ci_low=8.0, ci_high=22.0)
    below = draw_estimation(dataclasses.replace(two, differences=(None, percent), difference="Savings"))
    assert below.axes[1].get_ylabel().startswith("Savings (%)")
    wide = Number(-2.59, "J", ci_low=-40.0, ci_high=35.0)
    assert (
        len(
            {
                axes.get_position().y0
                for axes in draw_estimation(dataclasses.replace(two, differences=(None, wide))).axes
            }
        )
        == 2
    )


def test_days_have_marks_of_their_own_until_they_are_too_many(two):
    def drawn(labels):
        groups = tuple(dataclasses.replace(group, labels=labels[: len(group.values)]) for group in two.groups)
        return draw_estimation(dataclasses.replace(two, groups=groups), ONE_COLUMN_IN)

    days = drawn(("1 June", "2 June", "1 June", "2 June"))
    (legend,) = days.legends
    assert [text.get_text() for text in legend.get_texts()] == ["1 June", "2 June"]
    assert {line.get_marker() for line in days.axes[0].lines if line.get_alpha() == 0.75} == {"o", "s"}
    assert len(points(days.axes[0])) == 7
    assert drawn(("1 June",) * 4).legends == []
    many = tuple(EstimationGroup(name, tuple(map(float, range(9))), tuple("abcdefghi")) for name in "ab")
    assert draw_estimation(dataclasses.replace(two, groups=many)).legends == []


def test_constant_empty_and_single_groups_are_drawn(two):
    nothing = Number(Undefined(Reason.AS_SAID, said="group a is empty"), "J")
    for values in ((), (0.1,), (0.1,) * 5):
        groups = (EstimationGroup("CE", values), EstimationGroup("AD", (0.1, 0.1)))
        figure = draw_estimation(dataclasses.replace(two, groups=groups, differences=(None, nothing)))
        assert len(points(figure.axes[0])) == len(values) + 2
        ElementTree.fromstring(svg_bytes(figure))


@given(st.lists(st.floats(0, 20).map(lambda x: round(x, 1)), min_size=1, max_size=17))
def test_no_point_of_a_swarm_covers_another(values):
    axes = Figure(figsize=(3.5, 4)).add_subplot()
    axes.set_xlim(-0.5, 1.5)
    axes.set_ylim(-1, 101)
    offsets = swarm(values, axes, 3.0)
    assert max(map(abs, offsets)) <= 0.3
    at = axes.transData.transform(list(zip(offsets, values, strict=True))) * 72.0 / axes.figure.dpi
    assert min((math.dist(one, other) for one, other in itertools.combinations(at, 2)), default=9.0) >= 3.0
    assert swarm([7.0] * 500, axes, 3.0) == swarm([7.0] * 500, axes, 3.0)


@pytest.mark.parametrize("width_in", WIDTHS)
@pytest.mark.parametrize("count", [3, 30])
def test_marks_stay_clear_of_the_line_of_the_sd_beside_them(count, width_in):
    rng = np.random.default_rng(count)
    groups = tuple(EstimationGroup(f"g{place}", tuple(rng.normal(0.0, 1.0, 12).tolist())) for place in range(count))
    number = Number(0.1, "J", ci_low=-1.0, ci_high=1.2)
    upper = draw_estimation(Estimation("Energy", "J", groups, 0, (None, *[number] * (count - 1))), width_in).axes[0]
    in_pt = 72.0 / upper.figure.dpi

    def across(x):
        return upper.transData.transform((x, 0.0))[0] * in_pt

    sds = sorted({float(line.get_xdata()[0]) for line in upper.lines if line.get_linewidth() == 1.6})
    assert len(sds) == count
    for line in upper.lines:
        if line.get_alpha() == 0.75:
            right = max(across(x) for x in line.get_xdata()) + line.get_markersize() / 2
            beside = across(next(at for at in sds if at > line.get_xdata().max()))
            assert right <= beside - 0.8


@pytest.mark.parametrize("width_in", WIDTHS)
@pytest.mark.parametrize("called", ["", "Savings against gain 0"])
def test_the_words_beside_a_panel_are_no_longer_than_it_is(called, width_in):
    unit = "%" if called else "J"
    number = Number(3.0, unit, ci_low=-20.0, ci_high=17.0)
    groups = tuple(EstimationGroup(f"gain {gain}", (9.0, 10.0, 11.5)) for gain in (0, 50, 100))
    figure = draw_estimation(
        Estimation("Energy of a jump", "J", groups, 0, (None, number, number), (), called), width_in
    )
    figure.draw_without_rendering()
    for axes in figure.axes:
        assert axes.yaxis.label.get_window_extent().height <= 0.9 * axes.get_window_extent().height
    ticks = [round(abs(float(tick)), 9) for tick in figure.axes[1].get_yticks() if tick]
    assert all(
        tick / 10.0 ** math.floor(math.log10(tick)) in (1.0, 2.0, 3.0, 4.0, 5.0, 2.5, 7.5, 1.5) for tick in ticks
    )


def captions(groups, *differences):
    """What stands above a figure of these values, and at its places and axes."""
    drawn = tuple(EstimationGroup(name, values) for name, values in zip("abc", groups, strict=False))
    estimation = Estimation("Energy", "J", drawn, 0, (None, *differences), interval="Welch's t")
    figure = draw_estimation(estimation)
    about = [axes.get_ylabel() for axes in figure.axes]
    about += [label.get_text() for label in figure.axes[0].get_xticklabels()]
    return figure.get_suptitle(), any("%" in text for text in about)


def test_a_caption_names_only_what_is_drawn():
    scattered, alike, whole = (1.0, 2.0), (3.0, 3.0), Number(1.5, "J", ci_low=0.5, ci_high=2.5)
    none = Undefined(Reason.NO_GROUP_SCATTERS)
    without = Number(1.5, "J", ci_low=none, ci_high=none)
    undefined, endless = Number(none, "J"), Number(1.5, "J", ci_low=-math.inf, ci_high=math.inf)
    both, method = "Gapped line: mean and SD.", "Interval: Welch's t."
    assert captions((scattered, scattered), whole) == (f"{both} {method}", True)
    for absent in (without, undefined, endless):
        assert captions((scattered, scattered), absent) == (both, False)
        assert captions((scattered, scattered, scattered), absent, absent) == (both, False)
        assert captions((scattered, scattered, scattered), absent, whole) == (f"{both} {method}", True)
    caption, scatters = captions((alike, alike, alike), without, without)
    says(caption, "Short line", "without an SD")
    assert not scatters
    assert captions((alike, scattered), whole) == (f"{both} Short line: mean without an SD. {method}", True)
