"""Every published result of the thesis: reproduced, contradicted, dependent on what is not published, or not testable.

Also where its text contradicts itself.
"""

from __future__ import annotations

import functools
import importlib.resources
import tomllib
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # a report names what is published, and simulates none of it
    from simulator.steady.tables import BedTable
    from simulator.thesis.claims import Finding

REPRODUCED, CONTRADICTED, NOT_TESTABLE = "reproduced", "contradicted", "not testable"
DEPENDS = "depends on unpublished gains"
VERDICTS = (REPRODUCED, DEPENDS, CONTRADICTED, NOT_TESTABLE)


@dataclass(frozen=True, slots=True)
class PublishedResult:
    """A published result. `published` is its number, in `unit` ("p": a p value), to which `relation` belongs.

    `why` it cannot be tested: empty where the claim of the same id judges it, whose statement it then has. A p value of
    the bed is about the saving of one `foot` and extension `gain` over `damping_gains`. `at` has foot ("": none), gain
    and damping gains (0: CE) of the conditions that it is of, nothing where it is of none. `note`: what else to know.
    """

    id: str
    where: str
    statement: str = ""
    published: float | None = None
    unit: str = ""
    relation: str = ""
    why: str = ""
    note: str = ""
    foot: str = ""
    gain: float = 0.0
    damping_gains: tuple[float, ...] = ()
    at: tuple[tuple[str | float, ...], ...] = ()

    @property
    def of_apex(self) -> bool:
        """Whether it is an apex height; one of certain conditions is a saving else, or the p of one."""
        return self.unit == "m"


@dataclass(frozen=True, slots=True)
class JudgedResult:
    """A published result with the finding on its claim; None where it has none.

    `saving` is the simulated one of the conditions of a p value, None for all others. `met_otherwise`: other values of
    what was never published meet the claim.
    """

    result: PublishedResult
    finding: Finding | None
    saving: float | None = None
    met_otherwise: bool = False

    @property
    def verdict(self) -> str:
        """Whether the simulation gives it: at every point, within the claim's limits."""
        if self.finding is None:
            return NOT_TESTABLE
        if self.finding.agrees:
            return REPRODUCED
        return DEPENDS if self.met_otherwise else CONTRADICTED

    @property
    def statement(self) -> str:
        """What is published, in words."""
        return self.result.statement if self.finding is None else self.finding.claim.statement

    @property
    def remark(self) -> str:
        """Why it cannot be tested, or what else to know."""
        return self.result.why or self.result.note


@dataclass(frozen=True, slots=True)
class Contradiction:
    """Two statements of the thesis that exclude each other: where they stand, and what they say."""

    where: str
    text: str


@functools.cache
def published_results() -> tuple[PublishedResult, ...]:
    """Return every published result, in the order of the chapters."""
    found = _read()
    return tuple(_result(entry, found["why"]) for entry in found["result"])


def result_of(foot: str, gain: float, damping_gains: tuple[float, ...], *, of_apex: bool) -> PublishedResult | None:
    """Return what is published of an apex, or a saving, at these gains: of the bed with a `foot`, "" of the emulator.

    `damping_gains` is (0,) for CE, and has several, in order, where these are pooled.
    """
    found = (result for result in published_results() if result.of_apex is of_apex)
    return next((result for result in found if (foot, gain, *damping_gains) in result.at), None)


@functools.cache
def published_numbers() -> Mapping[str, float]:
    """Return the number of each published result that has one, by its id and in its unit."""
    return {result.id: result.published for result in published_results() if result.published is not None}


def contradictions() -> tuple[Contradiction, ...]:
    """Return where the thesis contradicts itself."""
    return tuple(Contradiction(**entry) for entry in _read()["contradiction"])


def judge_results(
    findings: Iterable[Finding], bed: BedTable, met_otherwise: Collection[str] = ()
) -> tuple[JudgedResult, ...]:
    """Give each published result its verdict, by what was found for the claim of its id.

    `met_otherwise` has the ids of claims that other values of what was never published meet.
    """
    by_id = {item.claim.id: item for item in findings}
    return tuple(
        JudgedResult(
            result,
            None if result.why else by_id[result.id],
            bed.saving(result.foot, result.gain, result.damping_gains) if result.foot else None,
            result.id in met_otherwise,
        )
        for result in published_results()
    )


def _read() -> dict[str, Any]:
    text = (importlib.resources.files("simulator.steady") / "results.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def _result(entry: Mapping[str, Any], why: Mapping[str, str]) -> PublishedResult:
    own = dict(entry)
    own["why"] = why[own["why"]] if "why" in own else ""
    own["damping_gains"] = tuple(float(gain) for gain in own.get("damping_gains", ()))
    own["at"] = tuple(map(tuple, own.get("at", ())))
    if own.get("foot"):
        own["at"] = ((own["foot"], own["gain"], *own["damping_gains"]),)
        gains = own["damping_gains"]
        damped = f"damping gain {gains[0]:g}" if len(gains) == 1 else "all damping gains"
        own["statement"] = f"active damping against CE: {own['foot']} foot, gain {own['gain']}, {damped}"
    return PublishedResult(**own)
