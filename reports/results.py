"""The results of a study: made by `labbook.analysis`, drawn, tabled and put into words here.

Every number comes with its unit, uncertainty, n and provenance id. `Undefined` stands where a number does
not exist, `None` where one does not apply. Values are never rounded here; only their display is.

The results are those of the functions that compute them: comparisons and what stands beside them, hypotheses and
predictions, drain fit, uncertainty budget, order in the day, recomputed headlines.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, NamedTuple, Self

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.vocabulary import ContrastKind, Rule, Undefined
from reports import display
from reports.display import sentence_start
from reports.numbers import Number, NumberNames, Result, SignificanceTest, Value, t_test

if TYPE_CHECKING:
    from simulator.steady.published_results import PublishedResult
    from stats.days.order import PositionsCompared
    from stats.lines.passive_drain import PassiveDrain


@dataclass(frozen=True, slots=True)
class Factor:
    """A factor of the study; `swept` is the one on the x axis (say the active-damping gain).

    Where levels are gains, physical = `slope` * gain + `offset` in `unit`; the control's gain stands for 0. Levels that
    are plain numbers are in `unit` themselves. `treatment` is what the levels beside the control are called together,
    `control_name` the control; "" where labbook.toml names neither.
    """

    name: str
    title: str
    symbol: str = ""
    unit: str = ""
    slope: float | None = None
    offset: float | None = None
    control: str | None = None
    swept: bool = False
    treatment: str = ""
    control_name: str = ""


@dataclass(frozen=True, slots=True)
class Level:
    """A factor's level in one condition: `label` as the study writes it ("small", "300").

    `value` is physical, in `unit` (foot radius in m, stiffness in N/m, damping in kg/s, 0 for control); `gain` is
    the controller's number that the value belongs to.
    """

    factor: str
    label: str
    value: float | None = None
    unit: str = ""
    gain: float | None = None


@dataclass(frozen=True, slots=True)
class Run:
    """An analysed run: when it was made and with what, and the apex height in m of each jump that counts, by number."""

    day: str
    position: int
    pack: str
    robot: str
    heights_m: Mapping[int, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ConditionSummary(Result):
    """One quantity in one condition: `mean` carries SE, CI and n (runs), `runs` the value of each by its name."""

    mean: Number
    sd: Number
    runs: tuple[tuple[str, float], ...]


@dataclass(frozen=True, slots=True)
class Condition:
    """One level of each factor, in the study's order; `control` marks the control; a summary an outcome measured."""

    levels: tuple[Level, ...]
    control: bool
    summaries: Mapping[Outcome, ConditionSummary] = field(default_factory=dict)

    @property
    def labels(self) -> dict[str, str]:
        """The label of each factor's level."""
        return {level.factor: level.label for level in self.levels}

    def level(self, factor: str) -> Level | None:
        """Return this condition's level of the factor, None where the factor is not part of it."""
        return next((level for level in self.levels if level.factor == factor), None)

    def summary(self, quantity: Outcome) -> ConditionSummary | None:
        """Return what was measured of the outcome, None where it was not."""
        return self.summaries.get(quantity)


def joule_deviations(condition: Condition) -> dict[str, float]:
    """Return each run's joules a jump less the mean of its condition, by the run's name."""
    summary = condition.summary(Outcome.JOULES)
    if summary is None:
        return {}
    mean = sum(value for _run, value in summary.runs) / len(summary.runs)
    return {run: value - mean for run, value in summary.runs}


