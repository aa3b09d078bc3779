"""Instruments whose makers fix what their files do not repeat: units, axes and signs, a rate.

A file takes an instrument's conventions when its columns are laid out as only that maker's program lays them out, or
when they are declared (`--instrument NAME`); a maker's name in a comment, or columns that any maker names so, are no
evidence. The registry: a new instrument is an entry of `INSTRUMENTS`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from data_schema.errors import unknown_name
from ingest.channels.columns import NO_CONVENTION, Convention
from ingest.channels.forces import Z_DOWN_ACTION

_BERTEC_AMPLIFIER_RATE_HZ = 1000.0


@dataclass(frozen=True, slots=True)
class Instrument:
    """What a maker's export adds to the plain reading: name of the part, units, axes, a rate fixed by hardware.

    `frame` is which axis points up in the file (a key of `channels.forces.AXES`), `axes` the signs of the components
    after that. `evidence` is why the file is taken for this instrument's; without one the signs of forces are only
    assumed. `steady` marks values that are constant by nature, as a charger's are, so that no note is due.
    """

    part: str = "log"
    convention: Convention = NO_CONVENTION
    axes: Mapping[str, int] = field(default_factory=dict)
    fixed_rate_hz: float | None = None
    evidence: str = ""
    steady: bool = False
    frame: str = "z up"


PLATE_UNITS: Mapping[str, str] = {
    f"{quantity}_{axis}": unit
    for quantity, unit in (("force", "N"), ("moment", "N*m"), ("free_moment", "N*m"), ("cop", "m"))
    for axis in "xyz"
}
"""Forces, moments and points of application in SI, for makers that write them so."""


def bertec_sdk(time_unit: str | None, evidence: str) -> Instrument:
    """Return the instrument of programs on Bertec's SDK, whose stamps are in `time_unit`."""
    convention = Convention("Bertec SDK", PLATE_UNITS, time_unit)
    return Instrument("force", convention, Z_DOWN_ACTION, _BERTEC_AMPLIFIER_RATE_HZ, evidence)


_DECLARED = "it is declared"

INSTRUMENTS: Mapping[str, Instrument] = {
    "bertec_acquire": Instrument(
        "force", Convention("Bertec Acquire", PLATE_UNITS, "ms"), Z_DOWN_ACTION, None, _DECLARED
    ),
    "bertec_sdk": bertec_sdk(None, _DECLARED),
    "bertec_balance": Instrument(
        "force", Convention("Bertec balance plate", PLATE_UNITS), Z_DOWN_ACTION, None, _DECLARED
    ),
    "amti": Instrument("force", Convention("AMTI NetForce", PLATE_UNITS), Z_DOWN_ACTION, evidence=_DECLARED),
    "reaction_z_up": Instrument(part="force", evidence=_DECLARED),
    "action_z_down": Instrument("force", Convention("axes z down", {}), Z_DOWN_ACTION, None, _DECLARED),
}
"""By the names of `--instrument`: makers' programs, and the two conventions of the signs of forces."""


def instrument_named(name: str) -> Instrument:
    """Return a declared instrument. Raises `UsageError` with the nearest name for one that is not known."""
    if name not in INSTRUMENTS:
        raise unknown_name("instrument", name, INSTRUMENTS)
    return INSTRUMENTS[name]
