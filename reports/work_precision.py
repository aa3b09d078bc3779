"""What accuracy costs, as its figure draws it: for each output of a jump, each method's error against its time."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Mark:
    """One method at one setting: how long it took, s, and the relative error that it made."""

    setting: str
    seconds: float
    error: float


@dataclass(frozen=True, slots=True)
class Curve:
    """One method's marks, from its coarsest setting to its finest; `setting` says what is set."""

    method: str
    setting: str
    marks: tuple[Mark, ...]


@dataclass(frozen=True, slots=True)
class Panel:
    """One output; under `floor`, a relative error, nothing is claimed."""

    output: str
    floor: float
    curves: tuple[Curve, ...]


@dataclass(frozen=True, slots=True)
class WorkPrecision:
    """All panels of a scene.

    `methods` names all, in the order of their looks; `notes` say against what errors are, on what machine times were
    taken, and which methods or settings are not drawn, and why.
    """

    title: str
    methods: tuple[str, ...]
    panels: tuple[Panel, ...]
    notes: tuple[str, ...] = ()