@dataclass(frozen=True, slots=True)
class Flow:
    """Counts of the selection: every run, and every jump of the runs that have apex heights.

    `runs_planned` is None where no plan was written, or the selection is by more than factors; `runs_withdrawn` counts
    runs taken off the plan. By quantity, `runs_with` counts the runs whose number was used and
    `runs_without` the other runs of jumps by reason; `runs_other` has kinds of runs that are neither of jumps nor idle.
    Reasons map to counts; a run has one reason a quantity, a jump has one. `jumps_reviewed` counts the jumps analysed
    on which a person's verdict stands, `jumps_with_the_rest` those that a person accepted with the rest of their runs,
    `jumps_rejected` those left out, `verdicts_blind` the verdicts on all three that were given without seeing which run
    the jump was of.
    """

    runs_planned: int | None
    runs_done: int
    runs_void: int
    runs_idle: int
    runs_other: Mapping[str, int]
    runs_with: Mapping[Outcome, int]
    runs_without: Mapping[Outcome, Mapping[str, int]]
    jumps_made: int
    jumps_detected: int
    jumps_excluded: Mapping[str, int]
    jumps_analysed: int
    runs_withdrawn: int = 0
    jumps_reviewed: int = 0
    jumps_with_the_rest: int = 0
    jumps_rejected: int = 0
    verdicts_blind: int = 0


@dataclass(frozen=True, slots=True)
class Day:
    """What was measured on one day; conditions, packs and checks as the reader should see them."""

    date: str
    runs: tuple[str, ...]
    conditions: tuple[str, ...]
    packs: tuple[str, ...] = ()
    checks_made: tuple[str, ...] = ()
    checks_not_made: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Claim:
    """One sentence of the report and the provenance ids of the numbers in it."""

    text: str
    provenance: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Provenance:
    """Where a number came from: what it is, and how many inputs went into it (`labbook why ID`)."""

    id: str
    what: str
    inputs: int


@dataclass(frozen=True, slots=True)
class Assumed:
    """A parameter without a source: its value as text, and why it was taken."""

    name: str
    value: str
    why: str


@dataclass(frozen=True, slots=True)
class CoarseCharger:
    """The step in which the charger shows mAh, and how far charges scatter within conditions, in mAh."""

    step_mah: float
    scatter_mah: float


class Source(StrEnum):
    """What a report cites for a method: keys of `templates/references.bib`."""

    THESIS = "roberts2021"
    FIELLER = "fieller1954"
    HOLM = "holm1979"
    PAIRED_ON_DAY_MEANS = "ibragimov2010"
    TOST = "schuirmann1987"
    WELCH = "welch1938"


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


@dataclass(frozen=True, slots=True)
class Plan:
    """What was decided about the analysis before the first measurement, and what departs from it.

    `stated` tells whether it was decided on in time, `decided` says what was; `run_before` is the day of the first run
    where that lies before the decision. `departures` are sentences on what departs, of which there are `departed`.
    `look` is which look at the data this is, None where none was before and one was planned.
    """

    stated: bool = False
    decided: tuple[str, ...] = ()
    run_before: str = ""
    departures: tuple[str, ...] = ()
    departed: int = 0
    look: Look | None = None


@dataclass(frozen=True, slots=True)
class Predictions:
    """All predictions of a report, and what they depend on; `scene` is "" where nothing was predicted.

    `accuracy` is the relative error asked of the simulator, `unmapped` names factors whose levels change nothing in the
    scene, `unconverted` those whose numbers are a parameter of it as they stand, with its name and unit; `units` has
    the scene's unit of factors that are one of its parameters, by name. Six count
    conditions: whose simulated jump hangs on a knife's edge and was simulated either way (`branched`), or only one way
    (`on_edge`), in which rounding grows beyond the accuracy (`grown`), in which the body gets under the grains
    (`under_surface`), whose energy book does not close within the accuracy (`open_book`), and whose jump comes to an
    apex only in one of both simulations, to the accuracy and a hundred times finer (`ends_otherwise`).
    """

    scene: str = ""
    accuracy: float = 0.0
    effects: tuple[str, ...] = ()
    unmapped: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    items: tuple[Prediction, ...] = ()
    judged: tuple[Judged, ...] = ()
    assumed: tuple[AssumedInput, ...] = ()
    branched: int = 0
    on_edge: int = 0
    grown: int = 0
    under_surface: int = 0
    open_book: int = 0
    ends_otherwise: int = 0
    unconverted: tuple[tuple[str, str, str], ...] = ()

    def of(self, quantity: PredictedQuantity) -> tuple[Prediction, ...]:
        """Return the predictions of one quantity."""
        return tuple(item for item in self.items if item.quantity is quantity)


