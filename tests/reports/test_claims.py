"""What is claimed: the numbers that decide, the groups and days that they are of, and what changes the sentence."""

import dataclasses

import pytest

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Rule, Undefined
from reports.claims import ELSEWHERE, family_claim, group_claim, groups_in_one_sentence, overall_claims
from reports.naming import level_of, levels_name
from reports.numbers import Number
from reports.results import Decision, Factor, Level
from tests.helpers.wording import says
from tests.reports import made
from tests.reports.made import DAYS, equivalence, overall_equivalence, overall_savings, plain, t_and_p

CHANGE = Number(0.4, "%", ci_low=0.1, ci_high=0.7, ci_level=0.9)


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


def said(content, outcome, **changes):
    return plain(group_claim(content, decided(content, outcome, **changes)).text)


def test_a_saving_comes_with_its_interval_its_test_and_its_group(content):
    text = said(content, Outcome.JOULES, other=7)
    says(text, "12.1 %", "95 %", "6.8", "17.2 %", "t(4)", "6.32", "small foot", "active damping".capitalize(), "7 runs")
    assert group_claim(content, decided(content, Outcome.JOULES)).provenance == ("abc",)


def test_treatment_and_control_have_the_names_that_the_study_gives_them(content):
    factor = Factor("ad_controller", "Active controller", control="normal", swept=True)
    smooth = tuple(
        dataclasses.replace(one, levels=(*one.levels[:2], Level(factor.name, "normal" if one.control else "smooth")))
        for one in content.conditions
    )
    changed = dataclasses.replace(content, factors=(*content.factors[:2], factor), conditions=smooth)
    text = said(changed, Outcome.JOULES)
    says(text, "Smooth", "normal")
    assert "active damping" not in text
    named = dataclasses.replace(factor, treatment="smoothing", control_name="bang-bang")
    says(said(dataclasses.replace(changed, factors=(*content.factors[:2], named)), Outcome.JOULES), "Smoothing")


def test_within_days_the_claim_and_its_test_of_equivalence_hold_for_these_days(content):
    within = equivalence(CHANGE)
    of_days = {"rule": Rule.WITHIN, "days": DAYS[:3]}
    text = said(content, Outcome.APEX, equivalence=within, **of_days)
    says(text, "3 days", "1.30 mm", "−3", "3 %", "90 %", "0.10")
    assert text.endswith(ELSEWHERE)
    unshown = dataclasses.replace(within, shown=False)
    nothing = said(content, Outcome.APEX, equivalence=unshown, rejected=False, **of_days)
    says(nothing, "3 days", "1.30 mm")
    assert ELSEWHERE not in nothing


def test_where_days_tell_nothing_there_is_the_reason_and_no_interval(content):
    why = Undefined(Reason.NO_DAY_HOLDS_BOTH, a="the control", b="the treatment")
    saved, nothing = Number(12.1, "%", ci_low=why, ci_high=why), t_and_p(why, why, why)
    text = said(content, Outcome.JOULES, rule=Rule.NONE, days=(), savings=saved, rejected=None, **nothing)
    says(text, why.reason, "12.1 %")
    assert "CI" not in text


def test_what_is_not_shown_is_said_otherwise_than_what_is(content):
    """By its own p, by Holm's, and where it cannot be bounded."""
    adjusted = {"adjusted": Number(0.06, "1", n=4), "adjusted_rejected": False}
    unbounded = dict.fromkeys(("ci_low", "ci_high"), Undefined(Reason.CONTROL_NEAR_ZERO))
    ways = ({}, {"rejected": False}, adjusted, {"savings": Number(12.1, "%", **unbounded)})
    texts = [said(content, Outcome.JOULES, **changes) for changes in ways]
    assert len({text.partition("(")[0] for text in texts}) == len(ways)
    for text in texts:
        says(text, "12.1 %", "t(4)", "6.32")


