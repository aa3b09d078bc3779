"""What is measured of a run, declared once: name, unit, where a run's value comes from, and what is compared of it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Self

from data_schema.vocabulary import FileRole


@dataclass(frozen=True, slots=True, kw_only=True)
class Declared:
    """What is declared of an outcome.

    Parameters
    ----------
    name : what results and reports call it
    key : names it in labbook.toml, on the command line and in names of tables and figures
    heading : heads its section and figures
    plural : names the values of several runs
    number_name : names it in results, in `unit`
    source : what a run's value is computed from
    file : the module of `labbook.analysis.outcomes` that computes it, alone or with others
    comparative : words for a larger value and for a smaller one
    undefined_because : why a run that has the source may have no value
    of_every_run : every run is expected to have it; else it is left out where no run has it
    of_jumps : it is of the jumps that count: which do, and the detector that finds them, change it
    of_push_off : of a single jump on a plate, the rules by which it begins and leaves the plate change it
    shares_error : its values always have an error in common, that of the passive-drain line
    has_savings : less is better, and it is compared as a share of the control's mean, and across groups too
    has_equivalence : no change is a claim, tested within bounds that were decided on
    """

    name: str
    key: str
    heading: str
    plural: str
    number_name: str
    unit: str
    source: FileRole
    file: str
    comparative: tuple[str, str] = ("higher", "lower")
    undefined_because: str
    of_every_run: bool = False
    of_jumps: bool = False
    of_push_off: bool = False
    shares_error: bool = False
    has_savings: bool = False
    has_equivalence: bool = False


class Outcome(StrEnum):
    """A measured outcome, with the fields of `Declared`; its value is its name."""

    key: str
    heading: str
    plural: str
    number_name: str
    unit: str
    source: FileRole
    file: str
    comparative: tuple[str, str]
    undefined_because: str
    of_every_run: bool
    of_jumps: bool
    of_push_off: bool
    shares_error: bool
    has_savings: bool
    has_equivalence: bool

    JOULES = Declared(
        name="joules a jump",
        key="joules",
        heading="Energy of a jump",
        plural="joules",
        number_name="joules_per_jump",
        unit="J",
        source=FileRole.CHARGE,
        file="run_energy",
        undefined_because="joules are undefined",
        of_every_run=True,
        shares_error=True,
        has_savings=True,
    )
    APEX = Declared(
        name="apex height",
        key="apex",
        heading="Apex height",
        plural="apex heights",
        number_name="apex_height",
        unit="m",
        source=FileRole.LOG,
        file="run_apexes",
        undefined_because="none of its jumps counts",
        of_every_run=True,
        of_jumps=True,
        has_equivalence=True,
    )
    PEAK_FORCE = Declared(
        name="peak force",
        key="peak_force",
        heading="Peak force",
        plural="peak forces",
        number_name="peak_force",
        unit="N",
        source=FileRole.FORCE,
        file="run_force",
        undefined_because="no contact is found in its force",
    )
    CONTACT_TIME = Declared(
        name="contact time",
        key="contact_time",
        heading="Contact time",
        plural="contact times",
        number_name="contact_time",
        unit="s",
        source=FileRole.FORCE,
        file="run_force",
        comparative=("longer", "shorter"),
        undefined_because="no contact is found in its force",
        of_push_off=True,
    )
    IMPULSE_HEIGHT = Declared(
        name="jump height from impulse",
        key="impulse_height",
        heading="Jump height from impulse",
        plural="jump heights from impulse",
        number_name="impulse_height",
        unit="m",
        source=FileRole.FORCE,
        file="run_force",
        undefined_because="no jump comes from quiet standing, and fewer than 3 follow each other, in its force",
        of_push_off=True,
    )
    FLIGHT_HEIGHT = Declared(
        name="jump height from flight time",
        key="flight_height",
        heading="Jump height from flight time",
        plural="jump heights from flight time",
        number_name="flight_height",
        unit="m",
        source=FileRole.FORCE,
        file="run_force",
        undefined_because="no jump from quiet standing lands again in its force",
        of_push_off=True,
    )

    @property
    def common_error(self) -> str:
        """What values of several runs may have an error of in common: the passive-drain line, or a calibration."""
        return "passive drain" if self.shares_error else "calibration"

    def __new__(cls, declared: Declared) -> Self:
        """Make a member that is its name, with what is declared of it."""
        found = str.__new__(cls, declared.name)
        found._value_ = declared.name
        for item in fields(Declared):
            if item.name != "name":
                setattr(found, item.name, getattr(declared, item.name))
        return found


SOURCES = tuple(dict.fromkeys(outcome.source for outcome in Outcome))
"""What outcomes are computed from."""
