"""Which methods a report used on which designs, and where one is known to err more often than it states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparisons import Compared
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.study import StudyAnalysis
from labbook.config.model import UnitOfAnalysis
from labbook.presenting.report.day_layout import MOSTLY, OWN, PARTLY, WHOSE, Runs, with_days, without_days
from reports.display import count_text, general_text, given_text, list_text
from reports.numbers import Number
from stats.planning.recorded import SIZE, WITH_LINE, Recorded, weak_point

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
        by_day = _by_day((item.pair.a, item.pair.b))
        for method in _methods(analysis, item):
            idle_runs = _idle_runs(analysis, item, method) if method in _WITH_LINE else 0
            if method in _BY_DAY or not _on_day_means(analysis):  # by day it is runs, whatever the other tests are on
                yield replace(on_runs(method, by_day), idle_runs=idle_runs)
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
    if is_defined(result.t):
        yield from ("f_then_t", "difference_ci_f_then_t")
    if is_defined(result.welch_t):
        yield from ("welch", "difference_ci_welch")
    if is_defined(result.brown_forsythe):
        yield "brown_forsythe"
    if by_day is not None and is_defined(by_day.t):
        yield from _MIXED if by_day.counted is None else _EXACT
    bounds = analysis.planned.settings.apex_bounds
    if bounds is not None and equivalent is not None and is_defined(equivalent.p):
        yield "equivalence_percent" if bounds.percent else "equivalence"
    if result.savings is not None and isinstance(result.savings.ci_low, float):
        yield "fieller"


def is_defined(number: Number) -> bool:
    """Whether a number is defined."""
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
    for drain in analysis.drains.values():
        line, duration_s = drain.line, drain.result.run_duration_s
        if isinstance(line, Undefined):
            continue
        read = ["slope", "intercept"]
        if duration_s is not None:
            along = (duration_s - line.duration_min_s) / (line.duration_max_s - line.duration_min_s)
            read += ["at"] if along > _LAST_QUARTER else ["middle"] if along > _FIRST_QUARTER else []
        yield from (Use(f"passive_drain_{of}_ci", (line.n,)) for of in read)


def spreads_text(row: Recorded) -> str:
    """Name the standard deviations of all groups in turn where they differ; they lie on equal ratios."""
    if row.sd_ratio == 1.0:
        return ""
    last = len(row.groups) - 1
    sds = [general_text(row.sd_ratio ** (1.0 - place / last)) for place in range(len(row.groups))]
    return f", should standard deviations be {' : '.join(sds)}"


NAMES = {
    "f_then_t": "the t-test that the F-test chooses",
    "difference_ci_f_then_t": "the interval of the t-test that the F-test chooses",
    "welch": "Welch's t-test",
    "brown_forsythe": "Brown and Forsythe's test",
    "difference_ci_welch": "Welch's interval",
    "blocked_by_day": "the test by day",
    "blocked_by_day_ci": "the interval by day",
    "blocked_by_day_exact": "the exact test by day",
    "blocked_by_day_exact_ci": "the exact test's interval by day",
    "equivalence": "TOST",
    "equivalence_percent": "TOST",
    "fieller": "Fieller's interval",
    "one_way_anova": "the analysis of variance",
    "passive_drain_slope_ci": "the interval of the passive drain",
    "passive_drain_intercept_ci": "the interval of the passive charge at once",
    "passive_drain_middle_ci": "the interval of the passive charge of a run",
    "passive_drain_at_ci": "the interval of the passive charge of a run",
}
"""What is looked up on record, by name of the method, in words."""

_Found = tuple[str, Recorded, int, int]
"""What a method is called, what is on record of it, for how many uses here that is nearest, and how many err less."""


def known_error_rates(used: Mapping[Use, int]) -> tuple[str, ...]:
    """Say for each method used so often, at its worst, how far size or coverage is off; nothing where none is.

    An introduction first, then a sentence for each design on record. Comparisons whose sides do not share their days
    stand apart: there all but the test by day take days for the treatment.
    """
    nearest: dict[tuple[str, str], Counter[Recorded]] = {}
    for use, count in used.items():
        of_use: dict[str, Recorded] = {}
        for row in use.weak_points():
            of_use[row.layout] = max(of_use.get(row.layout, row), row, key=lambda row: row.excess)
        for layout, row in of_use.items():
            nearest.setdefault((use.method, layout), Counter())[row] += count
    if not nearest:
        return ()
    by_design: dict[str, list[_Found]] = {}
    has_days = set()
    for (method, _layout), rows in nearest.items():
        worst = max(rows, key=lambda row: row.excess)
        has_days.add(bool(worst.days))
        found = NAMES[method], worst, rows[worst], rows.total() - rows[worst]
        by_design.setdefault(_design_text(worst), []).append(found)
    sentences = [f"At {design}: {_design_clauses(of_design)}." for design, of_design in by_design.items()]
    head = (
        "Simulated at the sizes and days on record nearest to these (docs/statistics.md), not every method keeps what "
        "it states whatever the standard deviations of runs and days, which so few runs do not tell."
    )
    if len(has_days) > 1:
        head += " Designs without days show what unequal standard deviations do, those with days what days do beside."
    return head, *sentences


def _design_text(row: Recorded) -> str:
    """Say which design on record this was simulated at."""
    if len(row.n) == 1:
        spread = f", should the longest scatter {row.sd_ratio:g} times as much as the shortest"
        return f"{count_text(row.n[0], 'idle run')}{spread if row.sd_ratio != 1.0 else ''}"
    line = f", corrected with {count_text(row.idle_runs, 'idle run')}" if row.idle_runs else ""
    days = ""
    if row.days is not None:
        apart = "as much as runs" if row.day_sd == 1.0 else f"{row.day_sd:g} times as much as runs"
        days = f", each group on {count_text(row.days, 'day')} {WHOSE[row.layout]}, days differing {apart}"
    return f"n = {list_text([str(n) for n in row.groups])}{line}{spreads_text(row)}{days}"


def _design_clauses(found: Sequence[_Found]) -> str:
    """Say what was found at one design, tests and intervals apart, and where this report comes near it."""
    kinds: dict[tuple[tuple[str, str], float], list[_Found]] = {}
    for each in found:
        kinds.setdefault((_of_what(each[1]), each[1].nominal), []).append(each)
    return "; ".join(_share_clause(*what, nominal, of_kind) for (what, nominal), of_kind in kinds.items())


def _of_what(row: Recorded) -> tuple[str, str]:
    """Return what a method does, and in how many of which studies its share is."""
    if row.kind != SIZE:
        return "holds the truth in", ""
    if row.method.startswith("equivalence"):
        return "claims equivalence in", " of studies whose true difference lies on a bound"
    return "rejects", " of studies without an effect"


def _share_clause(verb: str, of: str, nominal: float, found: Sequence[_Found]) -> str:
    """Write the shares of methods of one kind and their nominal level; numbers of uses are in the methods' order."""
    nominal_text = f"({given_text(100.0 * nominal)} % stated)"
    (first, row, *_uses), *others = found
    shares = [f"{first} {verb} {_share(row)}{of} {nominal_text}"]
    shares += [f"{name} {'in ' if verb.endswith(' in') else ''}{_share(row)}" for name, row, *_uses in others]
    uses = _uses_text([own for _name, _row, own, _less in found])
    less = [less for _name, _row, _own, less in found]
    more = f", {_uses_text(less)} that err{'s' if less == [1] else ''} less" if any(less) else ""
    return f"{', '.join(shares)} ({uses} here{more})"


def _uses_text(counts: Sequence[int]) -> str:
    if len({*counts}) == 1:
        return f"{count_text(counts[0], 'use')}{' of each' if len(counts) > 1 else ''}"
    return f"{list_text([str(count) for count in counts])} uses"


def _share(row: Recorded) -> str:
    return f"{general_text(100.0 * row.value)} %"
