"""The results a report shows: comparisons and what stands beside them, drain fit, uncertainty budget, order in the day,
sensitivity."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from data_schema.outcomes import Outcome
from data_schema.vocabulary import ContrastKind, Rule
from reports.numbers import Number, Result, SignificanceTest, t_test

UNITS = {Rule.PAIRED: "day", Rule.WITHIN: "run", Rule.NONE: ""}
"""What each rule counts."""


@dataclass(frozen=True, slots=True)
class Equivalence(Result):
    """Two one-sided tests of apex heights against bounds in m, or in % of the control's mean (`percent`).

    `estimate` is treatment less control in the unit of the bounds, with an interval of level 1 - 2 alpha; `p` is the
    larger of both, `shown` is None where there is no test. `exploratory` says why the test was not planned, "" where it
    was.
    """

    estimate: Number
    t_low: Number
    p_low: Number
    t_high: Number
    p_high: Number
    p: Number
    shown: bool | None
    low: float
    high: float
    percent: bool
    exploratory: str = ""


@dataclass(frozen=True, slots=True)
class Decision(Result):
    """The test that decides a comparison, by the days that hold both of its sides (`stats.days.decision`).

    `difference` is treatment less control; `t` and `p` are those of no difference, t positive for a saving where there
    are savings, p of no saving where it is `one_sided`. `control_mean` is that over the shared days, `run_sd` the
    standard deviation of runs within them. `n_control` and `n_treatment` are the runs that the means are of, all where
    no day is shared; `other` runs, on days without the other side, enter nothing. `rejected` is None where nothing is
    tested.

    Added where they are known: `adjusted`, p by Holm's method over the `n` tests of the family; `equivalence` by the
    same days; `charge_missing`, runs without a charge, with any of which something would be claimed.
    """

    rule: Rule
    days: tuple[str, ...]
    difference: Number
    t: Number
    p: Number
    control_mean: Number
    run_sd: Number
    n_control: int
    n_treatment: int
    other: int
    rejected: bool | None
    savings: Number | None = None
    one_sided: bool = False
    adjusted: Number | None = None
    adjusted_rejected: bool | None = None
    equivalence: Equivalence | None = None
    charge_missing: tuple[str, ...] = ()

    @property
    def unit(self) -> str:
        """What the test counts: "day" (paired on day means), "run" (within days, for these days alone), or ""."""
        return UNITS[self.rule]

    @property
    def test(self) -> SignificanceTest:
        """The test of no difference, or of no saving."""
        return t_test("by shared days", self.t, self.p, one_sided=self.one_sided)

    @property
    def test_of_difference(self) -> SignificanceTest:
        """The same test with the sign of the difference, as it stands beside it."""
        t, difference = self.t.value, self.difference.value
        if not isinstance(t, float) or not isinstance(difference, float):
            return self.test
        return replace(self.test, statistic=math.copysign(t, difference))

    @property
    def shown(self) -> bool | None:
        """Whether a difference is shown, Holm's p included; None where that cannot be told."""
        if self.rejected is None or self.adjusted_rejected is None:
            return self.rejected
        return self.rejected and self.adjusted_rejected


@dataclass(frozen=True, slots=True)
class OverallSavings(Result):
    """The mean of the savings of several groups, each counted once; `left_out` are groups without a claim.

    `days_measured_only`: a group was compared within days, so that the claim holds for these days. `spread` is the
    standard deviation of the groups' savings, `heterogeneity_p` the p of the test that all saved the same; `differ` is
    None where that is not tested. `exploratory` says why the effect was not planned, "" where it was.
    """

    quantity: Outcome
    savings: Number
    t: Number
    p: Number
    spread: Number
    heterogeneity_p: Number
    groups: tuple[Mapping[str, str], ...]
    left_out: tuple[Mapping[str, str], ...]
    days: tuple[str, ...]
    days_measured_only: bool
    rejected: bool | None
    differ: bool | None
    one_sided: bool = False
    exploratory: str = ""

    @property
    def test(self) -> SignificanceTest:
        """The test of no saving."""
        return t_test("overall", self.t, self.p, one_sided=self.one_sided)


@dataclass(frozen=True, slots=True)
class OverallEquivalence(Equivalence):
    """Whether the mean change of apex height of several groups, in percent of each control, lies within the bounds."""

    groups: tuple[Mapping[str, str], ...] = ()
    left_out: tuple[Mapping[str, str], ...] = ()
    days: tuple[str, ...] = ()
    days_measured_only: bool = False


@dataclass(frozen=True, slots=True)
class ThesisRoute(Result):
    """The test of thesis 5.2.1 over all values, whatever their days: an F-test, then the t-test that it chooses.

    `test` is that one's name, "Student" or "Welch"; `difference` is treatment less control with its interval.
    """

    f: Number
    f_p: Number
    test: str
    t: Number
    p: Number
    difference: Number
    n_control: int
    n_treatment: int


