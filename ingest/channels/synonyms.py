"""The names under which instruments and loggers write the channels that labbook knows.

Compared without case, blanks and underscores. Names that mean different things in different labs (`z`, `h`,
`velocity`, `voltage`, `position`) are left out on purpose: they are declared, not guessed.
"""

from __future__ import annotations

import re

from data_schema.vocabulary import CHANNELS
from ingest.tables.header_cells import squash

TIME_NAMES = frozenset(
    {
        "millis",
        "micros",
        "filetime",
        "time",
        "t",
        "timestamp",
        "elapsed",
        "elapsedtime",
        "timeelapsed",
        "epoch",
        "unixtime",
        "datetime",
        "dateandtime",
    }
)
UNIT_OF_NAME = {"millis": "ms", "micros": "us", "filetime": "filetime", "mah": "mAh"}
"""Names that say their unit: Arduino's clock functions are defined in milliseconds and microseconds."""

_WRITTEN_AS = {
    "body_height": "height, robot height, string pot, string pot height, string potentiometer, pot height, body z",
    "foot_height": "toe height",
    "leg_length": "leg len, leg extension length",
    "leg_velocity": "leg vel, leg speed, leg length velocity",
    "body_velocity": "body vel, vertical velocity, height rate",
    "platform_height": "platform, ground height, emulator height",
    "k_gain": "stiffness gain, extension gain",
    "b_gain": "damping gain",
    "b_ad_gain": "ad gain, b ad, active damping gain, active damping",
    "controller_state": "state, controller mode, control mode, fsm state",
    "battery_voltage": "v bat, pack voltage, v pack, battery v",
    "input_voltage": "v in, supply voltage",
    "current": "i bat, battery current",
    "charge": "mah",
    "temperature_internal": "int temp, t int, internal temperature",
    "temperature_external": "ext temp, t ext, external temperature",
    "force_x": "fx",
    "force_y": "fy",
    "force_z": "fz, grf v, grf z, v grf, vertical grf, vertical ground reaction force",
    "moment_x": "mx",
    "moment_y": "my",
    "moment_z": "mz",
    "cop_x": "cx",
    "cop_y": "cy",
    "cop_z": "cz",
    "free_moment_z": "tz",
    "sync": "",
    "aux": "",
    "sequence": "seq, sample, sample number, packet, packet number, frame",
}
_PLATED = re.compile(r"((?:force|moment|free_moment|cop)_[xyz])(?:_\d+)?")
_PLATE = re.compile(r"_(\d+)$")
_PLATE_NUMBER = re.compile(r"(f[xyz]|m[xyz]|cop[xyz]|force[xyz]|moment[xyz])([1-9])")

_CHANNEL_OF = {squash(name): name for name in CHANNELS}
_CHANNEL_OF |= {squash(word): name for name, words in _WRITTEN_AS.items() for word in words.split(",") if word}

_CHANNEL_IN_UNIT: dict[tuple[str, str | None], str] = {
    ("battery", "V"): "battery_voltage",
    ("battery", "mV"): "battery_voltage",
}
"""Names that may be those of several quantities, and the units that decide which."""


def channel_of(name: str, unit: str | None = None) -> str | None:
    """Return the channel that a source column of this name, in this unit, holds, None when it is not known.

    Force plates number their columns (`Fx1`, `COPx2`): plate 1 keeps the plain name, further ones a suffix.
    """
    squashed = squash(name)
    plate = _PLATE_NUMBER.fullmatch(squashed)
    if plate:
        channel = _CHANNEL_OF[plate[1]]
        return channel if plate[2] == "1" else f"{channel}_{plate[2]}"
    return _CHANNEL_OF.get(squashed) or _CHANNEL_IN_UNIT.get((squashed, unit))


def channel_kind(channel: str) -> str | None:
    """Return the key of `CHANNELS` for a channel, its plate suffix removed; None for a name that is not known."""
    plated = _PLATED.fullmatch(channel)
    if plated:
        return plated[1]
    return channel if channel in CHANNELS else None


def is_cop(channel: str) -> bool:
    """Whether a channel is a coordinate of a centre of pressure, of any plate."""
    return (channel_kind(channel) or "").startswith("cop_")


def plate_of(channel: str) -> int:
    """Return the number of the plate that a channel belongs to, 1 where it has none."""
    match = _PLATE.search(channel)
    return int(match[1]) if match else 1
