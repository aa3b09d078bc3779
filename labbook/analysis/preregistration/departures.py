"""What departs from what was decided, and which comparisons are exploratory for it.

Only what differs in the end is listed: who takes a correction back has changed nothing. It differs from what was first
stated after the first measurement, which is told and makes exploratory what it takes from a comparison, or from what a
report saw: a number that somebody had seen could have been replaced to please, so that its conditions are exploratory.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from data_schema.outcomes import Outcome, Source
from data_schema.queries.book_history import EntryRow
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import RunKind, RunState
from labbook.analysis.preregistration.book_state import (
    NO_RUN,
    BookHistory,
    BookState,
    Change,
    ChangeKind,
    difference,
    state_at,
)


class DepartureKind(Enum):
    """What departs; the value says it in words."""

    NO_ANALYSIS = "labbook.toml has no [analysis] any more: what it said before the first run was ingested stands"
    SETTING = (
        "[analysis] had {name} {was} before the first run was ingested and has {now} in labbook.toml{since}: {effect}"
    )
    JUMP_RULE = (
        "{name} of [protocol] was {was} before the first run was ingested and is {now} in labbook.toml: it is used, "
        "and apex heights are exploratory"
    )
    RUN_CORRECTED = "corrected after the first measurement: {column} of run {run} was {was} and is {now} ({by}){lost}"
    CHARGE_CORRECTED = (
        "corrected after the first measurement: {column} of the charge of run {run} was {was} and is {now} ({by}){lost}"
    )
    CHARGE_MOVED = "corrected after the first measurement: run of a charge was {was} and is {now} ({by}){lost}"
    LOG_REMOVED = "corrected after the first measurement: {name} was taken off run {run} ({by}){lost}"
    LOG_MOVED = (
        "corrected after the first measurement: {name} was taken off run {run} and given to run {now} ({by}){lost}"
    )
    CONDITION_CHANGED = (
        "the condition of run {run} was corrected after a report had been made: it was {was} and is {now} ({by})"
    )
    REPLACED = "{now} replaced {was} as the {source} of run {run} after a report had been made ({by})"
    SURPLUS = "{name} came to run {run} when it had its {source} ({by}){lost}"
    GIVEN_LATE = (
        "the {source} of run {run} was in the book when a report was made, and was given to it only afterwards ({by})"
    )
    RUNS_UNSELECTED = "the selection leaves out {runs} of the condition {condition} and takes its other runs"
    LEVELS_UNSELECTED = "the selection compares some levels of a group and leaves out {count} of it whole: {conditions}"
    CONDITIONS_UNSELECTED = (
        "the selection leaves out {count} whole, whose comparisons belong to the planned family (Holm's p of a report "
        "counts them): {conditions}"
    )

    def __str__(self) -> str:
        """Return the name, for programs."""
        return self.name.lower()


@dataclass(frozen=True, slots=True)
class Departure:
    """What departs, with what its words name, and what is exploratory for it.

    `quantities` are those whose comparisons are exploratory, none where it is only told; `conditions` the keys of the
    conditions that it is about, None where it is about all.
    """

    kind: DepartureKind
    parameters: Mapping[str, str]
    quantities: tuple[Outcome, ...] = ()
    conditions: tuple[str, ...] | None = None
    sentence: str = field(init=False)

    def __post_init__(self) -> None:
        """Put it in words."""
        object.__setattr__(self, "sentence", self.kind.value.format(**self.parameters))

    def touches(self, quantity: Outcome, conditions: Collection[str] | None) -> bool:
        """Tell whether a comparison of these conditions rests on it; None stands for any conditions."""
        about_them = conditions is None or self.conditions is None or not set(self.conditions).isdisjoint(conditions)
        return quantity in self.quantities and about_them


_LOST_BY: Mapping[str, Collection[Source]] = {
    "kind": tuple(Source),
    "starts": (Source.LOG,),
    **dict.fromkeys(("jumps_made", "duration_s", "mode"), (Source.CHARGE,)),
}
"""From which sources a run can have lost a number when a column of it or of its charge says otherwise."""


def departures_since(history: BookHistory, now: BookState, first_seq: int) -> list[Departure]:
    """List what departs from the book as it was first stated after an entry, and from what reports saw since."""
    states = _States(history, now, first_seq)
    return [*_corrected(states), *_condition_changed(states), *_replaced(states), *_came_late(states)]


class _States:
    """The book as it was first stated, as reports saw it and as it is now, and what several departures rest on."""

    def __init__(self, history: BookHistory, now: BookState, first_seq: int) -> None:
        self.history, self.now = history, now
        self.before = state_at(history, first_seq, arrivals=False)
        changed = [entry.seq for entry, _ in history.changes] + [entry.seq for entry in history.since.values()]
        changed.sort()
        same = {bisect(changed, seq): seq for seq in history.reports}  # of reports that saw the same, the last one
        self.reports = {seq: state_at(history, seq) for seq in same.values()}
        self.counting = [run for run in now.runs.values() if run.state is not RunState.VOID]
        self.given = {run.uid: now.given(run.uid) for run in self.counting}
        self.last: dict[tuple[str, str], EntryRow] = {}
        self.moves: dict[str, list[tuple[EntryRow, str, bool]]] = {}
        for entry, change in reversed(history.changes):
            self.last[change.item, change.column] = entry
            if change.column == "run_uid":
                self.moves.setdefault(change.item, []).extend([(entry, change.was, False), (entry, change.now, True)])
        self.exchanged = [item for run in self.counting for source in Source for item in self._exchanged(run, source)]
        self.elsewhere = {run.uid: keys for run in self.counting if (keys := self._other_conditions(run))}

    def outcomes(self, run: RunRow, source: Source) -> tuple[Outcome, ...]:
        """Return what a run gives a number of by a source."""
        return tuple(outcome for outcome in Outcome if outcome.source is source and outcome in self.given[run.uid])

    def _exchanged(self, run: RunRow, source: Source) -> Iterator[tuple[RunRow, Source, list[str], list[str]]]:
        """Find what a number came from at a report and comes not from now, and what it comes from instead."""
        gone: dict[str, None] = {}
        came: dict[str, None] = {}
        has = self.now.contents(run.uid, source)
        for state in self.reports.values() if self.outcomes(run, source) else ():
            had = state.contents(run.uid, source)
            if (left := _without(had, has)) and len(had) <= self.now.most(run.uid, source):
                gone, came = gone | left, came | _without(has, had)
        if gone:
            yield run, source, list(gone), list(came)

    def _other_conditions(self, run: RunRow) -> list[str]:
        """Return the keys of other conditions in which reports saw a run that has numbers."""
        seen = [state.runs[run.uid].condition_key for state in self.reports.values() if run.uid in state.runs]
        others = [key or "none" for key in dict.fromkeys(seen) if key != run.condition_key]
        return others if run.kind is RunKind.JUMPS and self.given[run.uid] else []

    def arrival(self, item: str, run_uid: str) -> EntryRow:
        """Return the entry with which a charge or a file came to its run; an absence that no report saw was none."""
        moves = [(entry, came) for entry, other, came in self.moves.get(item, ()) if other == run_uid]
        if not moves or not moves[0][1]:
            known = [entry for entry in (self.history.entry_of(item), self.history.since.get(run_uid)) if entry]
            moves.insert(0, (max(known, key=lambda entry: entry.seq), True))
        missed = max((seq for seq, state in self.reports.items() if not state.has(run_uid, item)), default=0)
        return next(entry for entry, came in moves if came and entry.seq > missed)

    def came_from_another(self, item: str, run_uid: str) -> bool:
        """Tell whether a charge or a file had been another run's when it came to this one."""
        since, moves = self.arrival(item, run_uid).seq, self.moves.get(item, ())
        return any(not came and run not in (run_uid, NO_RUN) and entry.seq <= since for entry, run, came in moves)

    def named(self, items: Iterable[str], *, typed: str = "a typed charge", read: str = "a charge of ") -> str:
        """Name charges by the files that they were read from, and logs by theirs."""
        of, names = self.history.file_of, self.history.file_names
        said = [
            names[item] if item not in of else read + names[of[item] or ""] if of[item] else typed for item in items
        ]
        return " and ".join(said)

    def shown(self, column: str, value: Any) -> str:
        """Return how the value of a column is shown."""
        if value is None or value == "":
            return "none"
        return (
            self.now.runs[value].name
            if column == "run_uid"
            else f"{value:g}"
            if isinstance(value, float)
            else str(value)
        )


