"""The typed model of `labbook.toml`: every table is a class, every key a field with its type and bounds.

`reading.py` reads a file into it, `labbook config --schema` exports it. Tables are frozen dataclasses, and
frozen Structs of msgspec where a key cannot be the field's name. Every mapping goes from a name that a person chose, in
the order of the file. `parsing.py` fills in what is marked `NOT_A_KEY`.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import date
from enum import StrEnum
from typing import Annotated, Any, Literal, get_args

from msgspec import Meta, Struct
from msgspec import field as named

from data_schema.calibration import Calibration, line_through
from data_schema.errors import InputRefused
from data_schema.outcomes import Outcome
from data_schema.vocabulary import ContrastKind, FactorKind, ReasonCode, StudyKind

Positive = Annotated[float, Meta(gt=0)]
Part = Annotated[float, Meta(gt=0, lt=1)]
Percent = Annotated[float, Meta(gt=0, lt=100)]
Count = Annotated[int, Meta(ge=1)]
Line = Annotated[int, Meta(ge=1, le=400)]
"""A line of a file, from 1; a header is looked for up to line 400."""
Label = Annotated[
    str,
    Meta(
        extra={"label": True},
        extra_json_schema={"type": ["string", "number"], "description": "a level, text or number"},
    ),
]
"""A level of a factor: a text, or a number that is read as one, `400` and `400.0` as "400"."""
Delimiter = Annotated[
    str,
    Meta(
        pattern=r"^[\t !#$%&()*,/:;<=>?@\[\\\]^_`{|}~]$",
        extra_json_schema={"description": 'one sign that parts cells, such as ";", "," or "\\t"'},
    ),
]
PostgresUrl = Annotated[
    str,
    Meta(
        pattern=r"^postgresql\+psycopg://",
        extra_json_schema={"description": "an address such as 'postgresql+psycopg://user@host/labbook'"},
    ),
]
License = Annotated[
    str,
    Meta(
        pattern=r"^([A-Za-z0-9._-]+|https?://\S+)$",
        extra_json_schema={"description": 'an SPDX identifier such as "CC-BY-4.0", or an address'},
    ),
]
NOT_A_KEY = Meta(extra_json_schema={"readOnly": True})

HOW_TO_DECIDE = (
    "write [analysis] in labbook.toml (the one that `labbook init` writes has an example) before the first file or "
    "charge comes in, or the report calls every comparison exploratory."
)


def number_label(value: float) -> str:
    """Write a number level as its label: `400`, never `400.0`."""
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


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
    """`[study]`. Joules are charge times `reference_voltage_v` (thesis: 15.4 V in 5.1.3, 16.8 V in 4.3.1).

    `run_names` is the scheme of names of runs (`run_names.RunNames`).
    """

    name: str
    kind: StudyKind
    reference_voltage_v: Annotated[float, Meta(gt=0, le=1000)]
    jumps_nominal: Count
    time_zone: str
    run_names: str = "r{:03d}"


@dataclass(frozen=True, slots=True)
class LevelSettings:
    """A level of a factor: `value` where the factor is a number, `attributes` such as a foot's `radius_m`."""

    label: str
    value: float | None
    attributes: Mapping[str, float | str]


class FactorSettings(Struct, frozen=True, rename={"given_levels": "levels"}):
    """`[factors.NAME]`; `title` is its name in text, `control` the label of the level that controls have.

    `control_name` is what that level is called in text, `treatment` what the others are called together.
    """

    kind: FactorKind
    given_levels: tuple[Label, ...] | dict[str, dict[str, float | str]]
    title: str | None = None
    unit: str | None = None
    control: Label | None = None
    control_name: str | None = None
    treatment: str | None = None

    @property
    def levels(self) -> tuple[LevelSettings, ...]:
        """The levels in the order of the file."""
        given = self.given_levels
        attributes = given if isinstance(given, dict) else {label: {} for label in given}
        is_number = self.kind is FactorKind.NUMBER
        return tuple(LevelSettings(label, float(label) if is_number else None, attributes[label]) for label in given)


RejectReason = Literal["dropped_packet", "wrong_apex", "touched_by_hand", "misfire", "sensor_fault", "other"]
"""A `ReasonCode` for which a jump is rejected: all but those for which one is accepted."""


