import dataclasses
import re

import pytest

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.content import Factor, Level
from reports.naming import level_of, levels_name
from reports.numbers import Number
from reports.remarks import NOT_FROM_DAYS
from reports.sentences import difference_claim, family_claim, savings_claim
from tests.helpers.wording import says


def plain(text):
    return text.replace("\u00a0", " ")


@pytest.fixture
def headline(content):
    return next(c for c in content.comparisons if c.opens and c.group == {"foot": "small", "k_gain": "400"})


def with_savings(comparison, *, shown=True, **changes):
    savings = dataclasses.replace(comparison.savings, **changes)
    return dataclasses.replace(comparison, savings=savings, savings_shown=shown)


def test_the_treatment_has_the_name_that_the_study_gives_it(content, headline):
    """It was "the treatment (smooth controller)", and of a factor such as `ad_gain` always "active damping"."""
    factor = Factor("ad_controller", "Active controller", control="normal", swept=True)
    smooth = tuple(
        dataclasses.replace(one, levels=(*one.levels[:2], Level(factor.name, "normal" if one.control else "smooth")))
        for one in content.conditions
    )
    changed = dataclasses.replace(content, factors=(*content.factors[:2], factor), conditions=smooth)
    text = plain(savings_claim(changed, with_savings(headline, value=10.6, se=1.0, ci_low=8.6, ci_high=12.6)).text)
    says(text, "Smooth saved 10.6 % of the energy of a jump against the control (normal)")
    assert not re.search(r"active damping|\bCE\b", text)
    named = dataclasses.replace(factor, treatment="smoothing", control_name="bang-bang")
    changed = dataclasses.replace(changed, factors=(*content.factors[:2], named))
    says(savings_claim(changed, headline).text, "Smoothing saved")


def test_a_saving_that_is_shown(content, headline):
    claim = savings_claim(content, with_savings(headline, value=15.2, se=3.4, ci_low=8.1, ci_high=21.9))
    says(plain(claim.text), "Active damping saved", "15.2 %", "1091 N/m", "95 %", "8.1", "21.9 %")
    beside = (headline.adjusted.provenance, headline.by_day.difference.provenance)
    assert claim.provenance == (headline.savings.provenance, headline.difference.provenance, *beside)


def test_no_saving_is_picked(content):
    assert not any("picked" in claim.text or "largest" in claim.text for claim in content.claims)


def test_too_few_runs_for_a_difference_are_counted(content):
    apex = next(c for c in content.comparisons if c.opens and c.quantity is Outcome.APEX)
    no_ends = dataclasses.replace(apex.welch_difference, ci_low=None, ci_high=None)
    claim = difference_claim(content, dataclasses.replace(apex, welch_difference=no_ends, n_control=1, n_treatment=2))
    says(plain(claim.text), "1 control", "2 treatment")


@pytest.mark.parametrize(
    ("changes", "shown", "start"),
    [
        ({"value": 3.0, "ci_low": -2.0, "ci_high": 8.0}, False, "No difference in energy was shown"),
        ({"value": -9.0, "ci_low": -14.0, "ci_high": -4.0}, True, "Active damping cost 9.0 % more energy a jump"),
        (
            {
                "value": 3.0,
                "ci_low": Undefined(Reason.AS_SAID, said="unbounded"),
                "ci_high": Undefined(Reason.AS_SAID, said="unbounded"),
            },
            None,
            "The savings with",
        ),
        (
            {
                "value": -1335.0,
                "ci_low": Undefined(Reason.AS_SAID, said="unbounded"),
                "ci_high": Undefined(Reason.AS_SAID, said="unbounded"),
            },
            None,
            "Active damping cost 1335.0 % more energy a jump with the small foot and k = 1091 N/m by the best "
            "estimate, which cannot be bounded",
        ),
        ({"value": Undefined(Reason.AS_SAID, said="the control's mean is zero")}, None, "The savings with"),
    ],
)
def test_no_more_is_claimed_than_is_shown(content, headline, changes, shown, start):
    claim = savings_claim(content, with_savings(headline, shown=shown, se=2.5, **changes))
    assert plain(claim.text).startswith(start)
    for value in changes.values():
        if isinstance(value, Undefined):
            assert value.reason in claim.text


