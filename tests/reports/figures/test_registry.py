import dataclasses
import xml.etree.ElementTree as ElementTree

import pytest

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.figures.by_level import file_name
from reports.figures.kind import draw_figure, svg_bytes
from reports.figures.registry import FIGURES
from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN
from reports.numbers import Number
from reports.results import Factor, Level, Limits
from tests.helpers.pages import FIGURE_NAMES, with_summary
from tests.helpers.wording import says


@pytest.mark.parametrize("name", FIGURE_NAMES)
def test_files_have_their_width_no_date_and_embedded_fonts(content, written, name):
    folder = written.parent / "figures"
    for ending, width_in in (("", TWO_COLUMNS_IN), ("_one_column", ONE_COLUMN_IN)):
        svg = (folder / f"{file_name(name, content)}{ending}.svg").read_bytes()
        root = ElementTree.fromstring(svg)
        assert float(root.attrib["viewBox"].split()[2]) == pytest.approx(72 * width_in)
        assert b"<dc:date>" not in svg
        pdf = (folder / f"{file_name(name, content)}{ending}.pdf").read_bytes()
        assert b"/FontFile2" in pdf
        assert b"/Type3" not in pdf
        assert b"/CreationDate" not in pdf


@pytest.mark.parametrize("name", FIGURE_NAMES)
def test_every_figure_draws_for_one_condition_alone(minimal, name):
    kind = FIGURES[name]
    ElementTree.fromstring(svg_bytes(draw_figure(kind, minimal, ONE_COLUMN_IN)))
    assert kind.absent(minimal) is None or kind.absent(minimal).endswith(".")


@pytest.mark.parametrize("name", FIGURE_NAMES)
def test_every_figure_says_in_words_what_it_shows(content, name):
    kind = FIGURES[name]
    assert kind.absent(content) is None
    assert len(kind.caption(content)) > 40
    assert len(kind.alternative(content)) > 40


NOTHING = Undefined(Reason.AS_SAID, said="one run only")


def undefined_everywhere(part):
    """The content with no number in it that exists."""
    if isinstance(part, Number):
        return Number(NOTHING, part.unit, se=NOTHING, ci_low=NOTHING, ci_high=NOTHING, n=1)
    if isinstance(part, Limits):
        return None
    if isinstance(part, tuple):
        return tuple(map(undefined_everywhere, part))
    if isinstance(part, dict):
        return {name: undefined_everywhere(value) for name, value in part.items()}
    if not dataclasses.is_dataclass(part):
        return part
    values = {field.name: getattr(part, field.name) for field in dataclasses.fields(part)}
    changed = {name: value for name, old in values.items() if (value := undefined_everywhere(old)) != old}
    return dataclasses.replace(part, **changed)


@pytest.mark.parametrize("name", FIGURE_NAMES)
def test_numbers_that_do_not_exist_are_left_out_or_named(content, name):
    changed = undefined_everywhere(content)
    kind = FIGURES[name]
    ElementTree.fromstring(svg_bytes(draw_figure(kind, changed, TWO_COLUMNS_IN)))
    assert kind.caption(changed)
    assert "nan" not in kind.alternative(changed)


@pytest.mark.parametrize("name", ["joules_by_level", pytest.param("savings", marks=pytest.mark.soak)])
def test_a_dollar_or_a_strange_letter_in_a_name_is_only_text(content, name):
    first, *others = content.conditions
    levels = tuple(dataclasses.replace(level, label="$\\frac{1") for level in first.levels)
    changed = dataclasses.replace(content, conditions=(dataclasses.replace(first, levels=levels), *others))
    ElementTree.fromstring(svg_bytes(draw_figure(FIGURES[name], changed, ONE_COLUMN_IN)))


def test_a_study_without_a_swept_factor_or_with_three_factors_is_drawn(content):
    plain = tuple(dataclasses.replace(factor, swept=False) for factor in content.factors)
    for factors in (plain, plain[:1], (*plain[:2], dataclasses.replace(plain[2], swept=True))):
        changed = dataclasses.replace(content, factors=factors)
        ElementTree.fromstring(svg_bytes(draw_figure(FIGURES["joules_by_level"], changed, TWO_COLUMNS_IN)))


def raised(condition, by_m):
    apex = condition.summaries[Outcome.APEX]
    runs = tuple((run, value + by_m) for run, value in apex.runs)
    ends = {"ci_low": apex.mean.ci_low + by_m - 0.01, "ci_high": apex.mean.ci_high + by_m + 0.01}
    mean = dataclasses.replace(apex.mean, value=apex.mean.value + by_m, **ends)
    return with_summary(condition, Outcome.APEX, dataclasses.replace(apex, mean=mean, runs=runs))


def intervals_of(content):
    """The ends of the intervals of apex height, series by series."""
    found = {}
    for one in content.conditions:
        mean = one.summaries[Outcome.APEX].mean
        found.setdefault((one.levels[0].label, one.levels[1].label), []).extend((mean.ci_low, mean.ci_high))
    return found.values()


