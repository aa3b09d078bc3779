"""Which scenes of a sweep cannot be simulated, since some of their values do not fit together, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulator.scene import Scene
from simulator.scene_rules import RULES
from simulator.sweep.checking import rule_reads
from simulator.sweep.design import Design, row_count

Flags = NDArray[np.bool_]
_BLOCK = 65_536


@dataclass(frozen=True, slots=True, eq=False)
class Broken:
    """A rule that some scenes break. `combinations`: which ones, of the swept parameters it reads, break it.

    `first`: the first of them in words, and the rule's sentence.
    """

    parameters: frozenset[str]
    combinations: Flags
    first: str


@dataclass(frozen=True, slots=True, eq=False)
class Refusals:
    """The scenes of a sweep that cannot be simulated: so many rows of its design, and the rules that they break."""

    design: Design
    broken: tuple[Broken, ...]
    count: int

    def rows(self, start: int, stop: int) -> Flags:
        """Return which of the rows from `start` to before `stop` cannot be simulated, shape (rows,)."""
        return _rows(self.design, self.broken, start, stop)

    @property
    def first(self) -> str:
        """One of them in words, and why it cannot be; empty where all can."""
        return self.broken[0].first if self.broken else ""


def refusals_of(scene: Scene, design: Design) -> Refusals:
    """Ask every rule about every combination of values that the sweep comes to."""
    plain = {name: value.value for name, value in scene.values.items()}
    swept = frozenset(axis.parameter for axis in design.axes)
    broken = []
    for rule in RULES:
        concerned = rule_reads(rule, plain) & swept if rule.effects <= scene.effects else frozenset()
        if not concerned:
            continue  # the scene itself keeps this rule, and so do all of the sweep
        first = ""
        flags = np.zeros(design.combination_count(concerned), np.bool_)
        for place, point in enumerate(design.combinations(concerned)):
            fault = rule.fault({**plain, **point})
            if fault is not None:
                flags[place] = True
                first = first or f"{_where(point)}: {fault}"
        if first:
            broken.append(Broken(concerned, flags, first))
    return Refusals(design, tuple(broken), _count(design, tuple(broken)))


def _where(point: Mapping[str, float]) -> str:
    return ", ".join(f"{name} = {number:g}" for name, number in point.items())


def _rows(design: Design, broken: tuple[Broken, ...], start: int, stop: int) -> Flags:
    found = np.zeros(stop - start, np.bool_)
    for rule in broken:
        found |= rule.combinations[design.combination_places(rule.parameters, start, stop)]
    return found


def _count(design: Design, broken: tuple[Broken, ...]) -> int:
    if not broken:
        return 0
    rows = row_count(design)
    starts = range(0, rows, _BLOCK)
    return sum(int(_rows(design, broken, start, min(start + _BLOCK, rows)).sum()) for start in starts)