POOLED = "pooled"
"""The level of a comparison that sets all treated levels together against the control."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """A treatment against its control: what decides, and the thesis's route beside it.

    `family` heads a block of the table ("each AD coefficient", "pooled over AD"); `group` holds the levels in
    common (foot, k_gain); `level` is the AD level as text or "pooled" (`POOLED`). `over_jumps` is the thesis's route
    over single jumps, in a study that repeats it. `exploratory` says why the comparison is not a planned one, "" where
    it is.
    """

    label: str
    quantity: Outcome
    group: Mapping[str, str]
    level: str
    family: str
    decision: Decision
    over_runs: ThesisRoute
    over_jumps: ThesisRoute | None = None
    exploratory: str = ""

    @property
    def opens(self) -> bool:
        """Whether all levels are pooled: what the page opens with."""
        return self.level == POOLED


@dataclass(frozen=True, slots=True)
class MeansContrast(Result):
    """A contrast of condition means by the days that they share, in percentage points of savings or the outcome's unit.

    `levels` of the `factor` are those compared, the second with the first, or those that a line goes through, which
    levels off `at` one of them; a trend's estimate is for each `per` of the factor. `side` says of which runs a
    difference is: "control" or "treated". `left_out` counts the combinations of other levels that one side lacks.

    Added where they are known: `adjusted`, p by Holm's method over all contrasts, by which `rejected` then goes;
    `exploratory`, why it was not planned.
    """

    kind: ContrastKind
    quantity: Outcome
    factor: str
    levels: tuple[str, ...]
    side: str
    per: float
    at: float | None
    left_out: int
    estimate: Number
    t: Number
    p: Number
    rule: Rule
    days: tuple[str, ...]
    rejected: bool | None
    adjusted: Number | None = None
    exploratory: str = ""

    @property
    def unit(self) -> str:
        """What the test counts, as in `Decision`."""
        return UNITS[self.rule]

    @property
    def test(self) -> SignificanceTest:
        """The test that it is 0."""
        return t_test("contrast", self.t, self.p)


@dataclass(frozen=True, slots=True)
class Anova(Result):
    """One-way analysis of variance over the swept factor's levels, control left out, within one group, by `n` runs."""

    label: str
    quantity: Outcome
    group: Mapping[str, str]
    f: Number
    p: Number
    df_between: int
    df_within: int
    n: int

    @property
    def test(self) -> SignificanceTest:
        """The F-test."""
        return SignificanceTest(
            "one-way ANOVA", self.f.value, (float(self.df_between), float(self.df_within)), self.p.value
        )


@dataclass(frozen=True, slots=True)
class IdlePoint:
    """One idle run: how long the robot was on, and the charge that went back in."""

    run: str
    duration_min: float
    charge_mah: float


@dataclass(frozen=True, slots=True)
class DrainFit:
    """One robot's passive drain (thesis 5.1.4): points, line with confidence band (arrays of one length), estimates.

    `at_run` is the drain at `run_duration_min`; `range_sentence` says that it lies outside the fitted range. `robot`
    names the robot where the report has several.
    """

    points: tuple[IdlePoint, ...]
    line_min: tuple[float, ...]
    line_mah: tuple[float, ...]
    band_low_mah: tuple[float, ...]
    band_high_mah: tuple[float, ...]
    slope: Number
    intercept: Number
    r_squared: Number
    at_run: Number
    run_duration_min: float
    range_sentence: str
    robot: str = ""


@dataclass(frozen=True, slots=True)
class BudgetItem:
    """One source of uncertainty of a joule a jump (J); `shared`: common to all runs; `total`: the sum.

    `joules` is for a single run, `of_mean` for the mean over the condition's runs. `within_robot`: what is shared is
    shared by the runs of one robot, of several.
    """

    component: str
    joules: Number
    of_mean: Number
    shared: bool
    note: str = ""
    total: bool = False
    within_robot: bool = False


@dataclass(frozen=True, slots=True)
class RunPoint:
    """A run in its day: `deviation_j` is its joules a jump minus the mean of its condition."""

    run: str
    day: str
    position: int
    pack: str
    joules: float
    deviation_j: float | None = None
    control: bool = False


@dataclass(frozen=True, slots=True)
class PackMean:
    """Joules a jump (or the deviation from the condition's mean, as `RunPoint` has it) of one pack's runs."""

    pack: str
    mean: Number


@dataclass(frozen=True, slots=True)
class Order:
    """Joules by position in the day and by pack; `sentences` name what is confounded with the day."""

    points: tuple[RunPoint, ...] = ()
    packs: tuple[PackMean, ...] = ()
    sentences: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Favoured:
    """A headline of a group, or over all (None), whose sides lie farther apart in the day than in a random order.

    Mean positions of both sides within shared days, Holm's p of the order, and by outcome the headline adjusted for
    position in the day; none where the runs leave no slope to adjust by.
    """

    group: Mapping[str, str] | None
    control_position: float
    treated_position: float
    p: float
    adjusted: Mapping[Outcome, Number]


@dataclass(frozen=True, slots=True)
class Variant:
    """A headline computed another way ("without exclusions", "other detector"), or without a `day`, "" elsewhere.

    `by_rules`: by one of all rules of onset and take-off, the protocol's among them.
    """

    label: str
    number: Number
    day: str = ""
    by_rules: bool = False


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """One headline: the number as reported and its recomputations.

    `rule_of_all_runs` is the rule that would decide about it without exclusions, "" where that is the same; `group`
    names the group that it is of, "" where a study has one.
    """

    headline: str
    as_reported: Number
    variants: tuple[Variant, ...]
    rule_of_all_runs: str = ""
    group: str = ""


_MUCH = 1.02
"""Times alpha, from which on looks err in more than was planned: less is the rounding of levels."""


@dataclass(frozen=True, slots=True)
class Look:
    """Which look at growing data this is, and at which level p is compared.

    `runs` are those of the study with a number, of `runs_planned`, None where no plan says. `level` takes the place of
    `alpha`. `share_in_error` is that of studies without an effect in which one of the looks so far finds one.
    """

    number: int
    planned: int
    runs: int
    runs_planned: int | None
    alpha: float
    level: float
    share_in_error: float

    @property
    def unplanned(self) -> bool:
        """Whether there were more looks than planned, or looks after all planned runs: they err in more than alpha."""
        return self.number > self.planned or self.share_in_error > _MUCH * self.alpha
