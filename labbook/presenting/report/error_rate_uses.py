"""What a report used on which design: tests and intervals of comparisons, analyses of variance and drain lines."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparisons import Compared
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.study import StudyAnalysis
from labbook.config.model import UnitOfAnalysis
from labbook.presenting.report.day_layout import MOSTLY, OWN, PARTLY, Runs, with_days, without_days
from reports.numbers import Number
from stats.days.blocked_result import MIXED_MODEL
from stats.planning.recorded import WITH_LINE, Recorded, weak_point

_WITH_LINE = ("f_then_t", "difference_ci_f_then_t", "welch", "difference_ci_welch", "fieller")
"""What takes the error of the passive-drain line into account."""
_MIXED = ("blocked_by_day", "blocked_by_day_ci")
_EXACT = ("blocked_by_day_exact", "blocked_by_day_exact_ci")
_BY_DAY = (*_MIXED, *_EXACT)
_LAST_QUARTER, _FIRST_QUARTER = 0.75, 0.25
"""Of the durations of the idle runs, from where on a drain is read as at the longest one, and as in their middle."""


@dataclass(frozen=True, slots=True)
class Use:
    """A method and a design that it was used on.

    `n` counts what was tested of each group, runs or day means; `days` and `layout` are those of the design on record
    that stands for how groups share their days (`day_layout`). Day means have neither: a day is one value. `tested` are
    the groups' own sizes where that design has others: groups of unequal size err whatever their days are. `idle_runs`
    counts those of the line whose error is in the result, 0 where there is none: how large it is is not known, so that
    what is known without a line counts, too.
    """

    method: str
    n: tuple[int, ...]
    days: int | None = None
    layout: str = ""
    tested: tuple[int, ...] = ()
    idle_runs: int = 0

    def weak_points(self) -> tuple[Recorded, ...]:
        """Return the worst on record of the method at such designs; days matter where groups do not share them all."""
        by_day = self.method in _BY_DAY
        found: list[Recorded | None] = []
        if by_day or self.layout in (OWN, PARTLY, MOSTLY):
            found.append(weak_point(self.method, self.n, self.layout, self.days))
        if not by_day:
            tested = self.tested or self.n
            found.append(weak_point(self.method, tested))
            if self.idle_runs:
                found.append(weak_point(f"{self.method}{WITH_LINE}", tested, idle_runs=self.idle_runs))
        return tuple(row for row in found if row is not None)


def uses(analysis: StudyAnalysis) -> Counter[Use]:
    """Return how often the report used which method on which design."""
    return Counter((*_of_comparisons(analysis), *_of_anovas(analysis), *_of_drains(analysis)))


def _of_comparisons(analysis: StudyAnalysis) -> Iterator[Use]:
    for item in analysis.compared:
        sides = (item.pair.a, item.pair.b)
        for method in _methods(analysis, item):
            idle_runs = _idle_runs(analysis, item, method) if method in _WITH_LINE else 0
            if method in _BY_DAY or not _on_day_means(analysis):  # by day it is runs, whatever the other tests are on
                yield replace(on_runs(method, _by_day(sides)), idle_runs=idle_runs)
            else:
                yield Use(method, (item.result.n_a, item.result.n_b), idle_runs=idle_runs)


def _idle_runs(analysis: StudyAnalysis, item: Compared, method: str) -> int:
    """Return the idle runs of the line whose error is left in what a method says, the fewest of its robots'; or 0."""
    if not item.quantity.shares_error:
        return 0
    number = item.result.savings if method == "fieller" else item.result.difference
    if number is None or not number.shared_se:
        return 0
    robots = {one.run.robot_uid for side in (item.pair.a, item.pair.b) for condition in side for one in condition.runs}
    lines = [analysis.drains[robot].line for robot in robots if robot in analysis.drains]
    return min((line.n for line in lines if not isinstance(line, Undefined)), default=0)


def _on_day_means(analysis: StudyAnalysis) -> bool:
    return analysis.planned.settings.unit_of_analysis is UnitOfAnalysis.DAY


def on_runs(method: str, by_day: Runs) -> Use:
    """Return the use of a method on groups of runs, given how many there are of each day."""
    if method in _BY_DAY:
        return Use(method, *with_days(by_day))
    return Use(method, *without_days(method, by_day), tested=tuple(group.total() for group in by_day))


def _by_day(groups: Sequence[Sequence[ConditionValues]]) -> list[Counter[str]]:
    return [Counter(one.run.day for condition in group for one in condition.runs) for group in groups]


def _methods(analysis: StudyAnalysis, item: Compared) -> Iterator[str]:
    result, by_day, equivalent = item.result, item.by_day, item.equivalent
    if _exists(result.t):
        yield from ("f_then_t", "difference_ci_f_then_t")
    if _exists(result.welch_t):
        yield from ("welch", "difference_ci_welch")
    if _exists(result.brown_forsythe):
        yield "brown_forsythe"
    if by_day is not None and _exists(by_day.t):
        yield from _MIXED if by_day.method == MIXED_MODEL else _EXACT
    bounds = analysis.planned.settings.apex_bounds
    if bounds is not None and equivalent is not None and _exists(equivalent.p):
        yield "equivalence_percent" if bounds.percent else "equivalence"
    if result.savings is not None and isinstance(result.savings.ci_low, float):
        yield "fieller"


def _exists(number: Number) -> bool:
    return not isinstance(number.value, Undefined)


def _of_anovas(analysis: StudyAnalysis) -> Iterator[Use]:
    for item in analysis.anovas:
        levels = [(one,) for one in analysis.levels_of(item)]
        if _on_day_means(analysis):
            yield Use("one_way_anova", tuple(map(len, _by_day(levels))))
        else:
            yield on_runs("one_way_anova", _by_day(levels))


def _of_drains(analysis: StudyAnalysis) -> Iterator[Use]:
    """Return the line's slope and intercept, and the line where the runs that are corrected with it last."""
    duration_s = analysis.evidence.configuration.protocol.run_duration_s
    for drain in analysis.drains.values():
        line = drain.line
        if isinstance(line, Undefined):
            continue
        read = ["slope", "intercept"]
        if duration_s is not None:
            along = (duration_s - line.duration_min_s) / (line.duration_max_s - line.duration_min_s)
            read += ["at"] if along > _LAST_QUARTER else ["middle"] if along > _FIRST_QUARTER else []
        yield from (Use(f"passive_drain_{of}_ci", (line.n,)) for of in read)
