"""The results a report shows: comparisons and what stands beside them, drain fit, uncertainty budget, order in the day,
sensitivity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from data_schema.outcomes import Outcome
from data_schema.vocabulary import ContrastKind
from reports.numbers import Number, SignificanceTest, Value


@dataclass(frozen=True, slots=True)
class Side:
    """Mean and standard deviation of the runs of one side of a comparison."""

    mean: Value
    sd: Value


@dataclass(frozen=True, slots=True)
class ByDay:
    """Treatment less control by y ~ condition + (1 | day).

    `method` names the test: "mixed model" (REML, degrees of freedom after Satterthwaite), or "exact test on ..." where
    the design is balanced. `day_sd` and `run_sd` are the standard deviations between days and between runs of a day, by
    REML. `confounding` says which conditions are confounded with days, "" where they do not; `notes`
    what the model left out.
    """

    difference: Number
    test: SignificanceTest
    days: int
    day_sd: Number
    run_sd: Number
    method: str
    confounding: str = ""
    notes: tuple[str, ...] = ()

    @property
    def kind(self) -> str:
        """The test in two words: "mixed model" or "exact test"."""
        return self.method.partition(" on ")[0]


@dataclass(frozen=True, slots=True)
class Equivalence:
    """Two one-sided tests of apex heights against bounds in m, or in % of the control's mean.

    `estimate` is treatment less control in the unit of the bounds, with an interval of level 1 - 2 alpha; `shown` is
    None where there is no test. `exploratory` says why the test was not planned, "" where it was.
    """

    estimate: Number
    low: float
    high: float
    at_low: SignificanceTest
    at_high: SignificanceTest
    p: Value
    shown: bool | None
    exploratory: str = ""


@dataclass(frozen=True, slots=True)
class Decision:
    """The test that decides a comparison, by the days that hold both of its sides.

    `unit` says what it counts: "day" (paired on day means), "run" (within days: it holds for these days), "" where
    nothing is claimed; `test` then has the reason. `n_control` and `n_treatment` are the runs that the means are of;
    `other` runs, on days without the other side, enter nothing. `charge_missing` names runs without a charge, with any
    of which something would be claimed. `adjusted` is p by Holm's method over the `n` tests of
    the family.
    """

    unit: str
    days: tuple[str, ...]
    n_control: int
    n_treatment: int
    other: int
    difference: Number
    savings: Number | None
    test: SignificanceTest
    rejected: bool | None
    adjusted: Number | None = None
    adjusted_rejected: bool | None = None
    equivalence: Equivalence | None = None
    charge_missing: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class OverGroups:
    """What an effect over groups is of; `left_out` are groups without a claim.

    `days_measured_only`: a group was compared within days, so that the claim holds for these days.
    """

    groups: tuple[Mapping[str, str], ...]
    left_out: tuple[Mapping[str, str], ...]
    days: tuple[str, ...]
    days_measured_only: bool


@dataclass(frozen=True, slots=True)
class OverallSavings:
    """The mean of the savings of several groups, each counted once.

    `spread` is the standard deviation of the groups' savings, `heterogeneity_p` the p of the test that all saved the
    same; `differ` is None where that is not tested.
    `exploratory` says why the effect was not planned, "" where it was.
    """

    quantity: Outcome
    savings: Number
    test: SignificanceTest
    spread: Number
    heterogeneity_p: Number
    differ: bool | None
    rejected: bool | None
    scope: OverGroups
    exploratory: str = ""


@dataclass(frozen=True, slots=True)
class OverallEquivalence:
    """Whether the mean change of apex height of several groups lies within the bounds."""

    tested: Equivalence
    scope: OverGroups


POOLED = "pooled"
"""The level of a comparison that sets all treated levels together against the control."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """Control against treatment on run means; `difference` = treatment - control, `savings` in percent.

    `family` heads a block of the table ("each AD coefficient", "pooled over AD"); `group` holds the levels in
    common (foot, k_gain); `level` is the AD level as text or "pooled" (`POOLED`). `test` is what the F-test
    chose (Student or Welch), `welch` stands beside it always.
    `sides` are those of the control and of the treatment. `adjusted` is Welch's p by Holm's method over the `n` tests
    of the family; `exploratory` says why the comparison is not a planned one, "" where it is; `one_day_each` that p and
    intervals are confounded with days, where each side had one day, and not the same, "" elsewhere. `decision` leads
    where the plan leaves the unit of analysis to the days.

    Verdicts: `rejected` says whether Welch's p is at most alpha, `adjusted_rejected` whether `adjusted` is,
    `savings_shown` whether the savings differ from zero; None where there is no such p or interval.
    """

    label: str
    quantity: Outcome
    group: Mapping[str, str]
    level: str
    n_control: int
    n_treatment: int
    variance_test: SignificanceTest
    test: SignificanceTest
    difference: Number
    welch: SignificanceTest
    welch_difference: Number
    savings: Number | None = None
    brown_forsythe: SignificanceTest | None = None
    family: str = ""
    sides: tuple[Side, Side] | None = None
    by_day: ByDay | None = None
    adjusted: Number | None = None
    rejected: bool | None = None
    adjusted_rejected: bool | None = None
    savings_shown: bool | None = None
    equivalence: Equivalence | None = None
    exploratory: str = ""
    one_day_each: str = ""
    decision: Decision | None = None

    @property
    def lead(self) -> Decision:
        """The test that decides: by shared days, or Welch's where the plan counts runs or days."""
        return self.decision or Decision(
            unit="run",
            days=(),
            n_control=self.n_control,
            n_treatment=self.n_treatment,
            other=0,
            difference=self.welch_difference,
            savings=self.savings,
            test=self.welch,
            rejected=self.rejected,
            adjusted=self.adjusted,
            adjusted_rejected=self.adjusted_rejected,
            equivalence=self.equivalence,
        )

    @property
    def unsure(self) -> str:
        """That p and intervals of the lead are confounded with days; "" where days that hold both sides decide."""
        return self.one_day_each if self.decision is None else ""

    @property
    def opens(self) -> bool:
        """Whether all levels are pooled: what the page opens with."""
        return self.level == POOLED


