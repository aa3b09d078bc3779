import dataclasses
import itertools
import xml.etree.ElementTree as ElementTree

import pytest

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.content import Factor, Level, Number, Summary, Variant
from reports.figures.by_level import file_name
from reports.figures.kind import draw_figure, pdf_bytes, svg_bytes
from reports.figures.registry import FIGURES
from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN
from tests.helpers.pages import FIGURE_NAMES, with_summary
from tests.helpers.wording import says


@pytest.mark.soak
@pytest.mark.parametrize("name", FIGURE_NAMES)
def test_the_same_content_gives_the_same_bytes(content, written, name):
    """Compared with what the report wrote a while ago: nothing of the clock or of an earlier drawing is in it. Of a few
    figures `test_figure_cache` says so by default.
    """
    folder = written.parent / "figures"
    figure = draw_figure(FIGURES[name], content, TWO_COLUMNS_IN)
    assert svg_bytes(figure) == (folder / f"{file_name(name, content)}.svg").read_bytes()
    assert pdf_bytes(figure) == (folder / f"{file_name(name, content)}.pdf").read_bytes()


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


def test_the_words_for_the_flow_diagram_hold_every_count(content):
    words = FIGURES["flow"].alternative(content)
    for count in (280, 272, 4, 12, 2, 1, 253, 255, 6375, 6361, 506, 83, 21, 5751):
        assert f" {count} " in f" {words} ".replace("(after ", " ")


def undefined_everywhere(content):
    nothing = Undefined(Reason.AS_SAID, said="one run only")
    number = Number(nothing, "J", se=nothing, ci_low=nothing, ci_high=nothing, n=1)
    conditions = tuple(
        with_summary(c, Outcome.JOULES, Summary(number, nothing, joules.runs[:1]))
        if c.control
        else with_summary(c, Outcome.JOULES, Summary(dataclasses.replace(joules.mean, se=nothing), nothing))
        for c in content.conditions
        for joules in [c.summaries[Outcome.JOULES]]
    )
    comparisons = tuple(
        dataclasses.replace(c, savings=dataclasses.replace(c.savings, value=nothing, ci_low=nothing, ci_high=nothing))
        if c.savings is not None
        else c
        for c in content.comparisons
    )
    sensitivity = tuple(
        dataclasses.replace(one, as_reported=number, variants=(dataclasses.replace(one.variants[0], number=number),))
        for one in content.sensitivity
    )
    drains = (dataclasses.replace(content.drains[0], at_run=number),)
    order = dataclasses.replace(
        content.order, packs=tuple(dataclasses.replace(pack, mean=number) for pack in content.order.packs)
    )
    return dataclasses.replace(
        content, conditions=conditions, comparisons=comparisons, sensitivity=sensitivity, drains=drains, order=order
    )


@pytest.mark.parametrize("name", [name for name in FIGURE_NAMES if name != "flow"])
def test_numbers_that_do_not_exist_are_left_out_or_named(content, name):
    changed = undefined_everywhere(content)
    kind = FIGURES[name]
    ElementTree.fromstring(svg_bytes(draw_figure(kind, changed, TWO_COLUMNS_IN)))
    assert kind.caption(changed)
    assert "nan" not in kind.alternative(changed)


@pytest.mark.parametrize(
    "name",
    ["joules_by_level", "flow", *(pytest.param(name, marks=pytest.mark.soak) for name in ("savings", "packs"))],
)
def test_a_dollar_or_a_strange_letter_in_a_name_is_only_text(content, name):
    levels = [
        dataclasses.replace(level, label="$\\frac{1") if level.label == "small" else level
        for level in content.conditions[0].levels
    ]
    first = dataclasses.replace(content.conditions[0], levels=tuple(levels))
    points = tuple(dataclasses.replace(point, pack="包 $x^") for point in content.order.points[:20])
    changed = dataclasses.replace(
        content,
        conditions=(first, *content.conditions[1:]),
        order=dataclasses.replace(content.order, points=points, packs=()),
        flow=dataclasses.replace(content.flow, runs_other={"$\\alpha <b> --> x": 3}),
    )
    ElementTree.fromstring(svg_bytes(draw_figure(FIGURES[name], changed, ONE_COLUMN_IN)))


