"""What a configuration holds; every mapping goes from a name that a person chose, in the order of the file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from data_schema.calibration import Calibration
from data_schema.outcomes import Outcome
from data_schema.vocabulary import ContrastKind, FactorKind, ReasonCode, StudyKind
from labbook.config.run_names import RunNames


class Detector(StrEnum):
    """Which detector finds the jumps: labbook's own, or the one published with the thesis (5.1.5)."""

    ROBUST = "robust"
    PUBLISHED = "published"


class Onset(StrEnum):
    """The rule by which a single jump on a force plate begins (`stats.single_jump.ONSETS`)."""

    SDS_BACK_30MS = "5sd_back_30ms"
    SDS_BACK_TO_WEIGHT = "5sd_back_to_weight"
    PERCENT = "10_percent"


class TakeOff(StrEnum):
    """The rule by which a single jump leaves a force plate (`stats.single_jump.TAKE_OFFS`)."""

    FLIGHT_SDS = "flight_5sd"
    NEWTONS_10 = "10n"
    NEWTONS_50 = "50n"
    PERCENT = "20_percent"


@dataclass(frozen=True, slots=True)
class StudySettings:
    """`[study]`. Joules are charge times `reference_voltage_v` (thesis: 15.4 V in 5.1.3, 16.8 V in 4.3.1)."""

    name: str
    kind: StudyKind
    reference_voltage_v: float
    jumps_nominal: int
    time_zone: str
    run_names: RunNames


@dataclass(frozen=True, slots=True)
class LevelSettings:
    """A level of a factor: `value` where the factor is a number, `attributes` such as a foot's `radius_m`."""

    label: str
    value: float | None
    attributes: Mapping[str, float | str]


@dataclass(frozen=True, slots=True)
class FactorSettings:
    """`[factors.NAME]`; `title` is its name in text, `control` the label of the level that controls have.

    `control_name` is what that level is called in text, `treatment` what the others are called together.
    """

    kind: FactorKind
    title: str | None
    unit: str | None
    levels: tuple[LevelSettings, ...]
    control: str | None
    control_name: str | None = None
    treatment: str | None = None


JUMP_RULES = {"exclude_first_jumps": "2", "exclude_gap_jumps": "true"}
"""Keys of `[protocol]` that say which jumps are left out without asking, and what the thesis has for them."""


@dataclass(frozen=True, slots=True)
class ProtocolSettings:
    """`[protocol]`: how a run is made and what of it is used.

    `run_duration_s` is None where runs have no set duration, `charger_resolution_mah` where the charges show the
    charger's step; `checks` are the names of those made before a day's first run; `rules_given` has the `JUMP_RULES`
    that labbook.toml sets.
    """

    run_duration_s: float | None
    detector: Detector
    exclude_first_jumps: int
    exclude_gap_jumps: bool
    onset: Onset
    take_off: TakeOff
    charger_resolution_mah: float | None
    idle_minutes: tuple[float, ...]
    checks: tuple[str, ...] = ()
    rules_given: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class GainSettings:
    """`[gains.FACTOR]`: slope * gain + offset in `unit`, but 0 at the gain `zero`, where nothing is applied."""

    symbol: str
    slope: float
    offset: float
    unit: str
    zero: float | None

    def physical(self, gain: float) -> float:
        """Convert a gain to `unit`."""
        return 0.0 if gain == self.zero else self.slope * gain + self.offset


@dataclass(frozen=True, slots=True)
class RobotSettings:
    """`[robots.NAME]`."""

    body_mass_kg: float
    foot_mass_kg: float
    link_1_m: float
    link_2_m: float
    rest_length_m: float
    leg_min_m: float
    leg_max_m: float


@dataclass(frozen=True, slots=True)
class BatterySettings:
    """`[batteries.NAME]`."""

    cells: int
    capacity_mah: float


