"""Conditions compared over days: y ~ condition + (1 | day) [+ (1 | day:run)], thesis 5.1 done with what days differ by.

Jumps of one day have that day in common. Taking them for independent finds "effects" that are days: with days that
differ as much as trials do and controllers on different days, a t-test over trials errs in 27 to 54 of 100 studies
without any effect. Here the day (and the run) is a random effect; a z-test, as some programs make of such a model,
takes the few days for infinitely many (p = 0.001 in place of 0.0035 for three days).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused, unknown_name
from data_schema.reasons import Limit, Reason
from data_schema.vocabulary import Remark, Undefined
from stats.checks import Labels, Missing, Sample, as_labels, as_level, as_sample, complete_rows, label_text
from stats.days.blocked_fit import Fit, Fitted, fit_by_day
from stats.days.blocked_result import BlockedByDay, ExactTest, MixedModel
from stats.days.cells import Codes, by_values, cells_of
from stats.days.exact_by_day import Strata, exact_test, paired_tests, strata_of
from stats.results import plural


def blocked_by_day(
    values: ArrayLike,
    condition: Labels,
    day: Labels,
    run: Labels | None = None,
    *,
    control: object = None,
    order: Sequence[object] | None = None,
    level: float = 0.95,
    missing: Missing = "refuse",
) -> BlockedByDay:
    """Compare the conditions of values of shape (n,), each with the labels of its condition, its day and its run.

    Runs are numbered within days: run 1 of Monday is not run 1 of Tuesday. Labels that are equal numbers, as 0 and 0.0,
    are one, called "0". `order` holds every condition once, in the order of the result, by default numbers by size and
    words by alphabet; `control` is the condition that the others are compared with, by default the first. What is
    stated comes from the exact F-test where the design is balanced, else from the mixed model, which agrees with
    lmerTest's Satterthwaite tests; where contrasts differ in their degrees of freedom, lmerTest's overall F-test
    depends on the order of the conditions and stands apart from the one that does not. Both take all conditions to
    scatter alike; paired tests on day means, which do not, stand beside them. Conditions of one day each get no p.
    Raises `InputRefused` for infinite values, labels of another length or of more than one dimension, an order of other
    conditions, and, unless `missing` is "drop", for values or labels that are missing (an infinite label and an empty
    one are); `UnknownName` for an unknown control.
    """
    level = as_level("level", level)
    read = _read(_columns(values, condition, day, run, missing), control, order, missing)
    n, names = read.sample.values.size, read.names
    notes = _merged(read.n_runs, read.n_days, n)
    with_runs = read.n_runs > 0 and not notes
    cells = cells_of(read.sample, read.condition, read.day, read.run if with_runs else read.day)
    strata = strata_of(cells)
    days_of = [np.unique(read.day[read.condition == k]).size for k in range(len(names))]
    result = fit_by_day(Fitted(cells, strata, with_runs, names, level), days_of)
    overall = result.overall
    exact = exact_test(cells, strata, with_runs, names, level)
    return BlockedByDay(
        n=n,
        n_days=read.n_days,
        n_runs=read.n_runs if run is not None else Undefined(Reason.NO_RUNS_GIVEN),
        level=level,
        conditions=result.conditions,
        mixed=MixedModel(
            f=overall if isinstance(overall, Undefined) else overall.f,
            df_between=len(names) - 1,
            df_within=overall if isinstance(overall, Undefined) else overall.df_within,
            p=overall if isinstance(overall, Undefined) else overall.tail.p,
            log10_p=overall if isinstance(overall, Undefined) else overall.tail.log10_p,
            contrasts=result.contrasts,
            lmertest_df_within=overall if isinstance(overall, Undefined) else overall.lmertest_df_within,
        ),
        exact=exact,
        paired=paired_tests(read.sample, read.condition, read.day, names, level),
        day_variance=result.day_variance,
        run_variance=result.run_variance if run is not None else Undefined(Reason.NO_RUNS_GIVEN),
        residual_variance=result.residual_variance,
        day_ratio=result.day_ratio,
        singular=result.singular,
        reml_criterion=result.reml_criterion,
        confounding=_confounding(strata, names, days_of, _counting(result, exact)),
        notes=notes,
        missing=read.missing,
    )


@dataclass(frozen=True, slots=True)
class _Labelled:
    """Values with the numbers of their condition, day and run, each of shape (n,), counted from 0."""

    sample: Sample
    names: tuple[str, ...]
    """Of the conditions, the control first."""
    condition: Codes
    day: Codes
    run: Codes
    """That of the day where no runs were given."""
    n_runs: int
    """0 where no runs were given."""
    missing: int
    """How many values were left out."""

    @property
    def n_days(self) -> int:
        return int(self.day.max()) + 1


def _columns(values: ArrayLike, condition: Labels, day: Labels, run: Labels | None, missing: Missing) -> list[Any]:
    """Return the values and the texts of their labels; without runs three columns."""
    given = {"condition": condition, "day": day} if run is None else {"condition": condition, "day": day, "run": run}
    return [values, *(as_labels(name, labels, missing) for name, labels in given.items())]


def _read(columns: list[Any], control: object, order: Sequence[object] | None, missing: Missing) -> _Labelled:
    """Check values and labels and number the labels; raises as `blocked_by_day` says."""
    (present, conditions, days, *runs), left_out = complete_rows(columns, missing)
    sample = as_sample("values", present)
    n = sample.values.size
    if n == 0:
        raise InputRefused("there are no values to compare: give at least one.")
    names, condition_codes = _coded("condition", conditions, n)
    _day_names, day_codes = _coded("day", days, n)
    day_codes = by_values(sample.values, day_codes)
    if order is not None:
        names, condition_codes = _ordered(order, names, condition_codes)
    if control is not None:
        names, condition_codes = _control_first(label_text(control), names, condition_codes)
    run_codes, n_runs = day_codes, 0
    if runs:
        _run_names, within_day = _coded("run", runs[0], n)
        run_codes = by_values(sample.values, day_codes * n + within_day)
        run_codes = np.unique(day_codes * n + run_codes, return_inverse=True)[1]
        n_runs = int(run_codes.max()) + 1
    return _Labelled(sample, names, condition_codes, day_codes, run_codes, n_runs, left_out)


def _coded(name: str, labels: NDArray[np.object_], n: int) -> tuple[tuple[str, ...], Codes]:
    """Return the distinct labels in order (numbers by size where all are numbers) and the number of each value's."""
    words: list[str] = labels.tolist()
    if len(words) != n:
        raise InputRefused(
            f"there {'is' if n == 1 else 'are'} {plural(n, 'value')} and {plural(len(words), 'label')} of {name}: "
            "give one label for each value."
        )
    names = sorted(set(words))
    try:
        names.sort(key=float)
    except ValueError:
        names.sort()
    place = {word: number for number, word in enumerate(names)}
    return tuple(names), np.array([place[word] for word in words], dtype=np.intp)


