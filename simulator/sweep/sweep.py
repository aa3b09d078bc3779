"""A sweep: a scene, what of it is varied, and how accurately; and which of its scenes cannot be, and why."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError
from simulator.declared import all_parameters
from simulator.error_bars import finer_accuracy
from simulator.scene import Scene
from simulator.scene_rules import RULES, Rule
from simulator.sweep.chunks import Chunks, chunks_for
from simulator.sweep.design import Design
from simulator.sweep.outputs import ERRORS, OUTPUTS, REFUSED, Output

JUMP = "jump"
"""Dimension of the jumps of scenes that have several."""
Flags = NDArray[np.bool_]
_BLOCK = 65_536
_SPREAD = (math.sqrt(5.0) - 1.0) / 2.0
"""Golden ratio: its multiples' fractions are spread evenly, and in step with no axis of a grid."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """A sweep that can be run; scenes whose values do not fit together are left out of it, and marked as refused.

    `labbook` is the version of the program that made it, stored with the result; `error_bars` the share of its rows
    that have them. Raises `UsageError` for an axis that nothing reads or that leaves its parameter's range, where every
    scene would be refused, and for error bars that cannot be.
    """

    scene: Scene
    design: Design
    accuracy: float = 1e-6
    labbook: str = ""
    error_bars: float = 0.0
    refusals: Refusals = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        _check_axes(self.scene, self.design)
        if self.error_bars and not 0.0 < self.error_bars <= 1.0:
            raise UsageError(
                f"{self.error_bars:g} is no share of the scenes to give error bars: give one above 0, to 1."
            )
        if self.error_bars and finer_accuracy(self.accuracy) >= self.accuracy:
            raise UsageError(
                f"nothing is simulated finer than an accuracy of {self.accuracy:g}, which error bars take: ask for a "
                "coarser one, or for no error bars."
            )
        object.__setattr__(self, "refusals", refusals_of(self.scene, self.design))
        if not self.legal_rows:
            raise UsageError(f"no scene of the sweep can be simulated: it comes to {self.refusals.first}")

    @property
    def legal_rows(self) -> int:
        """How many of its scenes can be simulated."""
        return self.design.row_count - self.refusals.count

    @property
    def jumps_wanted(self) -> int:
        """How many jumps are simulated, where all scenes make theirs."""
        return self.legal_rows * self.scene.jumps

    @property
    def refused(self) -> str:
        """How many of its scenes cannot be simulated, and why, in a sentence; empty where all can."""
        if not self.refusals.count:
            return ""
        be = "is" if self.refusals.count == 1 else "are"
        return (
            f"{self.refusals.count} of {self.design.row_count} scenes cannot be simulated and {be} marked {REFUSED}, "
            f"the first at {self.refusals.first}"
        )

    @property
    def chunks(self) -> Chunks:
        """How its rows are divided."""
        return chunks_for(self.design, self.scene.jumps)

    @property
    def dims(self) -> dict[str, int]:
        """Dimensions of the result and their lengths."""
        jumps = {JUMP: self.scene.jumps} if self.scene.jumps > 1 else {}
        return {**self.design.dims, **jumps}

    @property
    def outputs(self) -> tuple[Output, ...]:
        """What it gives for each jump."""
        return (*OUTPUTS, *ERRORS) if self.error_bars else OUTPUTS

    def has_error_bars(self, start: int, stop: int) -> Flags:
        """Return which of the rows from `start` to before `stop` have error bars, shape (rows,)."""
        found: Flags = np.modf((np.arange(start, stop) + 0.5) * _SPREAD)[0] < self.error_bars
        return found

    @property
    def n_with_error_bars(self) -> int:
        """How many of the scenes that can be simulated have error bars."""
        blocks = _blocks(self.design) if self.error_bars else ()
        return sum(int((self.has_error_bars(*block) & ~self.refusals.rows(*block)).sum()) for block in blocks)

    @property
    def assumed(self) -> tuple[str, ...]:
        """Names of the parameters without a source that the result depends on; what is swept is not assumed."""
        swept = {axis.parameter for axis in self.design.axes}
        return tuple(name for name in self.scene.assumed if name not in swept)


@dataclass(frozen=True, slots=True, eq=False)
class Refusals:
    """The scenes of a sweep that cannot be simulated: `count` rows of its design.

    `broken`: for each rule that some break, the swept parameters that it reads and which rows of `design.part` of them
    break it. `first`: one of the scenes in words, and why it cannot be; empty where all can.
    """

    design: Design
    broken: tuple[tuple[frozenset[str], Flags], ...]
    first: str
    count: int = field(init=False)

    def __post_init__(self) -> None:
        starts = _blocks(self.design) if self.broken else ()
        object.__setattr__(self, "count", sum(int(self.rows(*block).sum()) for block in starts))

    def rows(self, start: int, stop: int) -> Flags:
        """Return which of the rows from `start` to before `stop` cannot be simulated, shape (rows,)."""
        found = np.zeros(stop - start, np.bool_)
        for parameters, breaks in self.broken:
            found |= breaks[self.design.rows_in_part(parameters, start, stop)]
        return found


def refusals_of(scene: Scene, design: Design) -> Refusals:
    """Ask every rule about every combination of values that the sweep comes to."""
    plain = {name: value.value for name, value in scene.values.items()}
    swept = frozenset(axis.parameter for axis in design.axes)
    broken, first = [], ""
    for rule in RULES:
        concerned = rule_reads(rule, plain) & swept if rule.effects <= scene.effects else frozenset()
        if not concerned:
            continue  # the scene itself keeps this rule, and so do all of the sweep
        part = design.part(concerned)
        breaks = np.zeros(part.row_count, np.bool_)
        for place, point in enumerate(_points(part)):
            fault = rule.fault({**plain, **point})
            if fault is not None:
                breaks[place] = True
                first = first or f"{', '.join(f'{name} = {number:g}' for name, number in point.items())}: {fault}"
        if breaks.any():
            broken.append((concerned, breaks))
    return Refusals(design, tuple(broken), first)


def rule_reads(rule: Rule, values: Mapping[str, float]) -> frozenset[str]:
    """Return the parameters that a rule reads; a rule reads the same ones whatever their values."""
    watched = _Watched(values)
    rule.fault(watched)
    return frozenset(watched.read)


class _Watched(dict[str, float]):
    """Values that remember which of them were read."""

    def __init__(self, values: Mapping[str, float]) -> None:
        super().__init__(values)
        self.read = set[str]()

    def __getitem__(self, name: str) -> float:
        self.read.add(name)
        return super().__getitem__(name)


def _blocks(design: Design) -> Iterator[tuple[int, int]]:
    for start in range(0, design.row_count, _BLOCK):
        yield start, min(start + _BLOCK, design.row_count)


def _points(design: Design) -> Iterator[dict[str, float]]:
    names = [axis.parameter for axis in design.axes]
    for block in _blocks(design):
        yield from (dict(zip(names, row, strict=True)) for row in design.rows(*block).tolist())


def _check_axes(scene: Scene, design: Design) -> None:
    """Raise `UsageError`, with one sentence, for an axis that nothing reads or that leaves its parameter's range."""
    for swept in design.axes:
        parameter = all_parameters()[swept.parameter]
        extremes = (float(swept.values.min()), float(swept.values.max()))
        outside = [number for number in extremes if not parameter.low <= number <= parameter.high]
        if outside or swept.parameter not in scene.read:
            scene.changed({swept.parameter: (outside or extremes)[0]})  # which refuses it in the scene's own words
