"""How far to trust the answer, in three lines: the plan, one day less, and what the uncertainty comes from."""

import dataclasses
import math

import pytest

from reports.content import Variant
from reports.numbers import Number
from reports.trust import flow_sentence, robustness_sentences, trust_sentences
from tests.helpers.wording import says


def plain(sentences):
    return [sentence.replace("\u00a0", " ") for sentence in sentences]


def of_one_group(content, se, shared_se=0.1):
    """Keep the first group, whose savings have this error, and whose runs scatter by 3 J within days."""
    first = content.pooled[0]
    savings = dataclasses.replace(first.savings, se=se, shared_se=shared_se)
    by_day = dataclasses.replace(first.by_day, run_sd=Number(3.0, "J"))
    return dataclasses.replace(
        content, comparisons=(dataclasses.replace(first, savings=savings, by_day=by_day),), overall=()
    )


def by_runs(comparison):
    """The standard error that independent runs with a standard deviation of 3 J give savings."""
    ratio, mean = 1.0 - comparison.savings.value / 100.0, comparison.sides[0].mean
    return 300.0 / mean * math.sqrt(1.0 / comparison.n_treatment + ratio**2 / comparison.n_control)


@pytest.mark.parametrize(
    ("times", "said"),
    [(1.1, "runs' scatter"), (3.0, "days acting unlike")],
)
def test_the_third_line_says_what_the_uncertainty_comes_from_and_what_narrows_it(content, times, said):
    se = times * by_runs(content.pooled[0])
    third = plain(trust_sentences(of_one_group(content, se)))[-1]
    assert third.startswith(f"The answer's standard error, {se:.2g} points, is mostly {said}: more ")
    assert third.endswith(f"{'runs' if times < 2 else 'days'} narrow it; the passive drain's part is 0.1 points.")


def test_the_answer_s_standard_error_has_the_passive_drain_s_in_it(content):
    third = plain(trust_sentences(of_one_group(content, 0.05)))[-1]
    assert third.startswith(
        "The answer's standard error, 0.11 points, is mostly the passive drain: more idle runs narrow"
    )


def test_without_an_error_or_scatter_within_days_there_are_two_lines(content):
    changed = of_one_group(content, 2.0)
    assert len(trust_sentences(changed)) == 3
    (only,) = changed.comparisons
    for other in (
        dataclasses.replace(only, by_day=None),
        dataclasses.replace(only, savings=dataclasses.replace(only.savings, se=None)),
    ):
        assert len(trust_sentences(dataclasses.replace(changed, comparisons=(other,)))) == 2


def test_the_flow_line_says_how_many_runs_were_withdrawn_from_the_plan(content):
    assert "withdrawn" not in flow_sentence(content)
    flow = dataclasses.replace(content.flow, runs_withdrawn=8)
    (said,) = plain([flow_sentence(dataclasses.replace(content, flow=flow))])
    assert said.startswith("280 runs planned, 272 made; 8 withdrawn from the plan; 4 void; ")


def test_ranges_without_a_day_name_the_groups_alone(content):
    first = plain(robustness_sentences(content))[0]
    assert first.startswith("Savings without one day at a time: ")
    assert first.count("avings") == 1


def test_a_day_left_out_is_told_by_its_day_not_by_the_label(content):
    named = [
        dataclasses.replace(
            each, variants=tuple(dataclasses.replace(one, label=f"way {at}") for at, one in enumerate(each.variants))
        )
        for each in content.sensitivity
    ]
    changed = dataclasses.replace(content, sensitivity=tuple(named))
    assert plain(robustness_sentences(changed))[0] == plain(robustness_sentences(content))[0]


def test_a_day_of_idle_runs_alone_outside_the_selection_is_no_day_left_out(content):
    """The table has what the drain line without that day gives; the days measured are those of the selection."""
    one_day = dataclasses.replace(content, days=content.days[:1])
    own = {content.days[0].date}
    others = [
        dataclasses.replace(each, variants=tuple(one for one in each.variants if one.day not in own))
        for each in content.sensitivity
    ]
    one_day = dataclasses.replace(one_day, sensitivity=tuple(others))
    said = "The one day measured cannot be left out."
    assert said in plain(trust_sentences(one_day))
    assert plain(robustness_sentences(one_day))[0] == said
    assert not any("at a time" in each or "any one day" in each for each in plain(robustness_sentences(one_day)))


