"""Instruments whose makers fix what their files do not repeat: units, axes and signs, a rate.

A file takes an instrument's conventions when its columns are laid out as only that maker's program lays them out, or
when they are declared (`--instrument NAME`); a maker's name in a comment, or columns that any maker names so, are no
evidence. The registry: a new instrument is an entry of `INSTRUMENTS`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

from data_schema.errors import unknown_name
from ingest.channels.columns import NO_CONVENTION, Convention

_BERTEC_AMPLIFIER_RATE_HZ = 1000.0


@dataclass(frozen=True, slots=True)
class Instrument:
    """What a maker's export adds to the plain reading: name of the part, units, axes, a rate fixed by hardware.

    `frame` is which axis points up in the file (a key of `channels.forces.AXES`), `action` whether forces and moments
    are those on the plate, not the reaction on the robot. `evidence` is why the file is taken for this instrument's;
    without one the signs of forces are only assumed. `declared`: a person named the instrument or its axes. `steady`
    marks values that are constant by nature, as a charger's are, so that no note is due.
    """

    part: str = "log"
    convention: Convention = NO_CONVENTION
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


def _action_z_down(convention: Convention, evidence: str, fixed_rate_hz: float | None = None) -> Instrument:
    return Instrument("force", convention, "z down", action=True, fixed_rate_hz=fixed_rate_hz, evidence=evidence)


def bertec_sdk(time_unit: str | None, evidence: str) -> Instrument:
    """Return the instrument of programs on Bertec's SDK, whose stamps are in `time_unit`."""
    convention = Convention("Bertec SDK", PLATE_UNITS, time_unit)
    return _action_z_down(convention, evidence, _BERTEC_AMPLIFIER_RATE_HZ)


_NAMED = "its name"

INSTRUMENTS: Mapping[str, Instrument] = {
    "bertec_acquire": _action_z_down(Convention("Bertec Acquire", PLATE_UNITS, "ms"), _NAMED),
    "bertec_sdk": bertec_sdk(None, _NAMED),
    "bertec_balance": _action_z_down(Convention("Bertec balance plate", PLATE_UNITS), _NAMED),
    "amti": _action_z_down(Convention("AMTI NetForce", PLATE_UNITS), _NAMED),
    "reaction_z_up": Instrument("force", evidence=_NAMED),
    "action_z_down": _action_z_down(NO_CONVENTION, _NAMED),
}
"""By the names of `--instrument`: makers' programs, and the two conventions of the signs of forces."""


def instrument_named(name: str) -> Instrument:
    """Return a declared instrument. Raises `UsageError` with the nearest name for one that is not known."""
    if name not in INSTRUMENTS:
        raise unknown_name("instrument", name, INSTRUMENTS)
    return dataclasses.replace(INSTRUMENTS[name], declared=True)
