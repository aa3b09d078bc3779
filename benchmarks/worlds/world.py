"""Simulated campaigns of known truth, and how often what the first page says of them holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from data_schema.vocabulary import Undefined

LEAST_COVERAGE = 0.94
"""Of intervals of level .95, less the error of 2 000 campaigns."""
LEAST_WARNED, MOST_WARNED = 0.95, 0.05
"""Shares of campaigns with the warning, where it is needed and where it is not."""


Interval = tuple[float, float] | Undefined


def holds_truth(ci: Interval, truth: float) -> bool | None:
    """Tell whether an interval holds the truth; None where there is none."""
    return None if isinstance(ci, Undefined) else bool(ci[0] <= truth <= ci[1])


@dataclass(frozen=True, slots=True)
class Campaign:
    """What the first page says of one campaign.

    `covers`: whether its interval holds the truth, None where it gives none; `finds`: whether it claims an effect;
    `warns`: whether it says that the world is such that the interval cannot be trusted.
    """

    covers: bool | None
    finds: bool
    warns: bool


@dataclass(frozen=True, slots=True)
class World:
    """How campaigns are drawn and put through the functions that a report calls."""

    name: str
    truth: str
    """The true effect, in words: "5 %"."""
    warning_needed: bool | None
    """None where an interval that covers is enough without the warning."""
    simulate: Callable[[np.random.Generator], Campaign]


@dataclass(frozen=True, slots=True)
class Shares:
    """Shares over the campaigns of a world; `covers` is None where no campaign has an interval."""

    campaigns: int
    covers: float | None
    finds: float
    warns: float


def shares_of(world: World, campaigns: int, seed: int = 20261128) -> Shares:
    """Simulate campaigns, each with a generator of its own, so that the first are the same however many there are."""
    found = [world.simulate(np.random.default_rng([seed, number])) for number in range(campaigns)]
    with_interval = [each.covers for each in found if each.covers is not None]
    return Shares(
        campaigns,
        sum(with_interval) / len(with_interval) if with_interval else None,
        sum(each.finds for each in found) / campaigns,
        sum(each.warns for each in found) / campaigns,
    )


def holds(world: World, shares: Shares, tolerance: float = 0.0) -> bool:
    """Tell whether a reader is not misled: the page warns where that is needed; else the interval covers.

    Where no warning is needed there is none. `tolerance` is what shares of few campaigns may be off by.
    """
    if world.warning_needed:
        return shares.warns >= LEAST_WARNED - tolerance
    covers = shares.covers is None or shares.covers >= LEAST_COVERAGE - tolerance
    return covers and (world.warning_needed is None or shares.warns <= MOST_WARNED + tolerance)