def test_a_difference_in_height(content):
    apex = next(c for c in content.comparisons if c.opens and c.quantity is Outcome.APEX)
    shown = dataclasses.replace(apex.welch_difference, value=0.0022, se=0.0004, ci_low=0.0014, ci_high=0.003)
    claim = difference_claim(content, dataclasses.replace(apex, welch_difference=shown, rejected=True))
    says(plain(claim.text), "2.20 mm", "under active damping")
    unsure = dataclasses.replace(shown, ci_low=-0.001, ci_high=0.0054)
    claim = difference_claim(content, dataclasses.replace(apex, welch_difference=unsure, rejected=False))
    says(claim.text, "does not tell")
    nothing = dataclasses.replace(shown, value=Undefined(Reason.AS_SAID, said="one run only"))
    claim = difference_claim(content, dataclasses.replace(apex, welch_difference=nothing))
    says(claim.text, "one run only")


def test_a_claim_has_holms_p_and_the_test_by_day_beside_welchs(content, headline):
    text = plain(savings_claim(content, headline).text)
    says(text, "4 tests")
    alone = dataclasses.replace(headline, adjusted=None, by_day=None)
    assert "Holm" not in savings_claim(content, alone).text
    assert "by day" not in savings_claim(content, alone).text


DAYS_TELL_NOTHING = "the treatment and the control were measured on one day each"


def test_with_one_day_each_nothing_is_claimed_and_the_claim_says_so_in_few_words(content, headline):
    saved = with_savings(headline, value=15.2, se=3.4, ci_low=8.1, ci_high=21.9)
    text = plain(savings_claim(content, dataclasses.replace(saved, one_day_each=DAYS_TELL_NOTHING)).text)
    where = "with the small foot and k = 1091 N/m"
    start = f"No saving {where} can be told from a difference between days: the estimate is "
    says(text, start, "15.2 %", "95 %", "8.1", "21.9 %", "n = 14")
    assert text.count("difference between days") == 1
    assert "by day" not in text
    cost = with_savings(headline, value=-9.0, se=3.4, ci_low=-14.0, ci_high=-4.0)
    text = plain(savings_claim(content, dataclasses.replace(cost, one_day_each=DAYS_TELL_NOTHING)).text)
    assert text.startswith(f"{start}−9.0 %")
    apex = next(c for c in content.comparisons if c.opens and c.quantity is Outcome.APEX)
    equal = dataclasses.replace(apex.equivalence, shown=True)
    confounded = dataclasses.replace(apex, equivalence=equal, one_day_each=DAYS_TELL_NOTHING)
    text = plain(difference_claim(content, confounded).text)
    says(text, "835 N/m", "difference between days", "95 %")
    says(text, "−5", "5 mm", "difference between days", "90 %")
    assert DAYS_TELL_NOTHING not in text
    assert "was shown" not in text


def test_a_claim_that_was_not_planned_says_so(content, headline):
    assert "exploratory" not in savings_claim(content, headline).text
    unplanned = dataclasses.replace(headline, exploratory="nothing was decided")
    first = savings_claim(content, unplanned).text
    says(first, "an exploratory comparison")
    apex = next(c for c in content.comparisons if c.opens and c.quantity is Outcome.APEX)
    height = difference_claim(content, dataclasses.replace(apex, exploratory="nothing was decided")).text
    assert height.count("exploratory") == 1
    says(height, "an exploratory comparison", "Equivalence within")


def holm_of(comparison, p, *, rejected):
    adjusted = dataclasses.replace(comparison.adjusted, value=p)
    return dataclasses.replace(comparison, rejected=True, adjusted=adjusted, adjusted_rejected=rejected)


def test_what_the_interval_shows_and_holm_does_not_is_not_stated_as_shown(content, headline):
    saved = with_savings(headline, value=15.2, se=3.4, ci_low=8.1, ci_high=21.9)
    once = "once the 4 tests of the family are counted by Holm"
    assert once not in savings_claim(content, holm_of(saved, 0.05, rejected=True)).text
    text = plain(savings_claim(content, holm_of(saved, 0.064, rejected=False)).text)
    says(text, "No difference in", "small foot", "1091 N/m", once)
    says(text, "the estimated saving", "15.2 %", "95 %", "8.1", "21.9 %")
    apex = next(c for c in content.comparisons if c.opens and c.quantity is Outcome.APEX)
    shown = dataclasses.replace(apex.welch_difference, value=0.00123, se=0.0005, ci_low=0.00012, ci_high=0.00234)
    higher = dataclasses.replace(apex, welch_difference=shown)
    text = plain(difference_claim(content, holm_of(higher, 0.064, rejected=False)).text)
    says(text, "1.23 mm", "under active damping", "835 N/m", once, "95")
    assert once not in difference_claim(content, holm_of(higher, 0.05, rejected=True)).text
    assert once not in difference_claim(content, dataclasses.replace(higher, rejected=True, adjusted=None)).text