def test_a_day_of_the_selection_without_which_there_is_no_headline_is_counted(content):
    gone = content.days[0].date
    others = [
        dataclasses.replace(each, variants=tuple(one for one in each.variants if one.day != gone))
        for each in content.sensitivity
    ]
    second = plain(trust_sentences(dataclasses.replace(content, sensitivity=tuple(others))))[1]
    says(second, "without 1 other day", "no test")
    assert "other day" not in plain(trust_sentences(content))[1]


@pytest.mark.parametrize(
    ("run_before", "departed", "said"),
    [
        ("", 0, "beforehand, and nothing departs from it."),
        ("", 3, "beforehand, with 3 departures (Plan and deviations)."),
        (
            "2021-05-03",
            1,
            "before measurements came in, but after the first run (2021-05-03), with 1 departure "
            "(Plan and deviations).",
        ),
    ],
)
def test_the_first_line_says_when_the_analysis_was_decided_on_and_how_often_it_was_departed_from(
    content, run_before, departed, said
):
    """That a family counts as a whole stands among what departs, and is no departure."""
    told = ("Departure: one.", "A family counts as planned only as a whole.")
    changed = dataclasses.replace(content, planned=True, departures=told, departed=departed, run_before=run_before)
    assert plain(trust_sentences(changed))[0] == f"The analysis was decided on {said}"


def test_of_days_counted_or_days_compared_nothing_says_that_more_runs_help(content):
    """n counts days where the plan does; and of sides with a day each the error knows nothing of days."""
    changed = of_one_group(content, 2.0)
    (only,) = changed.comparisons
    apart = dataclasses.replace(only, one_day_each="of one day each")
    for other in (
        dataclasses.replace(changed, counted="day"),
        dataclasses.replace(changed, comparisons=(apart,)),
        dataclasses.replace(content, overall=()),  # several groups, and none of them is the answer
    ):
        assert not any("standard error" in each for each in trust_sentences(other))


def test_savings_lead_where_the_first_group_has_none(content):
    """The first group has heights alone: its differences in mm come after the savings of the others."""
    first, *others = content.sensitivity
    in_m = [dataclasses.replace(each, number=Number(0.0013, "m")) for each in first.variants]
    heights = dataclasses.replace(first, as_reported=Number(0.0012, "m"), variants=tuple(in_m))
    changed = dataclasses.replace(content, sensitivity=(heights, *others))
    assert plain(trust_sentences(changed))[1].startswith("Leaving out any one day moves the savings of a group by")
    assert plain(robustness_sentences(changed))[0].startswith("Savings without one day at a time: ")


def by_rules(each, *shifts):
    """A headline with recomputations by rules, which move it and its interval by these."""
    number = each.as_reported
    moved = [
        dataclasses.replace(number, value=number.value + by, ci_low=number.ci_low + by, ci_high=number.ci_high + by)
        for by in shifts
    ]
    variants = [Variant(f"rule {at}", one, by_rules=True) for at, one in enumerate(moved)]
    return dataclasses.replace(each, variants=(*each.variants, *variants))


def test_the_verdict_is_counted_over_all_rules_of_onset_and_take_off(content):
    first, *others = content.sensitivity
    away = -first.as_reported.value
    held, lost = by_rules(first, 0.0, 0.1, -0.1), by_rules(first, 0.0, 0.1, away)
    before = plain(robustness_sentences(content))
    for changed, said in ((held, "holds under all 3 rules"), (lost, "holds under 2 of 3 rules")):
        found = plain(robustness_sentences(dataclasses.replace(content, sensitivity=(changed, *others))))
        assert [sentence for sentence in found if sentence not in before] == found[-1:]
        says(found[-1], said, *(["rule 2"] if changed is lost else []))


def test_runs_unlike_those_of_their_condition_are_named_first(content):
    first, *others = plain(trust_sentences(dataclasses.replace(content, outside_limits=("r001",))))
    assert first == "1 run lies outside the control limits of its condition: r001."
    assert others == plain(trust_sentences(dataclasses.replace(content, outside_limits=())))
    several = dataclasses.replace(content, outside_limits=tuple(f"r{n}" for n in range(9)))
    assert plain(trust_sentences(several))[0].endswith("r0, r1, r2, r3, r4, r5 and 3 more.")