@dataclass(frozen=True, slots=True)
class StudyResults:
    """All results of a study, of the runs of a selection, and what a page says of itself.

    `claims` open the page; `selection` is the --where text as given. `drains` has those of the robots that have a line;
    `robots` counts the analysed runs of each, `runs` are these by name. `confounded` says what is confounded with the
    day, `void` which runs are void and why; `no_equivalence` why heights were not tested for equality, "" where they
    were or there are none; `without_charges` has the groups that no claim is of for want of charges, with the runs that
    lack theirs; `favoured` has the headlines that the order within days favours; `coarse_charger` is there where
    charges scatter by less than half a step of the charger, so that no interval of joules can be trusted.
    `overall` is the effect over all groups, where there are several. `sources` are those of the methods used;
    `outside_limits` names the runs whose joules are out of control limits, `exchanged_charges` pairs of them that are
    inside with each other's charge; `software` names the libraries that computed it, with versions.
    `stored` tells whether the book has the report, so that its numbers can be traced. `entry` is the number of the last
    entry of the journal that it is of, 0 where that is not known. `as_of` says at which earlier entry of the journal
    the book stood so. `first_only` tells that the first page stands alone, without the other sections.
    """

    title: str
    study: str
    selection: str
    made_at: str
    software_version: str
    configuration_hash: str
    detector: str
    people: tuple[str, ...]
    days: tuple[Day, ...]
    flow: Flow
    factors: tuple[Factor, ...]
    conditions: tuple[Condition, ...]
    claims: tuple[Claim, ...]
    comparisons: tuple[Comparison, ...] = ()
    anovas: tuple[Anova, ...] = ()
    drains: tuple[Drain, ...] = ()
    budget: JouleBudget | None = None
    packs: Mapping[str, PackDeviation] = field(default_factory=dict)
    confounded: tuple[str, ...] = ()
    variations: tuple[Varied, ...] = ()
    contrasts: tuple[MeansContrast, ...] = ()
    overall: tuple[OverallSavings, ...] = ()
    overall_equivalence: OverallEquivalence | None = None
    methods: tuple[str, ...] = ()
    limitations: tuple[str, ...] = ()
    outside_limits: tuple[str, ...] = ()
    exchanged_charges: tuple[tuple[str, str], ...] = ()
    assumed: tuple[Assumed, ...] = ()
    provenance: tuple[Provenance, ...] = ()
    runs: Mapping[str, Run] = field(default_factory=dict)
    robots: Mapping[str, int] = field(default_factory=dict)
    predictions: Predictions = field(default_factory=Predictions)
    hypotheses: tuple[Hypothesis, ...] = ()
    plan: Plan = field(default_factory=Plan)
    void: str = ""
    no_equivalence: str = ""
    without_charges: tuple[tuple[Mapping[str, str], tuple[str, ...]], ...] = ()
    favoured: tuple[Favoured, ...] = ()
    coarse_charger: CoarseCharger | None = None
    software: tuple[tuple[str, str], ...] = ()
    sources: tuple[Source, ...] = ()
    stored: bool = True
    entry: int = 0
    as_of: str = ""
    first_only: bool = False

    def section(self, title: str) -> str:
        """Refer to a section by its title, and say where it is if this page does not have it."""
        return f"{title}, in the full report" if self.first_only else title

    @property
    def outcomes(self) -> tuple[Outcome, ...]:
        """The outcomes that every run is expected to have, and those that were measured."""
        return tuple(outcome for outcome in Outcome if outcome.of_every_run or self.flow.runs_with.get(outcome))

    @property
    def by_group(self) -> list[Comparison]:
        """The comparisons in the order of their groups: of the first condition of each."""
        labels = [condition.labels.items() for condition in self.conditions]

        def place(comparison: Comparison) -> int:
            of_group = (at for at, found in enumerate(labels) if comparison.group.items() <= found)
            return next(of_group, len(labels))

        return sorted(self.comparisons, key=place)

    @property
    def pooled(self) -> list[Comparison]:
        """The comparisons of all levels with the control, group by group; none that pools a further factor."""
        found = [each for each in self.by_group if each.opens]
        narrowest = max((len(each.group) for each in found), default=0)
        return [each for each in found if len(each.group) == narrowest]

    @property
    def one_level(self) -> bool:
        """Whether each group has one treated level, so that its comparison and that of all levels are the same."""
        pooled = [one for one in self.comparisons if one.opens]
        return bool(pooled) and all(len(self._treated(one)) == 1 for one in pooled)

    def _treated(self, comparison: Comparison) -> list[Condition]:
        """Return the treated conditions of a comparison's group that have its quantity."""
        swept = {factor.name for factor in self.factors if factor.swept}
        return [
            one
            for one in self.conditions
            if not one.control and one.summary(comparison.quantity) is not None
            if {name: label for name, label in one.labels.items() if name not in swept} == comparison.group
        ]

    @property
    def headlines(self) -> list[tuple[Comparison, list[Varied]]]:
        """The pooled comparisons, each with its recomputations."""
        found = grouped(self.variations, [(one.headline, one.quantity) for one in self.variations])
        return [(each, found.get((each.label, each.quantity), [])) for each in self.pooled]