@dataclass(frozen=True, slots=True)
class MeansContrast:
    """A contrast of condition means by the days that they share, in percentage points of savings or the outcome's unit.

    `levels` of the `factor` are those compared, the second with the first, or those that a line goes through, which
    levels off `at` one of them; a trend's estimate is for each `per` of the factor. `side` says of which runs a
    difference is: "control" or "treated". `unit` and `days` are as in `Decision`; `adjusted` is p by Holm's method over
    all contrasts, and `rejected` whether it is at most alpha. `exploratory` says why it was not planned; `left_out`
    counts the combinations of other levels that one side lacks.
    """

    kind: ContrastKind
    quantity: Outcome
    factor: str
    levels: tuple[str, ...]
    side: str
    per: float
    at: float | None
    estimate: Number
    test: SignificanceTest
    adjusted: Number | None
    rejected: bool | None
    unit: str
    days: tuple[str, ...]
    exploratory: str = ""
    left_out: int = 0


@dataclass(frozen=True, slots=True)
class Anova:
    """One-way analysis of variance over the swept factor's levels, control left out, within one group.

    `exploratory` says why it was not planned, "" where it was; `one_day_each` is as in a comparison.
    """

    label: str
    quantity: Outcome
    group: Mapping[str, str]
    test: SignificanceTest
    n: int
    provenance: str = ""
    exploratory: str = ""
    one_day_each: str = ""


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
    band_level: float = 0.95
    robot: str = ""


@dataclass(frozen=True, slots=True)
class BudgetItem:
    """One source of uncertainty of a joule a jump (J); `shared`: common to all runs; `total`: the sum.

    `joules` is for a single run, `of_mean` for the mean over the condition's runs. `within_robot`: what is shared is
    shared by the runs of one robot, of several.
    """

    component: str
    joules: Value
    of_mean: Value
    shared: bool
    note: str = ""
    total: bool = False
    provenance: str = ""
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
