"""Numbers as reports carry them: value or reason, unit, uncertainty, n, provenance; and the base of results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, TypeAlias

from data_schema.reasons import Reason
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

    @property
    def known(self) -> float | None:
        """The value, None where it does not exist."""
        return None if isinstance(self.value, Undefined) else self.value

    @property
    def interval(self) -> tuple[float, float] | None:
        """Both ends of the interval, None where it has none."""
        low, high = self.ci_low, self.ci_high
        return (low, high) if isinstance(low, int | float) and isinstance(high, int | float) else None

    @property
    def side(self) -> int | None:
        """The sign of the number where its interval excludes 0, else 0; None where it has no interval."""
        return None if self.interval is None else (self.interval[0] > 0.0) - (self.interval[1] < 0.0)

    def named(self, provenance: str) -> Number:
        """Return the same under an id; in full, for every number of a report passes here."""
        return Number(
            self.value,
            self.unit,
            self.se,
            self.shared_se,
            self.ci_low,
            self.ci_high,
            self.ci_level,
            self.df,
            self.n,
            provenance,
        )

    def called(self, names: Mapping[str, str], unit: str) -> Number:
        """Return the same with other names of groups and values in its reasons, as `Undefined.called` has them."""
        parts = {one.name: getattr(self, one.name) for one in fields(self)}
        reasons: dict[str, Any] = {
            name: part.called(names, unit) for name, part in parts.items() if isinstance(part, Undefined)
        }
        return replace(self, **reasons)


@dataclass(frozen=True, slots=True)
class SignificanceTest:
    """A test: `df` has one entry for t, two for F; `one_sided` where p is against a saving alone."""

    name: str
    statistic: Value
    df: tuple[Value, ...]
    p: Value
    one_sided: bool = False


_NO_DF = Undefined(Reason.NORMAL)
"""Degrees of freedom of a test against the normal distribution."""


def t_test(name: str, t: Number, p: Number, *, one_sided: bool = False) -> SignificanceTest:
    """Return a test of its statistic, with degrees of freedom, and its p."""
    none = t.value if isinstance(t.value, Undefined) else _NO_DF
    return SignificanceTest(name, t.value, (none if t.df is None else t.df,), p.value, one_sided)


@dataclass(frozen=True, slots=True)
class Origin:
    """Which result something is: its key, what computed it, what it is about (`scope`), and what it came from."""

    key: str = ""
    kind: str = ""
    version: int = 0
    scope: Mapping[str, Any] = field(default_factory=dict)
    inputs: tuple[Any, ...] = ()

    @property
    def uid(self) -> str:
        """The name of the result as an input of others."""
        return self.key[:16]


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """Base of all results with numbers; `origin` is empty until they have their ids."""

    origin: Origin = field(default_factory=Origin, repr=False)


@dataclass(frozen=True, slots=True)
class NumberNames:
    """Annotates a field whose number has another name than it, or a mapping of numbers: "{}" is each one's key."""

    template: str
