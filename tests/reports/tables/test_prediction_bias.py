"""Predictions judged on the page: bias of each group, all together, and the sentence; no row counted twice."""

import dataclasses

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.numbers import Number
from reports.page.sections import Paragraph, TableHere, sections_of
from reports.results import PredictedQuantity, Predictions
from reports.tables.predictions import verdict_text
from reports.tables.registry import TABLES
from tests.helpers.judged import judged
from tests.helpers.wording import says

GROUPS = [("large", "300"), ("large", "400"), ("small", "300"), ("small", "400")]


def shifted(content, shift_j, se=0.1, groups=GROUPS):
    """Predict joules that are off by so much a group, each with this error; one group a pair of foot and stiffness."""
    items = []
    for item in content.predictions.of(PredictedQuantity.JOULES):
        key = item.group["foot"], item.group["k_gain"]
        if key in groups:
            value = item.measured.value + shift_j.get(key, 0.0)
            predicted = dataclasses.replace(item.check.predicted, value=value, se=se)
            items.append(dataclasses.replace(item, check=dataclasses.replace(item.check, predicted=predicted)))
    return judging(content, items)


def judging(content, items):
    about = dataclasses.replace(content.predictions, items=tuple(items), judged=judged(items))
    return dataclasses.replace(content, predictions=about)


def said(content):
    return verdict_text(content).replace("\u00a0", " ")


def test_where_and_by_how_much_predictions_are_biased_and_what_would_explain_it(content):
    off = {("large", "400"): 5.0, ("small", "400"): 6.0}
    says(
        said(shifted(content, off)),
        "5.00",
        "6.00 J",
        "large foot",
        "small foot",
        "1091 N/m",
        "kg_scale",
        "48 %",
        "10 %",
    )
    bare = dataclasses.replace(content, predictions=dataclasses.replace(content.predictions, assumed=()))
    assert "kg_scale" not in said(shifted(bare, off))
    says(said(shifted(content, dict.fromkeys(GROUPS[:3], 5.0))), "5.00 J", "3", "4 groups")
    both = said(shifted(content, {("large", "400"): 5.0, ("small", "400"): -6.0}))
    says(both, "5.00 J", "1091 N/m", "6.00 J", "small foot")


def test_what_would_explain_a_plate_s_quantity_is_said_as_of_joules(content, plated):
    """Contact times that are predicted 20 ms too long, and an input that changes them by 2 ms."""
    told = judging(content, plated.predictions.of(PredictedQuantity.CONTACT_TIME))
    says(said(told), "kg_scale", "100 % off", "(contact time)")
    table = TABLES["predicted_inputs"].make(told)
    assert table.records[0]["contact_time_s"] == 0.002
    assert "contact_time_s" not in TABLES["predicted_inputs"].make(content).records[0]


def test_without_bias_nothing_is_missing(content):
    text = said(shifted(content, {}))
    says(text, ".999", "τ = 1.00")
    one = said(shifted(content, {("large", "400"): 5.0}, groups=[("large", "400")]))
    assert "τ" not in one
    assert "5.00 J" in one


def test_an_agreement_that_assumed_inputs_buy_is_said(content):
    changed = shifted(content, dict.fromkeys(GROUPS, 5.0), se=9.0)
    assert said(changed) != said(shifted(content, dict.fromkeys(GROUPS, 0.0)))
    assert not any(group.differs for group in changed.predictions.judged[0].groups)
    assert all(group.agrees_only_by_assumed for group in changed.predictions.judged[0].groups)


def test_agreement_with_the_runs_that_inputs_were_fitted_to_is_no_test(content):
    first, *others = content.predictions.assumed
    about = dataclasses.replace(content.predictions, assumed=(dataclasses.replace(first, fitted=True), *others))
    says(said(shifted(dataclasses.replace(content, predictions=about), {})), "kg_scale")
    assert "kg_scale" not in said(shifted(content, {}))


def test_the_table_has_the_groups_and_says_the_unit(content):
    table = TABLES["prediction_bias"].make(content)
    assert [row.cells[0].text for row in table.rows] == ["joules a jump"] * 4 + ["apex height"] * 4
    says(table.caption, "kg/m")
    biases = [group.bias for one in content.predictions.judged for group in one.groups]
    assert [row.cells[-1].text for row in table.rows] == [bias.provenance for bias in biases]
    same = dataclasses.replace(content, predictions=dataclasses.replace(content.predictions, units={}))
    assert "kg/m" not in TABLES["prediction_bias"].make(same).caption


def test_the_verdict_stands_once_on_the_page(content):
    paragraphs = [
        part.text for section in sections_of(content) for part in section.parts if isinstance(part, Paragraph)
    ]
    assert paragraphs.count(verdict_text(content)) == 1
    (predicted,) = (section for section in sections_of(content) if section.anchor == "predicted")
    assert TableHere("prediction_bias") in predicted.parts


def test_without_errors_or_predictions_nothing_is_judged(content):
    none = Undefined(Reason.AS_SAID, said="it folds")
    items = tuple(
        dataclasses.replace(item, check=dataclasses.replace(item.check, predicted=Number(none, item.measured.unit)))
        for item in content.predictions.items
    )
    for changed in (judging(content, items), dataclasses.replace(content, predictions=Predictions())):
        assert changed.predictions.judged == ()
        assert all(part != Paragraph("") for section in sections_of(changed) for part in section.parts)
        assert TABLES["prediction_bias"].make(changed).rows == ()