def _without(some: Mapping[str, frozenset[Any]], others: Mapping[str, frozenset[Any]]) -> dict[str, None]:
    """Return those whose contents others have not."""
    return {uid: None for uid, of in some.items() if uid not in others and of.difference(*others.values())}


def _by(entry: EntryRow) -> str:
    return f"{entry.person}, {entry.at_utc[:10]}"


def _lost(runs: Sequence[RunRow], outcomes: Collection[Outcome]) -> str:
    names = ", ".join(run.name for run in runs)
    return f", which leaves run {names} without {' and '.join(outcome for outcome in Outcome if outcome in outcomes)}"


def _corrected(states: _States) -> Iterator[Departure]:
    """Find what is otherwise than it was first stated, and logs that reports saw elsewhere too."""
    now, before = states.now, states.before
    lost: dict[str, frozenset[Outcome]] = {}
    for run in states.counting:
        has = states.given[run.uid] if run.kind is before.runs[run.uid].kind else frozenset()
        lost |= {run.uid: gone} if (gone := before.given(run.uid, surplus=False) - has) else {}
    replaced = {(item, run.uid): bool(came) for run, _, gone, came in states.exchanged for item in gone}
    logs: dict[tuple[str, str], Change] = {}
    changes = difference(before, now)
    for change in changes:
        hidden = change.column == "condition_key" and change.item in states.elsewhere
        hidden |= change.column == "run_uid" and not change.now and replaced.get((change.item, change.was), False)
        if change.kind in (ChangeKind.RUN, ChangeKind.CHARGE) and not hidden:
            yield _correction(states, change, lost)
    for change in (*changes, *(change for state in states.reports.values() for change in difference(state, now))):
        if change.kind is ChangeKind.LOG and change.was and not now.has(change.was, change.item):
            logs.setdefault((change.item, change.was), change)
    for key, change in logs.items():
        if change.now or not replaced.get(key):
            told = _correction(states, change, lost)
            yield told if key not in replaced else _of_fewer_logs(states, told, now.runs[change.was])


