"""The words of labbook: closed lists that the tables enforce, and the channels with their units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Self

from data_schema.reasons import Code


@dataclass(frozen=True, slots=True, init=False)
class Remark:
    """A remark on a result: a code, with the parameters of its sentence."""

    code: Code
    parameters: tuple[tuple[str, str | int | float], ...]

    def __init__(self, code: Code, **parameters: str | int | float) -> None:
        """Say something by a code and the parameters of its sentence."""
        if not isinstance(code, Code):
            raise TypeError(f"{code!r} is no code of a reason: give one of `data_schema.reasons`")
        object.__setattr__(self, "code", code)
        object.__setattr__(self, "parameters", tuple(sorted(parameters.items())))

    @property
    def text(self) -> str:
        """The remark in words."""
        return self.code.in_words(dict(self.parameters))

    def called(self, names: Mapping[str, str], unit: str) -> Self:
        """Return the same, with groups called otherwise (`names` by what they are called now), and the values, too."""
        parameters = {
            name: names.get(value, value) if isinstance(value, str) else value for name, value in self.parameters
        }
        return type(self)(self.code, **{**parameters, "unit": unit})


@dataclass(frozen=True, slots=True, init=False, repr=False)
class Undefined(Remark):
    """A number that does not exist, and why (a code of `Reason`); stands where a float would (never NaN).

    It is neither true nor false: `if result.equivalent:` must not take what could not be tested for shown.
    """

    @property
    def reason(self) -> str:
        """Why it does not exist, in words."""
        return self.text

    def __repr__(self) -> str:
        """Show the reason in words."""
        return f"Undefined({self.reason!r})"

    def __bool__(self) -> bool:
        """Raise `TypeError`."""
        raise TypeError(f"what is undefined is neither true nor false ({self.reason}): ask isinstance(..., Undefined).")


class StudyKind(StrEnum):
    """What the robot jumps on."""

    BED = "bed"
    EMULATOR = "emulator"
    FORCE_PLATE = "force_plate"
    FIELD = "field"


class Rule(StrEnum):
    """How a control and a treatment are compared, by the days that both share."""

    PAIRED = "paired on day means"
    WITHIN = "within days"
    NONE = "no claim"


class FactorKind(StrEnum):
    """Whether the levels of a factor are numbers or labels."""

    NUMBER = "number"
    LABEL = "label"


class RunKind(StrEnum):
    """What a run is for: jumps are counted, idle runs measure the passive drain."""

    JUMPS = "jumps"
    IDLE = "idle"
    CHARACTERISATION = "characterisation"
    FIELD = "field"


class RunState(StrEnum):
    """Where a run stands: open until it is complete; void runs stay, no result uses them."""

    OPEN = "open"
    COMPLETE = "complete"
    VOID = "void"


class FileRole(StrEnum):
    """What a file says about a run; a study's sheet, or a log that one names, is about no run."""

    LOG = "log"
    FORCE = "force"
    CHARGE = "charge"
    SHEET = "sheet"


class IngestStatus(StrEnum):
    """How the reading of one file ended, and whether it is in force.

    `imported` is the reading in force, `superseded` an earlier one, `withdrawn` one whose file a person took out of
    use; `waiting`: imported once, and this labbook's reader refuses the bytes until something is declared about them.
    """

    IMPORTED = "imported"
    DUPLICATE = "duplicate"
    REFUSED = "refused"
    SUPERSEDED = "superseded"
    WITHDRAWN = "withdrawn"
    WAITING = "waiting"


class Severity(StrEnum):
    """How grave a finding is: a remark, a row left out, or the whole file refused."""

    NOTE = "note"
    ROW = "row"
    FILE = "file"


class ChargeMode(StrEnum):
    """What a charger was doing."""

    CHARGE = "charge"
    DISCHARGE = "discharge"


class ChargeState(StrEnum):
    """Whether a charge counts.

    `known`: another file's row says the same; `gone`: its file was withdrawn, or a newer reading has no such line;
    `dismissed`: a person took it out of the inbox.
    """

    COUNTED = "counted"
    KNOWN = "known"
    GONE = "gone"
    DISMISSED = "dismissed"


class GapKind(StrEnum):
    """Why samples are missing: dropped packets, a logging pause, rejected rows, a sensor that held its value."""

    DROPPED = "dropped"
    PAUSE = "pause"
    REJECTED = "rejected"
    HELD = "held"


class PlanMethod(StrEnum):
    """How the order of a day was drawn."""

    RANDOMISED = "randomised"
    BLOCKED = "blocked"


class TargetKind(StrEnum):
    """What a note or a decision is about."""

    JUMP = "jump"
    RUN = "run"
    CHARGE = "charge"
    CONDITION = "condition"
    DAY = "day"
    FILE = "file"


class Action(StrEnum):
    """What a journal row does to the book.

    `ingest` takes in what was read of a file, or why it was refused; `set` states facts of a thing, which it makes
    where no values before it are named; `exclude` and `include` say whether a thing counts. `merge` stands before the
    entries of another book.
    """

    INGEST = "ingest"
    SET = "set"
    EXCLUDE = "exclude"
    INCLUDE = "include"
    NOTE = "note"
    PLAN = "plan"
    REPORT = "report"
    MERGE = "merge"


