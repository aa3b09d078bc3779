"""The reference result that is stored of a scene, if any: the same effects, with the same numbers.

`references/SCENE.toml` hold results of more than thirty digits by an independent program, which writes them
(`benchmarks/reference_simulator` of the source tree).
"""

from __future__ import annotations

import importlib.resources
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

from simulator.accuracy.outputs import NAMES
from simulator.scene import Scene

SAME = 1e-14
"""Relative difference under which a double stands for a rational number."""
_BESIDE = frozenset({"drag", "passive_draw"})
"""Effects that change no motion: drag is stored apart, the passive draw is not compared."""


@dataclass(frozen=True, slots=True)
class StoredReference:
    """The outputs of a scene's last jump, None where it has none: where they are from and how many digits agree."""

    source: str
    agreeing_digits: int
    outcome: str
    values: Mapping[str, float | None]


def stored_reference(scene: Scene) -> StoredReference | None:
    """Find the stored result of a scene's last jump; None where no case has its effects and its numbers."""
    for name, case in _cases():
        if len(case["jump"]) < scene.jumps or not _is_of(scene, case["scene"]):
            continue
        jump = case["jump"][scene.jumps - 1]
        cost_j = Fraction(jump["cost_j"]) + (Fraction(jump["drag_j"]) if "drag" in scene.effects else 0)
        numbers = {**jump, "cost_J": cost_j}
        return StoredReference(
            source=f"stored case “{case['name']}” of {name}, Taylor series to {case['agreeing_digits']} digits",
            agreeing_digits=case["agreeing_digits"],
            outcome=jump["outcome"],
            values={output: float(numbers[output]) if output in numbers else None for output in NAMES},
        )
    return None


@cache
def _cases() -> tuple[tuple[str, dict[str, Any]], ...]:
    return tuple(_read())


def _read() -> Iterator[tuple[str, dict[str, Any]]]:
    folder = importlib.resources.files("simulator.accuracy") / "references"
    for file in sorted(folder.iterdir(), key=lambda file: file.name):
        document = tomllib.loads(file.read_text(encoding="utf-8"))
        yield from ((document["scene"], case) for case in document["case"] if "scene" in case)


def _is_of(scene: Scene, stored: Mapping[str, Any]) -> bool:
    numbers = stored["values"]
    beside = _BESIDE if Fraction(numbers["b_ad"]) else _BESIDE | {"active_damping"}
    return frozenset(stored["effects"]) - beside == scene.effects - beside and all(
        name in numbers and abs(scene[name] - float(Fraction(numbers[name]))) <= SAME * abs(scene[name])
        for name in scene.read
        if name != "passive_power"
    )
