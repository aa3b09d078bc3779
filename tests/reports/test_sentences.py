import dataclasses
import re

import pytest

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.content import Factor, Level
from reports.decided_sentences import group_claim
from reports.naming import level_of, levels_name
from reports.numbers import Number
from reports.sentences import family_claim
from tests.helpers.wording import says


def plain(text):
    return text.replace("\u00a0", " ")


@pytest.fixture
def headline(content):
    return next(c for c in content.comparisons if c.opens and c.group == {"foot": "small", "k_gain": "400"})


def with_savings(comparison, **changes):
    saved = dataclasses.replace(comparison.decision.savings, **changes)
    return dataclasses.replace(comparison, decision=dataclasses.replace(comparison.decision, savings=saved))


def test_the_treatment_has_the_name_that_the_study_gives_it(content, headline):
    """It was "the treatment (smooth controller)", and of a factor such as `ad_gain` always "active damping"."""
    factor = Factor("ad_controller", "Active controller", control="normal", swept=True)
    smooth = tuple(
        dataclasses.replace(one, levels=(*one.levels[:2], Level(factor.name, "normal" if one.control else "smooth")))
        for one in content.conditions
    )
    changed = dataclasses.replace(content, factors=(*content.factors[:2], factor), conditions=smooth)
    text = plain(group_claim(changed, with_savings(headline, value=10.6, se=1.0, ci_low=8.6, ci_high=12.6)).text)
    says(text, "Smooth saved 10.6 % of the energy of a jump against the control (normal)")
    assert not re.search(r"active damping|\bCE\b", text)
    named = dataclasses.replace(factor, treatment="smoothing", control_name="bang-bang")
    changed = dataclasses.replace(changed, factors=(*content.factors[:2], named))
    says(group_claim(changed, headline).text, "Smoothing saved")


def test_no_saving_is_picked(content):
    assert not any("picked" in claim.text or "largest" in claim.text for claim in content.claims)


def test_a_family_names_the_few_comparisons_that_are_shown(content):
    levels = [c for c in content.comparisons if not c.opens and c.quantity is Outcome.JOULES][:3]
    first, *others = (
        dataclasses.replace(c, decision=dataclasses.replace(c.decision, adjusted_rejected=shown))
        for c, shown in zip(levels, (True, False, False), strict=True)
    )
    text = plain(family_claim(content, [first, *others]).text)
    says(text, "1 of 3", plain(levels_name(content, first.group)), plain(level_of(content, first)))
    saved = [
        dataclasses.replace(
            first, decision=dataclasses.replace(first.decision, savings=Number(3.0 + at, "%", 0.2)), exploratory=""
        )
        for at in range(5)
    ]
    says(plain(family_claim(content, saved).text), "Decided on beforehand", "5 of 5", "3.00 to 7.00 %")
    says(plain(family_claim(content, [*saved[:1], *others]).text), "1 of 3", "saving 3.00 %")
    apex = [
        dataclasses.replace(
            each, quantity=Outcome.APEX, exploratory="not the primary outcome",
            decision=dataclasses.replace(each.decision, savings=None, adjusted_rejected=False),
        )
        for each in others
    ]  # fmt: skip
    says(plain(family_claim(content, [*saved, *apex]).text), "Decided on beforehand", "exploratory ones none of 2")


def test_a_family_counts_what_has_no_test(content):
    family = [c for c in content.comparisons if c.opens and c.quantity is Outcome.JOULES]
    why = Number(Undefined(Reason.GROUPS_WITHOUT_SCATTER), "1")
    untested = dataclasses.replace(family[0].decision, rejected=None, adjusted_rejected=None, t=why, p=why)
    text = plain(family_claim(content, [dataclasses.replace(family[0], decision=untested), *family[1:]]).text)
    says(text, "1 without a test)")
    assert text.endswith("The levels are pooled in what follows, which is exploratory.")
