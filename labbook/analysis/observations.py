"""Values with their group, day and run: what a comparison on the command line is made of, from a book or a table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from typing import Any

import sqlalchemy as sa

from data_schema.errors import InputRefused, UsageError, unknown_name
from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow, refuse_empty_selection
from data_schema.vocabulary import Undefined
from ingest.store import Store
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.pairing import sort_key, with_control
from labbook.analysis.outcomes.conditions import RunNumber, measure, run_numbers
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.preregistration.planned import Planned, planned_analysis
from labbook.analysis.results import Results
from labbook.analysis.study_data import StudyData, gather
from labbook.config.model import AnalysisSettings
from labbook.config.parsing import Configuration
from reports.display import shown_unit
from stats.compare.shared_error import SharedError, shared_of_mean

_MOST_NAMED = 5


def left_out(
    evidence: StudyData, numbers: Sequence[RunNumber], missing: Mapping[str, Undefined], quantity: Outcome
) -> list[str]:
    """Say which runs have no number, and why."""
    used = {item.run.uid for item in numbers}
    left = [run for run in evidence.runs if run.uid not in used]
    if not left:
        return []
    reasons = [
        f"{run.name} ({missing[run.uid].reason if run.uid in missing else 'undefined'})" for run in left[:_MOST_NAMED]
    ]
    more = ", ..." if len(left) > _MOST_NAMED else ""
    of_all = f"{len(left)} of {len(evidence.runs)} runs"
    return [f"{of_all} have no {quantity.plural} and are left out: {', '.join(reasons)}{more}."]


def _several_levels(numbers: Sequence[RunNumber], by: str, configuration: Configuration) -> list[str]:
    """Return which factors differ within the groups."""
    return [
        name
        for name in configuration.factors
        if name != by and len({item.run.levels.get(name) for item in numbers}) > 1
    ]


def pooled_over(numbers: Sequence[RunNumber], by: str, configuration: Configuration) -> list[str]:
    """Say which factors differ within the groups, whose runs are then compared as one."""
    found = _several_levels(numbers, by, configuration)
    if not found:
        return []
    return [
        f"Runs of several levels of {' and '.join(found)} are compared as one: --where selects one level, within which "
        "the planned families compare."
    ]


_OF_A_RUN: Mapping[str, Callable[[RunRow], str]] = {
    "day": lambda run: run.day,
    "robot": lambda run: run.robot,
    "battery": lambda run: run.battery,
}
"""What runs can be grouped by beside the study's factors."""


@dataclass(frozen=True, slots=True)
class Observation:
    """One value; None where it is missing and is to be left out. `shared` is its error in common with others.

    `pooled` are its levels of other factors that its group pools: groups are compared within them.
    """

    value: float | Decimal | None
    label: str
    """Of its group, as the table or the book writes it."""
    day: str = ""
    shared: SharedError = field(default_factory=SharedError)
    pooled: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Observations:
    """All values of one quantity in one unit, grouped by what is called `by`."""

    source: str
    quantity: str
    unit: str
    by: str
    control: str
    """Label of the group that the others are compared with."""
    rows: tuple[Observation, ...]
    notes: tuple[str, ...] = ()
    """What was left out, pooled or taken for granted."""
    plan: Planned | None = None
    """What rules the analysis of the book's values; None for a table."""
    measured: Outcome = Outcome.JOULES
    """Which of the book's quantities the values are."""
    configuration: Configuration | None = None
    """Of the book, which names its factors and their levels."""
    shown: Mapping[str, str] = field(default_factory=dict)
    """What groups are called for people, by label, where that is not what the table or the book writes."""
    shown_by: str = ""
    """What `by` is called for people, where that is something else."""

    @property
    def settings(self) -> AnalysisSettings | None:
        """The settings of the analysis that apply: those recorded in time, not those of labbook.toml today."""
        return None if self.plan is None else self.plan.settings

    @property
    def labels(self) -> list[str]:
        """Labels of the groups: the control's first, then numbers by size and words by alphabet."""
        found = sorted({row.label for row in self.rows}, key=sort_key)
        return sorted(found, key=lambda label: label != self.control)

    def name(self, label: str) -> str:
        """Return a group's name in sentences: as it is shown, or a bare number with what it is a level of."""
        if label in self.shown:
            return self.shown[label]
        return f"{self.by} {label}" if sort_key(label)[0] == 0 else label

    def values(self, label: str) -> list[Any]:
        """Return the values of a group, None for missing ones."""
        return [row.value for row in self.rows if row.label == label]

    def groups(self) -> dict[str, list[Any]]:
        """Return the values of every group by its name, the control first."""
        return {self.name(label): self.values(label) for label in self.labels}

    def shared(self, label: str) -> SharedError:
        """Return what the mean of a group takes from errors in common with others."""
        return shared_of_mean([row.shared for row in self.rows if row.label == label])

    def others(self) -> list[str]:
        """Return the labels of all groups but the control; raises `InputRefused` where there are none."""
        labels = self.labels[1:]
        if not labels:
            raise InputRefused(
                f"all values belong to one group ({self.name(self.control)}) of {self.by}: give values of at least 2, "
                "or group them with --by by something else."
            )
        return labels

    @property
    def rest(self) -> str:
        """The label of all groups but the control where they are one."""
        return f"every other {self.by}"

    def pooled(self) -> Observations:
        """Return all groups but the control as one."""
        self.others()
        return replace(
            self, rows=tuple(row if row.label == self.control else replace(row, label=self.rest) for row in self.rows)
        )

    def in_small_units(self) -> Observations:
        """Return lengths below 1 m in mm and times below 1 s in ms, as people read them; anything else as it is."""
        values = [row.value for row in self.rows if row.value is not None]
        unit, factor = shown_unit(self.unit)
        if factor == 1.0 or any(abs(float(value)) >= 1.0 for value in values):
            return self
        rows = tuple(
            replace(row, value=None if row.value is None else row.value * int(factor), shared=row.shared.times(factor))
            for row in self.rows
        )
        return replace(self, rows=rows, unit=unit)

    def known(self) -> Observations:
        """Return the observations that hold a value."""
        return replace(self, rows=tuple(row for row in self.rows if row.value is not None))