def _correction(states: _States, change: Change, lost: Mapping[str, frozenset[Outcome]]) -> Departure:
    """Tell a change; where a run that it is about lost numbers by it, comparisons of its condition are exploratory."""
    column, entry = change.column.removesuffix("_key"), states.last[change.item, change.column.removesuffix("_key")]
    owners, sources = [change.item], _LOST_BY.get(column, ())
    if change.kind is ChangeKind.RUN:
        kind = DepartureKind.RUN_CORRECTED
        sources = () if column in ("jumps_made", "duration_s") and change.now else sources
    elif change.kind is ChangeKind.LOG:
        kind, owners, sources = DepartureKind.LOG_MOVED, [change.was, change.now], (Source.LOG,)
        kind = kind if change.now else DepartureKind.LOG_REMOVED
        entry = next(entry for entry, run, came in states.moves[change.item][::-1] if run == change.was and not came)
    elif column == "run_uid":
        kind, owners, sources = DepartureKind.CHARGE_MOVED, [change.was, change.now], (Source.CHARGE,)
    else:
        kind, owners = DepartureKind.CHARGE_CORRECTED, [states.now.charges[change.item].run_uid]
    without = [run for uid, run in states.now.runs.items() if uid in lost and uid in owners]
    taken = {run.uid: [item for item in Outcome if item.source in sources and item in lost[run.uid]] for run in without}
    without = [run for run in without if taken[run.uid]]
    keys = tuple(states.before.runs[run.uid].condition_key for run in without)
    outcomes = tuple(item for item in Outcome if any(item in taken[run.uid] for run in without))
    parameters = {
        "column": column,
        "name": states.history.file_names.get(change.item, ""),
        "run": states.shown("run_uid", owners[0]),
        "was": states.shown(change.column, change.was),
        "now": states.shown(change.column, change.now),
        "by": _by(entry),
        "lost": _lost(without, outcomes) if without else "",
    }
    return Departure(kind, parameters, outcomes, keys if all(keys) and without else None)