@dataclass(frozen=True, slots=True)
class ProtocolSettings:
    """`[protocol]`: how a run is made and what of it is used.

    `run_duration_s` is None where runs have no set duration, `charger_resolution_mah` where the charges show the
    charger's step; `checks` are the names of those made before a day's first run, `reject_reasons` those that the page
    offers.
    """

    run_duration_s: Positive | None = None
    detector: Detector = Detector.ROBUST
    exclude_first_jumps: Annotated[int, Meta(ge=0)] = 0
    exclude_gap_jumps: bool = True
    onset: Onset = Onset.SDS_BACK_30MS
    take_off: TakeOff = TakeOff.FLIGHT_SDS
    charger_resolution_mah: Positive | None = None
    idle_minutes: tuple[Positive, ...] = ()
    checks: tuple[str, ...] = ()
    reject_reasons: tuple[RejectReason, ...] = get_args(RejectReason)


@dataclass(frozen=True, slots=True)
class GainSettings:
    """`[gains.FACTOR]`: slope * gain + offset in `unit`, but 0 at the gain `zero`, where nothing is applied."""

    symbol: str
    slope: float
    offset: float
    unit: str
    zero: float | None = None

    def physical(self, gain: float) -> float:
        """Convert a gain to `unit`."""
        return 0.0 if gain == self.zero else self.slope * gain + self.offset


@dataclass(frozen=True, slots=True)
class RobotSettings:
    """`[robots.NAME]`."""

    body_mass_kg: Positive
    foot_mass_kg: Positive
    link_1_m: Positive
    link_2_m: Positive
    rest_length_m: Positive
    leg_min_m: Positive
    leg_max_m: Positive


@dataclass(frozen=True, slots=True)
class BatterySettings:
    """`[batteries.NAME]`."""

    cells: Count
    capacity_mah: Positive


@dataclass(frozen=True, slots=True)
class InstrumentSettings:
    """`[instruments.NAME]`."""

    kind: str
    make: str | None = None
    model: str | None = None
    serial: str | None = None


Limit = Literal[
    "largest_file_bytes",
    "most_columns",
    "longest_line_bytes",
    "largest_expanded_bytes",
    "largest_expansion",
    "most_members",
    "deepest_nesting",
    "most_cells",
]
"""A bound of `ingest.model.Limits`."""


@dataclass(frozen=True, slots=True)
class FileSettings:
    """`[files]`: `limits` are the bounds on what a file may ask for that `[files.limits]` sets, by name."""

    limits: dict[Limit, Count] = field(default_factory=dict)


class CalibrationKeys(
    Struct, frozen=True, kw_only=True, rename={"first_day": "from", "last_day": "until", "known": "value"}
):
    """How a column is calibrated: by `scale` and `offset`, or by what it shows, `raw`, at `value`s or `height`s."""

    scale: float | None = None
    offset: float | None = None
    scale_se: Positive | None = None
    offset_se: Positive | None = None
    raw: tuple[float, ...] | None = None
    known: tuple[float, ...] | None = None
    height: tuple[float, ...] | None = None
    se: Positive | None = None
    source: str | None = None
    first_day: date | None = None
    last_day: date | None = None

    def calibration(self) -> Calibration | None:
        """Return the calibration, None where no key says one. Raises `InputRefused` for keys that make no line."""
        if all(getattr(self, key) is None for key in CalibrationKeys.__struct_fields__):
            return None
        first, last = (None if day is None else str(day) for day in (self.first_day, self.last_day))
        if first is not None and last is not None and first > last:
            raise InputRefused(f"until = {last} is before `from`, {first}: exchange them.")
        if self.raw is not None:
            if (self.scale, self.offset, self.scale_se, self.offset_se) != (None, None, None, None):
                raise InputRefused("scale and offset follow from `raw`, beside which they stand: leave them out.")
            line = line_through(self.raw, self.height or self.known or (), self.se)
            return replace(line, source=self.source, first_day=first, last_day=last)
        if (self.known, self.height, self.se) != (None, None, None):
            raise InputRefused("`value`, `height` and `se` belong to `raw` numbers, which are not there: give them.")
        if self.scale == 0:
            raise InputRefused("scale = 0 makes every value the same: give what one raw unit is.")
        errors = [(self.scale_se or 0.0, 0.0), (0.0, self.offset_se or 0.0)]
        return Calibration(
            1.0 if self.scale is None else self.scale,
            self.offset or 0.0,
            tuple(error for error in errors if any(error)),
            source=self.source,
            first_day=first,
            last_day=last,
        )