@dataclass(frozen=True, slots=True)
class ObservationRequest:
    """What is asked of a book: `by` and `control` None for the study's own."""

    quantity: Outcome = Outcome.JOULES
    by: str | None = None
    control: str | None = None
    where: str | None = None


def observations_of_book(
    connection: sa.Connection,
    store: Store,
    configuration: Configuration,
    asked: ObservationRequest,
    step: Callable[[str], None] = lambda _what: None,
) -> Observations:
    """Read the values that a report of the same runs shows: one a run, computed by the same functions.

    Raises `UnknownName` for a factor or a level that is not the study's.
    """
    refuse_empty_selection(connection, asked.where)
    evidence = gather(connection, configuration, asked.where)
    by = asked.by or pairing.swept_factor(configuration)
    if by is None:
        raise UsageError(
            "no factor of labbook.toml names its control, so that it is not clear what is compared: add --by."
        )
    names = [*configuration.factors, *_OF_A_RUN]
    if by not in names:
        raise unknown_name("factor or column of runs", by, names)
    numbers, missing = _numbers(connection, store, evidence, asked.quantity, step)
    if not numbers:
        why = f" ({next(iter(missing.values())).reason})" if missing else ""
        raise InputRefused(f"no selected run has a value of {asked.quantity}{why}: select others with --where.")
    swept = pairing.swept_factor(configuration)
    several = [name for name in _several_levels(numbers, by, configuration) if name != swept]
    rows = tuple(
        Observation(item.value, _label(item.run, by), item.run.day, item.shared, _levels(item.run, several))
        for item in numbers
    )
    factor = configuration.factors.get(by)
    control = with_control(asked.control, by, list({row.label for row in rows}), factor.control if factor else None)
    return Observations(
        source="book",
        quantity=asked.quantity.heading,
        unit=asked.quantity.unit,
        by=by,
        control=control,
        rows=rows,
        notes=(*left_out(evidence, numbers, missing, asked.quantity), *pooled_over(numbers, by, configuration)),
        plan=planned_analysis(connection, configuration, frozenset(run.uid for run in evidence.selected)),
        measured=asked.quantity,
        configuration=configuration,
    )


def _numbers(
    connection: sa.Connection,
    store: Store,
    evidence: StudyData,
    quantity: Outcome,
    step: Callable[[str], None],
) -> tuple[list[RunNumber], Mapping[str, Undefined]]:
    found = measure(quantity, Results(), Detections(connection, store, step), evidence)
    return run_numbers(evidence.runs, found.results, quantity), evidence.reasons(found.missing, quantity.source)


def _label(run: RunRow, by: str) -> str:
    return _OF_A_RUN[by](run) if by in _OF_A_RUN else run.levels.get(by, "none")


def _levels(run: RunRow, factors: Sequence[str]) -> tuple[str, ...]:
    return tuple(run.levels.get(name, "none") for name in factors)
