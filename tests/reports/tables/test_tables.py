import dataclasses
import math

import pytest

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.numbers import Number
from reports.tables.registry import TABLES
from tests.helpers.pages import with_summary
from tests.helpers.wording import says
from tests.reports import made
from tests.reports.made import csv_rows, overall_savings, t_and_p


def shown(table):
    return [made.shown(table, row) for row in table.rows]


def test_conditions_have_physical_values_with_the_gains_beside_them(content):
    table = TABLES["joules_by_condition"].make(content)
    assert [row[:3] for row in shown(table)[:3]] == [["CE", "0", "14"], ["186", "50", "10"], ["352", "100", "10"]]
    says(table.rows[0].block.replace("\u00a0", " "), "small foot", "835 N/m", "300")
    says(table.caption.replace("\u00a0", " "), "k = 2.56", "67.36 N/m")


@pytest.mark.parametrize(("name", "unit"), [("joules_by_condition", "j"), ("apex_by_condition", "m")])
def test_csv_has_the_conditions_unrounded_in_stored_units(content, name, unit):
    rows = csv_rows(name, content)
    assert len(rows) == 24
    for row, condition in zip(rows, content.conditions, strict=True):
        summary = condition.summaries[Outcome.JOULES] if unit == "j" else condition.summaries[Outcome.APEX]
        assert float(row[f"mean_{unit}"]) == summary.mean.value
        assert float(row[f"sd_{unit}"]) == summary.sd.value
        assert float(row[f"ci_low_{unit}"]) == summary.mean.ci_low
        assert (row["foot"], row["k_gain"], row["b_ad_gain"]) == tuple(level.label for level in condition.levels)
        assert float(row["k_gain_n_m"]) == condition.levels[1].value
        assert row["provenance"] == summary.mean.provenance


def test_comparisons_carry_tests_and_savings(content):
    effects, tests = csv_rows("comparisons_joules", content), csv_rows("tests_joules", content)
    chosen = [c for c in content.comparisons if c.quantity is Outcome.JOULES]
    for comparison, effect, test in zip(chosen, effects, tests, strict=True):
        decision, route = comparison.decision, comparison.over_runs
        assert float(effect["difference_j"]) == decision.difference.value
        assert float(effect["savings_percent"]) == decision.savings.value
        assert float(effect["savings_ci_high_percent"]) == decision.savings.ci_high
        assert (int(effect["n_control"]), int(effect["n_treatment"])) == (14, decision.n_treatment)
        assert test["test"] == route.test
        assert (float(test["t_statistic"]), float(test["t_df"])) == (route.t.value, route.t.df)
        assert (float(test["f_df_1"]), float(test["f_df_2"])) == (route.n_treatment - 1, route.n_control - 1)
        assert float(test["ci_low_j"]) == route.difference.ci_low


def test_a_hypothesis_that_no_day_can_tell_names_the_levels_that_it_compares(content):
    """Its sides are levels of a factor, neither of them the control."""
    for name in ("hypotheses", "hypotheses_in_full"):
        [why] = [note for note in TABLES[name].make(content).footnotes if "day" in note]
        says(why, "large foot", "small foot")


def test_intervals_of_hypotheses_that_differ_in_level_say_each_their_own(content):
    """A claim of the first page has its own level, a mean that of two one-sided tests."""
    first, *others = content.hypotheses
    one, *rest = first.parts
    claimed = dataclasses.replace(one, measured=dataclasses.replace(one.measured, ci_level=0.95))
    changed = dataclasses.replace(first, parts=(claimed, *rest))
    table = TABLES["hypotheses_in_full"].make(dataclasses.replace(content, hypotheses=(changed, *others)))
    texts = [" ".join(row) for row in shown(table)]
    assert [("95 %" in text, "90 %" in text) for text in texts] == [
        *[(True, False)], *[(False, True)] * len(rest), (False, False)
    ]  # fmt: skip
    assert not any("90 %" in text for row in shown(TABLES["hypotheses_in_full"].make(content)) for text in row)


def test_values_of_runs_in_one_column_have_the_same_decimals(content):
    """Round ones, too: 42 J beside 39.5 J is 42.0 J."""
    first, *others = content.conditions
    joules = first.summaries[Outcome.JOULES]
    (name, _), *runs = joules.runs
    changed = with_summary(first, Outcome.JOULES, dataclasses.replace(joules, runs=((name, 42.0), *runs)))
    table = TABLES["each_run"].make(dataclasses.replace(content, conditions=(changed, *others)))
    place = [head.head for head in table.heads].index("Energy of a jump (J)")
    texts = [row[place] for row in shown(table)]
    assert "42.0" in texts
    assert {len(text.partition(".")[2]) for text in texts} == {1}