class ProfileColumn(CalibrationKeys, frozen=True, kw_only=True):
    """What a column of a profile holds; None where the file says it. `sign` -1 turns it round.

    `unit` is that of the calibrated value where there is a calibration; several, each for its days, are `listed`.
    """

    channel: str | None = None
    unit: str | None = None
    sign: Literal[1, -1] | None = None
    listed: tuple[CalibrationKeys, ...] = named(name="calibrations", default=())

    @property
    def calibrations(self) -> tuple[Calibration, ...]:
        """The calibrations of the column."""
        found = [each.calibration() for each in (self, *self.listed)]
        return tuple(each for each in found if each is not None)


@dataclass(frozen=True, slots=True)
class TimeColumn:
    """`time` of a profile: the column of times, its unit, and the column of dates beside times of day."""

    column: str
    unit: str | None = None
    date_column: str | None = None


class ProfileSettings(
    Struct, frozen=True, rename={"decimal_sign": "decimal", "date_format": "date", "clock_format": "clock"}
):
    """`[profiles.NAME]`: how to read files that name the columns in `recognise`, or whose name fits `files`."""

    recognise: tuple[str, ...] = ()
    files: str | None = None
    time: TimeColumn | None = None
    columns: dict[str, ProfileColumn] = {}
    rate_hz: Positive | None = None
    encoding: str | None = None
    delimiter: Delimiter | None = None
    decimal_sign: Literal[".", ","] | None = None
    header_row: Annotated[int, Meta(ge=0, le=400)] | None = None
    units_row: Line | None = None
    first_row: Line | None = None
    comment: str | None = None
    footer: str | None = None
    date_format: str | None = None
    clock_format: str | None = None
    axes: str | None = None
    trials: str | None = None
    format: str | None = None
    instrument: str | None = None
    override_units: bool | None = None
    complete: bool | None = None
    no_robot_check: bool | None = None

    @property
    def settings(self) -> dict[str, Any]:
        """What the profile says, by the name of a field of `ingest.model.ReadingSettings`."""
        others = ("recognise", "files", "time", "columns")
        found = {name: getattr(self, name) for name in self.__struct_fields__ if name not in others}
        if self.time is not None:
            found |= {
                "time_column": self.time.column,
                "time_unit": self.time.unit,
                "date_column": self.time.date_column,
            }
        return {name: value for name, value in found.items() if value is not None and value is not False}


@dataclass(frozen=True, slots=True)
class SimulationSettings:
    """`[simulation]`: the scene that conditions are predicted with, and what becomes of it in each of them.

    `scene` names a shipped scene, or the file of one's own, whose text is then `scene_toml`.
    `factors` goes from a factor to the parameter that its physical value is, `levels` from a factor and a label to
    parameters; `parameters` hold in every condition, and those in `assumed` are given without a source.
    For the error every parameter without a source is varied by the part `varied_by`, those in `varied` by their own.
    """

    scene: str
    effects: str | None = None
    accuracy: Positive = 1e-6
    varied_by: Part = 0.1
    varied: dict[str, Part] = field(default_factory=dict)
    parameters: dict[str, float] = field(default_factory=dict)
    assumed: tuple[str, ...] = ()
    factors: dict[str, str] = field(default_factory=dict)
    levels: dict[str, dict[str, dict[str, float]]] = field(default_factory=dict)
    scene_toml: Annotated[str | None, NOT_A_KEY] = None


class Family(StrEnum):
    """The comparisons that are tested together: every level with the control, or all levels pooled, group by group."""

    EACH = "each"
    POOLED = "pooled"


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
    outcome: Outcome = Outcome.JOULES
    factor: str = ""
    side: Side | None = None
    levels: tuple[Label, ...] = ()
    at: float | None = None

    def __str__(self) -> str:
        """Return it in words."""
        parts = [str(self.kind).replace("_", " "), self.factor, str(self.side or ""), " to ".join(self.levels)]
        parts += [] if self.at is None else [f"at {self.at:g}"]
        return " ".join(filter(None, parts))


