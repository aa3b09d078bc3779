"""What a report shows: frozen, filled by `labbook`, drawn and worded here; nothing is computed from it.

Every number comes with its unit, uncertainty, n and provenance id. `Undefined` stands where a number does
not exist, `None` where one does not apply. Values are never rounded here; only their display is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from data_schema.outcomes import Outcome
from reports.evidence import (
    Anova,
    BudgetItem,
    Comparison,
    DrainFit,
    Favoured,
    Look,
    MeansContrast,
    Order,
    OverallEquivalence,
    OverallSavings,
    Sensitivity,
)
from reports.numbers import Number
from reports.predicted import Hypothesis, Predictions


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
class RunValue:
    """What one run contributes to a condition: the run's own value, or the mean of its jumps `jumps_m`, m.

    `jumps` are the numbers of these jumps in the run.
    """

    run: str
    value: float
    jumps_m: tuple[float, ...] = field(default=(), repr=False)
    jumps: tuple[int, ...] = field(default=(), repr=False)


@dataclass(frozen=True, slots=True)
class Summary:
    """One quantity in one condition: `mean` carries SE, CI and n (runs); `runs` has every point.

    `robots` counts the runs of each robot.
    """

    mean: Number
    sd: Number
    runs: tuple[RunValue, ...] = ()
    jumps: int | None = None
    robots: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Condition:
    """One level of each factor, in the study's order; `control` marks the control; a summary an outcome measured."""

    levels: tuple[Level, ...]
    control: bool
    summaries: Mapping[Outcome, Summary] = field(default_factory=dict)

    def level(self, factor: str) -> Level | None:
        """Return this condition's level of the factor, None where the factor is not part of it."""
        return next((level for level in self.levels if level.factor == factor), None)

    def summary(self, quantity: Outcome) -> Summary | None:
        """Return what was measured of the outcome, None where it was not."""
        return self.summaries.get(quantity)


@dataclass(frozen=True, slots=True)
class Flow:
    """Counts of the selection: every run, and every jump of the runs that have apex heights.

    `runs_planned` is None where no plan was written, or the selection is by more than factors; `runs_withdrawn` counts
    runs taken off the plan. By quantity, `runs_with` counts the runs whose number was used and
    `runs_without` the other runs of jumps by reason; `runs_other` has kinds of runs that are neither of jumps nor idle.
    Reasons map to counts; a run has one reason a quantity, a jump has one.
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

    @property
    def has_jump_runs(self) -> bool:
        """Whether any run of jumps counts, with numbers or without."""
        return any(self.runs_with.values()) or any(self.runs_without.values())


@dataclass(frozen=True, slots=True)
class Day:
    """What was measured on one day; conditions, packs and checks as the reader should see them."""

    date: str
    runs: tuple[str, ...]
    conditions: tuple[str, ...]
    packs: tuple[str, ...] = ()
    checks_made: tuple[str, ...] = ()
    checks_not_made: tuple[str, ...] = ()
    note: str = ""


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
    """A parameter without a source: its value as text, why it was taken, and how it was varied."""

    name: str
    value: str
    why: str
    varied: str = ""


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


@dataclass(frozen=True, slots=True)
class ReportContent:
    """All of one report. `claims` open the page; `selection` is the --where text as given.

    `drains` has one line a robot; `robots` counts the analysed runs of each. `planned` tells whether the analysis
    was decided on in time, `decided` says what was decided about the analysis before the first measurement,
    `run_before` is the day of the first run where that lies before the decision, `departures` says what departs from
    it, of which there are `departed`, `void` which runs are void and why; `no_equivalence` why heights were not tested
    for equality, "" where they were or there are none; `without_charges` has the groups that no
    claim is of for want of charges, with the runs that lack theirs; `favoured` has the headlines that the
    order within days favours; `coarse_charger` is there where charges scatter by less than half a step of the charger,
    so that no interval of joules can be trusted.
    `look` is which look at the data this report is, None where none was before and one was planned.
    `overall` is the effect over all groups, where there are several. `sources` are those of the methods used;
    `outside_limits` names the runs whose joules are out of control limits, `exchanged_charges` pairs of them that are
    inside with each other's charge; `software` names the libraries that
    computed it, with versions.
    `stored` tells whether the book has the report, so that its numbers can be traced.
    `first_only` tells that the first page stands alone, without the other sections.
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
    drains: tuple[DrainFit, ...] = ()
    budget: tuple[BudgetItem, ...] = ()
    budget_note: str = ""
    order: Order = field(default_factory=Order)
    sensitivity: tuple[Sensitivity, ...] = ()
    contrasts: tuple[MeansContrast, ...] = ()
    overall: tuple[OverallSavings, ...] = ()
    overall_equivalence: OverallEquivalence | None = None
    methods: tuple[str, ...] = ()
    limitations: tuple[str, ...] = ()
    outside_limits: tuple[str, ...] = ()
    exchanged_charges: tuple[tuple[str, str], ...] = ()
    assumed: tuple[Assumed, ...] = ()
    provenance: tuple[Provenance, ...] = ()
    robots: Mapping[str, int] = field(default_factory=dict)
    predictions: Predictions = field(default_factory=Predictions)
    hypotheses: tuple[Hypothesis, ...] = ()
    planned: bool = False
    decided: tuple[str, ...] = ()
    run_before: str = ""
    departures: tuple[str, ...] = ()
    departed: int = 0
    void: str = ""
    no_equivalence: str = ""
    without_charges: tuple[tuple[Mapping[str, str], tuple[str, ...]], ...] = ()
    look: Look | None = None
    favoured: tuple[Favoured, ...] = ()
    coarse_charger: CoarseCharger | None = None
    software: tuple[tuple[str, str], ...] = ()
    sources: tuple[Source, ...] = ()
    stored: bool = True
    first_only: bool = False

    def section(self, title: str) -> str:
        """Refer to a section by its title, and say where it is if this page does not have it."""
        return f"{title}, in the full report" if self.first_only else title

    @property
    def outcomes(self) -> tuple[Outcome, ...]:
        """The outcomes that every run is expected to have, and those that were measured."""
        return tuple(outcome for outcome in Outcome if outcome.of_every_run or self.flow.runs_with.get(outcome))

    def place_of(self, group: Mapping[str, str]) -> int:
        """Return where a group's first condition stands, so that groups have one order everywhere."""
        levels = [{level.factor: level.label for level in condition.levels} for condition in self.conditions]
        of_group = (at for at, found in enumerate(levels) if group.items() <= found.items())
        return next(of_group, len(levels))

    @property
    def by_group(self) -> list[Comparison]:
        """The comparisons in the order of their groups."""
        return sorted(self.comparisons, key=lambda comparison: self.place_of(comparison.group))

    @property
    def pooled(self) -> list[Comparison]:
        """The comparisons of all levels with the control, group by group; none that pools a further factor."""
        found = [each for each in self.by_group if each.opens]
        narrowest = max((len(each.group) for each in found), default=0)
        return [each for each in found if len(each.group) == narrowest]


EMPTY = ReportContent(
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
"""The content of a report of nothing."""