def _of_fewer_logs(states: _States, told: Departure, run: RunRow) -> Departure:
    """Make exploratory what rests on a run that has some of the logs that it had when a report was made."""
    lost = f"{told.parameters['lost']}, after a report had been made: run {run.name} keeps its other logs"
    outcomes = states.outcomes(run, Source.LOG)
    return Departure(
        told.kind, {**told.parameters, "lost": lost}, outcomes, (*(told.conditions or ()), run.condition_key)
    )


def _condition_changed(states: _States) -> Iterator[Departure]:
    """Find runs that are in another condition than when a report was made."""
    for uid, were in states.elsewhere.items():
        run = states.now.runs[uid]
        by, outcomes = _by(states.last[uid, "condition"]), [item for item in Outcome if item in states.given[uid]]
        parameters = {"run": run.name, "was": " and ".join(were), "now": run.condition_key, "by": by}
        yield Departure(DepartureKind.CONDITION_CHANGED, parameters, tuple(outcomes), (*were, run.condition_key))


def _replaced(states: _States) -> Iterator[Departure]:
    """Find charges and logs that took the place of others after a report; what nothing replaced was taken off."""
    for run, source, gone, came in states.exchanged:
        if came:
            last = max((states.arrival(item, run.uid) for item in came), key=lambda entry: entry.seq)
            said = {"was": states.named(gone), "now": states.named(came), "source": str(source), "run": run.name}
            yield Departure(
                DepartureKind.REPLACED, {**said, "by": _by(last)}, states.outcomes(run, source), _conditions(run)
            )


def _came_late(states: _States) -> Iterator[Departure]:
    """Find what came to a run that had all it can have, and what was in the book at a report and came to its run later.

    The first acts as an exclusion, unless one command brought all. Inboxes have to be emptied: the second is told only.
    """
    came = {(item, run.uid) for run, _, _, items in states.exchanged for item in items}
    for run in states.counting:
        missing = states.now.given(run.uid, surplus=False) - states.given[run.uid]
        for source in Source:
            said, items = {"run": run.name, "source": str(source)}, states.now.contents(run.uid, source)
            if lost := tuple(outcome for outcome in Outcome if outcome.source is source and outcome in missing):
                arrivals = sorted(
                    ((states.arrival(item, run.uid), item) for item in items), key=lambda each: each[0].seq
                )
                most = states.now.most(run.uid, source)
                had, _ = arrivals[most - 1]
                for entry, item in arrivals[most:]:
                    if _command(entry) != _command(had) and not states.came_from_another(item, run.uid):
                        name = states.named([item], typed="a further charge", read="a further charge of ")
                        words = {**said, "name": name, "by": _by(entry), "lost": _lost([run], lost)}
                        yield Departure(DepartureKind.SURPLUS, words, lost, _conditions(run))
            elif states.outcomes(run, source):
                for item in items:
                    read = states.history.entry_of(item)
                    if (item, run.uid) in came or read is None or states.came_from_another(item, run.uid):
                        continue
                    if any(read.seq < seq and not state.has(run.uid, item) for seq, state in states.reports.items()):
                        words = {**said, "by": _by(states.arrival(item, run.uid))}
                        yield Departure(DepartureKind.GIVEN_LATE, words)


def _command(entry: EntryRow) -> str:
    """Return what is the same for all that one command stated; the files of one `labbook ingest` share a batch."""
    return entry.new.get("batch") or str(entry.command)


def _conditions(run: RunRow) -> tuple[str, ...] | None:
    return None if run.kind is RunKind.IDLE else (run.condition_key,)
