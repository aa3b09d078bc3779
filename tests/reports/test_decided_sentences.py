"""What is said of comparisons that the days decide: no more than they tell, and for which days."""

import dataclasses

import pytest

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Rule, Undefined
from reports.decided_sentences import group_claim, groups_in_one_sentence, overall_claims
from reports.evidence import Decision
from reports.naming import levels_name
from reports.numbers import Number
from tests.helpers.wording import says
from tests.reports.made import DAYS, equivalence, overall_equivalence, overall_savings, t_and_p

ELSEWHERE = "That it holds on other days is not shown."


def decided(content, outcome, **changes):
    """A pooled comparison of the small foot, decided by five days."""
    comparison = next(c for c in content.pooled if c.quantity is outcome and c.group["foot"] == "small")
    savings = Number(12.1, "%", 2.0, None, 6.8, 17.2, provenance="abc") if outcome is Outcome.JOULES else None
    decision = Decision(
        rule=Rule.PAIRED, days=DAYS, n_control=16, n_treatment=50, other=0, savings=savings, rejected=True,
        difference=Number(0.0013, "m", 0.0003, None, 0.0003, 0.0023, provenance="abd"), control_mean=Number(40.0, "J"),
        run_sd=Number(3.0, "J"), **t_and_p(6.32, 4.0, 0.003),
    )  # fmt: skip
    return dataclasses.replace(comparison, exploratory="", decision=dataclasses.replace(decision, **changes))


def said(content, comparison):
    return group_claim(content, comparison).text.replace("\u00a0", " ")


def test_a_saving_by_day_means_names_its_test(content):
    text = said(content, decided(content, Outcome.JOULES))
    says(text, "12.1 %", "95 %", "6.8", "17.2 %", "t(4)", "6.32")
    assert group_claim(content, decided(content, Outcome.JOULES)).provenance == ("abc",)


def test_runs_of_other_days_are_counted(content):
    says(said(content, decided(content, Outcome.JOULES, other=7)), "7 runs")


def test_within_days_the_claim_and_its_test_of_equivalence_hold_for_these_days(content):
    estimate = Number(0.4, "%", ci_low=0.1, ci_high=0.7, ci_level=0.9)
    within = equivalence(estimate)
    text = said(content, decided(content, Outcome.APEX, rule=Rule.WITHIN, days=DAYS[:3], equivalence=within))
    says(text, "3 days", "1.30 mm", "−3", "3 %", "90 %", "0.10")
    assert text.endswith(ELSEWHERE)
    unshown = dataclasses.replace(within, shown=False)
    nothing = said(
        content, decided(content, Outcome.APEX, rule=Rule.WITHIN, days=DAYS[:3], equivalence=unshown, rejected=False)
    )
    says(nothing, "3 days", "not significant")
    assert ELSEWHERE not in nothing


def test_where_days_tell_nothing_there_is_no_p_and_no_interval(content):
    why = Undefined(Reason.NO_DAY_HOLDS_BOTH, a="the control", b="the treatment")
    saved = Number(12.1, "%", ci_low=why, ci_high=why)
    nothing = t_and_p(why, why, why)
    comparison = decided(content, Outcome.JOULES, rule=Rule.NONE, days=(), savings=saved, rejected=None, **nothing)
    text = said(content, comparison)
    says(text, "cannot be told", "12.1 %")
    assert "CI" not in text
    assert "p =" not in text


def test_holm_is_named_only_where_it_takes_something_away(content):
    adjusted = Number(0.06, "1", n=4)
    lost = {"adjusted": adjusted, "adjusted_rejected": False}
    once = "is not significant after Holm: 12.1 %"
    assert once in said(content, decided(content, Outcome.JOULES, **lost))
    never = said(content, decided(content, Outcome.JOULES, rejected=False, **lost))
    assert "after Holm" not in never
    says(never, "the small foot")


