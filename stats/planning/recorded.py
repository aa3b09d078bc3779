"""Size and coverage as simulated: how often each test errs and each interval covers where that is not as stated.

`recorded.csv` beside this module holds the shares of studies without an effect in which a test of level 0.05 rejects
(of equivalence: of studies whose true difference lies on a bound), and of studies in which an interval of level 0.95
holds the truth, by method and design; how each was simulated stands in docs/statistics.md.
"""

from __future__ import annotations

import csv
import importlib.resources
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from stats.compare.shared_error import ENOUGH_DEGREES

FILE = importlib.resources.files("stats") / "recorded.csv"
COLUMNS = (
    "method",
    "kind",
    "n",
    "sd_ratio",
    "days",
    "day_sd",
    "layout",
    "distribution",
    "nominal",
    "value",
    "standard_error",
    "runs",
    "seed",
)
MOST_SIZE, LEAST_COVERAGE = 0.06, 0.93
"""Beyond these by more than `ERRORS` Monte-Carlo errors a report says so."""
ERRORS = 2.0
SEVERAL = 3
"""So many groups, and more, are alike here."""
WITH_LINE = "_shared"
"""Ends the name of a method that counts the error of a line through idle runs, which all values are corrected with; the
last of `n` is then the number of these runs, which scatter as the last group does."""


@dataclass(frozen=True, slots=True)
class Recorded:
    """One method on one design, simulated."""

    method: str
    kind: str
    """"size": share of studies without an effect, or with one on the bound of equivalence, in which the test rejects;
    "coverage": share of intervals with the truth."""
    n: tuple[int, ...]
    """Number of values of each group, over all days; last that of the idle runs, if the method is one `WITH_LINE`."""
    sd_ratio: float
    """SD of the first group over that of the last; those between lie on equal ratios. Of a line, SD at its end over
    that at its start."""
    days: int | None
    """Days that each group was measured on; None where there are no days."""
    nominal: float
    """Level of the test, or of the interval."""
    value: float
    runs: int
    """Number of simulated studies; the Monte-Carlo error is sqrt(value (1 - value) / runs)."""
    day_sd: float | None = None
    """SD between days in SDs of the last group's values; None where there are no days."""
    layout: str = ""
    """"shared" where all groups share their days, "own" where each has days of its own, "partly" where they share the
    first and each has others of its own, "mostly" where they share all but the last; of shared days "holes" where
    values are missing, "runs" where each group has two runs a day; empty without days."""
    distribution: str = "normal"
    """Of the values: normal, t5, t3, exponential or uniform; "lag1 0.5" are normal ones with that correlation of
    neighbours."""

    @property
    def idle_runs(self) -> int:
        """How many idle runs the line goes through that all values are corrected with; 0 of a method that is not one
        `WITH_LINE` (a method named after its idle runs has as many in all designs)."""
        return self.n[-1] if self.method.endswith(WITH_LINE) else 0

    @property
    def groups(self) -> tuple[int, ...]:
        """Number of values of each group, the idle runs left out."""
        return self.n[:-1] if self.idle_runs else self.n

    @property
    def standard_error(self) -> float:
        """Monte-Carlo error of the share."""
        return math.sqrt(self.value * (1.0 - self.value) / self.runs)

    @property
    def weak(self) -> bool:
        """Whether the size is above 0.06 or the coverage below 0.93, by more than chance in drawing explains."""
        margin = ERRORS * self.standard_error
        return self.value - margin > MOST_SIZE if self.kind == "size" else self.value + margin < LEAST_COVERAGE


@lru_cache(maxsize=1)
def recorded() -> tuple[Recorded, ...]:
    """Return all rows, in the order of the file."""
    return tuple(map(_row, csv.DictReader(FILE.read_text(encoding="utf-8").splitlines())))


def weak_points(
    method: str,
    n: Sequence[int],
    days: int | None = None,
    *,
    layout: str | None = None,
    distribution: str = "normal",
    idle_runs: int = 0,
) -> tuple[Recorded, ...]:
    """Return where a method errs more than 0.06 or covers less than 0.93, at the recorded sizes nearest to `n`.

    `n` holds the number of values of each group; with `days`, rows simulated over the nearest number of days are
    meant, otherwise rows without days where there are any. Nearest is by the ratios of smallest and largest group, of
    how many times one is as large as the other, and of the number of groups; two groups are looked up among two,
    several among several. `idle_runs` counts those of the line that the values are corrected with, where the method's
    name says that its error is in it: five and fewer are looked up apart from more, as errors are then joined in
    another way. Empty where the method holds what it states there, or is none of those recorded.
    """
    rows = [
        row
        for row in recorded()
        if row.method == method
        and row.distribution == distribution
        and layout in (None, row.layout)
        and min(len(row.groups), SEVERAL) == min(len(n), SEVERAL)
    ]
    if days is None:
        rows = [row for row in rows if row.days is None] or rows
    else:
        rows = [row for row in rows if row.days is not None] or rows
    if not rows or not n or min(n) < 1:
        return ()
    least = min(_distance(row, n, days, idle_runs) for row in rows)
    return tuple(row for row in rows if row.weak and _distance(row, n, days, idle_runs) == least)


def _distance(row: Recorded, n: Sequence[int], days: int | None, idle_runs: int) -> tuple[float, float, float]:
    """Return how far apart designs are: errors joined in another way, then days, then sizes and number of groups."""
    lines = bool(idle_runs and row.idle_runs)
    other_way = lines and _one_quantile(idle_runs) != _one_quantile(row.idle_runs)
    apart = 0.0 if days is None or row.days is None else abs(row.days - days)
    least, most = (min(row.groups), min(n)), (max(row.groups), max(n))
    unequal = most[0] / least[0], most[1] / least[1]
    sizes: list[tuple[float, float]] = [least, most, unequal, (len(row.groups), len(n))]
    if lines:
        sizes.append((row.idle_runs, idle_runs))
    return float(other_way), apart, math.fsum(abs(math.log(one / other)) for one, other in sizes)


def _one_quantile(idle_runs: int) -> bool:
    """Whether scatter and the line's error have one quantile (`stats.compare.shared_error.joints`)."""
    return idle_runs - 2 >= ENOUGH_DEGREES


def _row(fields: dict[str, str]) -> Recorded:
    return Recorded(
        method=fields["method"],
        kind=fields["kind"],
        n=tuple(map(int, fields["n"].split())),
        sd_ratio=float(fields["sd_ratio"]),
        days=int(fields["days"]) if fields["days"] else None,
        nominal=float(fields["nominal"]),
        value=float(fields["value"]),
        runs=int(fields["runs"]),
        day_sd=float(fields["day_sd"]) if fields["day_sd"] else None,
        layout=fields["layout"],
        distribution=fields["distribution"],
    )
