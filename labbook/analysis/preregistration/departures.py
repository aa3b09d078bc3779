"""What a departure from the plan takes from which comparisons, and what the choice of runs for a report leaves out.

A selection that takes a part of a condition's runs could have been made after looking at them.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

import sqlalchemy as sa

from data_schema.outcomes import Outcome
from data_schema.queries.charges import ChargeOfRun, charges_by_run
from data_schema.queries.runs import RunRow, list_runs
from data_schema.queries.signals import SignalRow, signals_of_runs
from data_schema.vocabulary import FileRole, RunKind, RunState
from labbook.analysis.comparison.condition_order import place_configured
from labbook.analysis.outcomes.detecting import BODY_HEIGHT
from labbook.analysis.outcomes.passive_drain import recharge_of
from labbook.analysis.outcomes.run_apexes import usable_logs
from labbook.analysis.outcomes.run_energy import usable_charge
from labbook.config.model import Configuration


@dataclass(frozen=True, slots=True)
class Departure:
    """What departs, in words, and what is exploratory for it.

    `quantities` are those whose comparisons are exploratory, none where it is only told; `conditions` the keys of the
    conditions that it is about, None where it is about all.
    """

    sentence: str
    quantities: tuple[Outcome, ...] = ()
    conditions: tuple[str, ...] | None = None

    def touches(self, quantity: Outcome, conditions: Collection[str] | None) -> bool:
        """Tell whether a comparison of these conditions rests on it; None stands for any conditions."""
        about_them = conditions is None or self.conditions is None or not set(self.conditions).isdisjoint(conditions)
        return quantity in self.quantities and about_them


@dataclass(frozen=True, slots=True)
class Analysable:
    """All runs, and what those that count give to an analysis, by the run's uid."""

    runs: tuple[RunRow, ...]
    charges: dict[str, list[ChargeOfRun]]
    logs: dict[str, list[SignalRow]] = field(default_factory=dict)

    def given(self, run: RunRow) -> frozenset[Outcome]:
        """Return the quantities that have a number from this run; an idle run gives to all joules."""
        if run.state is RunState.VOID:
            return frozenset()
        charges = self.charges.get(run.uid, [])
        if run.kind is RunKind.IDLE:
            return frozenset({Outcome.JOULES} if not isinstance(recharge_of(run, charges), str) else ())
        found = {
            Outcome.JOULES: usable_charge(run, charges),
            Outcome.APEX: usable_logs(run, self.logs.get(run.uid, [])),
        }
        return frozenset(quantity for quantity, usable in found.items() if not isinstance(usable, str))


def read_analysable(connection: sa.Connection) -> Analysable:
    """Read the runs of the book with their charges and logs."""
    found = Analysable(tuple(list_runs(connection)), charges_by_run(connection))
    for signal in signals_of_runs(connection, FileRole.LOG):
        if BODY_HEIGHT in signal.channels:
            found.logs.setdefault(signal.run_uid, []).append(signal)
    return found


def parted_conditions(every: Analysable, configuration: Configuration, selected: Collection[str]) -> list[Departure]:
    """List the conditions of which a selection (uids of runs) takes some runs that have numbers, and leaves others."""
    uids = set(selected)
    by_condition: dict[str, list[RunRow]] = {}
    for run in sorted(every.runs, key=lambda run: place_configured(configuration, run.levels)):
        if run.kind is RunKind.JUMPS:
            by_condition.setdefault(run.condition_key, []).append(run)
    return [
        Departure(
            f"the selection leaves out {'run' if len(names) == 1 else 'runs'} {', '.join(names)} of the condition "
            f"{key} and takes its other runs",
            quantities,
            (key,),
        )
        for key, runs in by_condition.items()
        for quantities, names in [_parted(every, runs, uids)]
        if quantities
    ]


def _parted(every: Analysable, runs: Sequence[RunRow], selected: set[str]) -> tuple[tuple[Outcome, ...], list[str]]:
    taken = {quantity for run in runs if run.uid in selected for quantity in every.given(run)}
    left = {run.name: every.given(run) & taken for run in runs if run.uid not in selected}
    quantities = tuple(item for item in Outcome if any(item in given for given in left.values()))
    return quantities, [name for name, given in left.items() if given]