@pytest.mark.parametrize(("difference", "t"), [(-2.6, 2.75), (2.6, -2.75), (-2.6, -2.75)])
def test_the_sign_of_t_is_that_of_the_difference_beside_it(content, difference, t):
    """The t of savings is stored as positive for a saving, which is a negative difference."""
    first = next(c for c in content.comparisons if c.quantity is Outcome.JOULES)
    changed = dataclasses.replace(first.decision.difference, value=difference)
    decision = dataclasses.replace(first.decision, difference=changed, **t_and_p(t, 4.0, 0.051))
    comparison = dataclasses.replace(first, decision=decision)
    (row,) = csv_rows("comparisons_joules", dataclasses.replace(content, comparisons=(comparison,)))
    assert float(row["t_statistic"]) == math.copysign(2.75, difference)
    assert float(row["difference_j"]) == difference


def test_a_family_with_several_levels_has_a_block_a_group(content):
    table = TABLES["comparisons_joules"].make(content)
    blocks = [block.replace("\u00a0", " ") for block, _ in table.blocks]
    assert blocks[:2] == ["pooled over the AD gain", "each AD gain: small foot, k = 835 N/m"]
    says(shown(table)[0][0], "small foot", "835 N/m")
    says(shown(table)[4][0], "186 kg/s", "gain", "50")


def test_a_groups_p_is_holms_where_its_family_is_adjusted(content):
    joules = [each for each in content.pooled if each.quantity is Outcome.JOULES]
    holms = [0.012, 0.024, 0.036, 0.048]
    adjusted = made.decided(joules, *({"adjusted": Number(p, "1", n=4), "days": ("2021-05-03",)} for p in holms))
    holm = dataclasses.replace(content, comparisons=adjusted)
    assert [float(row["savings_p"]) for row in csv_rows("headlines", holm)] == holms
    says(TABLES["headlines"].make(holm).caption, "Holm", "4 tests")
    alone = made.changed(holm, adjusted=None)
    assert "Holm" not in TABLES["headlines"].make(alone).caption


def test_the_row_of_all_groups_counts_their_runs_and_no_day_twice(content):
    of_joules = [each.group for each in content.pooled if each.quantity is Outcome.JOULES]
    overall = (overall_savings(Number(11.2, "%", ci_low=8.1, ci_high=14.3), tuple(of_joules[:2])),)
    *groups, together = csv_rows("headlines", dataclasses.replace(content, overall=overall))
    for side in ("n_control", "n_treatment"):
        assert int(together[side]) == sum(int(row[side]) for row in groups[:2])


def test_sensitivity_lists_each_headline_first(content):
    rows = csv_rows("sensitivity", content)
    first, _varied = content.headlines[0]
    assert rows[0]["variant"] == "as reported"
    assert float(rows[0]["value"]) == first.decision.savings.value
    assert len(rows) == sum(1 + len(varied) for _comparison, varied in content.headlines)


def test_flow_and_days(content):
    flow = {(row["analysis"], row["step"]): row for row in csv_rows("flow", content)}
    assert {row["count"] for (_, step), row in flow.items() if step == "runs done"} == {"272"}
    joules, heights = flow["joules a jump", "runs with joules"], flow["apex height", "runs with apex heights"]
    assert (joules["count"], heights["count"]) == ("253", "255")
    says(joules["left_out"], "2 excluded")
    says(heights["left_out"], "4 void", "12 idle", "1 excluded")
    days = csv_rows("days", content)
    assert [day["day"] for day in days] == [day.date for day in content.days]
    assert days[2]["checks_not_made"] == "sensor zero"


def test_what_does_not_exist_is_a_dash_with_a_footnote(content):
    first = content.conditions[0]
    summary, one, none = (
        first.summaries[Outcome.JOULES],
        *(Undefined(Reason.AS_SAID, said=said) for said in ("one run only", "df = 0")),
    )
    mean = dataclasses.replace(summary.mean, se=one, ci_low=none, ci_high=none)
    alone = dataclasses.replace(summary, sd=Number(one, "J"), mean=mean)
    changed = dataclasses.replace(content, conditions=(with_summary(first, Outcome.JOULES, alone),))
    table = TABLES["joules_by_condition"].make(changed)
    assert table.footnotes == {"one run only": "a", "df = 0": "b"}
    assert shown(table)[0][4:7] == ["–", "–", "–"]


def test_a_selection_without_comparisons_still_has_its_tables(minimal):
    for kind in TABLES.values():
        table = kind.make(minimal)
        assert all(len(row.cells) == len(table.columns) for row in table.rows)
