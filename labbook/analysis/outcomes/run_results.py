"""What an outcome of runs comes to: a stored result a run, and why other runs have none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

from labbook.analysis.results.codec import StoredResult

T_co = TypeVar("T_co", bound=StoredResult, covariant=True)


@dataclass(frozen=True, slots=True)
class RunResults(Generic[T_co]):
    """Stored results by run uid, and why other runs have none."""

    results: Mapping[str, T_co]
    missing: Mapping[str, str]