@dataclass(frozen=True, slots=True)
class AnalysisSettings:
    """`[analysis]`: what was decided about the analysis before anything was measured.

    `exclusions` are the reasons for which a person may leave out a jump or a run. `alternative` is that of savings;
    differences of other outcomes are tested two-sided.
    """

    primary_outcome: Outcome = Outcome.JOULES
    family: Family = Family.POOLED
    alpha: Annotated[float, Meta(gt=0, lt=0.5)] = 0.05
    apex_bounds_m: tuple[float, float] | None = None
    apex_bounds_percent: tuple[float, float] | None = None
    exclusions: tuple[ReasonCode, ...] = tuple(ReasonCode)
    contrasts: tuple[ContrastSettings, ...] = ()
    alternative: Alternative = Alternative.TWO_SIDED

    @property
    def apex_bounds(self) -> Bounds | None:
        """The bounds of no loss of height, None where none were set."""
        given = self.apex_bounds_m or self.apex_bounds_percent
        return None if given is None else Bounds(*given, percent=self.apex_bounds_m is None)

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
    """`[hypotheses.NAME]`: `text` says it, `source` where it was published, `published` what was found there.

    `side`, `between`, `levels` (all where empty), `group` and `within_percent` are those that its claim needs.
    """

    text: str
    claim: ClaimKind
    source: str = ""
    published: str = ""
    outcome: Outcome = Outcome.JOULES
    side: Side = Side.TREATED
    between: str = ""
    levels: tuple[Label, ...] = ()
    group: dict[str, Label] = field(default_factory=dict)
    within_percent: Percent = 0.0
    name: Annotated[str, NOT_A_KEY] = ""


@dataclass(frozen=True, slots=True)
class StudyProtocol:
    """`[studies.NAME]`: what `labbook study NAME` is asked with; None where that is left to it.

    `sheet` names a file of the book, or its uid; `decimal` is the sign in it. The others are the options of their name.
    """

    sheet: str | None = None
    decimal: str | None = None
    grain_mm: Positive | None = None
    where: str | None = None
    window: Count | None = None
    constant: float | None = None
    ratio: Positive | None = None
    same_percent: Percent | None = None
    level: Part | None = None


@dataclass(frozen=True, slots=True)
class DatabaseSettings:
    """`[database]`: where the tables of a shared book are."""

    url: PostgresUrl | None = None


@dataclass(frozen=True, slots=True)
class StoreSettings:
    """`[store]`: where raw copies and journal lie, if not in the book."""

    path: str | None = None


@dataclass(frozen=True, slots=True)
class SharingSettings:
    """`[sharing]`: under which licence others may use what leaves the book, an SPDX identifier or an address."""

    license: License | None = None


Private = Literal["people", "notes", "paths"]
"""What a capsule for sharing can leave out: names of people, texts of notes, paths of files and the database's."""


@dataclass(frozen=True, slots=True)
class PrivacySettings:
    """`[privacy]`: what is left out of what is shared with everybody."""

    leave_out: tuple[Private, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Configuration:
    """All of `labbook.toml`; `people` goes from name to initials."""

    study: StudySettings
    people: dict[str, str] = field(default_factory=dict)
    factors: dict[str, FactorSettings] = field(default_factory=dict)
    protocol: ProtocolSettings = ProtocolSettings()
    gains: dict[str, GainSettings] = field(default_factory=dict)
    robots: dict[str, RobotSettings] = field(default_factory=dict)
    batteries: dict[str, BatterySettings] = field(default_factory=dict)
    instruments: dict[str, InstrumentSettings] = field(default_factory=dict)
    files: FileSettings = FileSettings()
    profiles: dict[str, ProfileSettings] = field(default_factory=dict)
    simulation: SimulationSettings | None = None
    analysis: AnalysisSettings | None = None
    hypotheses: dict[str, HypothesisSettings] = field(default_factory=dict)
    studies: Mapping[str, StudyProtocol] = field(default_factory=dict)
    database: DatabaseSettings = DatabaseSettings()
    store: StoreSettings = StoreSettings()
    sharing: SharingSettings = SharingSettings()
    privacy: PrivacySettings = PrivacySettings()
    text: Annotated[str, NOT_A_KEY] = ""
    """The file as it was, with that of a scene of one's own below it."""

    @property
    def sha256(self) -> str:
        """The hash of the text."""
        return hashlib.sha256(self.text.encode("utf-8")).hexdigest()
