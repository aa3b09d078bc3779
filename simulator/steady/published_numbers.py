"""What the thesis says of its experiments on emulator and force plate, against what the simulation gives."""

from __future__ import annotations

import importlib.resources
import tomllib
from dataclasses import dataclass
from typing import Any

import numpy as np

from simulator.steady.measured import MEASURES
from simulator.steady.tables import SteadyTables
from simulator.thesis.claims import Claim, Finding, judged

_APEXES = ("emu.apex_low", "emu.apex_high")
_OWN_KEYS = ("column", "gains", "beside", "reason")


@dataclass(frozen=True, slots=True)
class PublishedNumber:
    """A published number or statement as a claim, without a `measure` where the simulation gives nothing for it.

    `column` and `gains` say beside which simulated numbers it stands in the tables, in the words `beside`; `reason`
    why it cannot be matched, where it cannot.
    """

    claim: Claim
    column: str = ""
    gains: tuple[float, ...] = ()
    beside: str = ""
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Comparison:
    """A published number and what the simulation gives for it: None where it gives nothing to compare."""

    published: PublishedNumber
    finding: Finding | None

    @property
    def agrees(self) -> bool:
        """Whether the simulation gives it."""
        return self.finding is not None and self.finding.agrees


def published_numbers() -> tuple[PublishedNumber, ...]:
    """Return what is published, in the order of the tables."""
    text = (importlib.resources.files("simulator.steady") / "published.toml").read_text(encoding="utf-8")
    return tuple(_number(entry) for entry in tomllib.loads(text)["number"])


def comparisons(tables: SteadyTables) -> tuple[Comparison, ...]:
    """Hold everything published against the tables."""
    return tuple(
        Comparison(number, judged(number.claim, MEASURES[number.claim.id](tables)) if number.claim.measure else None)
        for number in published_numbers()
    )


def apex_between_m(gain: float) -> float:
    """Return the apex in m at a gain between the two at which apexes are published, on the straight line."""
    known = [
        (number.gains[0], number.claim.published)
        for number in published_numbers()
        if number.claim.id in _APEXES and number.claim.published is not None
    ]
    gains, apexes_m = zip(*known, strict=True)
    return float(np.interp(gain, gains, apexes_m))


def _number(entry: dict[str, Any]) -> PublishedNumber:
    own = {key: entry.pop(key) for key in _OWN_KEYS if key in entry}
    own["gains"] = tuple(float(gain) for gain in own.get("gains", ()))
    return PublishedNumber(Claim(**{**entry, "figures": tuple(entry["figures"])}), **own)
