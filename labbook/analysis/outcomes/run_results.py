"""What an outcome of runs comes to: a stored result a run, and why other runs have none."""

from __future__ import annotations

from dataclasses import dataclass

from data_schema.queries.results import ResultRow


@dataclass(frozen=True, slots=True)
class RunResults:
    """Stored results by run uid, and why other runs have none."""

    results: dict[str, ResultRow]
    missing: dict[str, str]
