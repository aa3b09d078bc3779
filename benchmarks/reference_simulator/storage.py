"""Stored reference results, one TOML file a scene: written by `regenerate`, read by `stored`."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields, replace
from decimal import Context, Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

from benchmarks.reference_simulator.cases import CASES, ReferenceCase, cases
from benchmarks.reference_simulator.result import ModeChange, ReferenceResult

DATA = Path(__file__).parents[2] / "simulator" / "accuracy" / "references"
STORED_DIGITS = 36
# A case is computed twice, with different working precision and different order of the series.
COARSE_DIGITS, COARSE_ORDER = 38, 28
FINE_DIGITS, FINE_ORDER = 48, 36


@dataclass(frozen=True, slots=True)
class StoredCase:
    """A case as stored; `agreeing_digits` is on how many digits both computations of every number agree."""

    name: str
    agreeing_digits: int
    jumps: tuple[ReferenceResult, ...]


def regenerate(scenes: Iterable[str] = tuple(CASES), folder: Path = DATA) -> None:
    """Compute the cases of the scenes anew and write their files; about thirteen minutes for all on one core."""
    for scene in scenes:
        found = []
        for case in cases(scene):
            coarse, fine = case.compute(COARSE_DIGITS, COARSE_ORDER), case.compute(FINE_DIGITS, FINE_ORDER)
            jumps = tuple(_shortened(jump) for jump in fine)
            found.append(StoredCase(case.name, agreeing_digits(coarse, fine), jumps))
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{scene}.toml").write_text(document(scene, found), encoding="utf-8")


def stored(scene: str, folder: Path = DATA) -> tuple[StoredCase, ...]:
    """The stored cases of a scene; UnknownName if it has none."""
    cases(scene)
    document = tomllib.loads((folder / f"{scene}.toml").read_text(encoding="utf-8"))
    return tuple(
        StoredCase(table["name"], table["agreeing_digits"], tuple(map(_jump, table["jump"])))
        for table in document["case"]
    )


def agreeing_digits(first: tuple[ReferenceResult, ...], second: tuple[ReferenceResult, ...]) -> int:
    """On how many significant digits two computations agree in all their numbers; 0 if their events differ."""
    agreement = STORED_DIGITS
    for one, other in zip(first, second, strict=True):
        if one.outcome != other.outcome or _modes(one) != _modes(other):
            return 0
        for left, right in zip(_numbers(one), _numbers(other), strict=True):
            if left != right:
                scale = max(abs(left), abs(right))
                agreement = min(agreement, -(abs(left - right) / scale).adjusted() - 1)
    return agreement


def _modes(result: ReferenceResult) -> list[str]:
    return [change.mode for change in result.mode_changes]


def _numbers(result: ReferenceResult) -> list[Decimal]:
    """Every number of a result but the energy residual, which is rounding alone."""
    values = [getattr(result, field.name) for field in fields(result) if field.name != "energy_residual_j"]
    return [value for value in values if isinstance(value, Decimal)] + [c.time_s for c in result.mode_changes]


def _shortened(result: ReferenceResult) -> ReferenceResult:
    """The result rounded to the digits that are stored."""
    context = Context(prec=STORED_DIGITS)
    numbers = {field.name: getattr(result, field.name) for field in fields(result)}
    rounded: dict[str, Any] = {
        name: context.plus(value) for name, value in numbers.items() if isinstance(value, Decimal)
    }
    rounded["energy_residual_j"] = Context(prec=2).plus(result.energy_residual_j)
    changes = tuple(ModeChange(context.plus(change.time_s), change.mode) for change in result.mode_changes)
    return replace(result, mode_changes=changes, **rounded)


def document(scene: str, found: Iterable[StoredCase]) -> str:
    """The text of a scene's file; `found` are all its cases."""
    return "\n".join(_lines(scene, found)) + "\n"


def _lines(scene: str, found: Iterable[StoredCase]) -> Iterator[str]:
    yield f"# Reference results of {scene}: Taylor series in fixed-point numbers, by benchmarks.reference_simulator."
    yield f"# Computed with {COARSE_DIGITS} digits at order {COARSE_ORDER} and {FINE_DIGITS} at order {FINE_ORDER}; SI."
    yield f'scene = "{scene}"'
    for case, one in zip(cases(scene), found, strict=True):
        yield from ("", "[[case]]", f'name = "{one.name}"', f"agreeing_digits = {one.agreeing_digits}")
        if case.is_scene:
            yield from _scene(case)
        for jump in one.jumps:
            yield from ("", "[[case.jump]]")
            yield from _entries(jump)


def _scene(case: ReferenceCase) -> Iterator[str]:
    """The case in the words of the simulator's scenes: what results are found by."""
    yield from ("", "[case.scene]", f"effects = {json.dumps(sorted(case.effects))}", "", "[case.scene.values]")
    yield from (f'{name} = "{_plain(value)}"' for name, value in case.values.items())


def _entries(jump: ReferenceResult) -> Iterator[str]:
    """A jump as TOML; what is None is left out."""
    for field in fields(jump):
        value = getattr(jump, field.name)
        if isinstance(value, tuple):
            yield f"{field.name} = ["
            yield from (f'  ["{change.time_s}", "{change.mode}"],' for change in value)
            yield "]"
        elif value is not None:
            yield f'{field.name} = "{value}"'


def _plain(value: Fraction) -> str:
    """A fraction as a decimal where it is one exactly."""
    decimal = Decimal(value.numerator) / Decimal(value.denominator)
    return f"{decimal:f}" if Fraction(decimal) == value else str(value)


def _jump(table: dict[str, Any]) -> ReferenceResult:
    values: dict[str, Any] = {field.name: None for field in fields(ReferenceResult)}
    values |= {name: Decimal(text) for name, text in table.items() if name not in ("outcome", "mode_changes")}
    values["outcome"] = table["outcome"]
    values["mode_changes"] = tuple(ModeChange(Decimal(time), mode) for time, mode in table["mode_changes"])
    return ReferenceResult(**values)