@dataclass(frozen=True, slots=True)
class InstrumentSettings:
    """`[instruments.NAME]`."""

    kind: str
    make: str | None
    model: str | None
    serial: str | None


LIMITS = (
    "largest_file_bytes",
    "most_columns",
    "longest_line_bytes",
    "largest_expanded_bytes",
    "largest_expansion",
    "most_members",
    "deepest_nesting",
    "most_cells",
)
"""The keys of `[files.limits]`."""


@dataclass(frozen=True, slots=True)
class FileSettings:
    """`[files]`: `limits` are those bounds of `ingest.model.Limits` that `[files.limits]` sets, by name."""

    limits: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class ProfileColumn:
    """What a column of a profile holds; None where the file says it. `sign` -1 turns it round.

    `unit` is that of the calibrated value where there are `calibrations`.
    """

    channel: str | None
    unit: str | None
    sign: int | None
    calibrations: tuple[Calibration, ...] = ()


@dataclass(frozen=True, slots=True)
class ProfileSettings:
    """`[profiles.NAME]`: how to read files that name the columns in `recognise`, or whose name fits `files`.

    `columns` goes from a column to what it holds, `settings` from the name of a field of `ingest.model.ReadingSettings`
    to what the profile says of it.
    """

    recognise: tuple[str, ...]
    files: str | None
    columns: Mapping[str, ProfileColumn]
    settings: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class SimulationSettings:
    """`[simulation]`: the scene that conditions are predicted with, and what becomes of it in each of them.

    `scene` names a shipped scene, or the file of one's own, whose text is then `scene_toml`.
    `factors` goes from a factor to the parameter that its physical value is, `levels` from a factor and a label to
    parameters; `parameters` hold in every condition, and those in `assumed` are given without a source.
    For the error every parameter without a source is varied by the part `varied_by`, those in `varied` by their own.
    """

    scene: str
    scene_toml: str | None
    effects: str | None
    accuracy: float
    varied_by: float
    varied: Mapping[str, float]
    parameters: Mapping[str, float]
    assumed: tuple[str, ...]
    factors: Mapping[str, str]
    levels: Mapping[str, Mapping[str, Mapping[str, float]]]


class Family(StrEnum):
    """The comparisons that are tested together: every level with the control, or all levels pooled, group by group."""

    EACH = "each"
    POOLED = "pooled"


class UnitOfAnalysis(StrEnum):
    """What counts as one independent observation: a run, the mean of a day's runs, or by the days that are shared.

    With shared days, each comparison is tested by the rule that fits its days (`stats.days.decision`): paired on day
    means from four shared days on, on runs within days where there are fewer.
    """

    RUN = "run"
    DAY = "day"
    SHARED_DAYS = "shared_days"

    @property
    def noun(self) -> str:
        """What summaries and the tests of the appendix count: "run" or "day"."""
        return "day" if self is UnitOfAnalysis.DAY else "run"


class Alternative(StrEnum):
    """What the test of a saving is against: any difference, or a saving alone."""

    TWO_SIDED = "two-sided"
    ONE_SIDED = "one-sided"


@dataclass(frozen=True, slots=True)
class Bounds:
    """The differences of apex height that are too small to matter: metres, or percent of the control's mean."""

    low: float
    high: float
    percent: bool


class Side(StrEnum):
    """Which runs a hypothesis or a contrast is about."""

    CONTROL = "control"
    TREATED = "treated"


@dataclass(frozen=True, slots=True)
class ContrastSettings:
    """A contrast of condition means that was decided on; `factor`, `side`, `levels` and `at` as its kind needs them."""

    kind: ContrastKind
    outcome: Outcome
    factor: str = ""
    side: Side | None = None
    levels: tuple[str, ...] = ()
    at: float | None = None

    def __str__(self) -> str:
        """Return it in words."""
        parts = [str(self.kind).replace("_", " "), self.factor, str(self.side or ""), " to ".join(self.levels)]
        parts += [] if self.at is None else [f"at {self.at:g}"]
        return " ".join(filter(None, parts))


