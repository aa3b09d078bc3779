"""The published claims of ch. 3 against what the simulation gives: found, not tuned."""

from __future__ import annotations

import importlib.resources
import tomllib
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulator.thesis.claim_values import VALUES
from simulator.thesis.figures import ThesisFigures

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Claim:
    """A claim of the thesis. It holds where every value of what is measured lies from `at_least` to `at_most`.

    `where` is the section or caption, `published` the thesis's own number, `unit` that of number, values and limits.
    """

    id: str
    where: str
    figures: tuple[str, ...]
    statement: str
    measure: str
    unit: str
    published: float | None = None
    at_least: float | None = None
    at_most: float | None = None


@dataclass(frozen=True, slots=True)
class Finding:
    """What the simulation gives for a claim: the range and median of `n` values, and how many lie within its limits."""

    claim: Claim
    lowest: float
    median: float
    highest: float
    n: int
    n_within: int

    @property
    def agrees(self) -> bool:
        """Whether every value lies within the claim's limits."""
        return self.n_within == self.n


def claims() -> tuple[Claim, ...]:
    """Return the claims, in the order of the chapter."""
    text = (importlib.resources.files("simulator.thesis") / "claims.toml").read_text(encoding="utf-8")
    return tuple(Claim(**{**entry, "figures": tuple(entry["figures"])}) for entry in tomllib.loads(text)["claim"])


def finding(claim: Claim, figures: ThesisFigures) -> Finding:
    """Compute a claim's values and judge them."""
    return judged(claim, VALUES[claim.id](figures))


def judged(claim: Claim, values: FloatArray) -> Finding:
    """Hold values of any shape against a claim's limits. A jump without an apex is NaN, and within no limits."""
    low = -np.inf if claim.at_least is None else claim.at_least
    high = np.inf if claim.at_most is None else claim.at_most
    return Finding(
        claim,
        lowest=float(np.nanmin(values)),
        median=float(np.nanmedian(values)),
        highest=float(np.nanmax(values)),
        n=values.size,
        n_within=int(np.count_nonzero((values >= low) & (values <= high))),
    )


def findings(figures: ThesisFigures, only: Collection[str] | None = None) -> tuple[Finding, ...]:
    """Judge all claims, or those about the figures of these numbers."""
    return tuple(
        finding(claim, figures) for claim in claims() if only is None or not set(only).isdisjoint(claim.figures)
    )
