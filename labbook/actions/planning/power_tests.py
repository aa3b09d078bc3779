"""The tests that a study is planned for, one function each: what they compare, at which level, with how many values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.conditions import Spread
from labbook.config.model import AnalysisSettings, Family, UnitOfAnalysis
from stats.planning.power import Power, power_anova, power_equivalence, power_t, power_welch
from stats.planning.power_percent import power_percent_equivalence


@dataclass(frozen=True, slots=True)
class Assumed:
    """A standard deviation and a control mean, in J or m; `spread` is what the former was estimated from, if it was.

    An undefined mean says what to do to have one.
    """

    sd: float
    mean: float | Undefined
    spread: Spread | None = None


@dataclass(frozen=True, slots=True)
class Design:
    """What is compared: in each of so many groups, so many treated levels of the swept factor with one control."""

    settings: AnalysisSettings
    swept: str
    treated: int
    groups: int

    @property
    def comparisons(self) -> int:
        """How many comparisons the family has."""
        return self.groups * (1 if self.settings.family is Family.POOLED else self.treated)

    def sizes(self, n: int) -> tuple[int, int]:
        """Return how many values of the control and of the treatment a comparison has, with n of each condition.

        Pooled runs are all of them values; a day's runs of all treated levels make one mean.
        """
        pooled_runs = self.settings.family is Family.POOLED and self.settings.unit_of_analysis is not UnitOfAnalysis.DAY
        return n, n * self.treated if pooled_runs else n


@dataclass(frozen=True, slots=True)
class PlannedTest:
    """A test at a level; `plan` goes from a standard deviation and the n of each condition to the power.

    `note` says what the name leaves open.
    """

    name: str
    alpha: float
    assumed: Assumed | Undefined
    plan: Callable[[float, int], Power]
    note: str = ""


MakeTest: TypeAlias = Callable[[Design, float, Assumed, Assumed | Undefined], PlannedTest | None]
"""Makes a test of a design for a difference of the primary outcome; None where the design has no such test."""


def _student(design: Design, difference: float, primary: Assumed, _apex: Assumed | Undefined) -> PlannedTest | None:
    alpha = design.settings.alpha
    return PlannedTest("Student's t", alpha, primary, lambda sd, n: power_t(difference, sd, *design.sizes(n), alpha))


def _welch(design: Design, difference: float, primary: Assumed, _apex: Assumed | Undefined) -> PlannedTest | None:
    return _welch_at(design, "Welch's t", design.settings.alpha, difference, primary)


def _welch_of_family(
    design: Design, difference: float, primary: Assumed, _apex: Assumed | Undefined
) -> PlannedTest | None:
    """Holm's procedure rejects at this level whatever the other comparisons give."""
    if design.comparisons == 1:
        return None
    alpha = design.settings.alpha / design.comparisons
    test = _welch_at(design, f"Welch's t, Holm over {design.comparisons}", alpha, difference, primary)
    return replace(test, note="rejects at this alpha whatever the other comparisons of the family give")


def _welch_at(design: Design, name: str, alpha: float, difference: float, primary: Assumed) -> PlannedTest:
    return PlannedTest(name, alpha, primary, lambda sd, n: power_welch(difference, sd, sd, *design.sizes(n), alpha))


def _anova(design: Design, difference: float, primary: Assumed, _apex: Assumed | Undefined) -> PlannedTest | None:
    """Two levels apart by the difference and the others half way: of all such means those hardest to find.

    Over two levels with as many values as the comparison with the control has, F is Student's t squared: no other test.
    """
    if design.treated < 2 or (design.treated == 2 and design.sizes(1) == (1, 1)):
        return None
    means = (-difference / 2.0, difference / 2.0, *[0.0] * (design.treated - 2))
    alpha = design.settings.alpha
    return PlannedTest(
        f"ANOVA over {design.treated} levels",
        alpha,
        primary,
        lambda sd, n: power_anova(means, sd, n, alpha),
        "two treated levels are that far apart and the others half way, the hardest case to find",
    )


def _equivalence(
    design: Design, _difference: float, _primary: Assumed, apex: Assumed | Undefined
) -> PlannedTest | None:
    """Apex heights that do not differ at all, against the bounds."""
    bounds, alpha = design.settings.apex_bounds, design.settings.alpha
    if bounds is None:
        return None
    name, note = "no loss of apex height (TOST)", "by Welch on all values; apexes do not differ at all"
    low, high = bounds.low, bounds.high
    if not bounds.percent:
        return PlannedTest(
            name, alpha, apex, lambda sd, n: power_equivalence(0.0, sd, low, high, *design.sizes(n), alpha), note
        )
    apex = percent_of_mean(apex)
    mean = apex if isinstance(apex, Undefined) else apex.mean
    if isinstance(mean, Undefined):
        return PlannedTest(name, alpha, apex, lambda sd, n: power_equivalence(0.0, sd, low, high, n, n), note)

    def plan(sd: float, n: int) -> Power:
        control, treated = design.sizes(n)
        found = power_percent_equivalence(0.0, mean, sd, low, high, treated, control, alpha)
        return replace(found, group_ns=(control, treated))

    return PlannedTest(
        name, alpha, apex, plan, f"{note}; the mean that the percent are of is estimated in the study, as in the test"
    )


def percent_of_mean(apex: Assumed | Undefined) -> Assumed | Undefined:
    """Return what is assumed of apex heights where bounds are in percent; undefined without a control's mean."""
    if isinstance(apex, Undefined) or not isinstance(apex.mean, Undefined):
        return apex
    return Undefined(Reason.BOUNDS_IN_PERCENT, reason=apex.mean.reason)


def tests_of(settings: AnalysisSettings) -> tuple[MakeTest, ...]:
    """Return the tests on all runs or day means, in the order in which they are shown; shared days have their own."""
    if settings.unit_of_analysis is UnitOfAnalysis.SHARED_DAYS:
        return (_anova,)
    return _student, _welch, _welch_of_family, _anova, _equivalence
