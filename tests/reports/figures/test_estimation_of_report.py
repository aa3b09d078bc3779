import dataclasses

import pytest

from data_schema.outcomes import Outcome
from reports.figures.kind import draw_figure
from reports.figures.registry import FIGURES
from reports.figures.style import TWO_COLUMNS_IN
from tests.reports.made import changed as with_decisions


@pytest.fixture(scope="module")
def drawn(content):
    """The figures of the unchanged content, which no test changes."""
    return {
        name: draw_figure(FIGURES[name], content, TWO_COLUMNS_IN) for name in ("estimation_joules", "estimation_apex")
    }


def panels(figure):
    """Upper and lower axes of every group."""
    shown = [axes for axes in figure.axes if axes.get_visible()]
    uppers = [axes for axes in shown if axes.get_title()]
    return uppers, [axes for axes in shown if axes not in uppers]


def points(axes, mark="o"):
    """The values that are drawn with a mark on an axis."""
    return sorted(y for line in axes.lines if line.get_marker() == mark for y in line.get_ydata())


def intervals(axes):
    """The ends of the vertical lines at the treatment's place, the thinner first."""
    found = [line for line in axes.lines if list(line.get_xdata()) == [1.0, 1.0]]
    return [list(line.get_ydata()) for line in sorted(found, key=lambda line: line.get_linewidth())]


@pytest.mark.parametrize(
    ("name", "quantity", "factor"),
    [("estimation_joules", Outcome.JOULES, 1.0), ("estimation_apex", Outcome.APEX, 1000.0)],
)
def test_every_run_of_control_and_treatment_is_drawn(content, drawn, name, quantity, factor):
    uppers, lowers = panels(drawn[name])
    assert len(uppers) == len(lowers) == 4
    for axes, (foot, gain) in zip(
        uppers, [("small", 300), ("small", 400), ("large", 300), ("large", 400)], strict=True
    ):
        values = [
            factor * value
            for condition in content.conditions
            if (condition.levels[0].label, condition.levels[1].gain) == (foot, gain)
            for _run, value in condition.summary(quantity).runs
        ]
        assert len(values) == 64
        assert points(axes) == pytest.approx(sorted(values))
    pooled = [c for c in content.comparisons if c.opens and c.quantity is quantity]
    for axes, comparison in zip(lowers, pooled, strict=True):
        difference = comparison.decision.difference
        assert points(axes, "_") == pytest.approx([factor * difference.value])
        assert points(axes) == []
        assert intervals(axes)[0] == pytest.approx([factor * difference.ci_low, factor * difference.ci_high])
    assert len({axes.get_ylim() for axes in lowers}) == 1
    assert len({axes.get_ylim() for axes in uppers}) == (1 if quantity is Outcome.JOULES else 4)


def test_bounds_are_drawn_in_the_unit_of_the_difference(content, drawn):
    def dashed(figure):
        lowers = panels(figure)[1]
        return [[line.get_ydata()[0] for line in axes.lines if line.get_linestyle() == "--"] for axes in lowers]

    assert dashed(drawn["estimation_apex"]) == [[-5.0, 5.0]] * 4
    assert dashed(drawn["estimation_joules"]) == [[]] * 4
    item = next(c.decision.equivalence for c in content.comparisons if c.decision.equivalence is not None)
    percent = dataclasses.replace(
        item, low=-3.0, high=3.0, percent=True, estimate=dataclasses.replace(item.estimate, unit="%")
    )
    changed = with_decisions(content, lambda c: c.quantity is Outcome.APEX, equivalence=percent)
    means_m = [condition.summary(Outcome.APEX).mean.value for condition in content.conditions if condition.control]
    for found, mean_m in zip(
        dashed(draw_figure(FIGURES["estimation_apex"], changed, TWO_COLUMNS_IN)), means_m, strict=True
    ):
        assert found == pytest.approx([-30.0 * mean_m, 30.0 * mean_m])


def test_the_interval_of_the_test_lies_thick_behind_that_of_the_difference(content, drawn):
    pooled = [c for c in content.comparisons if c.opens and c.quantity is Outcome.APEX]
    for axes, comparison in zip(panels(drawn["estimation_apex"])[1], pooled, strict=True):
        estimate = comparison.decision.equivalence.estimate
        thin, thick = intervals(axes)
        assert thick == pytest.approx([1000.0 * estimate.ci_low, 1000.0 * estimate.ci_high])
        assert thin[0] < thick[0] < thick[1] < thin[1]
    assert all(len(intervals(axes)) == 1 for axes in panels(drawn["estimation_joules"])[1])
