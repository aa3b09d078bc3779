"""How often each test rejects and each interval covers on designs that reports meet, as simulated.

`recorded.csv` beside this module has a row for each design and a column for each method, headed by what its shares
are: `size_welch` is the share of studies without an effect in which Welch's test at level 0.05 rejects (for tests of
equivalence: of studies whose true difference lies on a bound), `coverage_fieller` the share of studies in which
Fieller's interval at level 0.95 holds the truth. Of each method at given sizes and days only the ratio of standard
deviations at which it is worst is there; all that was simulated is in docs/statistics/error_rates.csv.
"""

from __future__ import annotations

import csv
import importlib.resources
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

from stats.compare.shared_error import ENOUGH_DEGREES

FILE = importlib.resources.files("stats.planning") / "recorded.csv"
DESIGN = ("n", "sd_ratio", "days", "day_sd", "layout", "distribution", "runs")
"""Columns that describe a design; all others are methods."""
SIZE, COVERAGE = "size", "coverage"
NOMINAL = {SIZE: 0.05, COVERAGE: 0.95}
MOST_SIZE, LEAST_COVERAGE = 0.06, 0.93
"""A method is weak where it lies beyond these by more than `ERRORS` Monte-Carlo errors."""
ERRORS = 2.0
SEVERAL = 3
"""So many groups, and more, are looked up alike."""
WITH_LINE = "_shared"
"""Ends the name of a method that counts the error of a line through idle runs, which all values are corrected with; the
last of `n` is then the number of these runs, which scatter as the last group does."""


@dataclass(frozen=True, slots=True)
class Recorded:
    """One method on one design, simulated."""

    method: str
    kind: str
    """`SIZE` or `COVERAGE`."""
    n: tuple[int, ...]
    """Number of values of each group, over all days; last that of the idle runs, if the method is one `WITH_LINE`."""
    value: float
    """The share of studies in which the test rejects or the interval holds the truth."""
    runs: int
    """Number of simulated studies."""
    sd_ratio: float = 1.0
    """SD of the first group over that of the last; those between lie on equal ratios. Of a line, SD at its end over
    that at its start."""
    days: int | None = None
    """Days that each group was measured on; None where there are no days."""
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
    def nominal(self) -> float:
        """Level of the test, or of the interval."""
        return NOMINAL[self.kind]

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
    def excess(self) -> float:
        """How far the size is above or the coverage below the nominal one; negative where the method is cautious."""
        return self.value - self.nominal if self.kind == SIZE else self.nominal - self.value

    @property
    def weak(self) -> bool:
        """Whether the size is above 0.06 or the coverage below 0.93, by more than chance in drawing explains."""
        margin = ERRORS * self.standard_error
        return self.value - margin > MOST_SIZE if self.kind == SIZE else self.value + margin < LEAST_COVERAGE


@lru_cache(maxsize=1)
def records() -> tuple[Recorded, ...]:
    """Return what is on record for reports, design by design."""
    return tuple(read(FILE.read_text(encoding="utf-8")))


def read(text: str) -> Iterator[Recorded]:
    """Read a table of designs and methods.

    Parameters
    ----------
    text
        CSV with the columns `DESIGN` and one for each method; an empty cell is a method not simulated there.

    Yields
    ------
    Recorded
        One for each cell that holds a share, row by row.

    """
    for fields in csv.DictReader(text.splitlines()):
        for column, value in fields.items():
            if value and column not in DESIGN:
                kind, _, method = column.partition("_")
                yield Recorded(
                    method=method,
                    kind=kind,
                    n=tuple(map(int, fields["n"].split())),
                    value=float(value),
                    runs=int(fields["runs"]),
                    sd_ratio=float(fields["sd_ratio"]),
                    days=int(fields["days"]) if fields["days"] else None,
                    day_sd=float(fields["day_sd"]) if fields["day_sd"] else None,
                    layout=fields["layout"],
                    distribution=fields["distribution"],
                )


@lru_cache(maxsize=4096)
def weak_point(
    method: str, n: tuple[int, ...], layout: str = "", days: int | None = None, *, idle_runs: int = 0
) -> Recorded | None:
    """Return the worst on record of a method at the design nearest to one's own.

    Nearest is first by days, then by the ratios of smallest and largest group, of how many times one is as large as
    the other, and of the number of groups; two groups are looked up among two, several among several.

    Parameters
    ----------
    method
        Its name on record.
    n
        Number of values of each group, over all days.
    layout
        How groups share their days, as in `Recorded.layout`; empty looks designs without days up.
    days
        Days of each group; None without days.
    idle_runs
        Runs of the line that the values are corrected with, where the method's name says that its error is counted:
        five and fewer are looked up apart from more, as errors are then joined in another way.

    Returns
    -------
    Recorded or None
        None where the method errs at most 0.06 and covers at least 0.93 there, or is not on record.

    """
    rows = _looked_up().get((method, layout, min(len(n), SEVERAL)), ())
    if not rows or not n or min(n) < 1:
        return None
    apart = [_distance(row, n, days, idle_runs) for row in rows]
    least = min(apart)
    weak = (row for row, distance in zip(rows, apart, strict=True) if distance == least and row.weak)
    return max(weak, key=lambda row: row.excess, default=None)


@lru_cache(maxsize=1)
def _looked_up() -> dict[tuple[str, str, int], list[Recorded]]:
    """Return the rows of each method and layout, of one group, two and several."""
    found: dict[tuple[str, str, int], list[Recorded]] = {}
    for row in records():
        found.setdefault((row.method, row.layout, min(len(row.groups), SEVERAL)), []).append(row)
    return found


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