def test_a_saving_that_cannot_be_bounded_is_not_sized(content):
    why = Undefined(Reason.CONTROL_NEAR_ZERO)
    unbounded = Number(12.1, "%", ci_low=why, ci_high=why)
    text = said(content, decided(content, Outcome.JOULES, savings=unbounded))
    says(text, "cannot be bounded", "12.1 %", "t(4)", "6.32", why.reason)
    unseen = said(content, decided(content, Outcome.JOULES, savings=unbounded, rejected=False))
    says(unseen, "not significant", "12.1 %", why.reason)


@pytest.mark.parametrize("measured_only", [True, False])
def test_an_effect_over_groups_says_what_it_is_of(content, measured_only):
    groups = [c.group for c in content.pooled if c.quantity is Outcome.JOULES]
    of = {"left_out": tuple(groups[3:]), "days_measured_only": measured_only}
    savings = overall_savings(Number(11.2, "%", 1.5, None, 8.1, 14.3), tuple(groups[:3]), **of)
    change = Number(-0.4, "%", ci_low=-0.7, ci_high=-0.1, ci_level=0.9)
    heights = overall_equivalence(equivalence(change), tuple(groups[:3]), **of)
    whole = dataclasses.replace(content, overall=(savings,), overall_equivalence=heights)
    (of_joules, saved), (of_apex, kept) = overall_claims(whole)
    assert (of_joules, of_apex) == (Outcome.JOULES, Outcome.APEX)
    for text in (saved.text, kept.text):
        assert text.startswith("On the days") is measured_only
        assert (ELSEWHERE in text) is measured_only
        assert "over 3\u00a0groups" in text
        says(text, "without a claim")
    assert "lost" not in kept.text  # it fell, within the bounds
    says(saved.text, "each counted once", "agree within their errors")
    assert "differ" not in saved.text


@pytest.mark.parametrize(
    ("low", "lower_bound", "said"),
    [
        (0.1, -3.0, "no apex height was lost"),
        (-0.1, -3.0, "changed by less than 3 %"),
        (-0.1, -2.0, "within −2 to 3 %"),
    ],
)
def test_no_loss_of_height_is_said_where_the_interval_excludes_one(content, low, lower_bound, said):
    groups = tuple(c.group for c in content.pooled if c.quantity is Outcome.APEX)[:2]
    change = Number(0.4, "%", ci_low=low, ci_high=0.9, ci_level=0.9)
    heights = overall_equivalence(equivalence(change, low=lower_bound), groups)
    ((_outcome, claim),) = overall_claims(dataclasses.replace(content, overall=(), overall_equivalence=heights))
    opening = claim.text.replace("\u00a0", " ").partition(" over ")[0].lower()
    assert said in opening


@pytest.mark.parametrize("differ", [True, None])
def test_groups_that_differ_are_given_each(content, differ):
    pooled = [c for c in content.pooled if c.quantity is Outcome.JOULES][:2]
    comparisons = tuple(
        dataclasses.replace(one, decision=dataclasses.replace(one.decision, savings=Number(value, "%", 1.0)))
        for one, value in zip(pooled, (5.4, -1.2), strict=True)
    )
    groups = tuple(one.group for one in pooled)
    savings = overall_savings(
        Number(2.1, "%", 0.7, None, 0.6, 3.6), groups, heterogeneity_p=Number(0.0123, "1"), differ=differ
    )
    ((_outcome, claim),) = overall_claims(dataclasses.replace(content, comparisons=comparisons, overall=(savings,)))
    assert "agree" not in claim.text  # nothing is said where it is not tested
    assert ("differ" in claim.text) is bool(differ)
    if differ:
        says(claim.text, "5.4 % (small foot", "1.2 % (small foot", "p = .012")


