"""What is odd in what was written down of a run: possible, so remarked on, never refused; each by one of `RULES`.

`labbook attention` finds by the same checks.
"""

from __future__ import annotations

import shlex
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.queries.runs import runs_named
from data_schema.queries.study import planned_runs
from labbook.actions.runs.attention import CHECKS, Check, Facts, Finding, Gravity, correcting, found
from labbook.config.parsing import Configuration
from labbook.config.run_names import RunNames
from labbook.terminal import listed

MOST_NAMED = 20
"""Runs that a remark names beside the first."""


@dataclass(frozen=True, slots=True)
class Remark:
    """One rule, the first thing that it is about, up to `MOST_NAMED` more, and how many there are in all."""

    rule: str
    count: int
    first: str
    more: tuple[str, ...]
    message: str


def _plan(facts: Facts) -> Iterator[Finding]:
    plan = {row.run_name: row for row in planned_runs(facts.connection)}
    for run in facts.runs:
        planned = plan.get(run.name)
        if planned is None or (planned.condition_key or "") == run.condition_key:
            continue
        if planned.condition_key is None:
            words = correcting(run.name, "kind=idle", "jumps_made=0", "levels=none")
            yield found(f"run {run.name} was planned as an idle run", *words, run=run)
        else:
            words = correcting(run.name, *planned.condition_key.split())
            yield found(f"run {run.name} was planned with {planned.condition_key}", *words, run=run)


RULES: Mapping[str, Check] = {
    **CHECKS,
    # no check of `attention`: it is asked once, when the run is stated, for of a run that was in truth made otherwise
    # than planned nothing would ever mend it
    "differs_from_plan": Check(Gravity.DOUBTFUL, _plan, columns="condition kind", alike=False),
}
"""The checks that remark, by name, in the order in which remarks are shown."""


def remarks_on(
    connection: sa.Connection,
    configuration: Configuration,
    runs: Sequence[str],
    columns: Collection[str] | None = None,
) -> list[Remark]:
    """Apply the rules to runs, given by name: all rules, or those that look at one of `columns`."""
    rows = runs_named(connection, runs)
    facts = Facts(connection, configuration, rows, days=sorted({row.day for row in rows}))
    remarks = []
    for name, rule in RULES.items():
        looked_at = set(rule.columns.split())
        if looked_at and (columns is None or looked_at.intersection(columns)):
            messages = {str(one.run): f"{one.what}: `{one.command}`" for one in rule.look(facts)}
            for several in [messages] if rule.alike else [{run: text} for run, text in messages.items()]:
                remarks += _remark(name, several)
    return remarks


def remarks_on_names(names: Sequence[str], known: Collection[str], scheme: RunNames) -> list[Remark]:
    """Compare the names of new runs with those of planned runs and of runs that were there, and with the scheme.

    `R 7` may be `r7`; names of another form than `[study] run_names` says are remarked on where they were not planned.
    """
    folded = {_folded(name): name for name in known}
    messages = {
        name: f"run {name} is another run than {folded[_folded(name)]}, and their names differ in case or blanks only: "
        f"`labbook correct {shlex.quote(name)} name=...` renames it"
        for name in names
        if name not in known and _folded(name) in folded
    }
    says = f'run_names = "{scheme.scheme}" in [study] of labbook.toml says: only a file whose name begins so is its own'
    others = {
        name: f"run {name} is not called as {says}"
        for name in names
        if scheme.number(name) is None and name not in known and name not in messages
    }
    return _remark("name_almost_taken", messages) + _remark("name_of_other_form", others)


def remarks_on_places(new: Mapping[str, tuple[str, int]], taken: Mapping[tuple[str, int], str]) -> list[Remark]:
    """Compare the (day, position) of new runs, by name, with those that runs in the book have."""
    messages = {
        name: f"run {name} has position {place[1]} of {place[0]}, as run {taken[place]} has: their order is not known"
        for name, place in new.items()
        if place in taken
    }
    return _remark("position_taken", messages)


def _folded(name: str) -> str:
    return "".join(name.split()).casefold()


def _remark(rule: str, messages: Mapping[str, str]) -> list[Remark]:
    if not messages:
        return []
    first, *more = messages
    message = messages[first]
    if more:
        message += f"; the same of {listed(more, MOST_NAMED)}"
    return [Remark(rule, len(messages), first, tuple(more[:MOST_NAMED]), f"{message}.")]
