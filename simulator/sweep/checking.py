"""Whether every value that a sweep gives to a parameter can be, and what the rules between parameters read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from simulator.declared import all_parameters
from simulator.scene import Scene
from simulator.scene_rules import Rule
from simulator.sweep.axis import Axis
from simulator.sweep.design import Design


def check_axes(scene: Scene, design: Design) -> None:
    """Raise `UsageError`, with one sentence, for an axis that nothing reads or that leaves its parameter's range."""
    for swept in design.axes:
        _check_axis(scene, swept)


def _check_axis(scene: Scene, swept: Axis) -> None:
    parameter = all_parameters()[swept.parameter]
    extremes = (float(swept.values.min()), float(swept.values.max()))
    outside = [number for number in extremes if not parameter.low <= number <= parameter.high]
    if outside or swept.parameter not in scene.read:
        scene.changed({swept.parameter: (outside or extremes)[0]})  # which refuses it in the scene's own words


class _Watched(Mapping[str, float]):
    """Values that remember which of them were read."""

    def __init__(self, values: Mapping[str, float]) -> None:
        self.values_, self.read = values, set[str]()

    def __getitem__(self, name: str) -> float:
        self.read.add(name)
        return self.values_[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.values_)

    def __len__(self) -> int:
        return len(self.values_)


def rule_reads(rule: Rule, values: Mapping[str, float]) -> frozenset[str]:
    """Return the parameters that a rule reads; a rule reads the same ones whatever their values."""
    watched = _Watched(values)
    rule.fault(watched)
    return frozenset(watched.read)
