"""What was predicted beside what was measured, as a report carries it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Self

from data_schema.vocabulary import Undefined
from reports import display
from reports.display import sentence_start
from reports.numbers import Number, NumberNames, Result, Value

if TYPE_CHECKING:
    from simulator.steady.published_results import PublishedResult

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
        value, se = self.check.predicted.value, self.check.predicted.se
        if self.quantity is PredictedQuantity.SAVINGS or isinstance(value, Undefined) or not isinstance(se, float):
            return False
        return COVERAGE_FACTOR * se >= abs(value)

    @property
    def agrees(self) -> bool | None:
        """Whether both agree, the error ratio within -1 to 1; None where that cannot be decided."""
        ratio = self.check.error_ratio.value
        agree = None if isinstance(ratio, Undefined) else abs(ratio) <= 1.0
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
        return _excludes_zero(self.bias)

    @property
    def agrees_only_by_assumed(self) -> bool:
        """Whether 0 lies inside it, but outside that with the errors of what was measured alone."""
        return not self.differs and _excludes_zero(self.of_measured)


def _excludes_zero(number: Number) -> bool:
    low, high = number.ci_low, number.ci_high
    return isinstance(low, float) and isinstance(high, float) and (low > 0.0 or high < 0.0)


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
class AssumedInput:
    """A parameter of the scene without a source: its value, why it was taken, and the most that varying it changed.

    It was raised and lowered by the part `varied_by`; `changes` has the largest part of any condition's error by
    quantity. `fitted` says that it was fitted to runs of the same study.
    """

    name: str
    value: float
    unit: str
    why: str
    varied_by: float
    changes: Mapping[PredictedQuantity, Value | None]
    fitted: bool = False


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
