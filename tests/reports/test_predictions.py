"""Predicted beside measured on the page: tables, figure and sentences; what does not exist is said."""

import dataclasses
import xml.etree.ElementTree as ElementTree

import pytest

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.figures.kind import draw_figure, svg_bytes
from reports.figures.registry import FIGURES
from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN
from reports.numbers import Number
from reports.page.sections import sections_of
from reports.results import ACCURACY, PredictedQuantity, PredictionCheck, Predictions
from reports.tables.predictions import prediction_sentences
from reports.tables.registry import TABLES
from tests.helpers.judged import judged
from tests.helpers.wording import says
from tests.reports.made import csv_rows, plain, shown

NAMES = {
    PredictedQuantity.JOULES: ("predicted_joules", "j"),
    PredictedQuantity.APEX: ("predicted_apex", "m"),
    PredictedQuantity.SAVINGS: ("predicted_savings", "percent"),
}


def told(content):
    return plain(" ".join(prediction_sentences(content)))


@pytest.mark.parametrize("quantity", NAMES)
def test_a_table_has_every_prediction_unrounded(content, quantity):
    name, slug = NAMES[quantity]
    items = content.predictions.of(quantity)
    assert len(items) == 24
    for row, item in zip(csv_rows(name, content), items, strict=True):
        assert float(row[f"measured_{slug}"]) == item.measured.value
        assert float(row[f"predicted_{slug}"]) == item.check.predicted.value
        assert float(row[f"predicted_se_{slug}"]) == item.check.predicted.se
        assert float(row[f"difference_{slug}"]) == item.check.difference.value
        assert float(row["error_ratio"]) == item.check.error_ratio.value
        assert float(row[f"numerical_error_{slug}"]) == item.check.numerical_error
        assert row["agrees" if "agrees" in row else "agree"] == ("yes" if item.agrees else "no")
        assert row["provenance"] == item.check.predicted.provenance


def test_a_prediction_that_the_simulation_knows_too_badly_is_marked_and_the_largest_error_is_said(content):
    first, second, *others = content.predictions.items
    errors = {ACCURACY: Number(1e-9, "J")}
    odd = [
        dataclasses.replace(item, check=dataclasses.replace(item.check, errors=errors, numerical_error=error))
        for item, error in ((first, 0.0123), (second, None))
    ]
    about = dataclasses.replace(content.predictions, items=(*odd, *others), ends_otherwise=1)
    changed = dataclasses.replace(content, predictions=about)
    moved, gone = TABLES["predicted_joules"].make(changed).explained.values()
    says(moved, "finer", "0.01")
    says(gone, "finer", "no such number")
    says(
        told(changed),
        "1 condition",
        "ends otherwise",
        f"{0.0123 / first.check.predicted.se:.1g} of their standard error",
        "2 of them",
    )
    calm = told(content)
    assert "mark" not in calm
    assert not TABLES["predicted_joules"].make(content).explained


def test_rows_stand_under_their_group_and_the_control_is_named(content):
    table = TABLES["predicted_joules"].make(content)
    assert [block.replace("\u00a0", " ") for block, _ in table.blocks][:2] == [
        "small foot, k = 835 N/m", "small foot, k = 1091 N/m",
    ]  # fmt: skip
    assert shown(table, table.rows[0])[0] == "CE"
    says(shown(table, table.rows[1])[0], "186 kg/s", "gain", "50")
    savings = TABLES["predicted_savings"].make(content)
    assert sum(row.strong for row in savings.rows) == 4


def test_assumed_inputs_say_what_varying_them_changes(content):
    table = TABLES["predicted_inputs"].make(content)
    first, second = (shown(table, row) for row in table.rows)
    assert first == ["kg_scale", "1.4", "fitted", "10", "1.25", "4.2", "0.61"]
    assert second[0:2] == ["foot_mass", "0.2 kg"]
    assert table.footnotes == {"it folds": "a"}


