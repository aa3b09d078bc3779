"""How far to trust the answer, in three lines: the plan, one day less, and what the uncertainty comes from."""

import dataclasses
import math
import re

import pytest

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.numbers import Number
from reports.results import Plan
from reports.trust import flow_sentence, review_sentence, trust_sentences
from tests.helpers.wording import says
from tests.reports import made
from tests.reports.made import changed as changed_decisions

MOVED = re.compile(r"[0-9.]+ points[.;]")
"""How far a headline moves."""


def plain(sentences):
    return [made.plain(sentence) for sentence in sentences]


def of_one_group(content, se, shared_se=0.1):
    """Keep the first group, whose savings have this error, and whose runs scatter by 3 J within days."""
    first = content.pooled[0]
    savings = dataclasses.replace(first.decision.savings, se=se, shared_se=shared_se)
    one = dataclasses.replace(content, comparisons=(first,), overall=())
    return changed_decisions(one, savings=savings, run_sd=Number(3.0, "J"))


def without_day(content, gone):
    """The content without what a headline is without that day."""
    return dataclasses.replace(content, variations=tuple(one for one in content.variations if one.day != gone))


def by_runs(comparison):
    """The standard error that independent runs with a standard deviation of 3 J give savings."""
    decision = comparison.decision
    ratio, mean = 1.0 - decision.savings.value / 100.0, decision.control_mean.value
    return 300.0 / mean * math.sqrt(1.0 / decision.n_treatment + ratio**2 / decision.n_control)


@pytest.mark.parametrize(("times", "said"), [(1.1, "runs"), (3.0, "days")])
def test_the_third_line_says_what_the_uncertainty_comes_from_and_what_narrows_it(content, times, said):
    se = times * by_runs(content.pooled[0])
    third = plain(trust_sentences(of_one_group(content, se)))[-1]
    says(third, f"{se:.2g} points", said, "0.1 points")


def test_the_answer_s_standard_error_has_the_passive_drain_s_in_it(content):
    third = plain(trust_sentences(of_one_group(content, 0.05)))[-1]
    says(third, "0.11 points", "idle runs")


def test_without_an_error_or_scatter_within_days_there_are_two_lines(content):
    changed = of_one_group(content, 2.0)
    assert len(trust_sentences(changed)) == 3
    (only,) = changed.comparisons
    none = Number(Undefined(Reason.ONE_VALUE_A_DAY), "J")
    for other in ({"run_sd": none}, {"savings": dataclasses.replace(only.decision.savings, se=None)}):
        assert len(trust_sentences(changed_decisions(changed, **other))) == 2


def test_the_flow_line_says_how_many_runs_were_withdrawn_from_the_plan(content):
    flow = dataclasses.replace(content.flow, runs_withdrawn=8)
    (said,) = plain([flow_sentence(dataclasses.replace(content, flow=flow))])
    says(said, "280", "272", "8", "4")
    assert flow_sentence(content) != said


@pytest.mark.parametrize(
    ("reviewed", "rejected", "blind", "said"),
    [
        (0, 0, 0, ("none", "5751 jumps")),
        (12, 0, 0, ("12", "5751 jumps", "none", "12 verdicts", "blind")),
        (12, 5, 3, ("12", "5751 jumps", "5 more", "3", "17 verdicts", "blind")),
        (0, 1, 1, ("none", "5751 jumps", "1 more", "blind")),
    ],
)
def test_a_sentence_says_how_many_jumps_a_person_reviewed(content, reviewed, rejected, blind, said):
    counts = {"jumps_reviewed": reviewed, "jumps_rejected": rejected, "verdicts_blind": blind}
    flow = dataclasses.replace(content.flow, **counts)
    sentence = review_sentence(dataclasses.replace(content, flow=flow))
    says(sentence, *said)
    assert sentence.count(".") == 1
    assert ("blind" in sentence) is (reviewed + rejected > 0)


def test_nothing_is_said_of_review_where_no_jump_is_analysed(content):
    flow = dataclasses.replace(content.flow, jumps_analysed=0)
    assert review_sentence(dataclasses.replace(content, flow=flow)) == ""


def test_a_day_of_idle_runs_alone_outside_the_selection_is_no_day_left_out(content):
    """The table has what the drain line without that day gives; the days measured are those of the selection."""
    one_day = dataclasses.replace(without_day(content, content.days[0].date), days=content.days[:1])
    assert not any(MOVED.search(each) for each in plain(trust_sentences(one_day)))


def test_a_day_of_the_selection_without_which_there_is_no_headline_is_counted(content):
    second = plain(trust_sentences(without_day(content, content.days[0].date)))[1]
    says(second, "1 other day")
    assert "1 other day" not in plain(trust_sentences(content))[1]


@pytest.mark.parametrize(("run_before", "departed"), [("", 0), ("", 3), ("2021-05-03", 1)])
def test_the_first_line_says_when_the_analysis_was_decided_on_and_how_often_it_was_departed_from(
    content, run_before, departed
):
    """That a family counts as a whole stands among what departs, and is no departure."""
    changed = dataclasses.replace(
        content, plan=Plan(stated=True, departures=("one", "two"), departed=departed, run_before=run_before)
    )
    says(plain(trust_sentences(changed))[0], *filter(None, (run_before, departed)))


def test_of_several_groups_none_is_the_answer(content):
    assert not any("standard error" in each for each in trust_sentences(dataclasses.replace(content, overall=())))


def test_savings_lead_where_the_first_group_has_none(content):
    """The first group has heights alone: its differences in mm come after the savings of the others."""
    first = content.pooled[0]

    def in_m(one, metres):
        return dataclasses.replace(one, savings=None, difference=Number(metres, "m"))

    changed = dataclasses.replace(
        content,
        comparisons=tuple(
            dataclasses.replace(each, decision=in_m(each.decision, 0.0012)) if each is first else each
            for each in content.comparisons
        ),
        variations=tuple(
            dataclasses.replace(each, result=in_m(each.result, 0.0013)) if each.headline == first.label else each
            for each in content.variations
        ),
    )
    assert any(MOVED.search(each) for each in plain(trust_sentences(changed)))


def test_runs_unlike_those_of_their_condition_are_named_first(content):
    first, *others = plain(trust_sentences(dataclasses.replace(content, outside_limits=("r001",))))
    says(first, "r001")
    assert others == plain(trust_sentences(dataclasses.replace(content, outside_limits=())))
    several = dataclasses.replace(content, outside_limits=tuple(f"r{n}" for n in range(9)))
    says(plain(trust_sentences(several))[0], "9", "r0, r1, r2, r3, r4, r5", "3")