EMPTY = StudyResults(
    title="",
    study="",
    selection="",
    made_at="",
    software_version="",
    configuration_hash="",
    detector="",
    people=(),
    days=(),
    flow=Flow(None, 0, 0, 0, {}, {}, {}, 0, 0, {}, 0),
    factors=(),
    conditions=(),
    claims=(),
)
"""The results of a study without runs."""

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
        t, difference = self.t.known, self.difference.known
        if t is None or difference is None:
            return self.test
        return replace(self.test, statistic=math.copysign(t, difference))

    @property
    def headline(self) -> Number:
        """The number that a claim states."""
        return self.savings or self.difference

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


MAH_MIN = 60.0
"""mAh/s to mAh/min."""


class IdleRun(NamedTuple):
    """One idle run: how long the robot was on, and the charge that went back in."""

    run: str
    duration_s: float
    charge_mah: float


@dataclass(frozen=True, slots=True)
class DrainFit(Result):
    """A robot's drain line in numbers: it, its fit, and what it gives at `run_duration_s`.

    That is the protocol's run duration, or the mean of the idle runs where it states none; `extrapolated`: it lies
    outside those of the idle runs. Both are None without a line.
    """

    slope: Number
    intercept: Number
    r_squared: Number
    at_run: Number
    run_duration_s: float | None = None
    extrapolated: bool | None = None


@dataclass(frozen=True, slots=True)
class Drain:
    """One robot's passive drain (thesis 5.1.4): its line, the numbers of that, and the idle runs it is fitted to."""

    robot: str
    line: PassiveDrain | Undefined
    result: DrainFit
    idle: tuple[IdleRun, ...]

    @property
    def run_duration_min(self) -> float:
        """The duration of a run at which `result` has the drain."""
        return (self.result.run_duration_s or 0.0) / MAH_MIN


IN_ALL = "in all"
"""The sum of all sources of uncertainty."""
OF_DRAIN = "drain fit"
"""The source that the runs of one robot share; others are shared by all runs."""


@dataclass(frozen=True, slots=True)
class BudgetSource:
    """A source of uncertainty by name.

    A `shared` one shifts all runs alike, so that more runs do not make it smaller. The scatter between runs may contain
    it already (`in_scatter`): it is shown then and not added again. The size of an `assumed` one has no source.
    """

    name: str
    shared: bool
    in_scatter: bool
    assumed: bool


@dataclass(frozen=True, slots=True)
class JouleBudget(Result):
    """What each source gives a run's joules and the mean over runs, by its name and `IN_ALL`; what 1 mAh is worth.

    The runs are those of the condition with these `levels`.
    """

    terms: tuple[BudgetSource, ...]
    one_run: Annotated[Mapping[str, Number], NumberNames("{}")]
    mean: Annotated[Mapping[str, Number], NumberNames("{}, mean")]
    one_mah: Annotated[Number, NumberNames("1 mAh")]
    levels: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class PackDeviation(Result):
    """Mean deviation of a pack's runs from the means of their conditions, joules a jump."""

    deviation: Number


