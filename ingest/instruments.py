"""Instruments whose makers fix what their files do not repeat: units, axes and signs, a rate.

A file takes an instrument's conventions when its columns are laid out as only that maker's program lays them out, or
when they are declared (`--instrument NAME`); a maker's name in a comment, or columns that any maker names so, are no
evidence. The registry: a new instrument is an entry of `INSTRUMENTS`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field

from data_schema.errors import unknown_name

_BERTEC_AMPLIFIER_RATE_HZ = 1000.0


@dataclass(frozen=True, slots=True)
class Instrument:
    """What a maker's export adds to the plain reading: name of the part, units, axes, a rate fixed by hardware.

    `units`, by channel, and `time_unit`, the clock's, are those that the `maker` fixes and the file does not repeat.
    `frame` is which axis points up in the file (a key of `channels.forces.AXES`), `action` whether forces and moments
    are those on the plate, not the reaction on the robot. `evidence` is why the file is taken for this instrument's;
    without one the signs of forces are only assumed. `declared`: a person named the instrument or its axes. `steady`
    marks values that are constant by nature, as a charger's are, so that no note is due.
    """

    part: str = "log"
    maker: str = ""
    units: Mapping[str, str] = field(default_factory=dict)
    time_unit: str | None = None
    frame: str = "z up"
    action: bool = False
    fixed_rate_hz: float | None = None
    evidence: str = ""
    declared: bool = False
    steady: bool = False


PLATE_UNITS: Mapping[str, str] = {
    f"{quantity}_{axis}": unit
    for quantity, unit in (("force", "N"), ("moment", "N*m"), ("free_moment", "N*m"), ("cop", "m"))
    for axis in "xyz"
}
"""Forces, moments and points of application in SI, for makers that write them so."""


def _action_z_down(
    maker: str, evidence: str, time_unit: str | None = None, fixed_rate_hz: float | None = None
) -> Instrument:
    units = PLATE_UNITS if maker else {}
    return Instrument("force", maker, units, time_unit, "z down", True, fixed_rate_hz, evidence)


def bertec_sdk(time_unit: str | None, evidence: str) -> Instrument:
    """Return the instrument of programs on Bertec's SDK, whose stamps are in `time_unit`."""
    return _action_z_down("Bertec SDK", evidence, time_unit, _BERTEC_AMPLIFIER_RATE_HZ)


_NAMED = "its name"

INSTRUMENTS: Mapping[str, Instrument] = {
    "bertec_acquire": _action_z_down("Bertec Acquire", _NAMED, "ms"),
    "bertec_sdk": bertec_sdk(None, _NAMED),
    "bertec_balance": _action_z_down("Bertec balance plate", _NAMED),
    "amti": _action_z_down("AMTI NetForce", _NAMED),
    "reaction_z_up": Instrument("force", evidence=_NAMED),
    "action_z_down": _action_z_down("", _NAMED),
}
"""By the names of `--instrument`: makers' programs, and the two conventions of the signs of forces."""


def instrument_named(name: str) -> Instrument:
    """Return a declared instrument. Raises `UsageError` with the nearest name for one that is not known."""
    if name not in INSTRUMENTS:
        raise unknown_name("instrument", name, INSTRUMENTS)
    return dataclasses.replace(INSTRUMENTS[name], declared=True)