def test_sentences_say_what_predictions_rest_on(content):
    sentences = [*map(plain, prediction_sentences(content))]
    for facts in (("kg_scale", "10 %", "foot_mass", "5 %"), ("1 condition",), ("2 conditions",), ("3 conditions",),
                  ("active damping", "motor heat"), ("scene bed",)):  # fmt: skip
        says(sentences, *facts)
    odd, calm = ({"under_surface": 1, "open_book": 2}, {"branched": 0, "on_edge": 0, "grown": 0})
    odd_text, calm_text = (
        told(dataclasses.replace(content, predictions=dataclasses.replace(content.predictions, **change)))
        for change in (odd, calm)
    )
    says(odd_text, "1 condition", "under the surface")
    says(odd_text, "2 conditions", "add up within")
    assert "under the surface" not in told(content)
    assert not any(f"{count} condition" in calm_text for count in (1, 2, 3))


def test_a_level_that_the_scene_takes_as_it_stands_is_named_with_its_unit_there(content):
    as_it_stands = dataclasses.replace(
        content.predictions, unconverted=(("damp", "b_ad", "kg/m"),), units={"damp": "kg/m"}
    )
    factor = dataclasses.replace(content.factors[-1], name="damp", title="damper", unit="kg/s", slope=None)
    named = dataclasses.replace(content, predictions=as_it_stands, factors=(*content.factors[:-1], factor))
    says(told(named), "damp", "b_ad", "kg/m")
    says(TABLES["prediction_bias"].make(named).caption, "kg/s in the study", "kg/m in the scene")


def test_without_predictions_there_is_no_section_and_the_figure_says_why(content):
    bare = dataclasses.replace(content, predictions=Predictions(), hypotheses=())
    assert "predicted" in [section.anchor for section in sections_of(content)]
    assert "predicted" not in [section.anchor for section in sections_of(bare)]
    assert "names no scene" in FIGURES["predictions"].absent(bare)
    assert prediction_sentences(bare) == ()
    assert all(TABLES[name].make(bare).rows == () for name, _slug in NAMES.values())


def test_what_does_not_exist_is_told_and_drawn_as_such(content):
    nothing = Undefined(Reason.AS_SAID, said="the simulated jump ends otherwise: leg_folded")
    first, *others = content.predictions.items
    check = PredictionCheck(Number(nothing, "J"), Number(nothing, "J"), Number(nothing, "1"), {}, None)
    ended = dataclasses.replace(first, check=check)
    changed = dataclasses.replace(
        content,
        predictions=dataclasses.replace(content.predictions, items=(ended, *others), judged=judged((ended, *others))),
    )
    table = TABLES["predicted_joules"].make(changed)
    assert nothing.reason in table.footnotes
    biases = [csv_rows("prediction_bias", one) for one in (content, changed)]
    assert [row["bias"] == other["bias"] for row, other in zip(*biases, strict=True)] == [False, *[True] * 7]
    svg = svg_bytes(draw_figure(FIGURES["predictions"], changed, TWO_COLUMNS_IN))
    ElementTree.fromstring(svg)
    assert "nan" not in FIGURES["predictions"].alternative(changed)


def test_a_study_without_a_swept_factor_is_shown_too(content):
    plain = tuple(dataclasses.replace(factor, swept=False) for factor in content.factors)
    items = tuple(
        dataclasses.replace(item, group={**item.group, "b_ad_gain": item.level}, level="", control=False)
        for item in content.predictions.of(PredictedQuantity.APEX)
    )
    changed = dataclasses.replace(
        content, factors=plain, predictions=dataclasses.replace(content.predictions, items=items)
    )
    table = TABLES["predicted_apex"].make(changed)
    assert len({shown(table, row)[0] for row in table.rows}) == 24
    ElementTree.fromstring(svg_bytes(draw_figure(FIGURES["predictions"], changed, ONE_COLUMN_IN)))