USING = (Action.EXCLUDE, Action.INCLUDE)
"""Statements on whether a thing counts."""


class Verdict(StrEnum):
    """What a person decided; `clear` takes the earlier verdict back.

    `move` puts the apex of a jump at another time, `add` states a jump that the detector has not.
    """

    ACCEPT = "accept"
    REJECT = "reject"
    MOVE = "move"
    ADD = "add"
    CLEAR = "clear"

    @property
    def action(self) -> Action:
        """What the journal calls its statement."""
        return {Verdict.ACCEPT: Action.INCLUDE, Verdict.REJECT: Action.EXCLUDE}.get(self, Action.SET)


class ReasonCode(StrEnum):
    """Why a person decided so."""

    DROPPED_PACKET = "dropped_packet"
    WRONG_APEX = "wrong_apex"
    TOUCHED_BY_HAND = "touched_by_hand"
    MISFIRE = "misfire"
    SENSOR_FAULT = "sensor_fault"
    LOOKS_RIGHT = "looks_right"
    WITH_THE_REST = "with_the_rest"
    """Accepted with the rest of its run, which nothing doubts: nobody looked at this one by itself."""
    OTHER = "other"


TO_ACCEPT = (ReasonCode.LOOKS_RIGHT, ReasonCode.WITH_THE_REST, ReasonCode.OTHER)
"""The reasons to accept a jump."""
TO_REJECT = tuple(one for one in ReasonCode if one is ReasonCode.OTHER or one not in TO_ACCEPT)
"""The reasons to reject one."""
REASONS: Mapping[Verdict, tuple[ReasonCode, ...]] = {Verdict.ACCEPT: TO_ACCEPT, Verdict.REJECT: TO_REJECT}
"""The reasons of verdicts that do not take all."""


class ReviewOrder(StrEnum):
    """The order in which jumps are looked at."""

    DOUBT = "doubt"
    RUN = "run"
    SHUFFLED = "shuffled"


class ContrastKind(StrEnum):
    """What a contrast of condition means asks."""

    DIFFERENCE = "difference"
    """What levels of a factor differ by, of the control's or of the treated runs."""
    INTERACTION = "interaction"
    """By how much the saving differs between levels of a factor."""
    TREND = "trend"
    """By how much the saving rises with the levels of the factor that has a control: a straight line."""
    LEVELS_OFF = "levels_off"
    """By how much it rises less from a level on than up to it."""


@dataclass(frozen=True, slots=True)
class ChannelKind:
    """A channel that labbook knows by name: the unit it is stored in and what it means."""

    unit: str
    meaning: str


CHANNELS: dict[str, ChannelKind] = {
    "body_height": ChannelKind("m", "height of the body above the undisturbed ground"),
    "foot_height": ChannelKind("m", "height of the foot above the undisturbed ground"),
    "leg_length": ChannelKind("m", "distance from hip to foot"),
    "leg_velocity": ChannelKind("m/s", "rate of change of the leg length"),
    "body_velocity": ChannelKind("m/s", "vertical velocity of the body"),
    "platform_height": ChannelKind("m", "height of the emulated ground"),
    "k_gain": ChannelKind("1", "stiffness gain in force"),
    "b_gain": ChannelKind("1", "damping gain in force"),
    "b_ad_gain": ChannelKind("1", "active-damping gain in force"),
    "controller_state": ChannelKind("1", "state of the controller"),
    "battery_voltage": ChannelKind("V", "voltage of the pack"),
    "input_voltage": ChannelKind("V", "voltage of the charger's supply"),
    "current": ChannelKind("A", "current, positive while charging"),
    "charge": ChannelKind("mAh", "charge counted by the instrument, negative while discharging"),
    "temperature_internal": ChannelKind("degC", "temperature inside the instrument"),
    "temperature_external": ChannelKind("degC", "temperature at the external probe"),
    "force_x": ChannelKind("N", "ground reaction on the robot, x"),
    "force_y": ChannelKind("N", "ground reaction on the robot, y"),
    "force_z": ChannelKind("N", "ground reaction on the robot, upward positive"),
    "moment_x": ChannelKind("N*m", "moment about the plate's x axis"),
    "moment_y": ChannelKind("N*m", "moment about the plate's y axis"),
    "moment_z": ChannelKind("N*m", "moment about the plate's z axis"),
    "cop_x": ChannelKind("m", "centre of pressure, x"),
    "cop_y": ChannelKind("m", "centre of pressure, y"),
    "cop_z": ChannelKind("m", "point of application, height"),
    "free_moment_x": ChannelKind("N*m", "moment about the x axis through the point of application"),
    "free_moment_y": ChannelKind("N*m", "moment about the y axis through the point of application"),
    "free_moment_z": ChannelKind("N*m", "moment about the vertical through the point of application"),
    "sync": ChannelKind("1", "synchronisation input"),
    "aux": ChannelKind("1", "auxiliary input"),
    "sequence": ChannelKind("1", "the instrument's own sample counter"),
    **{f"cell_{cell}_voltage": ChannelKind("V", f"voltage of cell {cell}") for cell in range(1, 11)},
}
"""Known channels; a second plate's channels carry the suffix `_2`, a third's `_3`. Others keep their own name."""