def test_a_study_without_a_swept_factor_or_with_three_factors_is_drawn(content):
    plain = tuple(dataclasses.replace(factor, swept=False) for factor in content.factors)
    for factors in (plain, plain[:1], (*plain[:2], dataclasses.replace(plain[2], swept=True))):
        changed = dataclasses.replace(content, factors=factors)
        ElementTree.fromstring(svg_bytes(draw_figure(FIGURES["joules_by_level"], changed, TWO_COLUMNS_IN)))


def raised(condition, by_m):
    apex = condition.summaries[Outcome.APEX]
    runs = tuple(dataclasses.replace(run, value=run.value + by_m) for run in apex.runs)
    mean = dataclasses.replace(apex.mean, value=apex.mean.value + by_m)
    return with_summary(condition, Outcome.APEX, dataclasses.replace(apex, mean=mean, runs=runs))


def test_series_far_apart_get_a_panel_each_at_one_scale(content):
    kind = FIGURES["apex_by_level"]
    assert len(draw_figure(kind, content, TWO_COLUMNS_IN).axes) == 1
    assert "side by side" in kind.caption(content)
    conditions = tuple(
        raised(condition, 0.2) if condition.levels[0].label == "large" else condition
        for condition in content.conditions
    )
    changed = dataclasses.replace(content, conditions=conditions)
    panels = draw_figure(kind, changed, TWO_COLUMNS_IN).axes
    spans = [high - low for low, high in (panel.get_ylim() for panel in panels)]
    assert len(panels) == 4
    assert spans == pytest.approx([spans[0]] * 4)
    says(kind.caption(changed), "Each group has")
    assert "one span" in kind.caption(changed)


def test_rows_pooled_across_groups_have_their_own_heading(content):
    pooled = next(c for c in content.comparisons if c.savings is not None)
    unbounded = Undefined(Reason.AS_SAID, said="unbounded")
    across = dataclasses.replace(
        pooled,
        group={"foot": "small"},
        savings=dataclasses.replace(pooled.savings, ci_low=unbounded, ci_high=unbounded),
    )
    changed = dataclasses.replace(content, comparisons=(*content.comparisons, across))
    axes = draw_figure(FIGURES["savings"], changed, TWO_COLUMNS_IN).axes[0]
    assert [label.get_text() for label in axes.get_yticklabels()][-2:] == ["pooled across groups", "small foot, pooled"]
    assert any("(no interval)" in text.get_text() for text in axes.texts)


def test_recomputations_that_change_nothing_are_counted_instead_of_drawn(content):
    kind = FIGURES["sensitivity"]
    first, *others = content.sensitivity
    assert "without one day" not in kind.caption(content)
    days = [variant for variant in first.variants if variant.label.startswith("without 2")]
    same = tuple(
        dataclasses.replace(variant, number=first.as_reported) if variant in days[:3] else variant
        for variant in first.variants
    )
    changed = dataclasses.replace(content, sensitivity=(dataclasses.replace(first, variants=same), *others))
    panels = draw_figure(kind, changed, TWO_COLUMNS_IN).axes
    assert len(panels[0].get_yticks()) == len(first.variants) + 1 - 3 - 1  # the first variant of each is as reported
    assert len(panels[1].get_yticks()) == len(first.variants) + 1 - 1
    total = len(days) * len(content.sensitivity)
    sets = len(content.sensitivity)
    left = f"without exclusions ({sets} of {sets}) and without one day (3 of {total})"
    assert f"not drawn: {left}." in kind.caption(changed)