@dataclass(frozen=True, slots=True)
class Favoured:
    """A headline of a group, or over all (None), whose sides lie farther apart in the day than in a random order.

    `positions` have Holm's p. By outcome `adjusted` has the headline adjusted for position in the day; none where the
    runs leave no slope to adjust by.
    """

    group: Mapping[str, str] | None
    positions: PositionsCompared
    adjusted: Mapping[Outcome, Number]


WITHOUT_EXCLUSIONS = "without exclusions"


@dataclass(frozen=True, slots=True)
class Varied:
    """One headline, by the label of its comparison, recomputed another way; `day` is one left out, "" elsewhere.

    `by_rules`: the way is one of all rules by which single jumps begin and leave the plate, the protocol's among them.
    """

    headline: str
    variant: str
    quantity: Outcome
    result: Decision
    day: str = ""
    by_rules: bool = False


COVERAGE_FACTOR = 2.0
"""Standard uncertainties of a prediction that count as its expanded uncertainty, about 95 % (JCGM 100, 6.3)."""


class Verdict(StrEnum):
    """What data say of a hypothesis."""

    HOLDS = "holds"
    FAILS = "fails"
    CANNOT_TELL = "cannot tell"

    @classmethod
    def of_all(cls, verdicts: Sequence[Verdict]) -> Verdict:
        """Return the verdict on what holds where each part holds, and fails where one fails."""
        if Verdict.FAILS in verdicts:
            return cls.FAILS
        return cls.HOLDS if verdicts and set(verdicts) == {Verdict.HOLDS} else cls.CANNOT_TELL