@pytest.mark.parametrize("measured_only", [True, False])
def test_an_effect_over_groups_says_what_it_is_of(content, measured_only):
    groups = [c.group for c in content.pooled if c.quantity is Outcome.JOULES]
    of = {"left_out": tuple(groups[3:]), "days_measured_only": measured_only}
    savings = overall_savings(Number(11.2, "%", 1.5, None, 8.1, 14.3), tuple(groups[:3]), **of)
    heights = overall_equivalence(equivalence(CHANGE), tuple(groups[:3]), **of)
    (of_joules, saved), (of_apex, kept) = overall_claims(
        dataclasses.replace(content, overall=(savings,), overall_equivalence=heights)
    )
    assert (of_joules, of_apex) == (Outcome.JOULES, Outcome.APEX)
    says(saved.text, "11.2", "95", "8.1", "14.3")
    says(kept.text, "0.4", "90", "TOST")
    for text in map(plain, (saved.text, kept.text)):
        assert (ELSEWHERE in text) is measured_only
        says(text, "3 groups")
        says(text, *(plain(levels_name(content, group)) for group in groups[3:]))


def test_that_groups_differ_is_said_with_the_p_of_its_test(content):
    pooled = [c for c in content.pooled if c.quantity is Outcome.JOULES][:2]
    groups, p = tuple(one.group for one in pooled), Number(0.0123, "1")
    for differ in (True, None):
        savings = overall_savings(Number(2.1, "%", 0.7, None, 0.6, 3.6), groups, heterogeneity_p=p, differ=differ)
        ((_outcome, claim),) = overall_claims(dataclasses.replace(content, overall=(savings,)))
        assert (".012" in plain(claim.text)) is bool(differ)


def test_one_group_speaks_for_itself(content):
    alone = overall_savings(Number(11.2, "%"), (content.pooled[0].group,))
    assert overall_claims(dataclasses.replace(content, overall=(alone,))) == []


@pytest.mark.parametrize(
    ("rule", "shown", "told"), [(Rule.PAIRED, True, True), (Rule.WITHIN, True, False), (Rule.PAIRED, False, False)]
)
def test_exploratory_groups_are_told_together_where_all_are_equivalent_by_day(content, rule, shown, told):
    within = equivalence(CHANGE, shown=shown)
    changes = {"rule": rule, "equivalence": within, "adjusted": Number(0.01, "1", n=2), "adjusted_rejected": True}
    one = dataclasses.replace(decided(content, Outcome.APEX, **changes), exploratory="not the primary outcome")
    heights = overall_equivalence(within, (one.group, one.group))
    of_both = dataclasses.replace(content, comparisons=(one, one), overall_equivalence=heights)
    assert bool(groups_in_one_sentence(of_both, Outcome.APEX)) is told
    planned = dataclasses.replace(one, exploratory="")
    both = dataclasses.replace(content, comparisons=(planned, planned), overall_equivalence=heights)
    assert groups_in_one_sentence(both, Outcome.APEX) == ""


def test_a_family_names_the_few_comparisons_that_are_shown_and_counts_the_others(content):
    levels = [c for c in content.comparisons if not c.opens and c.quantity is Outcome.JOULES][:3]
    first, *others = made.decided(levels, *({"adjusted_rejected": shown} for shown in (True, False, False)))
    text = plain(family_claim(content, [first, *others]).text)
    says(text, "1 of 3", plain(levels_name(content, first.group)), plain(level_of(content, first)))
    saved = made.decided([first] * 5, *({"savings": Number(3.0 + at, "%", 0.2)} for at in range(5)))
    says(plain(family_claim(content, saved).text), "5 of 5", "3.00", "7.00 %")
    why = Number(Undefined(Reason.GROUPS_WITHOUT_SCATTER), "1")
    untested = {"rejected": None, "adjusted_rejected": None, "t": why, "p": why}
    family = [*made.decided([first], untested), *others]
    assert family_claim(content, family).text != family_claim(content, others).text