def test_series_far_apart_get_a_panel_each_at_one_scale(content):
    kind = FIGURES["apex_by_level"]
    assert len(draw_figure(kind, content, TWO_COLUMNS_IN).axes) == 1
    conditions = tuple(
        raised(condition, 0.2) if condition.levels[0].label == "large" else condition
        for condition in content.conditions
    )
    changed = dataclasses.replace(content, conditions=conditions)
    panels = draw_figure(kind, changed, TWO_COLUMNS_IN).axes
    spans = [high - low for low, high in (panel.get_ylim() for panel in panels)]
    assert len(panels) == 4
    assert spans == pytest.approx([spans[0]] * 4)
    for panel, ends in zip(panels, intervals_of(changed), strict=True):
        low, high = panel.get_ylim()
        assert low < 1000 * min(ends)
        assert high > 1000 * max(ends)


def test_each_robot_has_a_line_a_colour_and_a_marker_of_its_own(content):
    kind, robots = FIGURES["passive_drain"], ("Minitaur", "leg_rig 2", "$x_1")
    assert draw_figure(kind, content, TWO_COLUMNS_IN).axes[0].get_legend() is not None
    drains = tuple(dataclasses.replace(content.drains[0], robot=robot) for robot in robots)
    changed = dataclasses.replace(content, drains=drains)
    axes = draw_figure(kind, changed, TWO_COLUMNS_IN).axes[0]
    handles = axes.get_legend().get_lines()
    assert [text.get_text() for text in axes.get_legend().get_texts()] == list(robots)
    assert len({(line.get_color(), line.get_marker()) for line in handles}) == 3
    assert all(f"12 of {robot}" in kind.caption(changed) for robot in robots)
    assert all(robot in kind.alternative(changed) for robot in robots)
    named = dataclasses.replace(content, drains=drains[:1])
    assert svg_bytes(draw_figure(kind, named, ONE_COLUMN_IN)) == svg_bytes(draw_figure(kind, content, ONE_COLUMN_IN))


def test_a_control_that_is_a_plain_number_stands_at_its_value(content):
    """Levels 2 (the control), 1 and 3: the control lies between them, not at 0."""
    load = Factor("load", "Load", unit="kg", control="2", swept=True)
    conditions = tuple(
        dataclasses.replace(c, levels=(Level("load", str(at), float(at), "kg"),), control=at == 2)
        for c, at in zip(content.conditions[:3], (2, 1, 3), strict=True)
    )
    changed = dataclasses.replace(content, factors=(load,), conditions=conditions)
    axes = draw_figure(FIGURES["joules_by_level"], changed, TWO_COLUMNS_IN).axes[0]
    assert axes.get_xticks().tolist() == [1.0, 2.0, 3.0]
    assert [label.get_text().replace("\u00a0", " ") for label in axes.get_xticklabels()] == ["1", "control (2 kg)", "3"]
    says(FIGURES["joules_by_level"].caption(changed).replace("\u00a0", " "), "The control", "2 kg")


def test_days_that_change_a_headline_are_drawn_and_a_variant_that_one_lacks_is_no_heading(content):
    """Of the first headline: one day changes it, the others do not, and it has no other variant."""
    (first, varied), *_ = content.headlines
    one, *others = [each for each in varied if each.day]
    same = [dataclasses.replace(each, result=first.decision) for each in others]
    rest = [each for each in content.variations if each not in varied]
    changed = dataclasses.replace(content, variations=(one, *same, *rest))
    panel = draw_figure(FIGURES["sensitivity"], changed, TWO_COLUMNS_IN).axes[0]
    drawn = [line.get_xdata()[0] for line in panel.lines if line.get_marker() in ("D", "o")]
    assert drawn == [first.decision.headline.value, one.result.headline.value]
    assert len(others) > 1
    assert {label.get_fontweight() for label in panel.get_yticklabels()} == {"normal"}


@pytest.mark.parametrize(("shared", "said"), [(0.4, True), (0.0, False), (None, False)])
def test_the_caption_says_where_bars_hold_the_error_of_the_drain(content, shared, said):
    conditions = []
    for one in content.conditions:
        joules = one.summaries[Outcome.JOULES]
        changed = dataclasses.replace(joules, mean=dataclasses.replace(joules.mean, shared_se=shared))
        conditions.append(with_summary(one, Outcome.JOULES, changed))
    whole = dataclasses.replace(content, conditions=tuple(conditions))
    captions = [FIGURES[name].caption(whole) for name in ("joules_by_level", "apex_by_level")]
    assert ["drain error included" in caption for caption in captions] == [said, False]


@pytest.mark.parametrize(("count", "pictured"), [(500, False), (20_000, True)])
def test_so_many_points_that_a_browser_would_be_slow_are_a_picture(content, count, pictured):
    first, *others = content.conditions
    joules = first.summaries[Outcome.JOULES]
    many = tuple((f"many {number}", 1000.0 + number % 97) for number in range(count))
    changed = with_summary(first, Outcome.JOULES, dataclasses.replace(joules, runs=many))
    crowded = dataclasses.replace(content, conditions=(changed, *others))
    figure = draw_figure(FIGURES["joules_by_level"], crowded, TWO_COLUMNS_IN)
    svg = svg_bytes(figure)
    assert (b"<image" in svg) is pictured
    assert len(svg) < 500_000
