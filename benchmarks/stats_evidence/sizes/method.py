"""A method under test, and how often it errs on a design."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from benchmarks.stats_evidence.sizes.design import Design, Floats, Groups, draw
from data_schema.vocabulary import Undefined

BATCH = 2000
"""Studies drawn at a time: fewer runs are the first of more."""
MOST_RUNS = 20_000
ALPHA, LEVEL = 0.05, 0.95

Kind = Literal["size", "coverage"]
_T = TypeVar("_T")


def never(_design: Design) -> bool:
    """Say that a method has no exact size or coverage."""
    return False


def alike(design: Design) -> bool:
    """Say that a method is exact for normal values of one SD that no day moves."""
    return design.normal_and_alike and design.no_day_moves


@dataclass(frozen=True, slots=True)
class Method:
    """A test, or an interval of a true value that is known."""

    name: str
    kind: Kind
    designs: tuple[Design, ...]
    one: Callable[[Groups, Design], Sequence[float]]
    """What the library's function says of one study: p or the interval's ends or a statistic, then whether it errs."""
    many: Callable[[Groups, Design], Floats] | None = None
    """The same of many studies at once, shape (runs, as many); None where only the library's function will do."""
    exact: Callable[[Design], bool] = never
    """Whether its size or coverage is the nominal one on a design."""
    runs: int = MOST_RUNS

    @property
    def nominal(self) -> float:
        """The size or coverage stated."""
        return ALPHA if self.kind == "size" else LEVEL


def seed_of(method: Method, design: Design) -> int:
    """Return the seed of a row of the record, another for each."""
    return zlib.crc32(f"{method.name} {design}".encode())


def studies(groups: Groups) -> Iterator[list[Floats]]:
    """Return the groups of each study."""
    for run in range(len(groups[0])):
        yield [group[run] for group in groups]


def said_of(method: Method, groups: Groups, design: Design) -> Floats:
    """Return what a method says of each study, shape (runs, columns); the last column is whether it errs."""
    if method.many is not None:
        return method.many(groups, design)
    return np.array([method.one(study, design) for study in studies(groups)], dtype=np.float64)


def simulated(method: Method, design: Design, runs: int, seed: int) -> float:
    """Return the share of studies in which a test rejects or an interval covers."""
    rng = np.random.default_rng(seed)
    wrong = 0.0
    for start in range(0, runs, BATCH):
        groups = draw(design, min(BATCH, runs - start), rng)
        wrong += float(said_of(method, groups, design)[:, -1].sum())
    return (wrong if method.kind == "size" else runs - wrong) / runs


def standard_error(value: float, runs: int) -> float:
    """Return the Monte-Carlo error of a share; that of one run in all where the share is 0 or 1."""
    return math.sqrt(max(value * (1.0 - value), 1.0 / runs) / runs)


def columns(*parts: Floats | NDArray[np.bool_]) -> Floats:
    """Return values by study side by side, shape (runs, columns)."""
    return np.column_stack(parts).astype(np.float64)


def of_p(p: Floats) -> Floats:
    """Return p and whether it rejects."""
    return columns(p, p <= ALPHA)


def of_interval(low: Floats, high: Floats, truth: float) -> Floats:
    """Return both ends and whether they miss the truth."""
    return columns(low, high, ~((low <= truth) & (truth <= high)))


def there(found: _T | Undefined) -> _T:
    """Return a result of the library that every study drawn here has; raises `ValueError` where it is undefined."""
    if isinstance(found, Undefined):
        raise ValueError(found.reason)
    return found


def number(value: float | Undefined) -> float:
    """Return a number of the library that every study drawn here has; raises `ValueError` where it is undefined."""
    return float(there(value))


def of_one_p(p: float | Undefined) -> tuple[float, bool]:
    """Return one p of the library and whether it rejects; what is undefined rejects nothing."""
    return (1.0, False) if isinstance(p, Undefined) else (p, p <= ALPHA)


def of_one_interval(ends: tuple[float, float] | Undefined, truth: float) -> tuple[float, float, bool]:
    """Return one interval of the library and whether it misses; an undefined one excludes nothing."""
    low, high = (-math.inf, math.inf) if isinstance(ends, Undefined) else ends
    return low, high, not low <= truth <= high