def test_a_claim_on_heights_counts_runs_as_one_on_joules_does(content):
    apex = next(c for c in content.comparisons if c.opens and c.quantity is Outcome.APEX)
    text = plain(difference_claim(content, apex).text)
    says(text, apex.n_control, "control and", apex.n_treatment, "treatment runs")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"shown": True}, "Equivalence within −5 to 5 mm was shown (90 % CI "),
        ({"shown": False}, "Equivalence within −5 to 5 mm was not shown (90 % CI "),
        ({"exploratory": "no bounds then"}, "), an exploratory test."),
        (
            {"p": Undefined(Reason.AS_SAID, said="one run only"), "shown": None},
            "Equivalence within −5 to 5 mm could not be tested: one run only.",
        ),
    ],
)
def test_a_claim_on_heights_says_whether_they_are_equal_within_the_bounds(content, changes, said):
    apex = next(c for c in content.comparisons if c.opens and c.quantity is Outcome.APEX)
    changed = dataclasses.replace(apex, equivalence=dataclasses.replace(apex.equivalence, **changes))
    claim = difference_claim(content, changed)
    assert said in plain(claim.text)
    assert apex.equivalence.estimate.provenance in claim.provenance
    untested = dataclasses.replace(apex, equivalence=None)
    assert "quivalence" not in difference_claim(content, untested).text


def test_bounds_in_percent_are_of_the_controls_mean(content):
    apex = next(c for c in content.comparisons if c.opens and c.quantity is Outcome.APEX)
    estimate = dataclasses.replace(apex.equivalence.estimate, unit="%", value=0.4, ci_low=0.1, ci_high=0.7)
    percent = dataclasses.replace(apex.equivalence, estimate=estimate, low=-3.0, high=3.0, shown=True)
    claim = difference_claim(content, dataclasses.replace(apex, equivalence=percent))
    says(plain(claim.text), "−3", "3 %", "mean was shown", "90 %", "0.10", "0.70 %")


def test_a_family_counts_apart_what_has_no_test_and_what_days_cannot_tell(content):
    """Decided by shared days, a comparison may lack a test for other reasons than its days."""
    family = [c for c in content.comparisons if c.opens and c.quantity is Outcome.JOULES]
    confounded = [dataclasses.replace(family[0], one_day_each=DAYS_TELL_NOTHING), *family[1:]]
    says(plain(family_claim(content, confounded).text), f"1 {NOT_FROM_DAYS})")
    why = Undefined(Reason.GROUPS_WITHOUT_SCATTER)
    decided = [dataclasses.replace(c, decision=c.lead) for c in family]
    lead = decided[0].lead
    test = dataclasses.replace(lead.test, p=why)
    untested = dataclasses.replace(lead, rejected=None, adjusted_rejected=None, test=test)
    text = plain(family_claim(content, [dataclasses.replace(decided[0], decision=untested), *decided[1:]]).text)
    says(text, "1 without a test)")
    assert NOT_FROM_DAYS not in text
    assert text.endswith("The levels are pooled in what follows, which is exploratory.")
    none = [dataclasses.replace(c, decision=dataclasses.replace(c.lead, adjusted_rejected=False)) for c in family]
    assert plain(family_claim(content, none, pooled=False).text).endswith("joules a jump.")


def test_a_family_names_the_few_comparisons_that_are_shown(content):
    levels = [c for c in content.comparisons if not c.opens and c.quantity is Outcome.JOULES][:3]
    first, *others = (
        dataclasses.replace(c, decision=dataclasses.replace(c.lead, adjusted_rejected=shown))
        for c, shown in zip(levels, (True, False, False), strict=True)
    )
    text = plain(family_claim(content, [first, *others]).text)
    says(text, "1 of 3", plain(levels_name(content, first.group)), plain(level_of(content, first)))
    saved = [
        dataclasses.replace(
            first, decision=dataclasses.replace(first.lead, savings=Number(3.0 + at, "%", 0.2)), exploratory=""
        )
        for at in range(5)
    ]
    says(plain(family_claim(content, saved).text), "Decided on beforehand", "5 of 5", "3.00 to 7.00 %")
    says(plain(family_claim(content, [*saved[:1], *others]).text), "1 of 3", "saving 3.00 %")
    apex = [
        dataclasses.replace(
            each, quantity=Outcome.APEX, exploratory="not the primary outcome",
            decision=dataclasses.replace(each.lead, savings=None, adjusted_rejected=False),
        )
        for each in others
    ]  # fmt: skip
    says(plain(family_claim(content, [*saved, *apex]).text), "Decided on beforehand", "exploratory ones none of 2")
