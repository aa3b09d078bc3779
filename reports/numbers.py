"""A number as a report carries it: value or reason, unit, uncertainty, n, provenance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from data_schema.vocabulary import Undefined

Value: TypeAlias = float | Undefined
"""A number, or the reason why there is none."""


@dataclass(frozen=True, slots=True)
class Number:
    """A number as it is reported: value, uncertainty and where it came from.

    `value`, `se`, `shared_se` and the interval are in `unit` ("J", "m", "mAh", "mAh/min", "%"; with "%", 15.2
    stands for 15.2 %). `se` is the independent part, `shared_se` the part common to several runs, of one
    passive-drain fit or one calibration. An interval that does not exist (Fieller, unbounded) is `Undefined` on both
    sides.
    """

    value: Value
    unit: str
    se: Value | None = None
    shared_se: Value | None = None
    ci_low: Value | None = None
    ci_high: Value | None = None
    ci_level: float = 0.95
    df: Value | None = None
    n: int | None = None
    provenance: str = ""


@dataclass(frozen=True, slots=True)
class SignificanceTest:
    """A test: `df` has one entry for t, two for F; `one_sided` where p is against a saving alone."""

    name: str
    statistic: Value
    df: tuple[Value, ...]
    p: Value
    one_sided: bool = False