@dataclass(frozen=True, slots=True)
class AnalysisSettings:
    """`[analysis]`: what was decided about the analysis before anything was measured.

    `exclusions` are the reasons for which a person may leave out a jump or a run; `apex_bounds` is None where no bounds
    were set. `alternative` is that of savings; differences of other outcomes are tested two-sided.
    """

    primary_outcome: Outcome = Outcome.JOULES
    family: Family = Family.POOLED
    alpha: float = 0.05
    apex_bounds: Bounds | None = None
    exclusions: tuple[ReasonCode, ...] = tuple(ReasonCode)
    unit_of_analysis: UnitOfAnalysis = UnitOfAnalysis.SHARED_DAYS
    contrasts: tuple[ContrastSettings, ...] = ()
    alternative: Alternative = Alternative.TWO_SIDED

    @property
    def one_sided(self) -> bool:
        """Whether savings are tested against a saving alone."""
        return self.alternative is Alternative.ONE_SIDED

    @property
    def outside(self) -> float:
        """What the interval of a saving leaves out on both sides together: alpha, or 2 alpha of a one-sided test."""
        return 2.0 * self.alpha if self.one_sided else self.alpha


class ClaimKind(StrEnum):
    """What a hypothesis claims."""

    SAME = "same"
    """Of the control's or the treated runs, an outcome is the same at all levels of a factor, within bounds."""
    NOT_LOWER = "not_lower"
    """In each group, an outcome of the treated runs is not lower than the control's, by more than a bound."""
    SAVES = "saves"
    """In each group, the treated runs save of an outcome."""
    LARGEST_SAVING = "largest_saving"
    """One group saves more than any other."""
    SMALLEST_SAVING = "smallest_saving"
    """One group saves less than any other."""


@dataclass(frozen=True, slots=True)
class HypothesisSettings:
    """A hypothesis: `text` says it, `source` where it was published, `published` what was found there, "" if unknown.

    `side`, `between`, `levels` (all where empty), `group` and `within_percent` are those that its claim needs.
    """

    name: str
    text: str
    source: str
    published: str
    claim: ClaimKind
    outcome: Outcome
    side: Side
    between: str
    levels: tuple[str, ...]
    group: Mapping[str, str]
    within_percent: float


@dataclass(frozen=True, slots=True)
class StudyProtocol:
    """`[studies.NAME]`: what `labbook study NAME` is asked with; None where that is left to it.

    `sheet` names a file of the book, or its uid; `decimal` is the sign in it. The others are the options of their name.
    """

    sheet: str | None = None
    decimal: str | None = None
    grain_mm: float | None = None
    where: str | None = None
    window: int | None = None
    constant: float | None = None
    ratio: float | None = None
    same_percent: float | None = None
    level: float | None = None


@dataclass(frozen=True, slots=True)
class Configuration:
    """All of `labbook.toml`; `people` goes from name to initials, `text` is the file as it was, with that of a scene of
    one's own below it, `sha256` its hash."""

    study: StudySettings
    people: Mapping[str, str]
    factors: Mapping[str, FactorSettings]
    protocol: ProtocolSettings
    gains: Mapping[str, GainSettings]
    robots: Mapping[str, RobotSettings]
    batteries: Mapping[str, BatterySettings]
    instruments: Mapping[str, InstrumentSettings]
    files: FileSettings
    profiles: Mapping[str, ProfileSettings]
    simulation: SimulationSettings | None
    analysis: AnalysisSettings | None
    hypotheses: tuple[HypothesisSettings, ...]
    studies: Mapping[str, StudyProtocol]
    database_url: str | None
    store_path: str | None
    text: str
    sha256: str


def number_label(value: float) -> str:
    """Write a number level as its label: `400`, never `400.0`."""
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