def saved_over(content, rejected, costs=(False, False)):
    """Return the claim over two groups, whose own savings are significant or not, and savings or costs."""
    pooled = [c for c in content.pooled if c.quantity is Outcome.JOULES][:2]
    comparisons = tuple(
        dataclasses.replace(
            one,
            decision=dataclasses.replace(
                one.decision, rejected=each, adjusted=None, difference=Number(2.0 if cost else -2.0, "J")
            ),
        )
        for one, each, cost in zip(pooled, rejected, costs, strict=True)
    )
    savings = overall_savings(Number(11.2, "%", 1.5, None, 8.1, 14.3), tuple(one.group for one in pooled))
    ((_outcome, claim),) = overall_claims(dataclasses.replace(content, comparisons=comparisons, overall=(savings,)))
    return claim.text


@pytest.mark.parametrize(("rejected", "named"), [((True, False), True), ((True, True), False), ((False, False), False)])
def test_groups_that_are_significant_alone_are_named_where_not_all_or_none_are(content, rejected, named):
    text = saved_over(content, rejected)
    assert ("Significant alone: " in text) is named
    if named:
        says(text, "Significant alone", "foot")


@pytest.mark.parametrize(
    ("rejected", "costs", "saving", "cost"),
    [
        ((True, True), (True, False), True, True),
        ((True, False), (True, False), False, True),
        ((True, True), (True, True), False, False),
    ],
)
def test_a_group_that_alone_cost_more_is_not_named_as_a_saving(content, rejected, costs, saving, cost):
    text = saved_over(content, rejected, costs)
    assert "Significant alone" not in text
    assert ("Significant saving alone: " in text) is saving
    assert ("Significant cost alone: " in text) is cost


@pytest.mark.parametrize("shown", [(True, False), (True, True), (False, False)])
def test_groups_whose_own_height_is_not_shown_to_be_kept_are_named_where_others_are(content, shown):
    change = Number(-0.4, "%", ci_low=-0.7, ci_high=-0.1, ci_level=0.9)
    pooled = [c for c in content.pooled if c.quantity is Outcome.APEX][:2]
    comparisons = tuple(
        dataclasses.replace(
            one,
            decision=dataclasses.replace(one.decision, equivalence=equivalence(change, p=0.1, shown=each)),
        )
        for one, each in zip(pooled, shown, strict=True)
    )
    heights = overall_equivalence(equivalence(change), tuple(one.group for one in pooled))
    whole = dataclasses.replace(content, comparisons=comparisons, overall=(), overall_equivalence=heights)
    ((_outcome, claim),) = overall_claims(whole)
    assert ("Not shown alone: " in claim.text) is (shown == (True, False))
    if shown == (True, False):
        assert claim.text.endswith(f"Not shown alone: {levels_name(whole, pooled[1].group)}.")


def test_one_group_speaks_for_itself(content):
    alone = overall_savings(Number(11.2, "%"), (content.pooled[0].group,))
    assert overall_claims(dataclasses.replace(content, overall=(alone,))) == []


@pytest.mark.parametrize(
    ("rule", "shown", "told"),
    [(Rule.PAIRED, True, True), (Rule.WITHIN, True, False), (Rule.PAIRED, False, False)],
)
def test_exploratory_groups_are_told_together_where_all_are_equivalent_by_day(content, rule, shown, told):
    within = equivalence(Number(0.4, "%", ci_low=0.1, ci_high=0.7, ci_level=0.9), shown=shown)
    changes = {"rule": rule, "equivalence": within, "adjusted": Number(0.01, "1", n=2), "adjusted_rejected": True}
    one = dataclasses.replace(decided(content, Outcome.APEX, **changes), exploratory="not the primary outcome")
    heights = overall_equivalence(within, (one.group, one.group))
    text = groups_in_one_sentence(
        dataclasses.replace(content, comparisons=(one, one), overall_equivalence=heights), Outcome.APEX
    )
    assert ("exploratory" in text and "2 of 2" in text) is told
    planned = dataclasses.replace(one, exploratory="")
    both = dataclasses.replace(content, comparisons=(planned, planned), overall_equivalence=heights)
    assert groups_in_one_sentence(both, Outcome.APEX) == ""