def test_missing_joules_and_drain_are_not_explained_by_a_guess(content):
    conditions = tuple(with_summary(condition, Outcome.JOULES, None) for condition in content.conditions)
    changed = dataclasses.replace(content, conditions=conditions, drains=())
    reasons = "; the reasons are listed under Limitations."
    says(FIGURES["joules_by_level"].absent(changed), "no joules for", reasons)
    says(FIGURES["passive_drain"].absent(changed), "no passive-drain fit", reasons)


def test_a_recomputation_shows_how_many_runs_it_rests_on(content):
    one = content.sensitivity[0]
    put_back = Variant("without exclusions", dataclasses.replace(one.as_reported, n=one.as_reported.n + 3))
    changed = dataclasses.replace(content, sensitivity=(dataclasses.replace(one, variants=(put_back,)),))
    (panel,) = draw_figure(FIGURES["sensitivity"], changed, TWO_COLUMNS_IN).axes
    assert [label.get_text() for label in panel.get_yticklabels()] == ["as reported", "without exclusions"]
    counts = [text.get_text().replace("\u00a0", " ") for text in panel.texts]
    assert counts == [f"n = {one.as_reported.n}", f"n = {one.as_reported.n + 3}"]
    assert panel.get_title().replace("\n", " ").endswith("(%)")


def test_recomputations_by_other_rules_are_one_row(content):
    one = content.sensitivity[0]
    moved = [dataclasses.replace(one.as_reported, value=one.as_reported.value + by) for by in (0.0, 0.1, 0.2)]
    variants = tuple(Variant(f"rule {at}", number, by_rules=True) for at, number in enumerate(moved))
    changed = dataclasses.replace(content, sensitivity=(dataclasses.replace(one, variants=variants),))
    (panel,) = draw_figure(FIGURES["sensitivity"], changed, TWO_COLUMNS_IN).axes
    assert [label.get_text() for label in panel.get_yticklabels()] == ["as reported", "by other rules, each"]
    says(FIGURES["sensitivity"].caption(changed), "other rules", "1 of 3")


@pytest.mark.parametrize("width_in", [pytest.param(ONE_COLUMN_IN, marks=pytest.mark.soak), TWO_COLUMNS_IN])
def test_recomputations_fit_on_a_page_however_many_days_there_are(content, width_in):
    days = tuple(
        Variant(f"without {date}", dataclasses.replace(one.number, value=50.0 + day, n=40 + day), date)
        for day, one in zip(range(1, 29), itertools.cycle(content.sensitivity[0].variants), strict=False)
        for date in [f"2022-01-{day:02d}"]
    )
    sets = tuple(dataclasses.replace(one, variants=(*one.variants[:2], *days)) for one in content.sensitivity)
    sets *= 1 if width_in == ONE_COLUMN_IN else 3
    figure = draw_figure(FIGURES["sensitivity"], dataclasses.replace(content, sensitivity=sets), width_in)
    assert figure.get_figheight() <= 9.0
    panel = figure.axes[0]
    says([label.get_text() for label in panel.get_yticklabels()][-1], "without one day")
    assert panel.texts[-1].get_text().replace("\u00a0", " ") == "n = 41–68"


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
    assert all(f"{robot}: slope" in kind.alternative(changed) for robot in robots)
    named = dataclasses.replace(content, drains=drains[:1])
    assert svg_bytes(draw_figure(kind, named, ONE_COLUMN_IN)) == svg_bytes(draw_figure(kind, content, ONE_COLUMN_IN))


def test_a_robot_without_an_interval_leaves_the_inset_out(content):
    unknown = dataclasses.replace(content.drains[0].at_run, ci_low=None, ci_high=None)
    changed = dataclasses.replace(content, drains=(dataclasses.replace(content.drains[0], at_run=unknown),))
    assert "inset" in FIGURES["passive_drain"].caption(content)
    assert "inset" not in FIGURES["passive_drain"].caption(changed)
    assert draw_figure(FIGURES["passive_drain"], changed, ONE_COLUMN_IN).axes[0].child_axes == []


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
