"""What is measured of a run, declared once: name, unit, where a run's value comes from, and what is compared of it."""

from __future__ import annotations

from enum import StrEnum
from typing import Self


class Source(StrEnum):
    """What a run's value of an outcome is computed from."""

    CHARGE = "charge"
    LOG = "log"


class Outcome(StrEnum):
    """A measured outcome; its value is what results and reports call it.

    `key` names it in labbook.toml and on the command line, `number_name` in stored results, in `unit`. `heading` heads
    its figures. `shares_error`: its values have an error in common, that of the passive-drain line. `has_savings`: less
    is better, and it is compared as a share of the control's mean too. `has_equivalence`: no change is a claim, tested
    within bounds that were decided on.
    """

    key: str
    heading: str
    number_name: str
    unit: str
    source: Source
    shares_error: bool
    has_savings: bool
    has_equivalence: bool

    JOULES = "joules a jump", "joules", "Energy of a jump", "joules_per_jump", "J", Source.CHARGE, True, True, False
    APEX = "apex height", "apex", "Apex height", "apex_height", "m", Source.LOG, False, False, True

    def __new__(
        cls,
        name: str,
        key: str,
        heading: str,
        number_name: str,
        unit: str,
        source: Source,
        shares_error: bool,
        has_savings: bool,
        has_equivalence: bool,
    ) -> Self:
        """Make a member that is its name, with what is declared of it."""
        found = str.__new__(cls, name)
        found._value_ = name
        found.key, found.heading, found.number_name, found.unit, found.source = key, heading, number_name, unit, source
        found.shares_error, found.has_savings, found.has_equivalence = shares_error, has_savings, has_equivalence
        return found