def _control_first(control: str, names: tuple[str, ...], codes: Codes) -> tuple[tuple[str, ...], Codes]:
    if control not in names:
        raise unknown_name("condition", control, names)
    return _renumbered((control, *(name for name in names if name != control)), names, codes)


def _ordered(order: Sequence[object], names: tuple[str, ...], codes: Codes) -> tuple[tuple[str, ...], Codes]:
    """Return the conditions in the order given, which holds each of them once."""
    given = tuple(as_labels("order", [order] if isinstance(order, str) else [*order], "drop").tolist())
    counts = Counter(given)
    faults = {
        "it lacks": [name for name in names if name not in counts],
        "no value has": [name for name in counts if name not in names],
        "it repeats": [name for name in names if counts[name] > 1],
    }
    if any(faults.values()):
        fault = " and ".join(f"{what} {', '.join(map(repr, some))}" for what, some in faults.items() if some)
        raise InputRefused(f"order is not that of the conditions: {fault}; give every condition that has values once.")
    return _renumbered(given, names, codes)


def _renumbered(order: tuple[str, ...], names: tuple[str, ...], codes: Codes) -> tuple[tuple[str, ...], Codes]:
    """Return the names in another order and the codes, which count them, accordingly."""
    place = {name: number for number, name in enumerate(order)}
    return order, np.array([place[name] for name in names], dtype=np.intp)[codes]


def _merged(n_runs: int, n_days: int, n: int) -> tuple[Remark, ...]:
    """Return the remark for a design in which two terms of the model are the same."""
    if n_days == n and n > 1:
        return (Remark(Limit.ONE_VALUE_A_DAY),)
    if n_runs == n:
        return (Remark(Limit.ONE_VALUE_A_RUN),)
    return (Remark(Limit.ONE_RUN_A_DAY),) if 0 < n_runs == n_days else ()


def _counting(fit: Fit, exact: ExactTest | Undefined) -> Limit:
    """Return the limit of conditions that share no day: which values their test takes for independent."""
    if (isinstance(exact, ExactTest) and exact.balanced) or isinstance(fit.day_variance, Undefined):
        return Limit.DAYS_COUNT
    if fit.day_variance > 0.0:
        return Limit.VALUES_DEPEND
    return Limit.RUNS_COUNT if isinstance(fit.run_variance, float) and fit.run_variance > 0.0 else Limit.VALUES_COUNT


def _confounding(strata: Strata, names: tuple[str, ...], days_of: list[int], counting: Limit) -> Remark | None:
    parts = int(strata.by_day.max()) + 1
    if parts == 1 or strata.day_is_value:
        return None
    groups = [
        [name for name, part in zip(names, strata.by_day, strict=True) if part == number] for number in range(parts)
    ]
    listed = " with ".join(", ".join(group) for group in groups)
    if strata.day == 0:
        return Remark(Limit.DAYS_UNMEASURED, listed=listed)
    few = ", ".join(name for name, count in zip(names, days_of, strict=True) if count == 1)
    return Remark(counting, listed=listed, n=strata.day, single=f"; {few} had one day only" if few else "")