@dataclass(frozen=True, slots=True)
class HypothesisPart(Result):
    """One comparison of a hypothesis: the levels `of` what is compared, and in which what it is set `against` differs.

    Without the latter it is set against the control. `measured` has the interval that decides, `simulated` a standard
    uncertainty, both in percent of the first mean, or in percentage points where `savings` are compared. The claim is
    that they lie between `low` and `high`, None for no bound; `no_interval` says why `measured` has no interval.
    """

    of: Mapping[str, str]
    against: Mapping[str, str]
    measured: Number
    simulated: Number
    verdict: Verdict
    simulated_verdict: Verdict
    low: float | None
    high: float | None
    no_interval: Undefined | None = None
    savings: bool = False


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A hypothesis of labbook.toml with its comparisons; `published` is what the source found, "" if unknown."""

    name: str
    text: str
    source: str
    published: str
    parts: tuple[HypothesisPart, ...]

    @property
    def verdict(self) -> Verdict:
        """What was measured says."""
        return Verdict.of_all([part.verdict for part in self.parts])

    @property
    def simulated_verdict(self) -> Verdict:
        """What is simulated says."""
        return Verdict.of_all([part.simulated_verdict for part in self.parts])


class PredictedQuantity(StrEnum):
    """What is predicted of a condition, in a stored `unit`; its savings are set against the control of its group.

    `heading` heads its table, and `short` a column or an axis.
    """

    unit: str
    heading: str
    short: str

    JOULES = "joules a jump", "J", "Energy of a jump", "energy"
    APEX = "apex height", "m", "Apex height", "apex"
    CONTACT_TIME = "contact time", "s", "Contact time", "contact"
    IMPULSE_HEIGHT = "jump height from impulse", "m", "Jump height from impulse", "impulse height"
    SAVINGS = "savings", "%", f"{sentence_start(display.SAVINGS)} against the control", display.SAVINGS

    def __new__(cls, name: str, unit: str = "", heading: str = "", short: str = "") -> Self:
        """Make the member whose value is its name; called with a name alone, the enumeration looks it up."""
        member = str.__new__(cls, name)
        member._value_ = name
        member.unit, member.heading, member.short = unit, heading, short
        return member


ACCURACY = "accuracy"
"""The part of a prediction's error that is the simulator's own; the others go by the names of what was varied."""
_NEGLIGIBLE = 0.1
"""Share of a standard uncertainty that changes it by half a percent."""


@dataclass(frozen=True, slots=True)
class PredictionCheck(Result):
    """What is predicted of runs as they were made, beside what was measured of them.

    `predicted` carries its standard uncertainty as `se`; `errors` are its parts by their source. `difference` is
    predicted less measured, `error_ratio` that over the expanded uncertainty of both (the E_n of ISO 13528).
    `numerical_error` is by how much a simulation a hundred times finer differs, in the unit of the prediction; None
    where one of the two gives no value.
    """

    predicted: Number
    difference: Number
    error_ratio: Number
    errors: Annotated[Mapping[str, Number], NumberNames("predicted, error by {}")]
    numerical_error: float | None

    @property
    def imprecise(self) -> bool:
        """Whether the numerical error is above what the error has for it, and a tenth of the error or more."""
        error, se = self.numerical_error, self.predicted.se
        if not self.errors or error is None:
            return bool(self.errors)
        accounted = [self.errors[ACCURACY].value, _NEGLIGIBLE * se if isinstance(se, float) else 0.0]
        return all(isinstance(part, float) and error > part for part in accounted)


@dataclass(frozen=True, slots=True)
class Prediction:
    """One quantity of a condition, or of a pair with its control, measured and predicted.

    `group` holds the levels in common with the control, `level` that of the swept factor or "pooled" (`POOLED`); `n`
    counts the runs that were measured. `published` is what the thesis has of it.
    """

    quantity: PredictedQuantity
    group: Mapping[str, str]
    level: str
    control: bool
    n: int
    measured: Number
    check: PredictionCheck
    published: PublishedResult | None = None

    @property
    def unsure(self) -> bool:
        """Whether the expanded uncertainty of the prediction is as large as what is predicted: agreement says nothing.

        Savings may be near 0, and are never unsure.
        """
        value, se = self.check.predicted.known, self.check.predicted.se
        if self.quantity is PredictedQuantity.SAVINGS or value is None or not isinstance(se, float):
            return False
        return COVERAGE_FACTOR * se >= abs(value)

    @property
    def agrees(self) -> bool | None:
        """Whether both agree, the error ratio within -1 to 1; None where that cannot be decided."""
        ratio = self.check.error_ratio.known
        agree = None if ratio is None else abs(ratio) <= 1.0
        return None if self.unsure and agree else agree


@dataclass(frozen=True, slots=True)
class JudgedGroup(Result):
    """The predictions of one group: `bias` is predicted less measured, `of_measured` the same as if they were exact."""

    group: Mapping[str, str]
    bias: Number
    of_measured: Number
    p: Number
    measured: Number
    predicted: Number
    days: int

    @property
    def differs(self) -> bool:
        """Whether 0 lies outside the interval with the errors of what was measured and of what was assumed."""
        return bool(self.bias.side)

    @property
    def agrees_only_by_assumed(self) -> bool:
        """Whether 0 lies inside it, but outside that with the errors of what was measured alone."""
        return not self.differs and bool(self.of_measured.side)


@dataclass(frozen=True, slots=True)
class Limits(Result):
    """Predicted less measured over conditions: the mean difference, and its limits of agreement."""

    mean_difference: Number
    lower_limit: Number
    upper_limit: Number


@dataclass(frozen=True, slots=True)
class Judged:
    """One quantity: its groups, the p of no bias in any of them, and Kendall's tau of their order, of several.

    `limits` are those of three conditions or more.
    """

    quantity: PredictedQuantity
    groups: tuple[JudgedGroup, ...]
    joint_p: Number
    tau: Number | None
    limits: Limits | None = None


@dataclass(frozen=True, slots=True)
class AssumedParameter:
    """A parameter without a source: its value, why it was taken, and the part by which it was varied."""

    value: float
    unit: str
    why: str
    varied_by: float


@dataclass(frozen=True, slots=True)
class AssumedInput:
    """A parameter of the scene without a source, and the most that varying it changed.

    It was raised and lowered; `changes` has the largest part of any condition's error by quantity. `fitted` says that
    it was fitted to runs of the same study.
    """

    name: str
    parameter: AssumedParameter
    changes: Mapping[PredictedQuantity, Value | None]
    fitted: bool = False
